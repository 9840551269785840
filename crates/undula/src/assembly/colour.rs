//! Colours: no two batches of a colour share an unknown.

/// Sort `items` (lists of what each batch touches, numbers below `n`) into colours.
///
/// Returns a permutation of the batches, sorted by colour, and where each colour begins and ends in it.
/// Greedy in the given order, so that the result depends on the mesh alone.
pub fn colour(items: &[Vec<u32>], n: usize) -> (Vec<usize>, Vec<std::ops::Range<usize>>) {
    // `used[i]`: bit c is set when unknown i is touched by a batch of colour c.
    let mut used = vec![0u64; n];
    let mut colours: Vec<Vec<usize>> = vec![];
    for (batch, touched) in items.iter().enumerate() {
        let taken = touched.iter().fold(0, |bits, &i| bits | used[i as usize]);
        let c = (!taken).trailing_zeros() as usize;
        assert!(c < 64, "more than 64 colours: a node belongs to too many batches");
        for &i in touched {
            used[i as usize] |= 1 << c;
        }
        if colours.len() <= c {
            colours.push(vec![]);
        }
        colours[c].push(batch);
    }
    let mut ranges = vec![];
    let mut order = vec![];
    for list in colours {
        ranges.push(order.len()..order.len() + list.len());
        order.extend(list);
    }
    (order, ranges)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_of_a_colour_are_disjoint() {
        let items: Vec<Vec<u32>> = (0..50).map(|i| vec![i, i + 1, (i * 7) % 51]).collect();
        let (order, ranges) = colour(&items, 52);
        let mut seen = order.clone();
        seen.sort_unstable();
        assert_eq!(seen, (0..50).collect::<Vec<_>>());
        for range in ranges {
            let mut all: Vec<u32> = order[range]
                .iter()
                .flat_map(|&b| {
                    let mut own = items[b].clone();
                    own.sort_unstable();
                    own.dedup();
                    own
                })
                .collect();
            let n = all.len();
            all.sort_unstable();
            all.dedup();
            assert_eq!(all.len(), n);
        }
    }
}
