//! The extension as a system of its own: δu in the fluid from δu on the interface.
//!
//! Where the model is linear its matrix stays for the run, and is factorised once.

use super::contract::{Test, Trial};
use super::kernel::{Kernel, StepView};
use super::scatter::DROP;
use super::simd::Width;
use super::tangents::{Directions, TangentTasks};
use crate::algebra::{Csr, Pattern};
use crate::math::Lanes;
use crate::space::{Constraints, FsiSpace, PsiOwner};
use crate::tangent::{ByHand, Linearization, Tangent};
use std::sync::Arc;

/// `A_F δu_F = r_F − A_I δu_I` over the free nodes of the fluid off the interface.
#[derive(Clone, Debug)]
pub struct ExtensionSystem {
    /// A_F.
    pub matrix: Csr,
    /// Place in `[v, u, p]` of each unknown.
    pub places: Vec<u32>,
    /// Rows of A_I that are not zero, with the ends of their entries.
    rows: Vec<(u32, u32)>,
    /// Entries of A_I: place in `[v, u, p]`, value.
    entries: Vec<(u32, f64)>,
}

impl ExtensionSystem {
    /// From `visit`, which calls back with (row, column, value) by places in `[v, u, p]`, always alike.
    pub(super) fn new<const D: usize>(
        space: &FsiSpace<D>,
        constraints: &Constraints<D>,
        mut visit: impl FnMut(&mut dyn FnMut(u32, u32, f64)),
    ) -> ExtensionSystem {
        let first = space.n_v() as u32;
        let mut number = vec![DROP; space.n_unknowns()];
        let mut places = vec![];
        for node in
            (0..space.nodes.len()).filter(|&n| space.owner[n] == PsiOwner::Extension && !constraints.u[n])
        {
            for i in 0..D {
                let place = first + (node * D + i) as u32;
                number[place as usize] = places.len() as u32;
                places.push(place);
            }
        }
        let mut lists: Vec<Vec<u32>> = vec![vec![]; places.len()];
        let mut interface: Vec<Vec<(u32, f64)>> = vec![vec![]; places.len()];
        let given = |place: u32| constraints.u[(place - first) as usize / D];
        visit(&mut |row, column, value| {
            let (row, other) = (number[row as usize], number[column as usize]);
            match (row, other) {
                (DROP, _) => {}
                (row, DROP) if !given(column) => interface[row as usize].push((column, value)),
                (_, DROP) => {}
                (row, other) => lists[row as usize].push(other),
            }
        });
        let pattern = Arc::new(Pattern::from_rows(&lists));
        drop(lists);
        let mut matrix = Csr::zeros(&pattern);
        visit(&mut |row, column, value| {
            let (row, column) = (number[row as usize], number[column as usize]);
            if let (true, Some(at)) = (row != DROP, pattern_find(&pattern, row, column)) {
                matrix.values[at] += value;
            }
        });
        let (mut rows, mut entries) = (vec![], vec![]);
        for (row, list) in interface.into_iter().enumerate().filter(|(_, list)| !list.is_empty()) {
            entries.extend(list);
            rows.push((row as u32, entries.len() as u32));
        }
        ExtensionSystem { matrix, places, rows, entries }
    }

    /// `b ← r_F − A_I δu_I` with the residual `r` and the update `delta`, both `[v, u, p]`.
    pub fn right_hand_side(&self, r: &[f64], delta: &[f64], b: &mut [f64]) {
        for (b, &place) in b.iter_mut().zip(&self.places) {
            *b = r[place as usize];
        }
        let mut start = 0;
        for &(row, end) in &self.rows {
            for &(place, value) in &self.entries[start..end as usize] {
                b[row as usize] -= value * delta[place as usize];
            }
            start = end as usize;
        }
    }
}

fn pattern_find(pattern: &Pattern, row: u32, column: u32) -> Option<usize> {
    if row == DROP || column == DROP { None } else { pattern.find(row as usize, column as usize) }
}

impl<F: ByHand<D>, const D: usize, const L: usize> Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    /// Call `visit(row, column, value)` for the entries of ψ against u, by places in `[v, u, p]`.
    pub fn extension(&self, step: &StepView<'_>, visit: &mut dyn FnMut(u32, u32, f64)) {
        let n = self.batches.n_basis;
        let n_v = step.new.v.len() as u32;
        for batch in 0..self.batches.len() {
            self.scratch.with(|s| {
                let (linearization, tangent) = (Linearization::Newton, Tangent::Analytic);
                let directions = Directions::All;
                TangentTasks { kernel: self, step, linearization, tangent, directions, batch, scratch: s }
                    .run();
                for piece in &self.pieces {
                    let (Test::Psi(i), Trial::U(j)) = (piece.test, piece.trial) else { continue };
                    let block = &mut s.piece[..n * n];
                    Lanes::<L>::dispatch(super::tasks::PieceTask {
                        tangents: self.tangents(batch, &s.tangent),
                        piece,
                        block,
                    });
                    for (at, value) in block.iter().enumerate() {
                        let rows = &self.rows_psi[batch * n + at / n];
                        let nodes = &self.batches.nodes[batch * n + at % n];
                        for l in (0..self.batches.active[batch]).filter(|&l| rows[l] != DROP) {
                            visit(rows[l] + i as u32, n_v + nodes[l] * D as u32 + j as u32, value.0[l]);
                        }
                    }
                }
            });
        }
    }
}
