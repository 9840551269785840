//! Cells of one region, `L` at a time.

use super::chunks::chunks;
use super::evaluate::Point;
use super::tensor::TensorBasis;
use crate::element::{BasisTable, Quadrature};
use crate::math::{Lanes, Scalar, Tensor, Vector};
use crate::space::FsiSpace;
use std::ops::Range;

/// All cells of one region in batches.
pub struct Batches<const D: usize, const L: usize> {
    /// Cells of every batch; the last cell repeats in padded lanes.
    pub cells: Vec<[u32; L]>,
    /// How many lanes of a batch are real.
    pub active: Vec<usize>,
    /// Batches that belong to one thread's work.
    pub chunks: Vec<Range<usize>>,
    /// Nodes, `[batch][basis]`.
    pub nodes: Vec<[u32; L]>,
    /// Pressure unknowns, `[batch][basis]`; empty in the solid.
    pub pressure: Vec<[u32; L]>,
    /// Points, `[batch][point]`.
    pub points: Vec<Point<D, L>>,
    /// Pressure basis at the points, `[batch][point][basis]`.
    pub pressure_basis: Vec<Lanes<L>>,
    /// Basis of v and u: `[point][basis][1 + D]`, value first, then reference gradient.
    pub basis: Vec<f64>,
    /// The same as products, where sums over one coordinate after the other are faster.
    pub tensor: Option<TensorBasis>,
    /// Basis functions of v and u in a cell.
    pub n_basis: usize,
    /// Pressure basis functions in a cell.
    pub n_pressure: usize,
    /// Quadrature points in a cell.
    pub n_points: usize,
    /// Position of the points \[m\], `[batch][point]`; in (r, z) they know their distance to the axis.
    pub positions: Vec<Vector<Lanes<L>, D>>,
}

/// Geometry at the nodes of one region, fixed for the run.
pub(crate) struct Corners<const D: usize, const L: usize> {
    /// Reference gradients of the basis at the nodes, `[node][basis][D]`.
    pub(crate) grad: Vec<f64>,
    /// ∂ξ_d/∂x_j at the nodes \[1/m\], `[batch][node]`.
    pub(crate) inverse: Vec<Tensor<Lanes<L>, D>>,
}

impl<const D: usize, const L: usize> Batches<D, L> {
    /// Batch the cells in `list` (in this order), with `stiffness` at positions x.
    pub fn new(
        space: &FsiSpace<D>,
        list: &[usize],
        with_pressure: bool,
        quadrature: usize,
        stiffness: &dyn Fn(&[f64; D]) -> f64,
    ) -> Batches<D, L> {
        let mesh = &space.mesh;
        let rule = Quadrature::cell(mesh.shape, quadrature);
        // Cells with bubbles have more nodes.
        let bubble = list.first().is_some_and(|&cell| space.nodes.has_bubble(cell));
        let mut table = BasisTable::lagrange(mesh.shape, space.nodes.degree, &rule);
        if bubble {
            table = table.with_bubbles(mesh.shape, &rule);
        }
        let (n_basis, n_points) = (table.n_basis, table.n_points);
        let n_pressure = if with_pressure { space.pressure.per_cell } else { 0 };
        let mut batches = Batches {
            cells: vec![],
            active: vec![],
            chunks: chunks(list.len().div_ceil(L)),
            nodes: vec![],
            pressure: vec![],
            points: vec![],
            pressure_basis: vec![],
            basis: interleave(&table),
            tensor: TensorBasis::new(mesh.shape, space.nodes.degree, quadrature),
            n_basis,
            n_pressure,
            n_points,
            positions: vec![],
        };
        for cells in list.chunks(L) {
            batches.push(space, cells, &rule, stiffness);
        }
        batches
    }

    fn push(
        &mut self,
        space: &FsiSpace<D>,
        chunk: &[usize],
        rule: &Quadrature,
        stiffness: &dyn Fn(&[f64; D]) -> f64,
    ) {
        let cells: [usize; L] = std::array::from_fn(|l| chunk[l.min(chunk.len() - 1)]);
        for a in 0..self.n_basis {
            self.nodes.push(std::array::from_fn(|l| space.nodes.cell(cells[l])[a]));
        }
        for a in 0..self.n_pressure {
            self.pressure.push(std::array::from_fn(|l| space.pressure.cell(cells[l])[a]));
        }
        for (q, xi) in rule.points.iter().enumerate() {
            let xi: [f64; D] = std::array::from_fn(|d| xi[d]);
            let mut point =
                Point { inverse: Tensor::zero(), weight: Lanes::zero(), stiffness: Lanes::constant(1.0) };
            let mut position = Vector::<Lanes<L>, D>::zero();
            let mut basis = vec![Lanes::<L>::zero(); self.n_pressure];
            for l in 0..L {
                let x = space.mesh.map(cells[l], xi);
                let jacobian = Tensor(space.mesh.map_gradient(cells[l], xi));
                let det = jacobian.det();
                let inverse = jacobian.cofactor().t() * (1.0 / det);
                for i in 0..D {
                    position.0[i].0[l] = x[i];
                    for j in 0..D {
                        point.inverse.0[i][j].0[l] = inverse.0[i][j];
                    }
                }
                let weight = rule.weights[q] * det * space.coordinates.measure(&x);
                point.weight.0[l] = if l < chunk.len() { weight } else { 0.0 };
                point.stiffness.0[l] = stiffness(&x);
                if self.n_pressure > 0 {
                    for (b, value) in space.pressure.basis(&space.mesh, cells[l], &xi, &x).iter().enumerate()
                    {
                        basis[b].0[l] = *value;
                    }
                }
            }
            self.points.push(point);
            self.positions.push(position);
            self.pressure_basis.extend(basis);
        }
        self.cells.push(cells.map(|c| c as u32));
        self.active.push(chunk.len());
    }

    /// Number of batches.
    pub fn len(&self) -> usize {
        self.cells.len()
    }
}

/// `[point][basis][1 + D]` from values and gradients.
pub(super) fn interleave(table: &BasisTable) -> Vec<f64> {
    let mut out = vec![];
    for q in 0..table.n_points {
        for a in 0..table.n_basis {
            out.push(table.value(q)[a]);
            out.extend(&table.grad(q)[a * table.dim..(a + 1) * table.dim]);
        }
    }
    out
}
