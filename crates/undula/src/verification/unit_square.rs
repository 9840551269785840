//! Known solutions on the unit square, and the errors with which a case computes them.
//!
//! A case gives the spaces, the materials, the extension and the scheme; its boundary conditions decide where the flow
//! leaves. Its data are replaced by those of the known solution.

use super::equal_steps;
use super::manufactured::{Exact, InTime, Manufactured, Number, Values, cos, number, sample, sin};
use crate::case::{Case, Condition};
use crate::error::Error;
use crate::mesh::{INTERFACE, Mesh};
use crate::space::BoundaryCondition::{self, Outflow};
use crate::space::{Against, VelocityData};
use crate::system::Options;
use crate::time::Scheme;
use std::f64::consts::PI;
use std::sync::Arc;

/// 16 x (1 − x) y (1 − y).
pub fn bubble(x: [Number; 2]) -> Number {
    let [x, y] = x;
    (x - x * x) * (y - y * y) * 16.0
}

/// Not polynomial; F not symmetric, in the solid v ≠ ∂_t u; without deformation for a flow alone.
pub fn smooth(deforms: bool) -> Exact {
    let size = if deforms { 1.0 } else { 0.0 };
    Arc::new(move |[x, y], t| {
        let (w, a) = (bubble([x, y]) * size, number(1.0) + sin(t) * 0.3);
        Values {
            v: [sin(x * 2.0 + y * 1.5 + t), cos(x - y * 2.0 + t * 0.5)],
            u: [w * a * (number(0.035) + y * 0.025), w * a * (x * 0.045 - number(0.05))],
            p: sin(x * 3.0 + t) * cos(y * 2.0) + x,
        }
    })
}

/// At every time in the spaces Q2-P1dc on squares, so that all of the error is that of time.
pub fn in_the_spaces() -> Exact {
    Arc::new(|[x, y], t| {
        let w = bubble([x, y]);
        let (one, a, b) = (number(1.0), sin(t * 2.0 + number(0.4)), cos(t * 1.5));
        Values {
            v: [(one + x + y * y) * cos(t) + x * y * a, (x * x - y) * b + x * y * y * 0.5 + sin(t * 3.0)],
            u: [w * a * 0.09, w * b * -0.07],
            p: x * cos(t * 2.0) - y * a + sin(t) * 2.0,
        }
    })
}

/// The same with deformations of two profiles, one of them with a kink at x = ½, where a side of cells must be. Where u
/// is one profile times a vector, det ∇u and cof(∇∂_t u) ∂_t u vanish, and all domain-motion terms are equal.
pub fn of_two_profiles() -> Exact {
    let first = in_the_spaces();
    Arc::new(move |[x, y], t| {
        let hat = if x.re < 0.5 { x } else { number(1.0) - x };
        let values = first([x, y], t);
        Values { u: [values.u[0], hat * (y - y * y) * cos(t * 1.5) * -0.6], ..values }
    })
}

/// The velocity of `exact`.
pub fn velocity(exact: &Exact) -> VelocityData<2> {
    let exact = exact.clone();
    Arc::new(move |x: &[f64; 2], t| sample(&exact, *x, t).fields.v.0)
}

/// Errors in L²(Ω); in time the largest of all steps.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Errors {
    /// Of the velocity \[m²/s\].
    pub v: f64,
    /// Of the deformation \[m²\].
    pub u: f64,
    /// Of the pressure, where there is one \[Pa m\]; in time at t⁻ + θ k.
    pub p: f64,
    /// Number of unknowns.
    pub unknowns: usize,
}

/// Errors of the known solution on the spaces of `case`. A case in time is computed with its scheme and step from time
/// 0 to its end on the squares of its mesh, with [`of_two_profiles`]; a stationary one with [`smooth`] on cells that are
/// bent. Every boundary has the velocity of the solution, but for outflows.
///
/// # Errors
/// [`Error::Case`] if the domain is not the unit square, as [`Case::build_space`], and if Newton's method fails.
pub fn errors(case: &Case) -> Result<Errors, Error> {
    case.needs_plane("errors")?;
    let mut mesh = case.build_mesh()?;
    let inside = |x: &[f64; 2]| x.iter().all(|x| (-1e-9..=1.0 + 1e-9).contains(x));
    let corner = |at: [f64; 2]| mesh.nodes.iter().any(|x| (x[0] - at[0]).hypot(x[1] - at[1]) < 1e-9);
    if !mesh.nodes.iter().all(inside) || !corner([0.0; 2]) || !corner([1.0; 2]) {
        let message = "the known solution lives on the unit square: expected a mesh of (0, 1)²";
        return Err(case.refuse("mesh", message.into()));
    }
    if let Some((name, _)) = case.boundary.iter().find(|(_, condition)| !takes_the_solution(condition)) {
        let message = "the known solution has its own data: expected a velocity, a wall or an outflow";
        return Err(case.refuse(&format!("boundary.{name}.condition"), message.into()));
    }
    let k = equal_steps(case)?.unwrap_or(1.0);
    let in_time = case.time.as_ref();
    if in_time.is_none() {
        bend(&mut mesh);
    }
    let space = case.space_on(&mesh)?;
    let exact = if in_time.is_some() { of_two_profiles() } else { smooth(space.deforms) };
    let conditions = space.mesh.boundaries.iter().map(|name| match case.boundary.get(name) {
        Some(Condition::DoNothing) => Outflow { do_nothing: true, backflow: Against::None },
        _ if name == INTERFACE => BoundaryCondition::Free,
        _ => BoundaryCondition::Velocity(velocity(&exact)),
    });
    let conditions = conditions.collect();
    let accurate = case.space.quadrature + if in_time.is_some() { 0 } else { 2 };
    let problem = Manufactured {
        physics: case.physics(),
        conditions,
        exact,
        in_time: if in_time.is_some() { InTime::Derivative } else { InTime::Difference },
        fluid: true,
        quadrature: accurate,
        space: Arc::new(space),
    };
    let options = Options::serial(case.space.quadrature);
    let unknowns = problem.space.n_field_unknowns();
    let Some(time) = in_time else {
        let mut stepper = problem.stepper(Scheme::BackwardEuler, 0.0, false, &options);
        stepper.assembler.stabilize(&case.stabilization, &options)?;
        stepper.newton.settings.floor = Some(1e-10);
        stepper.stationary()?;
        let found = problem.errors(&stepper.new, 0.0, 0.0, accurate);
        return Ok(Errors { v: found.v, u: found.u, p: found.p, unknowns });
    };
    let mut stepper = problem.stepper(time.scheme, 0.0, false, &options);
    stepper.assembler.stabilize(&case.stabilization, &options)?;
    stepper.settings.domain_motion = time.domain_motion;
    let steps = (time.end / k).round().max(1.0) as usize;
    let mut worst = Errors { unknowns, ..Errors::default() };
    for _ in 0..steps {
        stepper.step(time.end / steps as f64)?;
        let found = problem.errors(&stepper.new, stepper.time, stepper.force_time(), accurate);
        worst.v = worst.v.max(found.v);
        worst.u = worst.u.max(found.u);
        worst.p = worst.p.max(found.p);
    }
    Ok(worst)
}

/// Whether the data of the known solution can take the place of a condition.
fn takes_the_solution(condition: &Condition) -> bool {
    use Condition::{Clamped, DoNothing, NoSlip, TractionFree, Velocity};
    matches!(condition, Velocity(_) | NoSlip | Clamped | DoNothing | TractionFree)
}

/// Moves the nodes, the boundary stays: no side inside is straight.
fn bend(mesh: &mut Mesh<2>) {
    for x in &mut mesh.nodes {
        let bump = (PI * x[0]).sin() * (PI * x[1]).sin();
        *x = [x[0] + 0.06 * bump, x[1] - 0.05 * bump];
    }
}
