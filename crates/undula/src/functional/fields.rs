//! The solution for people and programs: arrays at the nodes, values at points, integrals.

use super::{Functional, Snapshot};
use crate::element::{Quadrature, lagrange};
use crate::math::{Tensor, Vector};
use crate::mesh::{Located, Locator, MeshError};
use crate::physics::{Fields as Values, Kinematics, axisymmetric};
use crate::sampling::fields_at;
use crate::sampling::for_each_point;
use crate::space::{FsiSpace, Region, State};
use std::cell::OnceCell;

/// The solution after a step, on the reference domain: arrays at the nodes, values at points, integrals.
///
/// ```
/// use undula::{CaseBuilder, Simulation};
/// let mut simulation = Simulation::new(CaseBuilder::load("csm1")?.set("mesh.refine", 0).build()?, 1)?;
/// let row = simulation.step()?;
/// let fields = simulation.fields();
///
/// let lowest = fields.displacement().into_iter().map(|u| u[1]).fold(0.0, f64::min);
/// assert!((lowest / row["uy_A"] - 1.0).abs() < 0.02);
/// assert_eq!(fields.coordinates().len(), fields.displacement().len());
///
/// let tip = fields.at([0.6, 0.2])?; // a position on the reference domain
/// assert!((tip.displacement[1] - row["uy_A"]).abs() < 1e-12);
/// assert!(fields.at([9.0, 9.0]).is_err());
///
/// let mass = fields.integrate(|point| if point.is_solid { 1e3 } else { 0.0 });
/// assert!((mass / (1e3 * 0.35 * 0.02) - 1.0).abs() < 0.01);
/// # Ok::<(), undula::Error>(())
/// ```
pub struct Fields<'a, const D: usize = 2> {
    space: &'a FsiSpace<D>,
    state: &'a State,
    locator: OnceCell<Locator<'a, D>>,
}

/// The solution at one point of the reference domain.
///
/// Gradients are with respect to the reference coordinates: `[i][j]` is the derivative of component i along x_j.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PointFields<const D: usize = 2> {
    /// Position on the reference domain \[m\]; that at present is `x + displacement`.
    pub x: [f64; D],
    /// Whether the point belongs to the solid.
    pub is_solid: bool,
    /// v \[m/s\].
    pub velocity: [f64; D],
    /// ∇v \[1/s\].
    pub velocity_gradient: [[f64; D]; D],
    /// u \[m\].
    pub displacement: [f64; D],
    /// ∇u.
    pub displacement_gradient: [[f64; D]; D],
    /// p \[Pa\]; 0 in a compressible solid.
    pub pressure: f64,
    /// (r + u_r)/r in the coordinates (r, z), the stretch around the axis; 1 in the plane.
    pub hoop_stretch: f64,
}

impl<const D: usize> PointFields<D> {
    /// J = det(I + ∇u): present volume per reference volume.
    ///
    /// ```
    /// let case = undula::CaseBuilder::load("csm1")?.set("mesh.refine", 0).build()?;
    /// let simulation = undula::Simulation::new(case, 1)?; // at rest
    /// assert_eq!(simulation.fields().at([0.5, 0.2])?.jacobian(), 1.0);
    /// # Ok::<(), undula::Error>(())
    /// ```
    pub fn jacobian(&self) -> f64 {
        Kinematics::of(&Tensor(self.displacement_gradient)).J * self.hoop_stretch
    }

    fn new(space: &FsiSpace<D>, x: [f64; D], region: Region, at: &Values<f64, D>) -> PointFields<D> {
        let hoop = |r| 1.0 + axisymmetric::fields_at(at, r).grad_u.0[2][2];
        PointFields {
            x,
            is_solid: region == Region::Solid,
            velocity: at.v.0,
            velocity_gradient: at.grad_v.0,
            displacement: at.u.0,
            displacement_gradient: at.grad_u.0,
            pressure: at.p,
            hoop_stretch: space.coordinates.radius(&x).map_or(1.0, hoop),
        }
    }
}

impl<'a, const D: usize> Fields<'a, D> {
    /// The solution `state` on `space`.
    pub(crate) fn new(space: &'a FsiSpace<D>, state: &'a State) -> Self {
        Fields { space, state, locator: OnceCell::new() }
    }

    /// Reference coordinates of the nodes \[m\], those of all arrays. Nodes of periodic boundaries are on both of them.
    pub fn coordinates(&self) -> Vec<[f64; D]> {
        self.space.places().points[..self.n_nodes()].to_vec()
    }

    /// Velocity at the nodes \[m/s\].
    pub fn velocity(&self) -> Vec<[f64; D]> {
        self.nodal(&self.state.v)
    }

    /// Displacement of the nodes \[m\]; 0 in a flow without body.
    pub fn displacement(&self) -> Vec<[f64; D]> {
        self.nodal(&self.state.u)
    }

    /// Pressure at the nodes \[Pa\]: the mean over the cells of the fluid, inside of an incompressible solid over those
    /// of the solid, and 0 inside of a compressible one.
    pub fn pressure(&self) -> Vec<f64> {
        let of = |region| nodal_pressure(self.space, self.state, region);
        let [fluid, solid] = [Region::Fluid, Region::Solid].map(of);
        let value = |node: usize| fluid[node].or(solid[node]).unwrap_or(0.0);
        (0..self.n_nodes()).map(|place| value(self.space.node_at(place))).collect()
    }

    /// The solution at the reference position `x` \[m\]. On the side of several cells it is that in the cell with the
    /// lowest number, which matters for gradients and for a discontinuous pressure.
    ///
    /// # Errors
    /// [`MeshError::Outside`] if `x` lies in no cell.
    pub fn at(&self, x: [f64; D]) -> Result<PointFields<D>, MeshError> {
        Ok(self.value(&self.locate(x)?))
    }

    /// The cell of the reference position `x` \[m\], to ask for its values after every step without a new search.
    ///
    /// # Errors
    /// [`MeshError::Outside`] if `x` lies in no cell.
    pub fn locate(&self, x: [f64; D]) -> Result<Located<D>, MeshError> {
        self.locator.get_or_init(|| Locator::new(&self.space.mesh)).find(x)
    }

    /// The solution at a point that [`Fields::locate`] has found.
    pub fn value(&self, point: &Located<D>) -> PointFields<D> {
        let FsiSpace { mesh, nodes, pressure, regions, .. } = self.space;
        let &Located { cell, xi } = point;
        let rule = Quadrature { points: vec![std::array::from_fn(|d| if d < D { xi[d] } else { 0.0 })], weights: vec![1.0] };
        let table = nodes.table(mesh.shape, &rule);
        let map = Tensor(mesh.map_gradient(cell, xi));
        let inverse_t = map.cofactor() * (1.0 / map.det());
        let gradient = |g: &[f64]| (inverse_t * Vector(std::array::from_fn::<_, D, _>(|d| g[d]))).0;
        let gradients: Vec<[f64; D]> = table.grad(0).chunks_exact(D).map(gradient).collect();
        let mut fields = fields_at(nodes.cell(cell), table.value(0), &gradients, self.state);
        let x = mesh.map(cell, xi);
        let dofs = pressure.cell(cell);
        if !dofs.is_empty() {
            let basis = pressure.basis(mesh, cell, &xi, &x);
            fields.p = dofs.iter().zip(&basis).map(|(&dof, b)| b * self.state.p[dof as usize]).sum();
        }
        PointFields::new(self.space, x, regions[cell], &fields)
    }

    /// ∫ f dx over the reference domain, the whole body of revolution in (r, z), by one Gauss point per direction more than the degree of the velocity.
    ///
    /// Times [`PointFields::jacobian`] it is the integral over the present domain.
    pub fn integrate(&self, f: impl Fn(&PointFields<D>) -> f64) -> f64 {
        let mut sum = 0.0;
        for_each_point(self.space, self.state, self.space.nodes.degree + 1, |point| {
            sum += point.weight * f(&PointFields::new(self.space, point.x, point.region, &point.fields));
        });
        sum
    }

    /// Places of nodes; bubbles have none.
    fn n_nodes(&self) -> usize {
        self.space.places().n_lagrange
    }

    /// A vector field at the nodes; 0 where it is not computed.
    fn nodal(&self, values: &[f64]) -> Vec<[f64; D]> {
        if values.is_empty() {
            return vec![[0.0; D]; self.n_nodes()];
        }
        self.space.at_places(values.as_chunks::<D>().0, 1)
    }
}

/// Pressure of a region at the nodes, the mean over its cells; `None` where it has none.
pub(crate) fn nodal_pressure<const D: usize>(space: &FsiSpace<D>, state: &State, region: Region) -> Vec<Option<f64>> {
    let n = space.nodes.n_lagrange;
    let (mut sum, mut count) = (vec![0.0; n], vec![0.0; n]);
    for cell in 0..space.mesh.n_cells() {
        let dofs = space.pressure.cell(cell);
        if dofs.is_empty() || space.regions[cell] != region {
            continue;
        }
        let nodes = &space.nodes.cell(cell)[..space.mesh.shape.n_nodes(space.nodes.degree)];
        for ((a, &node), &place) in nodes.iter().enumerate().zip(space.places().cell(cell)) {
            let xi = lagrange::node(space.mesh.shape, space.nodes.degree, a);
            let x = space.places().points[place as usize];
            let basis = space.pressure.basis(&space.mesh, cell, &xi, &x);
            sum[node as usize] += dofs.iter().zip(&basis).map(|(&d, b)| b * state.p[d as usize]).sum::<f64>();
            count[node as usize] += 1.0;
        }
    }
    sum.iter().zip(&count).map(|(s, c)| (*c > 0.0).then(|| s / c)).collect()
}

/// A functional of another program.
pub(crate) struct OwnFunctional<F> {
    /// SI unit.
    pub unit: &'static str,
    /// The value after a step.
    pub value: F,
}

impl<const D: usize, F: Fn(&Fields<'_, D>) -> f64 + Send> Functional<D> for OwnFunctional<F> {
    fn unit(&self) -> &'static str {
        self.unit
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        (self.value)(&Fields::new(at.space, at.new))
    }
}
