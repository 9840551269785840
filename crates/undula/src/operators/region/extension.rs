//! The entries of the extension, for a system of its own.

use super::kernel::Kernel;
use super::residual::PieceTask;
use super::tangents::ExtensionTask;
use crate::loops::scatter::DROP;
use crate::loops::test_functions::{Test, Trial};
use crate::loops::width::Width;
use crate::math::Lanes;
use crate::operators::StepView;
use crate::tangent::StepForm;

impl<F: StepForm<D>, const D: usize, const L: usize> Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    /// Call `visit(row, column, value)` for the entries of ψ against u, by places in `[v, u, p]`.
    pub(super) fn visit_extension(&self, step: &StepView<'_>, visit: &mut dyn FnMut(u32, u32, f64)) {
        let n = self.batches.n_basis;
        let n_v = step.new.v.len() as u32;
        for batch in 0..self.batches.len() {
            self.scratch.with(|s| {
                Lanes::<L>::dispatch(ExtensionTask { kernel: self, step, batch, scratch: &mut *s });
                for piece in &self.pieces {
                    let (Test::Psi(i), Trial::U(j)) = (piece.test, piece.trial) else { continue };
                    let block = &mut s.piece[..n * n];
                    Lanes::<L>::dispatch(PieceTask {
                        tangents: self.tangents(batch, &s.tangent, None),
                        piece,
                        block,
                        work: &mut s.tensor.matrices,
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
