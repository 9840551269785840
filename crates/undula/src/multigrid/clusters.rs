//! Which cells the smoother takes together.
//!
//! The children of a coarser cell are one group: with them, velocities that are free of divergence on the coarser level
//! become so on the finer one. Where cells are long and thin, errors hardly change across the thin side, and groups are
//! joined there: to columns through a boundary layer, or through the thickness of a thin body.

use super::lists::Lists;
use crate::mesh::Mesh;

/// Cells are joined across facets where both are at most this part of their largest size.
const THIN: f64 = 0.6;

/// How many cells like this one, side by side, are about as long in all directions.
pub fn side_by_side<const D: usize>(mesh: &Mesh<D>, cell: u32) -> usize {
    let sizes = mesh.sizes(cell as usize);
    let longest = sizes.iter().copied().fold(0.0, f64::max);
    sizes.iter().map(|size| (longest / size).round()).product::<f64>() as usize
}

/// Groups of cells of `mesh`, with `most` of their first cells in them at most, where the first `axes` of a cell are
/// coarsened: cells may be as long as they are along the others.
pub fn groups<const D: usize>(mesh: &Mesh<D>, axes: usize, most: impl Fn(u32) -> usize) -> Vec<Vec<u32>> {
    let n = mesh.n_cells();
    let strong = strong_neighbours(mesh, axes);
    let mut order: Vec<u32> = (0..n as u32).collect();
    // From the ends of columns.
    order.sort_by_key(|&cell| strong[cell as usize].len());
    let mut is_taken = vec![false; n];
    let mut groups = vec![];
    for first in order {
        if std::mem::replace(&mut is_taken[first as usize], true) {
            continue;
        }
        let (mut group, most) = (vec![first], most(first));
        let mut next = 0;
        while let Some(&cell) = group.get(next) {
            for &other in &strong[cell as usize] {
                if group.len() < most && !std::mem::replace(&mut is_taken[other as usize], true) {
                    group.push(other);
                }
            }
            next += 1;
        }
        groups.push(group);
    }
    // In the order of the mesh, so that neighbours are near in memory.
    groups.sort_by_key(|group| group.iter().copied().min());
    groups
}

/// The cells across the facets to which each cell is thin.
fn strong_neighbours<const D: usize>(mesh: &Mesh<D>, axes: usize) -> Vec<Vec<u32>> {
    let mut strong = vec![vec![]; mesh.n_cells()];
    if mesh.shape.is_simplex() {
        return strong;
    }
    let sizes: Vec<[f64; D]> = (0..mesh.n_cells()).map(|cell| mesh.sizes(cell)).collect();
    let is_thin = |cell: u32, local: u8| {
        let sizes = &sizes[cell as usize];
        sizes[usize::from(local) / 2] <= THIN * sizes[..axes].iter().copied().fold(0.0, f64::max)
    };
    for [one, two] in mesh.facets_of_cells().inner {
        if is_thin(one.cell, one.local) && is_thin(two.cell, two.local) {
            strong[one.cell as usize].push(two.cell);
            strong[two.cell as usize].push(one.cell);
        }
    }
    strong
}

/// Colours of lists of numbers below `n`: lists of one colour have none in common.
pub fn colours(lists: &Lists<u32>, n: usize) -> Vec<Vec<u32>> {
    let mut used: Vec<u64> = vec![0; n];
    let mut colours: Vec<Vec<u32>> = vec![];
    for (number, list) in lists.iter().enumerate() {
        let taken = list.iter().fold(0, |taken, &item| taken | used[item as usize]);
        // With more than 64 colours the last one would have lists that meet.
        let colour = (!taken).trailing_zeros().min(63) as usize;
        list.iter().for_each(|&item| used[item as usize] |= 1 << colour);
        colours.resize(colours.len().max(colour + 1), vec![]);
        colours[colour].push(number as u32);
    }
    colours
}
