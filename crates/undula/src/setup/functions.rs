//! Expressions of a case as functions of position and time.

use crate::case::expression::Expression;
use crate::space::MotionData;
use crate::system::CurrentForce;
use crate::time::Force;
use std::sync::Arc;

/// A position as expressions take it: z is 0 in the plane.
pub(super) fn padded<const D: usize>(x: &[f64; D]) -> [f64; 3] {
    std::array::from_fn(|d| if d < D { x[d] } else { 0.0 })
}

/// A body force, `None` if it is zero everywhere.
pub(super) fn body_force<const D: usize>(f: &[Expression]) -> Option<Force<D>> {
    if f.iter().all(Expression::is_zero) {
        return None;
    }
    Some(function(f))
}

/// An expression for each component as a function of position and time.
pub(super) fn function<const D: usize>(f: &[Expression]) -> Force<D> {
    let f = f.to_vec();
    Box::new(move |x, t| {
        let x = padded(x);
        std::array::from_fn(|i| f[i].eval(&x, t))
    })
}

/// A displacement with its rate.
pub(super) fn motion<const D: usize>(u: &[Option<Expression>]) -> MotionData<D> {
    let u = u.to_vec();
    Arc::new(move |x, t| {
        let at = |e: &Expression| {
            let (u, rate) = e.eval_with_rate(&padded(x), t);
            [u, rate]
        };
        std::array::from_fn(|i| u[i].as_ref().map(at))
    })
}

/// The same with its gradient, to be taken at current positions.
pub(super) fn current_force<const D: usize>(f: &[Expression]) -> Option<CurrentForce<D>> {
    let _ = body_force::<D>(f)?;
    let f = f.to_vec();
    Some(CurrentForce::new(Box::new(move |x, t| {
        let (mut value, mut gradient) = ([0.0; D], [[0.0; D]; D]);
        for (i, f) in f.iter().enumerate().take(D) {
            let (f, df) = f.eval_with_gradient(&padded(x), t);
            value[i] = f;
            gradient[i].copy_from_slice(&df[..D]);
        }
        (value, gradient)
    })))
}
