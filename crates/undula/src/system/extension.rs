//! The extension as a system of its own: δu in the fluid from δu on the interface.
//!
//! Where the model is linear its matrix stays for the run, and is factorised once.

use super::directions::DirectedBlocks;
use crate::algebra::{Csr, Pattern, add_column};
use crate::loops::scatter::DROP;
use crate::space::{Constraints, Directions, FsiSpace, PsiOwner};
use std::sync::Arc;

/// `A_F δu_F = r_F − A_I δu_I` over the free unknowns of the fluid off the interface.
#[derive(Clone, Debug)]
pub struct ExtensionSystem<const D: usize> {
    /// A_F.
    pub matrix: Csr,
    /// Place in `[v, u, p]` of each unknown.
    pub places: Vec<u32>,
    /// Rows of A_I that are not zero, with the ends of their entries.
    rows: Vec<(u32, u32)>,
    /// Entries of A_I: place in `[v, u, p]`, value.
    entries: Vec<(u32, f64)>,
    /// Directions in which u vanishes, in the matrix and in right-hand sides.
    directions: DirectedBlocks<D>,
    along: Vec<(u32, Directions<D>)>,
    /// Where each entry visited goes: in the matrix, behind it in `entries`, or nowhere. Empty if nothing changes.
    slots: Vec<u32>,
}

/// Take a value to its place.
fn put(matrix: &mut Csr, entries: &mut [(u32, f64)], slot: u32, value: f64) {
    let behind = matrix.values.len();
    match slot {
        DROP => {}
        at if (at as usize) < behind => matrix.values[at as usize] += value,
        at => entries[at as usize - behind].1 = value,
    }
}

/// Leave out entries that are zero: what other components have where the operator does not couple components.
fn drop_zeros(rows: &mut [(u32, u32)], entries: &mut Vec<(u32, f64)>) {
    let (mut start, mut kept) =
        (0, Vec::with_capacity(entries.iter().filter(|entry| entry.1 != 0.0).count()));
    for (_, end) in rows {
        kept.extend(entries[start..*end as usize].iter().filter(|entry| entry.1 != 0.0));
        (start, *end) = (*end as usize, kept.len() as u32);
    }
    *entries = kept;
}

/// Numbers of the unknowns by their places in `[v, u, p]`, and the places by their numbers.
fn numbers<const D: usize>(space: &FsiSpace<D>, given: impl Fn(u32) -> bool) -> (Vec<u32>, Vec<u32>) {
    let mut number = vec![DROP; space.n_field_unknowns()];
    let mut places = vec![];
    for node in (0..space.nodes.len()).filter(|&n| space.owner[n] == PsiOwner::Extension) {
        let components = (0..D).map(|i| (space.n_v() + node * D + i) as u32);
        for place in components.filter(|&place| !given(place)) {
            number[place as usize] = places.len() as u32;
            places.push(place);
        }
    }
    (number, places)
}

impl<const D: usize> ExtensionSystem<D> {
    /// From `visit`, which calls back with (row, column, value) by places in `[v, u, p]`, always alike; `changes`: there
    /// will be other values.
    pub(super) fn new(
        space: &FsiSpace<D>,
        constraints: &Constraints<D>,
        changes: bool,
        mut visit: impl FnMut(&mut dyn FnMut(u32, u32, f64)),
    ) -> ExtensionSystem<D> {
        let first = space.n_v() as u32;
        let given = |place: u32| constraints.u[(place - first) as usize / D][(place - first) as usize % D];
        let moved: Vec<u32> = constraints.motion.iter().map(|(node, _)| *node).collect();
        // Given, and not 0: the update of an interface, or of a boundary whose displacement is given.
        let drives = |place: u32| !given(place) || moved.binary_search(&((place - first) / D as u32)).is_ok();
        let (number, places) = numbers(space, given);
        let mut lists: Vec<Vec<u32>> = vec![vec![]; places.len()];
        let mut interface: Vec<Vec<u32>> = vec![vec![]; places.len()];
        visit(&mut |row, column, _| {
            let (row, other) = (number[row as usize], number[column as usize]);
            match (row, other) {
                (DROP, _) => {}
                (row, DROP) if drives(column) => interface[row as usize].push(column),
                (_, DROP) => {}
                (row, other) => add_column(&mut lists[row as usize], other),
            }
        });
        let mut directions = DirectedBlocks::new(space, constraints, &number, &mut lists);
        let pattern = Arc::new(Pattern::from_rows(&lists));
        drop(lists);
        directions.place(&pattern);
        let in_fluid = |at: &&Directions<D>| at.u && number[space.n_v() + at.node as usize * D] != DROP;
        let along = constraints.directions.iter().filter(in_fluid);
        let along = along.map(|at| (number[space.n_v() + at.node as usize * D], at.clone())).collect();
        let (mut rows, mut starts) = (vec![], vec![0; places.len()]);
        let mut entries = Vec::with_capacity(interface.iter().map(Vec::len).sum());
        for (row, list) in interface.iter().enumerate().filter(|(_, list)| !list.is_empty()) {
            starts[row] = entries.len();
            entries.extend(list.iter().map(|&place| (place, 0.0)));
            rows.push((row as u32, entries.len() as u32));
        }
        let (behind, mut slots, mut matrix) = (pattern.nnz() as u32, vec![], Csr::zeros(&pattern));
        visit(&mut |row, column, value| {
            let (row, other) = (number[row as usize], number[column as usize]);
            let slot = match (row, other) {
                (DROP, _) => DROP,
                (row, DROP) if drives(column) => {
                    starts[row as usize] += 1;
                    behind + starts[row as usize] as u32 - 1
                }
                (_, DROP) => DROP,
                (row, other) => pattern.find(row as usize, other as usize).map_or(DROP, |at| at as u32),
            };
            put(&mut matrix, &mut entries, slot, value);
            if changes {
                slots.push(slot);
            }
        });
        directions.constrain(&mut matrix);
        if !changes {
            drop_zeros(&mut rows, &mut entries);
        }
        ExtensionSystem { matrix, places, rows, entries, directions, along, slots }
    }

    /// Forget the matrix, which has its factors and will not change.
    pub fn settle(&mut self) {
        self.matrix = Csr::zeros(&Arc::new(Pattern::from_rows::<[u32; 0]>(&[])));
    }

    /// Take the values that `visit` calls back with, in the same order as before.
    pub(super) fn fill(&mut self, mut visit: impl FnMut(&mut dyn FnMut(u32, u32, f64))) {
        let Self { matrix, entries, slots, .. } = self;
        matrix.values.fill(0.0);
        let mut slots = slots.iter();
        visit(&mut |_, _, value| put(matrix, entries, slots.next().copied().unwrap_or(DROP), value));
        self.directions.constrain(&mut self.matrix);
    }

    /// `b ← r_F − A_I δu_I` with the residual `r` and the update `delta`, both `[v, u, p]`; without `r` it is zero
    /// but for the neighbours of the interface.
    pub fn right_hand_side(&self, r: Option<&[f64]>, delta: &[f64], b: &mut [f64]) {
        match r {
            Some(r) => b.iter_mut().zip(&self.places).for_each(|(b, &place)| *b = r[place as usize]),
            None => b.fill(0.0),
        }
        let mut start = 0;
        for &(row, end) in &self.rows {
            for &(place, value) in &self.entries[start..end as usize] {
                b[row as usize] -= value * delta[place as usize];
            }
            start = end as usize;
        }
        for (first, at) in &self.along {
            at.project(&mut b[*first as usize..*first as usize + D]);
        }
    }
}
