//! Eigenfrequencies of the elastic body at rest: in vacuum, and with the mass of the fluid that it sets in motion.
//!
//! A motion u(x, t) = Re(φ(x) exp(iωt)) of small amplitude in vacuum obeys
//!
//! K φ = ω² M φ,  K_ab = (C ∇φ_b, ∇φ_a)_S,  M_ab = (ρ_s φ_b, φ_a)_S,
//!
//! with the derivative C = ∂P/∂∇u of the law at u = 0; φ = 0 where the case holds the solid, and K_ab has ⟨k φ_b, φ_a⟩ of
//! springs on its boundary. The fluid is taken without
//! viscosity and without flow of its own: ρ_f ∂_t v = −∇p, div v = 0. Then −Δp = 0 with ∂_n p = ρ_f ω² n·φ on the
//! interface I, n pointing out of the fluid, ∂_n p = 0 on walls and where the velocity is given, and p = 0 on outlets
//! (`do-nothing`, `traction-free`):
//!
//! L p = ω² C φ,  L_qr = (ρ_f⁻¹ ∇r, ∇q)_F,  C_qa = (n·φ_a, q)_I.
//!
//! The traction p n on the solid is ω² Cᵀ L⁻¹ C φ, so that the fluid adds a mass, symmetric and not negative:
//!
//! K φ = ω² (M + M_a) φ,  M_a = Cᵀ L⁻¹ C.
//!
//! In a part of the fluid without outlet p is determined up to a constant and n·φ has no mean on the surface of the
//! part: one pressure is fixed, and φ is sought among the motions with g·φ = 0, g_a = (n·φ_a, 1)_I, by a multiplier
//! (the constant of p).
//!
//! H. J.-P. Morand and R. Ohayon, *Fluid Structure Interaction*, Wiley 1995, on vibrations with an incompressible
//! fluid.

mod body;
mod fluid;
mod lanczos;
mod spring;
mod write;

pub use write::{check_empty, write};

use crate::algebra::{LinearSolver, MultifrontalLu, Options, SolverError};
use crate::case::expression::Expression;
use crate::case::{Case, Condition, Load, SolidSpec};
use crate::error::Error;
use crate::physics::{Reference, Solid};
use crate::space::{Constraints, FsiSpace, Region};
use body::Body;
use fluid::AddedMass;
use std::f64::consts::PI;

/// What a body may vibrate with.
#[derive(Clone, Debug)]
pub struct Setting<'a> {
    /// Spaces on the body and, if there is one, the fluid.
    pub space: &'a FsiSpace<2>,
    /// Density and law of each body, by the material of the space.
    pub solids: Vec<Solid>,
    /// ρ_f \[kg/m³\].
    pub fluid_density: Option<f64>,
    /// Components of the displacement that are 0, for every node of the space; those of the fluid alone do not count.
    pub held: Vec<[bool; 2]>,
    /// Entries of K of springs: places 2 a + i of row and column, node a and component i, and value \[Pa\].
    pub springs: Vec<(u32, u32, f64)>,
    /// For every boundary of the mesh whether p = 0 there.
    pub open: Vec<bool>,
    /// Gauss points per direction.
    pub quadrature: usize,
}

/// One mode.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// ω/(2π) \[Hz\].
    pub frequency: f64,
    /// φ at the nodes of the space, `[node][component]`, with φᵀ M φ = 1 kg/m or φᵀ (M + M_a) φ = 1 kg/m; 0 off the
    /// body.
    pub shape: Vec<f64>,
}

/// The lowest modes, each list by ascending frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    /// Without fluid.
    pub vacuum: Vec<Mode>,
    /// With the added mass of the fluid; `None` without fluid.
    pub with_fluid: Option<Vec<Mode>>,
    /// Number of unknowns of the displacement.
    pub n_u: usize,
    /// Number of unknowns of the pressure.
    pub n_p: usize,
}

impl Setting<'_> {
    /// The `count` lowest modes, or as many as there are.
    ///
    /// Lanczos' method for K⁻¹ M and K⁻¹ (M + M_a): K and L are factorised once.
    ///
    /// # Errors
    /// [`SolverError::Singular`] or [`SolverError::NotDefinite`] if the body is not held; if memory is short.
    pub fn modes(&self, count: usize) -> Result<Modes, SolverError> {
        let body = Body::new(self);
        let mut stiffness = MultifrontalLu::definite(Options::default());
        stiffness.analyse(&body.stiffness.pattern, &body.unknowns)?;
        stiffness.factor(&body.stiffness)?;
        let n = body.places.len();
        let found = lanczos::largest(n, count, |b, x| stiffness.apply(b, x), |x, y| body.mass.mul(x, y));
        let modes = |found: Vec<(f64, Vec<f64>)>| found.into_iter().map(|pair| body.mode(&pair)).collect();
        let vacuum: Vec<Mode> = modes(found);
        let Some(density) = self.fluid_density else {
            return Ok(Modes { vacuum, with_fluid: None, n_u: n, n_p: 0 });
        };
        let mut added = AddedMass::new(self, &body, density)?;
        let volumes = added.volumes(|g, z| stiffness.apply(g, z));
        let found = lanczos::largest(
            n,
            count,
            |b, x| {
                stiffness.apply(b, x);
                volumes.iter().for_each(|volume| volume.keep(x));
            },
            |x, y| {
                body.mass.mul(x, y);
                added.add(x, y);
            },
        );
        Ok(Modes { vacuum, with_fluid: Some(modes(found)), n_u: n, n_p: added.n_p() })
    }

    /// The box around a part of the body that nothing holds \[m\]: fewer than three components of its nodes are given or
    /// on springs.
    pub fn unheld(&self) -> Option<([f64; 2], [f64; 2])> {
        let FsiSpace { mesh, nodes, regions, .. } = self.space;
        let parts = self.space.components_by(&self.space.inner_facets());
        let n_parts = parts.iter().max().map_or(0, |&last| last as usize + 1);
        let mut held = self.held.clone();
        for (place, ..) in self.springs.iter().filter(|(row, column, k)| row == column && *k > 0.0) {
            held[*place as usize / 2][*place as usize % 2] = true;
        }
        (0..n_parts).find_map(|part| {
            let of_part = |&cell: &usize| parts[cell] as usize == part && regions[cell] == Region::Solid;
            let cells = (0..mesh.n_cells()).filter(of_part);
            let mut own: Vec<usize> =
                cells.flat_map(|cell| nodes.cell(cell).iter().map(|&node| node as usize)).collect();
            own.sort_unstable();
            own.dedup();
            let given: usize = own.iter().map(|&a| held[a].iter().filter(|held| **held).count()).sum();
            let end = |start: f64, pick: fn(f64, f64) -> f64| {
                [0, 1].map(|d| own.iter().map(|&a| nodes.points[a][d]).fold(start, pick))
            };
            let around = (end(f64::INFINITY, f64::min), end(f64::NEG_INFINITY, f64::max));
            (!own.is_empty() && given < 3).then_some(around)
        })
    }
}

/// ω/(2π) of an eigenvalue 1/ω².
fn frequency(inverse: f64) -> f64 {
    1.0 / (2.0 * PI * inverse.sqrt())
}

/// The spaces of `case` and its `count` lowest modes, computed on `threads` threads.
///
/// # Errors
/// [`Error::Case`] if there is no solid, if it is incompressible, or if a part of it is not held; as
/// [`Case::build_space`]; if a matrix cannot be factorised.
pub fn of_case(case: &Case, count: usize, threads: usize) -> Result<(FsiSpace<2>, Modes), Error> {
    if case.solids.is_empty() {
        let message = "there is no [solid]: expected an elastic body, whose modes are computed";
        return Err(case.refuse("solid", message.into()));
    }
    case.needs_plane("modes")?;
    if case.mesh.dimension == 3 {
        let message = "modes in space are not yet available: expected a mesh of the plane";
        return Err(case.refuse("mesh", message.into()));
    }
    let fluids = &case.fluids[..];
    if let [first, others @ ..] = fluids
        && let Some(other) = others.iter().find(|other| other.density != first.density)
    {
        let message = "modes with fluids of several densities are not yet available: expected equal ones";
        return Err(case.refuse(&format!("{}.density", other.table()), message.into()));
    }
    if let Some(solid) = case.solids.iter().find(|s| s.law.is_incompressible() && s.own.is_none()) {
        let message = format!(
            "`{}` has a pressure of its own, for which modes are not yet available: expected a compressible law, such \
             as `neo-hookean`",
            solid.law.name()
        );
        return Err(case.refuse(&format!("{}.law", solid.table()), message));
    }
    if let Some(solid) = case.solids.iter().find(|solid| solid.reference != Reference::Free) {
        let message = "modes are those of a body without stress at rest: expected a case without `prestress`";
        return Err(case.refuse(&format!("{}.prestress", solid.table()), message.into()));
    }
    let space = case.build_space()?;
    let constraints = Constraints::new(&space, &case.conditions(&space.mesh));
    if !constraints.directions.is_empty() {
        let message = "modes hold components of u, and a boundary with `slip` or `symmetry` is inclined or curved: expected \
                       boundaries parallel to axes";
        return Err(case.refuse("boundary", message.into()));
    }
    let setting = setting(case, &space, &constraints);
    if let Some((lower, upper)) = setting.unheld() {
        let message = format!(
            "nothing holds the part of the solid in {lower:?} to {upper:?} m, so that it has rigid motions and K is \
             singular: expected a boundary of it with condition = `clamped` or `spring`"
        );
        return Err(case.refuse("solid", message));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let modes = pool.map_err(|_| Error::Threads(threads))?.install(|| setting.modes(count));
    match modes {
        Ok(modes) => Ok((space, modes)),
        Err(error @ (SolverError::Singular { .. } | SolverError::NotDefinite { .. })) => {
            let message = format!(
                "its stiffness at rest is singular: {error}; expected a solid that is stable at rest and held, such as \
                 by a boundary with condition = `clamped`"
            );
            Err(case.refuse("solid", message))
        }
        Err(error) => Err(error.into()),
    }
}

/// The keys of the loads and dashpots of `case`, which have no effect: modes are those of a body at rest without loads
/// and without damping.
pub fn unused_loads(case: &Case) -> Vec<String> {
    let acts = |load: &Load<'_>| !load.force.iter().all(Expression::is_zero);
    let forces = case.loads().into_iter().filter(acts);
    let loads = |(name, condition): (&String, &Condition)| -> Vec<String> {
        let data = condition.data().into_iter().filter(|_| !matches!(condition, Condition::Velocity(_)));
        let loaded = data.filter(|(key, data)| *key != "stiffness" && !data.iter().all(|e| e.is_zero()));
        loaded.map(|(key, _)| format!("boundary.{name}.{key}")).collect()
    };
    let of_side = case.boundary.iter().flat_map(loads);
    forces.map(|load| load.key).chain(of_side).collect()
}

fn setting<'a>(case: &Case, space: &'a FsiSpace<2>, constraints: &Constraints<2>) -> Setting<'a> {
    let held = constraints.v.iter().zip(&constraints.u);
    let held = held.map(|(v, u)| std::array::from_fn(|i| v[i] || u[i])).collect();
    let open = |name: &String| case.boundary.get(name).is_some_and(Condition::is_natural);
    Setting {
        space,
        solids: case.solids.iter().map(SolidSpec::physics).collect(),
        fluid_density: case.fluids.first().map(|fluid| fluid.density),
        held,
        springs: spring::entries(case, space),
        open: space.mesh.boundaries.iter().map(open).collect(),
        quadrature: case.space.quadrature,
    }
}
