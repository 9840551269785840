//! The matrices of the stabilisation by differences in nodal values.

use super::tasks::{MatrixTask, Scratch};
use crate::loops::test_functions::Trial;
use crate::loops::width::Task;
use crate::math::{Lanes, Scalar};
use crate::tangent::Difference;

/// The matrix by differences of the terms in nodal values, as `crate::operators::region` has them.
pub(super) struct DifferenceTask<'a, const D: usize, const L: usize> {
    pub(super) by: &'a Difference,
    pub(super) task: MatrixTask<'a, D, L>,
}

impl<const D: usize, const L: usize> Task for DifferenceTask<'_, D, L> {
    #[inline(always)]
    fn run(self) {
        let MatrixTask { of, step, couplings, slots, batch, scratch: s, out } = self.task;
        let (n, m) = (of.tables.velocity.n, of.tables.pressure.n);
        let points = of.tables.points() * n;
        let gradients = &of.tables.velocity.grad[batch * points..(batch + 1) * points];
        let steps = self.by.steps(gradients.iter().flat_map(|g| (0..L).map(|l| g.map(|x| x.0[l]))));
        let [h_v, h_u, h_p] = steps.map(Lanes::<L>::splat);
        of.load(step, batch, s);
        let (mut matrix, mut base) = (std::mem::take(&mut s.matrix), std::mem::take(&mut s.base));
        // The first column stands for the iterate itself.
        let columns = couplings.iter().flat_map(|coupling| {
            let (nodes, components) = if coupling.trial == Trial::P { (m, 1) } else { (n, D) };
            (0..nodes * components).map(move |at| Some((coupling.trial, at / components, at % components)))
        });
        let mut entries = matrix.chunks_exact_mut(n * D + m);
        for column in std::iter::once(None).chain(columns) {
            let mut h = Lanes::zero();
            let mut before = Lanes::zero();
            if let Some((trial, b, j)) = column {
                h = match trial {
                    Trial::V(_) => h_v,
                    Trial::U(_) => h_u,
                    Trial::P => h_p,
                };
                let value = s.unknown(trial, b, j);
                before = *value;
                *value += h;
            }
            of.rows(step, batch, s);
            let rows = s.phi.iter().flat_map(|phi| phi.0).chain(s.xi.iter().copied());
            let Some((trial, b, j)) = column else {
                base.iter_mut().zip(rows).for_each(|(base, row)| *base = row);
                continue;
            };
            let Some(entries) = entries.next() else { return };
            for ((entry, row), base) in entries.iter_mut().zip(rows).zip(&base) {
                *entry = (row - *base) / h;
            }
            *s.unknown(trial, b, j) = before;
        }
        of.scatter(couplings, &matrix, (slots, batch), out);
        (s.matrix, s.base) = (matrix, base);
    }
}

impl<const D: usize, const L: usize> Scratch<D, L> {
    /// Component `j` of basis function `b` of a field of the iterate.
    fn unknown(&mut self, trial: Trial, b: usize, j: usize) -> &mut Lanes<L> {
        match trial {
            Trial::V(_) => &mut self.v[0][b].0[j],
            Trial::U(_) => &mut self.u[0][b].0[j],
            Trial::P => &mut self.p[b],
        }
    }
}
