//! Expressions of a case as functions of position and time.

use crate::case::expression::Expression;
use crate::space::MotionData;
use crate::system::CurrentForce;
use crate::time::Force;
use std::sync::Arc;

/// A body force, `None` if it is zero everywhere.
pub(super) fn body_force(f: &[Expression; 2]) -> Option<Force<2>> {
    if f.iter().all(Expression::is_zero) {
        return None;
    }
    Some(function(f))
}

/// Two expressions as a function of position and time.
pub(super) fn function(f: &[Expression; 2]) -> Force<2> {
    let f = f.clone();
    Box::new(move |x, t| {
        let x = [x[0], x[1], 0.0];
        [f[0].eval(&x, t), f[1].eval(&x, t)]
    })
}

/// A displacement with its rate.
pub(super) fn motion(u: &[Option<Expression>; 2]) -> MotionData<2> {
    let u = u.clone();
    Arc::new(move |x, t| {
        let at = |e: &Expression| {
            let (u, rate) = e.eval_with_rate(&[x[0], x[1], 0.0], t);
            [u, rate]
        };
        [0, 1].map(|i: usize| u[i].as_ref().map(at))
    })
}

/// The same with its gradient, to be taken at current positions.
pub(super) fn current_force(f: &[Expression; 2]) -> Option<CurrentForce<2>> {
    let _ = body_force(f)?;
    let f = f.clone();
    Some(CurrentForce::new(Box::new(move |x, t| {
        let at = |f: &Expression| f.eval_with_gradient(&[x[0], x[1], 0.0], t);
        let [(a, da), (b, db)] = [at(&f[0]), at(&f[1])];
        ([a, b], [[da[0], da[1]], [db[0], db[1]]])
    })))
}
