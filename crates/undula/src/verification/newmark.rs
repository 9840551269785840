//! Newmark's method for the elastic body beside the Crank-Nicolson scheme of the mixed formulation, section 5.1.2.1.
//!
//! Newmark's method with β = ¼ and γ = ½ seeks u, v = ∂_t u and a = ∂_t v with M a + A(u) = F at every time step and
//!
//! u = u⁻ + k v⁻ + k²/4 (a⁻ + a),  v = v⁻ + k/2 (a⁻ + a).
//!
//! With û = u⁻ + k v⁻ + k²/4 a⁻ it reads M (u − û)/h² + A(u) = F, h = k/2: a step of the backward Euler scheme of
//! length h from the deformation û and the velocity 0. The first acceleration is that of a step of the explicit Euler
//! scheme, M (v − v⁻)/k + A(u⁻) = F.

use super::equal_steps;
use crate::case::expression::Expression;
use crate::case::{Case, Condition, SolidSpec};
use crate::error::Error;
use crate::physics::Reference;
use crate::time::{Scheme, Stepper};

/// Both methods beside each other.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Beside {
    /// Largest difference of a component of u at a node over all steps, relative to the largest component.
    pub difference: f64,
    /// Steps.
    pub steps: usize,
}

/// Largest absolute value of a difference, and of a value.
fn compare(a: &[f64], b: &[f64]) -> [f64; 2] {
    a.iter().zip(b).fold([0.0, 0.0], |[d, s], (a, b)| [d.max((a - b).abs()), s.max(a.abs())])
}

/// The vibrations of the solid of `case` by both methods with its step from rest to its end. Forces on the solid must
/// not depend on time.
///
/// # Errors
/// [`Error::Case`] for a case with a fluid or without time, and if Newton's method fails.
pub fn newmark(case: &Case, threads: usize) -> Result<Beside, Error> {
    let Some(time) = case.time.as_ref().filter(|_| case.fluids.is_empty() && !case.solids.is_empty()) else {
        let message =
            "Newmark's method is that of an elastic body alone in time: expected a case such as `csm3`";
        return Err(case.refuse("fluid", message.into()));
    };
    case.needs_plane("steps of Newmark's method")?;
    let k = equal_steps(case)?.unwrap_or(1.0);
    let changes = |solid: &&SolidSpec| solid.body_force.iter().any(|force| force.depends_on_time());
    if let Some(solid) = case.solids.iter().find(changes) {
        let message = "Newmark's method is compared under a force that does not depend on t";
        return Err(case.refuse(&format!("{}.body-force", solid.table()), message.into()));
    }
    if let Some(solid) = case.solids.iter().find(|solid| solid.reference != Reference::Free) {
        let message = "Newmark's method is compared without prestress, from rest";
        return Err(case.refuse(&format!("{}.prestress", solid.table()), message.into()));
    }
    let damped =
        |solid: &&SolidSpec| [solid.viscosity, solid.damping_mass, solid.damping_stiffness] != [0.0; 3];
    if let Some(solid) = case.solids.iter().find(damped) {
        let message = "Newmark's method is compared without damping, as u alone is in its equation";
        return Err(case.refuse(&solid.table(), message.into()));
    }
    let changes = |condition: &Condition| {
        let damped = |damping: &Expression| damping.constant_value() != Some(0.0);
        match condition {
            Condition::Velocity(_) => true,
            Condition::Spring { damping, .. } if damped(damping) => true,
            other => other.depends_on_time(),
        }
    };
    if case.boundary.values().any(changes) {
        let message =
            "Newmark's method is compared with boundaries that are held, free, or under a constant traction";
        return Err(case.refuse("boundary", message.into()));
    }
    let mut steppers = vec![];
    for scheme in [Scheme::CrankNicolson, Scheme::BackwardEuler, Scheme::Theta { theta: 0.0 }] {
        let mut stepper = case.build_stepper(threads)?;
        stepper.settings.scheme = scheme;
        // States are set between the steps of Newmark's method, there is nothing to extrapolate.
        stepper.settings.extrapolate = scheme == Scheme::CrankNicolson;
        stepper.settings.max_halvings = 0;
        steppers.push(stepper);
    }
    let [mixed, newmark, explicit] = &mut steppers[..] else { unreachable!("three were made") };
    explicit.step(k)?;
    let mut a: Vec<f64> = explicit.new.v.iter().map(|v| v / k).collect();
    let (mut u, mut v) = (newmark.new.u.clone(), newmark.new.v.clone());
    let steps = ((time.end - time.start) / k).round().max(1.0) as usize;
    let (mut difference, mut size) = (0.0f64, 0.0f64);
    for _ in 0..steps {
        mixed.step(k)?;
        step(newmark, k, [&mut u, &mut v, &mut a])?;
        let [d, s] = compare(&mixed.new.u, &u);
        (difference, size) = (difference.max(d), size.max(s));
    }
    Ok(Beside { difference: difference / size.max(f64::MIN_POSITIVE), steps })
}

/// One step of Newmark's method.
fn step(euler: &mut Stepper<2>, k: f64, [u, v, a]: [&mut Vec<f64>; 3]) -> Result<(), Error> {
    for (i, start) in euler.new.u.iter_mut().enumerate() {
        *start = u[i] + k * v[i] + 0.25 * k * k * a[i];
    }
    let start = euler.new.u.clone();
    euler.new.v.fill(0.0);
    euler.step(0.5 * k)?;
    u.copy_from_slice(&euler.new.u);
    for i in 0..u.len() {
        let new = (u[i] - start[i]) / (0.25 * k * k);
        v[i] += 0.5 * k * (a[i] + new);
        a[i] = new;
    }
    Ok(())
}
