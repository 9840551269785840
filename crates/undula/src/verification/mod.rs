//! Whether the program solves its equations, and how well they can be solved.
//!
//! `manufactured` has problems whose solution is known, `body_force` their forces, `unit_square` two of them with their
//! errors, `newmark` another method for the elastic body, `jacobians` compares all Jacobians of a case with each other,
//! `matrix` describes the blocks of one, and `stability` computes inf-sup constants and condition numbers. No simulation
//! needs this.

pub mod body_force;
pub mod jacobians;
pub mod manufactured;
pub mod matrix;
pub mod newmark;
pub mod stability;
pub mod unit_square;

use crate::case::Case;
use crate::error::Error;

/// The length of the steps of `case` \[s\], all of which are equal.
///
/// # Errors
/// [`Error::Case`] for steps that change, with time or by an estimate of the error.
fn equal_steps(case: &Case) -> Result<Option<f64>, Error> {
    let Some(time) = &case.time else { return Ok(None) };
    if time.adaptive.is_some() || time.step.depends_on_time() {
        let message =
            "the comparison with a known solution takes equal steps: expected a number, without control";
        return Err(case.refuse("time.step", message.into()));
    }
    Ok(Some(time.step.eval(&[0.0; 3], time.start)))
}
