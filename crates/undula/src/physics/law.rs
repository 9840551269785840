//! Laws that are evaluated number by number.
//!
//! Lanes are taken apart in functions of their own: nothing here is compiled for wide vectors.

use crate::math::{Dual, Scalar, Tensor, Vector};

/// A law as the kernels call it: energy and stress with their derivatives, by number; `fibre` is the direction of the
/// fibres, 0 for that of the law.
pub(super) trait Law: Send + Sync {
    /// Value of W at ∇u and its derivative in the direction that comes with it; lists are of D² pairs.
    fn energy_at(&self, fibre: &[f64], grad_u: &[[f64; 2]]) -> [f64; 2];
    /// The same for P, into `stress`.
    fn stress_at(&self, fibre: &[f64], grad_u: &[[f64; 2]], stress: &mut [[f64; 2]]);
}

/// ∇u in space: plane strain if it is one of the plane.
pub(super) fn in_space(grad_u: &[[f64; 2]]) -> Tensor<Dual<f64>, 3> {
    let d = grad_u.len().isqrt();
    let mut at = Tensor::zero();
    for (n, &[re, eps]) in grad_u.iter().enumerate() {
        at.0[n / d][n % d] = Dual { re, eps };
    }
    at
}

/// The components of P that a list as long as that of ∇u has.
pub(super) fn write(P: &Tensor<Dual<f64>, 3>, stress: &mut [[f64; 2]]) {
    let d = stress.len().isqrt();
    for (n, component) in stress.iter_mut().enumerate() {
        let Dual { re, eps } = P.0[n / d][n % d];
        *component = [re, eps];
    }
}

/// Lane `lane` of a direction.
fn direction<S: Scalar, const D: usize>(fibre: &Vector<S, D>, lane: usize) -> [f64; D] {
    fibre.0.map(|x| x.lane(lane)[0])
}

/// W at ∇u.
#[cold]
#[inline(never)]
pub(super) fn energy<T: Scalar, const D: usize>(
    law: &dyn Law,
    fibre: &Vector<T::Value, D>,
    grad_u: &Tensor<T, D>,
) -> T {
    let mut W = T::zero();
    for lane in 0..T::LANES {
        let at = grad_u.0.map(|row| row.map(|x| x.lane(lane)));
        W.set_lane(lane, law.energy_at(&direction(fibre, lane), at.as_flattened()));
    }
    W
}

/// P at ∇u, with its derivative if `T` has one.
#[cold]
#[inline(never)]
pub(super) fn stress<T: Scalar, const D: usize>(
    law: &dyn Law,
    fibre: &Vector<T::Value, D>,
    grad_u: &Tensor<T, D>,
) -> Tensor<T, D> {
    let mut P = Tensor::zero();
    for lane in 0..T::LANES {
        let at = grad_u.0.map(|row| row.map(|x| x.lane(lane)));
        fill(law, (&direction(fibre, lane), &at), |pair| pair, lane, &mut P);
    }
    P
}

/// Derivative of P at ∇u in the direction ∇w.
#[cold]
#[inline(never)]
pub(super) fn derivative<T: Scalar, const D: usize>(
    law: &dyn Law,
    fibre: &Vector<T::Value, D>,
    grad_u: &Tensor<T, D>,
    grad_w: &Tensor<T, D>,
) -> Tensor<T, D> {
    let mut dP = Tensor::zero();
    for lane in 0..T::LANES {
        let mut at = grad_u.0.map(|row| row.map(|x| x.lane(lane)));
        for (pair, w) in at.as_flattened_mut().iter_mut().zip(grad_w.0.as_flattened()) {
            pair[1] = w.lane(lane)[0];
        }
        fill(law, (&direction(fibre, lane), &at), |[_, slope]| [slope, 0.0], lane, &mut dP);
    }
    dP
}

/// What `part` takes of P at ∇u, into lane `lane` of `out`.
fn fill<T: Scalar, const D: usize>(
    law: &dyn Law,
    (fibre, at): (&[f64; D], &[[[f64; 2]; D]; D]),
    part: impl Fn([f64; 2]) -> [f64; 2],
    lane: usize,
    out: &mut Tensor<T, D>,
) {
    let mut stress = [[[0.0; 2]; D]; D];
    law.stress_at(fibre, at.as_flattened(), stress.as_flattened_mut());
    for (component, value) in out.0.as_flattened_mut().iter_mut().zip(stress.as_flattened()) {
        component.set_lane(lane, part(*value));
    }
}
