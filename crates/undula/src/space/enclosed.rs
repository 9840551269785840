//! Connected parts of the fluid that nothing opens: their boundary data must be in balance, and where no solid gives
//! way their pressure is determined up to a constant.

use super::{BoundaryCondition, FsiSpace, PressureKind, Region};
use crate::element::Quadrature;
use crate::math::{Tensor, Vector};

/// A connected part of the fluid without a boundary through which it can flow out.
#[derive(Clone, Debug)]
pub struct Enclosed<const D: usize> {
    /// Its cells, ascending.
    pub cells: Vec<u32>,
    /// Lower corner of the box around it \[m\].
    pub lower: [f64; D],
    /// Upper corner of the box around it \[m\].
    pub upper: [f64; D],
    /// Whether it touches the solid.
    pub touches_solid: bool,
    /// ∫ ∂_i φ dx \[m^(D−1)\] of the basis function of each of its nodes: 0 inside, ∫ φ n_i ds on the boundary.
    outflow: Vec<(u32, [f64; D])>,
}

/// The parts of the fluid of `space` that are closed in, in the order of their first cells; `conditions` has one entry
/// per boundary of the mesh.
pub fn enclosed<const D: usize>(
    space: &FsiSpace<D>,
    conditions: &[BoundaryCondition<D>],
) -> Vec<Enclosed<D>> {
    let mesh = &space.mesh;
    let inner = space.inner_facets();
    let component = space.components_by(&inner);
    let n = component.iter().max().map_or(0, |&last| last as usize + 1);
    let (mut open, mut touches, mut cells) = (vec![false; n], vec![false; n], vec![vec![]; n]);
    for facet in &mesh.facets {
        if let BoundaryCondition::Outflow { .. } = conditions[facet.boundary as usize] {
            open[component[facet.cell as usize] as usize] = true;
        }
    }
    for [one, two] in inner {
        let [one, two] = [one.cell as usize, two.cell as usize];
        if space.regions[one] != space.regions[two] {
            (touches[component[one] as usize], touches[component[two] as usize]) = (true, true);
        }
    }
    for cell in (0..mesh.n_cells()).filter(|&cell| space.regions[cell] == Region::Fluid) {
        cells[component[cell] as usize].push(cell as u32);
    }
    let closed = (0..n).filter(|&part| !open[part] && !cells[part].is_empty());
    closed.map(|part| Enclosed::new(space, cells[part].clone(), touches[part])).collect()
}

impl<const D: usize> Enclosed<D> {
    fn new(space: &FsiSpace<D>, cells: Vec<u32>, touches_solid: bool) -> Enclosed<D> {
        let mesh = &space.mesh;
        let rule = Quadrature::cell(mesh.shape, space.nodes.degree + mesh.degree);
        let table = space.nodes.table(mesh.shape, &rule);
        let mut sums = vec![[0.0; D]; space.nodes.len()];
        let (mut lower, mut upper) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
        for &cell in &cells {
            for (q, (xi, weight)) in rule.points.iter().zip(&rule.weights).enumerate() {
                let xi = std::array::from_fn(|d| xi[d]);
                let jacobian = Tensor(mesh.map_gradient(cell as usize, xi));
                let (cofactor, x) = (jacobian.cofactor(), mesh.map(cell as usize, xi));
                let measure = space.coordinates.measure(&x);
                // ∫ ∂_i φ, and in (r, z) ∫ φ/r beside.
                let hoop = space.coordinates.radius(&x).map_or(0.0, |r| measure / r * jacobian.det());
                for (a, &node) in space.nodes.cell(cell as usize).iter().enumerate() {
                    let slope = cofactor * Vector(std::array::from_fn(|d| table.grad(q)[a * D + d]));
                    (0..D).for_each(|i| sums[node as usize][i] += weight * measure * slope.0[i]);
                    sums[node as usize][0] += weight * hoop * table.value(q)[a];
                }
            }
            for &node in mesh.cell(cell as usize) {
                let x = mesh.nodes[node as usize];
                (0..D).for_each(|d| (lower[d], upper[d]) = (lower[d].min(x[d]), upper[d].max(x[d])));
            }
        }
        let outflow = sums.into_iter().enumerate().filter(|(_, sum)| *sum != [0.0; D]);
        let outflow = outflow.map(|(node, sum)| (node as u32, sum)).collect();
        Enclosed { cells, lower, upper, touches_solid, outflow }
    }

    /// ∫ v·n ds \[m^D/s\] of the velocity with nodal values `v`, and about ½ ∫ |v| ds, with the components that are `given`.
    pub fn flux(&self, v: &[f64], given: impl Fn(usize) -> [bool; D]) -> (f64, f64) {
        let (mut net, mut size) = (0.0, 0.0);
        for (node, weight) in &self.outflow {
            let given = given(*node as usize);
            let v: [f64; D] = std::array::from_fn(|i| if given[i] { v[*node as usize * D + i] } else { 0.0 });
            net += Vector(v).dot(Vector(*weight));
            size += 0.5 * (Vector(v).dot(Vector(v)) * Vector(*weight).dot(Vector(*weight))).sqrt();
        }
        (net, size)
    }

    /// Whether its pressure is continuous with that of another part, which it touches in points only.
    pub fn shares_pressures(&self, space: &FsiSpace<D>) -> bool {
        let mut own = vec![false; space.n_p()];
        for &cell in &self.cells {
            space.pressure.cell(cell as usize).iter().for_each(|&dof| own[dof as usize] = true);
        }
        let mut others =
            (0..space.mesh.n_cells()).filter(|&cell| self.cells.binary_search(&(cell as u32)).is_err());
        others.any(|cell| space.pressure.cell(cell).iter().any(|&dof| own[dof as usize]))
    }

    /// How its pressure is determined: one unknown is given in all corrections, and the mean set to 0 afterwards.
    pub fn pressure(&self, space: &FsiSpace<D>) -> ClosedPressure {
        let (mesh, pressure) = (&space.mesh, &space.pressure);
        let rule = Quadrature::cell(mesh.shape, pressure.kind.degree() + 2 * mesh.degree);
        let mut weights = vec![0.0; pressure.n];
        let (mut constant, mut volume) = (vec![], 0.0);
        for cell in self.cells.iter().map(|&cell| cell as usize) {
            let dofs = pressure.cell(cell);
            match pressure.kind {
                // The first function of each cell is 1.
                PressureKind::Pdc(_) => constant.push(dofs[0]),
                PressureKind::Continuous(_) => constant.extend(dofs),
            }
            for (xi, weight) in rule.points.iter().zip(&rule.weights) {
                let at = std::array::from_fn(|d| xi[d]);
                let x = mesh.map(cell, at);
                let weight =
                    weight * Tensor(mesh.map_gradient(cell, at)).det() * space.coordinates.measure(&x);
                let basis = pressure.basis(mesh, cell, xi, &x);
                dofs.iter().zip(basis).for_each(|(&dof, b)| weights[dof as usize] += weight * b);
                volume += weight;
            }
        }
        constant.sort_unstable();
        constant.dedup();
        let mean = weights.into_iter().enumerate().filter(|(_, weight)| *weight != 0.0);
        ClosedPressure {
            fixed: constant[0],
            mean: mean.map(|(dof, weight)| (dof as u32, weight / volume)).collect(),
            constant,
        }
    }
}

/// The pressure of a part of the fluid whose data determine it up to a constant.
#[derive(Clone, Debug)]
pub struct ClosedPressure {
    /// The unknown that corrections leave alone; `u32::MAX` where that is of another process.
    pub fixed: u32,
    /// The unknowns that are 1 where the pressure is 1, all others being 0.
    constant: Vec<u32>,
    /// The mean of the pressure as a sum over unknowns.
    mean: Vec<(u32, f64)>,
}

impl ClosedPressure {
    /// The unknowns that are 1 where the pressure is 1.
    pub fn constant(&self) -> &[u32] {
        &self.constant
    }

    /// The same in a part of the space.
    #[must_use]
    pub fn part<const D: usize>(&self, space: &FsiSpace<D>) -> ClosedPressure {
        let here = |dof: u32| space.pressure_here(dof);
        ClosedPressure {
            fixed: here(self.fixed).unwrap_or(u32::MAX),
            constant: self.constant.iter().filter_map(|&dof| here(dof)).collect(),
            mean: self.mean.iter().filter_map(|&(dof, w)| Some((space.own_pressure(dof)?, w))).collect(),
        }
    }

    /// Makes the mean of the pressure 0.
    pub fn level<const D: usize>(&self, space: &FsiSpace<D>, p: &mut [f64]) {
        let mean = space.sum(self.mean.iter().map(|&(dof, weight)| weight * p[dof as usize]).sum());
        self.constant.iter().for_each(|&dof| p[dof as usize] -= mean);
    }
}
