//! J at the nodes of all cells: quadrature points alone would not see a cell that folds at a corner.

use super::kernel::Kernel;
use crate::element::{BasisTable, Quadrature, lagrange};
use crate::loops::batch::Corners;
use crate::loops::evaluate::gather;
use crate::loops::scatter::Shared;
use crate::loops::width::{Task, Width};
use crate::math::{Lanes, Tensor, Vector};
use crate::space::FsiSpace;
use crate::tangent::StepForm;

impl<F: StepForm<D>, const D: usize, const L: usize> Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    fn corners(&self, space: &FsiSpace<D>) -> Corners<D, L> {
        let (mesh, degree) = (&space.mesh, space.nodes.degree);
        // Bubbles count at the centre of their cell.
        let n_nodes = mesh.shape.n_nodes(degree);
        let node = |a| if a < n_nodes { lagrange::node(mesh.shape, degree, a) } else { mesh.shape.centre() };
        let points: Vec<[f64; 3]> = (0..self.batches.n_basis).map(node).collect();
        let weights = vec![1.0; points.len()];
        let mut inverse = vec![];
        for cells in &self.batches.cells {
            for xi in &points {
                let mut all = Tensor::<Lanes<L>, D>::zero();
                for (l, &cell) in cells.iter().enumerate() {
                    let jacobian = Tensor(mesh.map_gradient(cell as usize, std::array::from_fn(|d| xi[d])));
                    let one = jacobian.cofactor().t() * (1.0 / jacobian.det());
                    for i in 0..D {
                        (0..D).for_each(|j| all.0[i][j].0[l] = one.0[i][j]);
                    }
                }
                inverse.push(all);
            }
        }
        let rule = Quadrature { points, weights };
        let table = BasisTable::lagrange(mesh.shape, degree, &rule);
        let bubbles = self.batches.n_basis > n_nodes;
        let table = if bubbles { table.with_bubbles(mesh.shape, &rule) } else { table };
        Corners { grad: table.grad, inverse }
    }

    /// The smallest J of the last residual and at the nodes, whose deformation is `u`; for [`Kernel::worst_cells`], too.
    pub(super) fn min_j_at_nodes(&mut self, space: &FsiSpace<D>, u: &[f64]) -> f64 {
        let corners = self.corners.take().unwrap_or_else(|| self.corners(space));
        let mut min_j = std::mem::take(&mut self.min_j);
        let n = self.batches.n_basis;
        let slots = Shared::new(&mut min_j);
        self.for_each_batch(|batch| {
            self.scratch.with(|s| {
                gather(&self.batches.nodes[batch * n..(batch + 1) * n], u, &mut s.u);
                let inverse = &corners.inverse[batch * n..(batch + 1) * n];
                Lanes::<L>::dispatch(NodesTask { grad: &corners.grad, inverse, u: &s.u, batch, out: &slots });
            });
        });
        let smallest = min_j.iter().copied().fold(f64::INFINITY, f64::min);
        (self.min_j, self.corners) = (min_j, Some(corners));
        smallest
    }
}

struct NodesTask<'a, const D: usize, const L: usize> {
    grad: &'a [f64],
    inverse: &'a [Tensor<Lanes<L>, D>],
    u: &'a [Vector<Lanes<L>, D>],
    batch: usize,
    out: &'a Shared<'a>,
}

impl<const D: usize, const L: usize> Task for NodesTask<'_, D, L> {
    #[inline(always)]
    fn run(self) {
        let mut min_j = [f64::INFINITY; L];
        for (grad, inverse) in self.grad.chunks_exact(self.u.len() * D).zip(self.inverse) {
            let mut reference = Tensor::<Lanes<L>, D>::zero();
            for (u, grad) in self.u.iter().zip(grad.chunks_exact(D)) {
                for i in 0..D {
                    for d in 0..D {
                        reference.0[i][d].add_product(grad[d], u.0[i]);
                    }
                }
            }
            let j = (Tensor::identity() + reference * *inverse).det();
            for l in 0..L {
                min_j[l] = min_j[l].min(j.0[l]);
            }
        }
        for (l, j) in min_j.into_iter().enumerate() {
            let at = self.batch * L + l;
            self.out.set(at, j.min(self.out.get(at as u32)));
        }
    }
}
