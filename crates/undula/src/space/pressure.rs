//! Pressure spaces on the fluid cells.

use super::dofs::Nodes;
use crate::element::{Quadrature, lagrange};
use crate::math::Tensor;
use crate::mesh::Mesh;

/// Which pressure space.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum PressureKind {
    /// Discontinuous polynomials of this total degree in the reference-domain coordinates x of the cell, see
    /// [`monomials`]: a basis mapped with the cell would lose an order on cells that are not parallelograms.
    Pdc(usize),
    /// Continuous, of this degree.
    Continuous(usize),
}

impl PressureKind {
    /// Polynomial degree.
    pub fn degree(self) -> usize {
        let (PressureKind::Pdc(degree) | PressureKind::Continuous(degree)) = self;
        degree
    }
}

/// The pressure unknowns.
#[derive(Clone, Debug)]
pub struct PressureSpace<const D: usize> {
    /// Which space.
    pub kind: PressureKind,
    /// Number of unknowns.
    pub n: usize,
    /// Unknowns of a cell.
    pub per_cell: usize,
    /// `n_cells × per_cell`; `u32::MAX` on cells without pressure.
    pub cell_dofs: Vec<u32>,
    /// Centre and size of every cell \[m\] (Pdc).
    pub frames: Vec<([f64; D], f64)>,
    /// Position of every unknown \[m\].
    pub points: Vec<[f64; D]>,
}

impl<const D: usize> PressureSpace<D> {
    /// On the cells where `fluid` holds.
    pub fn new(mesh: &Mesh<D>, kind: PressureKind, fluid: impl Fn(usize) -> bool) -> PressureSpace<D> {
        match kind {
            PressureKind::Continuous(degree) => {
                let nodes = Nodes::on_cells(mesh, degree, fluid);
                PressureSpace {
                    kind,
                    n: nodes.len(),
                    per_cell: nodes.per_cell,
                    cell_dofs: nodes.cell_nodes,
                    frames: vec![],
                    points: nodes.points,
                }
            }
            PressureKind::Pdc(degree) => {
                let per_cell = monomials(degree, &[0.0; D]).len();
                let mut cell_dofs = vec![u32::MAX; mesh.n_cells() * per_cell];
                let (mut frames, mut points, mut n) = (vec![], vec![], 0);
                for c in 0..mesh.n_cells() {
                    let x = mesh.map(c, [0.5; D]);
                    frames.push((x, cell_size(mesh, c)));
                    if fluid(c) {
                        for a in 0..per_cell {
                            cell_dofs[c * per_cell + a] = n;
                            points.push(x);
                            n += 1;
                        }
                    }
                }
                PressureSpace { kind, n: n as usize, per_cell, cell_dofs, frames, points }
            }
        }
    }

    /// Unknowns of cell `cell`; empty where there is no pressure.
    pub fn cell(&self, cell: usize) -> &[u32] {
        let dofs = &self.cell_dofs[cell * self.per_cell..(cell + 1) * self.per_cell];
        if dofs.first() == Some(&u32::MAX) { &[] } else { dofs }
    }

    /// Values of the basis of `cell` at reference coordinates `xi`, whose position is `x`.
    pub fn basis(&self, mesh: &Mesh<D>, cell: usize, xi: &[f64], x: &[f64; D]) -> Vec<f64> {
        match self.kind {
            PressureKind::Continuous(degree) => lagrange::basis(mesh.shape, degree, xi).0,
            PressureKind::Pdc(degree) => {
                let (centre, h) = &self.frames[cell];
                monomials(degree, &std::array::from_fn::<f64, D, _>(|d| (x[d] - centre[d]) / h))
            }
        }
    }
}

/// All products of the entries of `x` with at most `degree` factors, by degree: 1, x, y, x², x y, y², …
pub fn monomials(degree: usize, x: &[f64]) -> Vec<f64> {
    let mut list = vec![1.0];
    // Those of the last degree with the number of their last factor, so that each product occurs once.
    let mut last = vec![(1.0, 0)];
    for _ in 0..degree {
        last = last.iter().flat_map(|&(p, d)| (d..x.len()).map(move |e| (p * x[e], e))).collect();
        list.extend(last.iter().map(|(p, _)| *p));
    }
    list
}

/// ĥ = |K̂|^(1/D).
fn cell_size<const D: usize>(mesh: &Mesh<D>, cell: usize) -> f64 {
    let rule = Quadrature::cell(mesh.shape, mesh.degree + 1);
    let det = |xi: &[f64; 3]| Tensor(mesh.map_gradient(cell, std::array::from_fn(|d| xi[d]))).det();
    let volume: f64 = rule.points.iter().zip(&rule.weights).map(|(xi, w)| w * det(xi)).sum();
    volume.abs().powf(1.0 / D as f64)
}
