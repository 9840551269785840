//! Segments that become lines.

use std::collections::BTreeMap;

/// Joins segments that have ends in common, of which no more than two meet, to lines.
pub fn chains(segments: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut beside: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (n, segment) in segments.iter().enumerate() {
        segment.iter().for_each(|&end| beside.entry(end).or_default().push(n));
    }
    let mut is_left = vec![true; segments.len()];
    let mut chains = vec![];
    // Open lines begin at an end; what is left then is closed.
    let ends = beside.iter().filter(|(_, at)| at.len() == 1).chain(&beside).map(|(&point, _)| point);
    for start in ends {
        let mut chain = vec![start];
        let mut at = start;
        while let Some(&next) = beside[&at].iter().find(|&&n| is_left[n]) {
            is_left[next] = false;
            let [a, b] = segments[next];
            at = if a == at { b } else { a };
            chain.push(at);
        }
        if chain.len() > 1 {
            chains.push(chain);
        }
    }
    chains
}

/// A line without the points that are no farther than `tolerance` from the line through the others.
pub fn simplified(line: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let [Some(&first), Some(&last)] = [line.first(), line.last()] else { return vec![] };
    let along = [last[0] - first[0], last[1] - first[1]];
    let size = along[0].hypot(along[1]);
    let distance = |x: &[f64; 2]| {
        let from = [x[0] - first[0], x[1] - first[1]];
        // A closed line has no direction.
        if size > tolerance {
            (from[0] * along[1] - from[1] * along[0]).abs() / size
        } else {
            from[0].hypot(from[1])
        }
    };
    let farthest = (0..line.len()).max_by(|&a, &b| distance(&line[a]).total_cmp(&distance(&line[b])));
    match farthest {
        Some(n) if distance(&line[n]) > tolerance => {
            let mut kept = simplified(&line[..=n], tolerance);
            kept.pop();
            kept.extend(simplified(&line[n..], tolerance));
            kept
        }
        _ => vec![first, last],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_joined_and_closed_ones_are_closed() {
        assert_eq!(chains(&[[5, 3], [1, 2], [2, 3]]), [[1, 2, 3, 5]]);
        assert_eq!(chains(&[[1, 2], [3, 1], [3, 2]]), [[1, 2, 3, 1]]);
        assert!(chains(&[]).is_empty());
    }

    #[test]
    fn lines_keep_the_points_in_which_they_bend() {
        let line = [[0.0, 0.0], [1.0, 0.01], [2.0, 0.0], [3.0, 1.0], [3.5, 1.5], [4.0, 2.0]];
        assert_eq!(simplified(&line, 0.02), [[0.0, 0.0], [2.0, 0.0], [4.0, 2.0]]);
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 1.0], [0.0, 1.0], [0.0, 0.0]];
        assert_eq!(simplified(&square, 0.02).len(), 5);
    }
}
