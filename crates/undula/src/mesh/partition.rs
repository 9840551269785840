//! Cells in parts of equal work, for processes that share a mesh.

use super::{Hierarchy, Mesh};

impl<const D: usize> Mesh<D> {
    /// The part of every cell, of `n` parts: halves of halves, cut across the longest side of the box around each, so that
    /// the parts of the work are those of the numbers of parts on both sides. `work` is that of a cell.
    ///
    /// Children of a cell, as `hierarchy` knows them, stay together: patches and coarser meshes are not cut. The result
    /// depends on the mesh alone. `None` if there are too few cells to be shared.
    pub fn partition(
        &self,
        hierarchy: &Hierarchy<D>,
        n: usize,
        work: impl Fn(usize) -> f64,
    ) -> Option<Vec<u32>> {
        let level = hierarchy.coarser().len();
        let of = |cell: usize| if level > 0 { hierarchy.child(level - 1, cell).parent } else { cell };
        let mut units: Vec<Unit<D>> = vec![];
        for cell in 0..self.n_cells() {
            let (number, x, work) = (of(cell), self.centre(cell), work(cell));
            match units.last_mut().filter(|unit| unit.number == number) {
                Some(unit) => {
                    unit.work += work;
                    (0..D).for_each(|d| unit.at[d] += work * x[d]);
                }
                None => units.push(Unit { number, at: x.map(|x| work * x), work, part: 0 }),
            }
        }
        if units.len() < LEAST * n {
            return None;
        }
        for unit in &mut units {
            unit.at = unit.at.map(|sum| sum / unit.work);
        }
        bisect(&mut units, 0, n);
        units.sort_unstable_by_key(|unit| unit.number);
        let find = |number: usize| units.binary_search_by_key(&number, |unit| unit.number).ok();
        (0..self.n_cells()).map(|cell| Some(units[find(of(cell))?].part)).collect()
    }
}

/// Units that each part has at least.
const LEAST: usize = 4;

/// A cell, or the children of one.
struct Unit<const D: usize> {
    number: usize,
    at: [f64; D],
    work: f64,
    part: u32,
}

/// Gives `units` the parts from `first` on, `n` of them.
fn bisect<const D: usize>(units: &mut [Unit<D>], first: usize, n: usize) {
    if n == 1 {
        units.iter_mut().for_each(|unit| unit.part = first as u32);
        return;
    }
    let extent = |d: usize| {
        let range = |(low, high): (f64, f64), unit: &Unit<D>| (low.min(unit.at[d]), high.max(unit.at[d]));
        let (low, high) = units.iter().fold((f64::INFINITY, f64::NEG_INFINITY), range);
        high - low
    };
    let extents: [f64; D] = std::array::from_fn(extent);
    let axis = (0..D).fold(0, |most, d| if extents[d] > extents[most] { d } else { most });
    units.sort_unstable_by(|a, b| a.at[axis].total_cmp(&b.at[axis]).then(a.number.cmp(&b.number)));
    let all: f64 = units.iter().map(|unit| unit.work).sum();
    let (left, mut sum) = (n / 2, 0.0);
    let wanted = all * left as f64 / n as f64;
    let mut cut = 0;
    while cut < units.len() && sum + 0.5 * units[cut].work < wanted {
        sum += units[cut].work;
        cut += 1;
    }
    // Every part has something, whatever the work of single units is.
    let cut = cut.clamp(left, units.len() - (n - left));
    let (one, two) = units.split_at_mut(cut);
    bisect(one, first, left);
    bisect(two, first + left, n - left);
}

#[cfg(test)]
mod tests {
    use crate::mesh::{Hierarchy, generate};

    #[test]
    fn parts_have_equal_work_and_keep_children_together() {
        let mesh = generate::rectangle([0.0; 2], [3.0, 1.0], [12, 4], 0).unwrap();
        let (fine, hierarchy) = Hierarchy::refine(mesh, 2, &[]);
        for n in [1, 2, 3, 4, 7] {
            let parts = fine.partition(&hierarchy, n, |_| 1.0).unwrap();
            let count = |part: usize| parts.iter().filter(|&&other| other as usize == part).count();
            let counts: Vec<usize> = (0..n).map(count).collect();
            let mean = fine.n_cells() / n;
            assert!(counts.iter().all(|count| count.abs_diff(mean) <= mean / 16), "{counts:?}");
            assert!(parts.chunks(4).all(|children| children.iter().all(|part| *part == children[0])));
        }
        // Cells that cost three times as much: a third of them is half of the work.
        let left = |cell: usize| fine.centre(cell)[0] < 1.0;
        let parts = fine.partition(&hierarchy, 2, |cell| if left(cell) { 4.0 } else { 1.0 }).unwrap();
        let first = parts.iter().filter(|part| **part == 0).count();
        assert!(first.abs_diff(fine.n_cells() / 4) <= 16, "{first}");
        assert!(fine.partition(&hierarchy, 100, |_| 1.0).is_none(), "192 units");
    }
}
