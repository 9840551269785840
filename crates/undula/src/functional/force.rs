//! Force of the fluid on boundaries.
#![allow(non_snake_case)]

use super::{Functional, Snapshot};
use crate::assembly::facets::{FacetPoint, facet_points, fields_at};
use crate::math::{Tensor, Vector};
use crate::mesh::Facet;
use crate::physics::kinematics::cofactor;
use crate::physics::{Fields, Kinematics};
use crate::space::{FsiSpace, Region, State};

/// −R_f(e_i): the residual of the fluid alone, tested with e_i on all nodes of the boundaries and 0
/// elsewhere. It converges with twice the order of the surface integral.
///
/// A residual over fluid and solid would contain the inertia of the body, which is force only when steady.
pub struct ForceByResidual {
    nodes: Vec<u32>,
    component: usize,
    factor: f64,
    unit: &'static str,
}

impl ForceByResidual {
    /// On the boundaries `names`; the value is multiplied by `factor` and has then the unit `unit`.
    pub fn new<const D: usize>(
        space: &FsiSpace<D>,
        names: &[String],
        component: usize,
        factor: f64,
        unit: &'static str,
    ) -> Self {
        let mut nodes: Vec<u32> = names.iter().flat_map(|name| space.boundary_nodes(name)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        ForceByResidual { nodes, component, factor, unit }
    }
}

impl<const D: usize> Functional<D> for ForceByResidual {
    fn unit(&self) -> &'static str {
        self.unit
    }

    fn at_force_time(&self) -> bool {
        true
    }

    fn residual_nodes(&self) -> &[u32] {
        &self.nodes
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        let sum: f64 = self.nodes.iter().map(|&n| at.fluid_residual[n as usize * D + self.component]).sum();
        -self.factor * sum
    }
}

/// ∫ J σ_f F⁻ᵀ n ds, n pointing into the fluid: the cross-check of [`ForceByResidual`].
pub struct ForceBySurface<const D: usize> {
    facets: Vec<(usize, Vec<FacetPoint<D>>)>,
    component: usize,
    factor: f64,
    unit: &'static str,
}

impl<const D: usize> ForceBySurface<D> {
    /// On those facets of the boundaries `names` that belong to fluid cells, with `n` Gauss points.
    pub fn new(
        space: &FsiSpace<D>,
        names: &[String],
        component: usize,
        factor: f64,
        unit: &'static str,
        n: usize,
    ) -> Self {
        let in_fluid = |f: &&Facet| space.regions[f.cell as usize] == Region::Fluid;
        let facets = space.mesh.facets_on(names);
        let points = |f: &Facet| (f.cell as usize, facet_points(space, f, n));
        let facets = facets.iter().filter(in_fluid).map(points).collect();
        ForceBySurface { facets, component, factor, unit }
    }

    /// Traction at a point, the pressure `p` acting on the geometry of `state`.
    fn traction(
        at: &Snapshot<'_, D>,
        fields: &Fields<f64, D>,
        p: f64,
        normal: Vector<f64, D>,
    ) -> Vector<f64, D> {
        let viscosity = at.physics.fluid.map_or(0.0, |f| f.rho * f.nu);
        let Kinematics { F_inv, .. } = Kinematics::of(&fields.grad_u);
        let grad_v = fields.grad_v * F_inv;
        let sigma = viscosity * (grad_v + grad_v.t()) - p * Tensor::identity();
        // The normal of the fluid cell points out of the fluid.
        -(sigma * (cofactor(&fields.grad_u) * normal))
    }
}

impl<const D: usize> Functional<D> for ForceBySurface<D> {
    fn unit(&self) -> &'static str {
        self.unit
    }

    fn at_force_time(&self) -> bool {
        true
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        let theta = at.rule.theta;
        let mut sum = 0.0;
        for (cell, points) in &self.facets {
            let nodes = at.space.nodes.cell(*cell);
            let dofs = at.space.pressure.cell(*cell);
            for point in points {
                let basis = at.space.pressure.basis(&at.space.mesh, *cell, &point.xi, &point.x);
                let p: f64 = dofs.iter().zip(&basis).map(|(&dof, b)| b * at.new.p[dof as usize]).sum();
                let of = |state: &State| {
                    let fields = fields_at(nodes, &point.value, &point.grad, state);
                    Self::traction(at, &fields, p, point.normal).0[self.component]
                };
                sum += point.weight * (theta * of(at.new) + (1.0 - theta) * of(at.old));
            }
        }
        self.factor * sum
    }
}
