//! Known solutions on the unit square or the unit cube, and the errors with which a case computes them.
//!
//! A case gives the spaces, the materials, the extension and the scheme; its boundary conditions decide where the flow
//! leaves. Its data are replaced by those of the known solution.

use super::body_force::give_force;
use super::equal_steps;
use super::manufactured::{Exact, InTime, Manufactured, Number, Values, cos, number, sample, sin};
use crate::case::schema::TimeSpec;
use crate::case::{Case, Condition};
use crate::error::Error;
use crate::mesh::{INTERFACE, Mesh};
use crate::setup::dimension::Dimension;
use crate::space::BoundaryCondition::{self, Outflow};
use crate::space::{Against, VelocityData};
use crate::system::{Dim, Kernels, Options};
use crate::time::Scheme;
use std::f64::consts::PI;
use std::sync::Arc;

/// What the plane and space have in common, with z = 0 in the plane.
fn coordinates<const D: usize>(x: [Number; D]) -> [Number; 3] {
    std::array::from_fn(|d| if d < D { x[d] } else { number(0.0) })
}

/// The components that there are.
fn first<const D: usize>(all: [Number; 3]) -> [Number; D] {
    std::array::from_fn(|d| all[d])
}

/// 4 x (1 − x) of every coordinate, multiplied.
pub fn bubble<const D: usize>(x: [Number; D]) -> Number {
    let parts = x.map(|x| x - x * x);
    parts[1..].iter().fold(parts[0], |product, part| product * *part) * 4.0_f64.powi(D as i32)
}

/// Not polynomial; F not symmetric, in the solid v ≠ ∂_t u; without deformation for a flow alone.
pub fn smooth<const D: usize>(deforms: bool) -> Exact<D> {
    let size = if deforms { 1.0 } else { 0.0 };
    Arc::new(move |at, t| {
        let ([x, y, z], w, a) = (coordinates(at), bubble(at) * size, number(1.0) + sin(t) * 0.3);
        let v = [
            sin(x * 2.0 + y * 1.5 + z + t),
            cos(x - y * 2.0 + z * 0.7 + t * 0.5),
            sin(x + y * 0.8 - z * 1.5 - t * 0.7),
        ];
        let u = [
            w * a * (number(0.035) + y * 0.025 - z * 0.02),
            w * a * (x * 0.045 - number(0.05) + z * 0.03),
            w * a * (number(0.04) - x * 0.03 + y * 0.02),
        ];
        Values { v: first(v), u: first(u), p: sin(x * 3.0 + t) * cos(y * 2.0 + z) + x }
    })
}

/// At every time in the spaces Q2-P1dc on squares or cubes, so that all of the error is that of time.
pub fn in_the_spaces<const D: usize>() -> Exact<D> {
    Arc::new(|at, t| {
        let ([x, y, z], w) = (coordinates(at), bubble(at));
        let (one, a, b) = (number(1.0), sin(t * 2.0 + number(0.4)), cos(t * 1.5));
        let v = [
            (one + x + y * y) * cos(t) + x * y * a + z * z * b,
            (x * x - y) * b + x * y * y * 0.5 + sin(t * 3.0) - x * z * a,
            (y * z - x * x) * a + (one + y - z * z) * sin(t * 1.2),
        ];
        let u = [w * a * 0.09, w * b * -0.07, w * sin(t * 1.2) * 0.06];
        Values { v: first(v), u: first(u), p: x * cos(t * 2.0) - y * a + z * b + sin(t) * 2.0 }
    })
}

/// The same with deformations of two profiles, one of them with a kink at x = ½, where a side of cells must be. Where u
/// is one profile times a vector, det ∇u and cof(∇∂_t u) ∂_t u vanish, and all domain-motion terms are equal.
pub fn of_two_profiles<const D: usize>() -> Exact<D> {
    let first = in_the_spaces();
    Arc::new(move |at: [Number; D], t| {
        let mut values: Values<D> = first(at, t);
        let hat = if at[0].re < 0.5 { at[0] } else { number(1.0) - at[0] };
        let across = at[1..].iter().fold(hat, |product, x| product * (*x - *x * *x));
        values.u[1] = across * cos(t * 1.5) * (-0.15 * 4.0_f64.powi(D as i32 - 1));
        values
    })
}

/// The velocity of `exact`.
pub fn velocity<const D: usize>(exact: &Exact<D>) -> VelocityData<D> {
    let exact = exact.clone();
    Arc::new(move |x: &[f64; D], t| sample(&exact, *x, t).fields.v.0)
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
/// 0 to its end on the squares or cubes of its mesh, with [`of_two_profiles`]; a stationary one with [`smooth`] on cells
/// that are bent. Every boundary has the velocity of the solution, but for outflows.
///
/// # Errors
/// [`Error::Case`] if the domain is not the unit square or cube, as [`Case::build_space`], and if Newton's method fails.
pub fn errors(case: &Case) -> Result<Errors, Error> {
    match case.mesh.dimension {
        3 => errors_in::<3>(case),
        _ => errors_in::<2>(case),
    }
}

fn errors_in<const D: usize>(case: &Case) -> Result<Errors, Error>
where
    Dim<D>: Dimension<D>,
{
    case.needs_plane("errors")?;
    let mut mesh = case.mesh_in::<D>()?;
    check_domain(case, &mesh)?;
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
    match in_time {
        None => stationary(case, &problem),
        Some(time) => of_steps(case, time, k, &problem),
    }
}

/// Errors of a stationary solution.
fn stationary<const D: usize>(case: &Case, problem: &Manufactured<D>) -> Result<Errors, Error>
where
    Dim<D>: Kernels<D>,
{
    let options = Options::serial(case.space.quadrature);
    let mut stepper = problem.stepper(Scheme::BackwardEuler, 0.0, false, &options);
    stepper.assembler.stabilize(&case.stabilization, &options)?;
    if case.stabilization.has_residual() {
        give_force(problem, &mut stepper);
    }
    stepper.newton.settings.floor = Some(1e-10);
    stepper.stationary()?;
    let found = problem.errors(&stepper.new, 0.0, 0.0, problem.quadrature);
    Ok(Errors { v: found.v, u: found.u, p: found.p, unknowns: problem.space.n_field_unknowns() })
}

/// The largest errors of steps of about `k` \[s\].
fn of_steps<const D: usize>(
    case: &Case,
    time: &TimeSpec,
    k: f64,
    problem: &Manufactured<D>,
) -> Result<Errors, Error>
where
    Dim<D>: Kernels<D>,
{
    let options = Options::serial(case.space.quadrature);
    let mut stepper = problem.stepper(time.scheme, 0.0, false, &options);
    stepper.assembler.stabilize(&case.stabilization, &options)?;
    stepper.settings.domain_motion = time.domain_motion;
    let steps = (time.end / k).round().max(1.0) as usize;
    let mut worst = Errors { unknowns: problem.space.n_field_unknowns(), ..Errors::default() };
    for _ in 0..steps {
        stepper.step(time.end / steps as f64)?;
        let found = problem.errors(&stepper.new, stepper.time, stepper.force_time(), problem.quadrature);
        worst.v = worst.v.max(found.v);
        worst.u = worst.u.max(found.u);
        worst.p = worst.p.max(found.p);
    }
    Ok(worst)
}

/// Refuses a mesh of another domain.
fn check_domain<const D: usize>(case: &Case, mesh: &Mesh<D>) -> Result<(), Error> {
    let inside = |x: &[f64; D]| x.iter().all(|x| (-1e-9..=1.0 + 1e-9).contains(x));
    let corner = |at: f64| mesh.nodes.iter().any(|x| x.iter().all(|x| (x - at).abs() < 1e-9));
    if mesh.nodes.iter().all(inside) && corner(0.0) && corner(1.0) {
        return Ok(());
    }
    let (name, power) = if D == 3 { ("cube", "³") } else { ("square", "²") };
    let message = format!("the known solution lives on the unit {name}: expected a mesh of (0, 1){power}");
    Err(case.refuse("mesh", message))
}

/// Whether the data of the known solution can take the place of a condition.
fn takes_the_solution(condition: &Condition) -> bool {
    use Condition::{Clamped, DoNothing, NoSlip, TractionFree, Velocity};
    matches!(condition, Velocity(_) | NoSlip | Clamped | DoNothing | TractionFree)
}

/// Moves the nodes, the boundary stays: no side inside is straight.
fn bend<const D: usize>(mesh: &mut Mesh<D>) {
    for x in &mut mesh.nodes {
        let bump: f64 = x.iter().map(|x| (PI * x).sin()).product();
        *x = std::array::from_fn(|d| x[d] + [0.06, -0.05, 0.04][d] * bump);
    }
}
