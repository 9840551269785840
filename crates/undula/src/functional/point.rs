//! Values at material points.

use super::site::Place;
use super::{Functional, Snapshot};
use crate::element::{Quadrature, lagrange};
use crate::math::Tensor;
use crate::mesh::{Locator, MeshError};

use crate::space::pressure::monomials;
use crate::space::{FsiSpace, Region};

/// One component of the deformation of a material point \[m\].
pub struct Displacement {
    nodes: Vec<u32>,
    basis: Vec<f64>,
    component: usize,
}

impl Displacement {
    /// At the reference position `x` \[m\].
    ///
    /// # Errors
    /// If `x` lies outside of the mesh.
    pub fn new<const D: usize>(
        space: &FsiSpace<D>,
        x: [f64; D],
        component: usize,
    ) -> Result<Self, MeshError> {
        let found = space.with_whole(|whole| Locator::new(&whole.mesh).find(x))?;
        let (basis, _) = lagrange::basis(space.mesh.shape, space.nodes.degree, &found.xi);
        let cell = space.own_cell(found.cell);
        let nodes = cell.map_or(vec![], |cell| space.nodes.cell(cell).to_vec());
        Ok(Displacement { nodes, basis, component })
    }
}

impl<const D: usize> Functional<D> for Displacement {
    fn unit(&self) -> &'static str {
        "m"
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        if !at.space.deforms {
            return 0.0;
        }
        let value = |node: u32| at.new.u[node as usize * D + self.component];
        at.space.sum(self.nodes.iter().zip(&self.basis).map(|(&node, b)| b * value(node)).sum())
    }
}

/// p(a) − p(b) \[Pa\] at material points.
///
/// A pressure of degree m is of order m + 1 at a point, and where it is discontinuous it has several values
/// there. So it is recovered: a polynomial of degree m + 1 is fitted, by least squares over the cells around
/// the point, to the moments of the pressure against the monomials of degree m in each cell, with coordinates relative to
/// the diameter of the cell. On an extruded plane that is the one in the plane, so that the value is the same.
pub struct PressureDifference {
    /// (unknown, weight).
    terms: Vec<(u32, f64)>,
}

impl PressureDifference {
    /// At reference positions \[m\]; diameters of cells are those along the first `along` coordinates.
    ///
    /// # Errors
    /// If a point lies outside of the mesh, or where there is no pressure.
    pub fn new<const D: usize>(
        space: &FsiSpace<D>,
        a: [f64; D],
        b: [f64; D],
        along: usize,
    ) -> Result<Self, MeshError> {
        let mut terms = vec![];
        for (x, sign) in [(a, 1.0), (b, -1.0)] {
            let recovered = space.with_whole(|whole| recovery(whole, x, along))?;
            terms.extend(recovered.into_iter().map(|(dof, w)| (dof, sign * w)));
        }
        Ok(PressureDifference { terms: own_terms(space, terms) })
    }
}

/// p \[Pa\] at a material point, recovered as in [`PressureDifference`].
pub struct Pressure {
    /// (unknown, weight).
    terms: Vec<(u32, f64)>,
}

impl Pressure {
    /// At the reference position `x` \[m\] in `place`; without it in the fluid, if it reaches there. Diameters of cells are
    /// those along the first `along` coordinates.
    ///
    /// # Errors
    /// If `x` lies outside of the body or of the mesh, or where there is no pressure.
    pub fn new<const D: usize>(
        space: &FsiSpace<D>,
        x: [f64; D],
        place: Option<Place>,
        along: usize,
    ) -> Result<Self, MeshError> {
        let terms = space.with_whole(|whole| Pressure::terms(whole, x, place, along))?;
        Ok(Pressure { terms: own_terms(space, terms) })
    }

    fn terms<const D: usize>(
        space: &FsiSpace<D>,
        x: [f64; D],
        place: Option<Place>,
        along: usize,
    ) -> Result<Vec<(u32, f64)>, MeshError> {
        let Some(place) = place else { return recovery(space, x, along) };
        let locator = Locator::new(&space.mesh);
        locator.find(x)?;
        let within = locator.find_where(x, INSIDE, |cell| place.has(space, cell));
        let cell = within.map_err(|_| MeshError::OtherRegion { point: x.to_vec() })?.cell;
        let patch = patch_in(space, place, cell, x);
        recovery_on(space, x, &patch, along)
    }
}

/// A point may lie outside of a body by this part of the size of a cell.
const INSIDE: f64 = 1e-3;

impl<const D: usize> Functional<D> for Pressure {
    fn unit(&self) -> &'static str {
        "Pa"
    }

    fn at_force_time(&self) -> bool {
        true
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        sum(&self.terms, at)
    }
}

fn sum<const D: usize>(terms: &[(u32, f64)], at: &Snapshot<'_, D>) -> f64 {
    at.space.sum(terms.iter().map(|&(dof, w)| w * at.new.p[dof as usize]).sum())
}

/// Those of the `terms` of the whole space that this process counts.
fn own_terms<const D: usize>(space: &FsiSpace<D>, terms: Vec<(u32, f64)>) -> Vec<(u32, f64)> {
    terms.into_iter().filter_map(|(dof, w)| Some((space.own_pressure(dof)?, w))).collect()
}

/// Weights of the pressure unknowns in the recovered value at `x`.
fn recovery<const D: usize>(
    space: &FsiSpace<D>,
    x: [f64; D],
    along: usize,
) -> Result<Vec<(u32, f64)>, MeshError> {
    recovery_on(space, x, &patch_around(space, Locator::new(&space.mesh).find(x)?.cell, x), along)
}

/// The largest distance of two vertices of a cell along the first `along` coordinates \[m\].
fn diameter<const D: usize>(space: &FsiSpace<D>, cell: usize, along: usize) -> f64 {
    let at: Vec<[f64; D]> =
        space.mesh.cell_vertices(cell).iter().map(|&v| space.mesh.nodes[v as usize]).collect();
    let distance = |a: &[f64; D], b: &[f64; D]| (0..along).map(|d| (a[d] - b[d]).powi(2)).sum::<f64>().sqrt();
    at.iter().flat_map(|a| at.iter().map(move |b| distance(a, b))).fold(0.0, f64::max)
}

/// The same on the cells of `patch`.
fn recovery_on<const D: usize>(
    space: &FsiSpace<D>,
    x: [f64; D],
    patch: &[usize],
    along: usize,
) -> Result<Vec<(u32, f64)>, MeshError> {
    if patch.iter().all(|&c| space.pressure.cell(c).is_empty()) {
        return Err(MeshError::NoPressure { point: x.to_vec() });
    }
    let size = patch.iter().map(|&c| diameter(space, c, along)).fold(0.0, f64::max);
    let degree = space.pressure.kind.degree();
    let rule = Quadrature::cell(space.mesh.shape, degree + 3);
    let [n, n_moments] = [degree + 1, degree].map(|m| monomials(m, &[0.0; D]).len());
    // One row per cell and moment: those of the monomials, and those of the pressure basis.
    let mut rows: Vec<Vec<f64>> = vec![];
    let mut data: Vec<Vec<(u32, f64)>> = vec![];
    for &cell in patch {
        let (mut row, mut datum) = (vec![vec![0.0; n]; n_moments], vec![vec![]; n_moments]);
        let centre = space.mesh.centre(cell);
        let (mut volume, h) = (0.0, diameter(space, cell, along));
        for (xi, w) in rule.points.iter().zip(&rule.weights) {
            let xi: [f64; D] = std::array::from_fn(|d| xi[d]);
            let at = space.mesh.map(cell, xi);
            let weight = w * Tensor(space.mesh.map_gradient(cell, xi)).det();
            volume += weight;
            let local = monomials(degree + 1, &std::array::from_fn::<f64, D, _>(|d| (at[d] - x[d]) / size));
            let tested = monomials(degree, &std::array::from_fn::<f64, D, _>(|d| (at[d] - centre[d]) / h));
            let basis = space.pressure.basis(&space.mesh, cell, &xi, &at);
            for ((row, datum), tested) in row.iter_mut().zip(&mut datum).zip(tested) {
                let moment = weight * tested;
                row.iter_mut().zip(&local).for_each(|(r, l)| *r += moment * l);
                datum.extend(space.pressure.cell(cell).iter().zip(&basis).map(|(&dof, b)| (dof, moment * b)));
            }
        }
        rows.extend(row.into_iter().map(|r| r.into_iter().map(|x| x / volume).collect::<Vec<_>>()));
        data.extend(
            datum.into_iter().map(|d| d.into_iter().map(|(dof, x)| (dof, x / volume)).collect::<Vec<_>>()),
        );
    }
    // value(x) = e₀ᵀ (MᵀM)⁻¹ Mᵀ N p, so the weights are Nᵀ M (MᵀM)⁻¹ e₀.
    let normal: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| rows.iter().map(|r| r[i] * r[j]).sum()).collect()).collect();
    let y = solve_small(normal);
    let mut terms = vec![];
    for (row, datum) in rows.iter().zip(data) {
        let share: f64 = row.iter().zip(&y).map(|(m, y)| m * y).sum();
        terms.extend(datum.into_iter().map(|(dof, w)| (dof, share * w)));
    }
    Ok(terms)
}

/// Part of the square of a column that is left if those before determine it.
const DEPENDENT: f64 = 1e-10;

/// The solution of `a y = e₀` for a small symmetric matrix of scalar products, by elimination. What depends on those before
/// is left out: the moments of z² on one layer of cells are those of a constant.
fn solve_small(mut a: Vec<Vec<f64>>) -> Vec<f64> {
    let n = a.len();
    let mut y = vec![0.0; n];
    y[0] = 1.0;
    let size: Vec<f64> = (0..n).map(|k| a[k][k]).collect();
    for k in 0..n {
        if a[k][k] <= DEPENDENT * size[k] {
            a.iter_mut().for_each(|row| row[k] = 0.0);
            a[k] = vec![0.0; n];
            (a[k][k], y[k]) = (1.0, 0.0);
            continue;
        }
        let pivot = a[k].clone();
        for i in k + 1..n {
            let factor = a[i][k] / pivot[k];
            for (x, p) in a[i].iter_mut().zip(&pivot) {
                *x -= factor * p;
            }
            y[i] -= factor * y[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * y[j]).sum();
        y[k] = (y[k] - known) / a[k][k];
    }
    y
}

/// The cells at `x` and their neighbours across nodes, all of one body: of the fluid if it is at `x`, else of
/// the solid.
fn patch_around<const D: usize>(space: &FsiSpace<D>, cell: usize, x: [f64; D]) -> Vec<usize> {
    let of_fluid = patch_in(space, Region::Fluid.into(), cell, x);
    if of_fluid.is_empty() { patch_in(space, Region::Solid.into(), cell, x) } else { of_fluid }
}

/// The cells of `place` at `x` and their neighbours, all of the material of the first.
fn patch_in<const D: usize>(space: &FsiSpace<D>, place: Place, cell: usize, x: [f64; D]) -> Vec<usize> {
    // A cell beyond a seam lies elsewhere.
    let places = space.places();
    let inside = |c: &usize| place.has(space, *c);
    let near = |&node: &u32| {
        let at = places.points[node as usize];
        (0..D).all(|d| (at[d] - x[d]).abs() < 1e-9)
    };
    let touching = |nodes: &[u32]| -> Vec<usize> {
        let shares = |c: &usize| places.cell(*c).iter().any(|n| nodes.contains(n));
        (0..space.mesh.n_cells()).filter(inside).filter(shares).collect()
    };
    let at_node: Vec<u32> = places.cell(cell).iter().copied().filter(near).collect();
    let inner =
        if at_node.is_empty() { vec![cell].into_iter().filter(inside).collect() } else { touching(&at_node) };
    let inner: Vec<usize> = inner;
    let Some(&first) = inner.first() else { return vec![] };
    let of_material = |c: &usize| space.material[*c] == space.material[first];
    let inner = inner.iter().filter(|c| of_material(c));
    let nodes: Vec<u32> = inner.flat_map(|&c| places.cell(c).to_vec()).collect();
    touching(&nodes).into_iter().filter(of_material).collect()
}

impl<const D: usize> Functional<D> for PressureDifference {
    fn unit(&self) -> &'static str {
        "Pa"
    }

    fn at_force_time(&self) -> bool {
        true
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        sum(&self.terms, at)
    }
}
