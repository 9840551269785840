//! The unknowns that the smoother takes together.

use super::lists::Lists;
use super::numbers::{Cells, NONE, Numbers};

/// Groups of cells in parts of one process each, with that of each part.
pub fn by_rank(groups: Vec<Vec<u32>>, ranks: &[u32]) -> (Vec<Vec<u32>>, Vec<u32>) {
    let mut parts = vec![];
    for mut group in groups {
        // In their order within a part.
        group.sort_by_key(|&cell| ranks[cell as usize]);
        let of_rank = group.chunk_by(|&a, &b| ranks[a as usize] == ranks[b as usize]);
        parts.extend(of_rank.map(|part| (part.to_vec(), ranks[part[0] as usize])));
    }
    parts.into_iter().unzip()
}

/// The unknowns of groups of cells in the order of elimination, and the groups that have some: cell by cell, those that
/// later cells have, too, behind the others, pressures behind the velocities that feel them.
pub fn of_groups<const D: usize>(
    groups: &[Vec<u32>],
    numbers: &Numbers,
    cells: &Cells,
    continuous: bool,
) -> (Lists<u32>, Vec<usize>) {
    let (mut lists, mut made) = (Lists::default(), vec![]);
    // Cells of the group that each unknown is still to be met in.
    let mut ahead: Vec<u8> = vec![0; numbers.n];
    let mut is_listed = vec![false; numbers.n];
    for (number, group) in groups.iter().enumerate() {
        let velocities = |cell: usize| {
            let of = |&node: &u32| &numbers.v[node as usize * D..(node as usize + 1) * D];
            cells.nodes[cell].iter().flat_map(of).copied().filter(|number| *number != NONE)
        };
        let pressures = |cell: usize| {
            let of = cells.pressures[cell].iter().map(|&dof| numbers.p[dof as usize]);
            of.filter(|number| *number != NONE)
        };
        for cell in group.iter().map(|&cell| cell as usize) {
            velocities(cell).chain(pressures(cell)).for_each(|number| ahead[number as usize] += 1);
        }
        let mut list: Vec<u32> = vec![];
        for cell in group.iter().map(|&cell| cell as usize) {
            velocities(cell).chain(pressures(cell)).for_each(|number| ahead[number as usize] -= 1);
            for shared in [false, true] {
                for number in velocities(cell) {
                    let at = number as usize;
                    if !is_listed[at] && (ahead[at] > 0) == shared {
                        is_listed[at] = true;
                        list.push(number);
                    }
                }
            }
            for number in pressures(cell) {
                if !(is_listed[number as usize] || continuous && ahead[number as usize] > 0) {
                    is_listed[number as usize] = true;
                    list.push(number);
                }
            }
        }
        list.iter().for_each(|&number| is_listed[number as usize] = false);
        if !list.is_empty() {
            lists.push(list);
            made.push(number);
        }
    }
    (lists, made)
}
