//! Numbers of the unknowns of a level.

use crate::algebra::Unknown;

/// A place without unknown.
pub const NONE: u32 = u32::MAX;

/// Numbers of the unknowns of a level.
pub struct Numbers {
    /// Of the components of v at each node.
    pub v: Vec<u32>,
    /// Of each pressure.
    pub p: Vec<u32>,
    /// How many there are.
    pub n: usize,
}

/// The unknowns that `rows` have entries of, numbered anew. Where the finest level has eliminated the slopes of the
/// pressure, nothing depends on those along an axis that is not halved.
pub fn without_idle(
    mut numbers: Numbers,
    unknowns: Vec<Unknown>,
    rows: &mut [Vec<(u32, f32)>],
) -> (Numbers, Vec<Unknown>) {
    let mut is_used = vec![false; numbers.n];
    rows.iter().flatten().for_each(|&(column, _)| is_used[column as usize] = true);
    let mut next = 0..numbers.n as u32;
    let number = |used: &bool| used.then(|| next.next()).flatten().unwrap_or(NONE);
    let renumbered: Vec<u32> = is_used.iter().map(number).collect();
    let all = numbers.v.iter_mut().chain(&mut numbers.p).filter(|number| **number != NONE);
    all.for_each(|number| *number = renumbered[*number as usize]);
    rows.iter_mut().flatten().for_each(|(column, _)| *column = renumbered[*column as usize]);
    numbers.n = next.start as usize;
    let unknowns = unknowns.into_iter().zip(is_used).filter_map(|(unknown, used)| used.then_some(unknown));
    (numbers, unknowns.collect())
}

/// The nodes and pressures of the cells of a level.
pub struct Cells {
    pub nodes: Vec<Vec<u32>>,
    pub pressures: Vec<Vec<u32>>,
}
