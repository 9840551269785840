//! Pressure spaces on the cells of the fluid, and of an incompressible solid.

use super::dofs::Nodes;
use crate::element::{Quadrature, lagrange};
use crate::math::Tensor;
use crate::mesh::Mesh;

/// Which pressure space.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum PressureKind {
    /// Discontinuous polynomials of this total degree in the reference-domain coordinates x of the cell, spanned by
    /// products of Legendre polynomials in (x − x_c)/h, so 1, (x − x_c)/h, (y − y_c)/h for degree 1: a basis mapped
    /// with the cell would lose an order on cells that are not parallelograms.
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
                    let x = mesh.map(c, mesh.reference_centre());
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

    /// Together with a space on other cells; both stay apart where their cells meet.
    pub fn joined(mut self, other: PressureSpace<D>) -> PressureSpace<D> {
        for (dof, of_other) in self.cell_dofs.iter_mut().zip(other.cell_dofs) {
            if of_other != u32::MAX {
                *dof = self.n as u32 + of_other;
            }
        }
        self.points.extend(other.points);
        self.n += other.n;
        self
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
                let factors: [Vec<f64>; D] =
                    std::array::from_fn(|d| legendre(degree, (x[d] - centre[d]) / h));
                products(degree, &factors)
            }
        }
    }
}

impl<const D: usize> PressureSpace<D> {
    /// Gradients \[1/m\] with respect to x of the discontinuous basis of `cell` at `x`; empty where the space is
    /// continuous.
    pub fn discontinuous_gradients(&self, cell: usize, x: &[f64; D]) -> Vec<[f64; D]> {
        let PressureKind::Pdc(degree) = self.kind else { return vec![] };
        let (centre, h) = &self.frames[cell];
        let at: [f64; D] = std::array::from_fn(|d| (x[d] - centre[d]) / h);
        let along = |d: usize| {
            let of = |e: usize| if d == e { legendre_slopes(degree, at[e]) } else { legendre(degree, at[e]) };
            products(degree, &std::array::from_fn::<_, D, _>(of))
        };
        let parts: [Vec<f64>; D] = std::array::from_fn(along);
        (0..self.per_cell).map(|a| std::array::from_fn(|d| parts[d][a] / h)).collect()
    }
}

/// Derivatives of [`legendre`].
fn legendre_slopes(degree: usize, t: f64) -> Vec<f64> {
    let (values, mut list) = (legendre(degree, t), vec![0.0, 1.0]);
    for n in 1..degree {
        let square = (n * n) as f64;
        list.push(values[n] + t * list[n] - square / (4.0 * (4.0 * square - 1.0)) * list[n - 1]);
    }
    list.truncate(degree + 1);
    list
}

/// All products of the entries of `x` with at most `degree` factors, by degree: 1, x, y, x², x y, y², …
pub fn monomials(degree: usize, x: &[f64]) -> Vec<f64> {
    let powers = |x: &f64| (0..=degree).map(|i| x.powi(i as i32)).collect();
    products(degree, &x.iter().map(powers).collect::<Vec<_>>())
}

/// Legendre polynomials on [−½, ½] up to `degree` at `t`, leading coefficients 1: 1, t, t² − 1/12, …
fn legendre(degree: usize, t: f64) -> Vec<f64> {
    let mut list = vec![1.0, t];
    for n in 1..degree {
        let square = (n * n) as f64;
        list.push(t * list[n] - square / (4.0 * (4.0 * square - 1.0)) * list[n - 1]);
    }
    list.truncate(degree + 1);
    list
}

/// All products with one of `factors[d]`, numbered by degree, for each coordinate d and a total of at most `degree`.
fn products(degree: usize, factors: &[Vec<f64>]) -> Vec<f64> {
    (0..=degree).flat_map(|total| products_of(total, factors)).collect()
}

/// Those of degree `total`.
fn products_of(total: usize, factors: &[Vec<f64>]) -> Vec<f64> {
    match factors {
        [] if total == 0 => vec![1.0],
        [] => vec![],
        [first, rest @ ..] => {
            let with = |i: usize| products_of(total - i, rest).into_iter().map(move |p| first[i] * p);
            (0..=total).rev().flat_map(with).collect()
        }
    }
}

/// ĥ = |K̂|^(1/D).
fn cell_size<const D: usize>(mesh: &Mesh<D>, cell: usize) -> f64 {
    let rule = Quadrature::cell(mesh.shape, mesh.degree + 1);
    let det = |xi: &[f64; 3]| Tensor(mesh.map_gradient(cell, std::array::from_fn(|d| xi[d]))).det();
    let volume: f64 = rule.points.iter().zip(&rule.weights).map(|(xi, w)| w * det(xi)).sum();
    volume.abs().powf(1.0 / D as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_are_numbered_by_degree() {
        assert_eq!(monomials(2, &[2.0, 3.0]), [1.0, 2.0, 3.0, 4.0, 6.0, 9.0]);
        assert_eq!(monomials(1, &[2.0, 3.0, 5.0]), [1.0, 2.0, 3.0, 5.0]);
        assert_eq!(monomials(0, &[2.0]), [1.0]);
        let (x, w) = crate::element::quadrature::gauss(4);
        let at: Vec<Vec<f64>> = x.iter().map(|x| legendre(3, x - 0.5)).collect();
        for i in 0..4 {
            for j in 0..i {
                let product: f64 = at.iter().zip(&w).map(|(l, w)| w * l[i] * l[j]).sum();
                assert!(product.abs() < 1e-16, "{i} and {j}");
            }
        }
    }

    #[test]
    fn gradients_of_discontinuous_bases_are_differences() {
        let mesh = crate::mesh::generate::rectangle([0.0; 2], [2.0, 3.0], [1, 1], 0).unwrap();
        let x = [0.3, 0.7];
        for degree in 0..4 {
            let space = PressureSpace::new(&mesh, PressureKind::Pdc(degree), |_| true);
            let exact = space.discontinuous_gradients(0, &x);
            for d in 0..2 {
                let moved = |h: f64| {
                    let mut x = x;
                    x[d] += h;
                    space.basis(&mesh, 0, &[0.0; 3], &x)
                };
                let (plus, minus) = (moved(1e-5), moved(-1e-5));
                assert_eq!(exact.len(), plus.len());
                for (a, slope) in exact.iter().enumerate() {
                    assert!((slope[d] - (plus[a] - minus[a]) / 2e-5).abs() < 1e-9, "{degree} {a}");
                }
            }
        }
    }
}
