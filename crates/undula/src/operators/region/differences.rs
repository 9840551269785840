//! The element matrices of a batch by differences in nodal values, see [`super::nodal`].

use super::kernel::{Kernel, Scratch};
use super::nodal::{Cell, CellPoint, Equations, Nodal, interpolate};
use super::tangents::Directions;
use crate::loops::width::Width;
use crate::math::{Lanes, Scalar, Vector};
use crate::operators::{End, StepView};
use crate::physics::Fields;
use crate::tangent::{Difference, Linearization, StepForm};

impl<F: StepForm<D>, const D: usize, const L: usize> Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    /// The cell in lane `l` of a batch.
    fn load_cell(&self, cell: &mut Cell<D>, step: &StepView<'_>, batch: usize, l: usize) {
        let b = &self.batches;
        let (n, m) = (b.n_basis, b.n_pressure);
        let nodes = &b.nodes[batch * n..(batch + 1) * n];
        let fill = |out: &mut Vec<Vector<f64, D>>, x: &[f64], there: bool| {
            let at = |node: u32| Vector(std::array::from_fn(|i| x[node as usize * D + i]));
            out.clear();
            out.extend(nodes.iter().filter(|_| there).map(|lanes| at(lanes[l])));
        };
        fill(&mut cell.v, &step.new.v, true);
        fill(&mut cell.u, &step.new.u, self.deforms);
        fill(&mut cell.old[0], &step.old.v, true);
        fill(&mut cell.old[1], &step.old.u, self.deforms);
        let pressures = &b.pressure[batch * m..(batch + 1) * m];
        cell.p.clear();
        cell.p.extend(pressures.iter().map(|lanes| step.new.p[lanes[l] as usize]));
        cell.pressure.clear();
        cell.points.clear();
        for q in 0..b.n_points {
            let index = batch * b.n_points + q;
            let place = self.place(End::New, index);
            let pressure = &b.pressure_basis[index * m..(index + 1) * m];
            cell.pressure.extend(pressure.iter().map(|x| x.0[l]));
            let inverse = b.points[index].inverse.map(|x| x.0[l]);
            let (v, grad_v) = interpolate(self.basis(q), &cell.old[0], &inverse);
            let (u, grad_u) = interpolate(self.basis(q), &cell.old[1], &inverse);
            cell.points.push(CellPoint {
                inverse,
                weight: b.points[index].weight.0[l],
                place: place.map(|x| x.0[l]),
                new: Fields::zero(),
                old: Fields { v, grad_v, u, grad_u, p: 0.0 },
            });
        }
        for q in 0..b.n_points {
            cell.points[q].new = cell.fields(self.basis(q), q);
        }
        cell.rows.clear();
        cell.rows.resize(2 * n * D + m, 0.0);
        cell.base.clone_from(&cell.rows);
    }

    /// The element matrices of a batch into its work space.
    pub(super) fn differences(
        &self,
        step: &StepView<'_>,
        linearization: Linearization,
        by: &Difference,
        directions: Directions,
        batch: usize,
        s: &mut Scratch<D, L>,
    ) {
        let b = &self.batches;
        let n = b.n_basis * D;
        let size = 2 * n + b.n_pressure;
        let lagged = linearization == Linearization::FixedPoint;
        let of = Equations { form: &self.form, rule: &step.rule, basis: &b.basis, lagged };
        let (with_u, coupling) = match directions {
            Directions::Condensed { coupling } => (false, coupling),
            Directions::All | Directions::Flow => (self.deforms, 0.0),
        };
        let Nodal { matrix, cell } = &mut s.nodal;
        matrix.clear();
        matrix.resize(size * size, Lanes::zero());
        for l in 0..b.active[batch] {
            self.load_cell(cell, step, batch, l);
            cell.columns(&of, by, (with_u, coupling), &mut |column, quotients| {
                for (entry, quotient) in matrix[column * size..].iter_mut().zip(quotients) {
                    entry.0[l] = *quotient;
                }
            });
        }
    }
}
