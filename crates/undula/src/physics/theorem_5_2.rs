//! The Jacobian by hand, term for term as in Theorem 5.2, extended to θ and to both ends of the step.
//!
//! It exists a second time on purpose: as a check of the automatic derivative and as a second choice.
//! Errata of the printed theorem, each shown by the test `derivatives`: the data term
//! −(J tr(F⁻¹∇w) ρ f + J ρ ∇f w, φ) is missing (its second part for a force at the current position x + u),
//! and λ tr(dE) lacks the factor I.

use super::{Backflow, Fields, Fluid, Kinematics, Outflow, Place, Pressure, Solid, Spring, StepRule, Tested};
use crate::math::{Scalar, Tensor, Vector};

/// (5.14) in the fluid: A'(U)(W, ·) with W = {z, w, q}.
#[inline(always)]
pub fn fluid<S: Scalar<Value = S>, const D: usize>(
    form: &Fluid,
    rule: &StepRule,
    place: &Place<S, D>,
    new: &Fields<S, D>,
    old: &Fields<S, D>,
    W: &Fields<S, D>,
) -> Tested<S, D> {
    let mut r = Tested::zero();
    rate(form, rule, new, old, W, &mut r);
    for (weight, tau) in rule.transport_points::<D>() {
        transport(form, weight, place, &old.lerp(new, tau), &scaled(W, tau), &mut r);
    }
    pressures(rule, new, old, W, &mut r);
    divergence(new, W, &mut r);
    r.grad_psi = extension(form, place, new, old, W);
    r
}

/// The part of the extension: what stands before ∇ψ in the fluid.
#[inline(always)]
pub fn extension<S: Scalar<Value = S>, const D: usize>(
    form: &Fluid,
    place: &Place<S, D>,
    new: &Fields<S, D>,
    old: &Fields<S, D>,
    W: &Fields<S, D>,
) -> Tensor<S, D> {
    let stiffness = form.extension.stiffness(place.stiffness, &old.grad_u);
    form.extension.derivative(&new.grad_u, &W.grad_u, stiffness)
}

/// Derivative of ρ J (∂_t v − ∇v F⁻¹ ∂_t u) at the times of the rule.
#[inline(always)]
fn rate<S: Scalar<Value = S>, const D: usize>(
    form: &Fluid,
    rule: &StepRule,
    new: &Fields<S, D>,
    old: &Fields<S, D>,
    W: &Fields<S, D>,
    r: &mut Tested<S, D>,
) {
    let dv_dt = rule.per_k * (new.v - old.v);
    let du_dt = rule.per_k * (new.u - old.u);
    for (weight, tau) in rule.inertia_points::<D>() {
        let at = old.lerp(new, tau);
        let Kinematics { F_inv, J, .. } = Kinematics::of(&at.grad_u);
        let (grad_z, grad_w) = (tau * W.grad_v, tau * W.grad_u);
        let motion = F_inv * du_dt;
        r.phi += weight
            * form.rho
            * ((dv_dt - at.grad_v * motion) * (F_inv * grad_w).trace() + rule.per_k * W.v - grad_z * motion
                + at.grad_v * (F_inv * (grad_w * motion))
                - rule.per_k * (at.grad_v * (F_inv * W.u)))
            * J;
    }
}

/// Derivative of ρ J (∇v F⁻¹ v − f) and J σ F⁻ᵀ.
#[inline(always)]
fn transport<S: Scalar<Value = S>, const D: usize>(
    form: &Fluid,
    theta: f64,
    place: &Place<S, D>,
    new: &Fields<S, D>,
    W: &Fields<S, D>,
    r: &mut Tested<S, D>,
) {
    let Kinematics { F_inv, J, .. } = Kinematics::of(&new.grad_u);
    let F_inv_t = F_inv.t();
    let tr = (F_inv * W.grad_u).trace();
    let grad_v = new.grad_v * F_inv;
    let sigma = form.friction(grad_v, grad_v);
    let grad_z = W.grad_v * F_inv;
    let grad_vw = grad_v * W.grad_u * F_inv;
    let dsigma = form.rho * form.nu * (grad_z + grad_z.t() - grad_vw - grad_vw.t());
    let dsigma = form.friction_derivative(&grad_v, dsigma);
    let convection = (grad_v * new.v - place.force) * tr + grad_z * new.v + grad_v * W.v
        - grad_vw * new.v
        - place.force_slope * W.u;
    r.phi += theta * form.rho * convection * J;
    let stress = sigma * F_inv_t * tr - sigma * F_inv_t * W.grad_u.t() * F_inv_t + dsigma * F_inv_t;
    r.grad_phi += theta * stress * J;
}

/// `tau` times a direction.
#[inline(always)]
fn scaled<S: Scalar<Value = S>, const D: usize>(W: &Fields<S, D>, tau: f64) -> Fields<S, D> {
    Fields::zero().lerp(W, tau)
}

/// Derivative of −(p J F⁻ᵀ, ∇φ), J F⁻ᵀ weighted over the step.
#[inline(always)]
fn pressures<S: Scalar<Value = S>, const D: usize>(
    rule: &StepRule,
    new: &Fields<S, D>,
    old: &Fields<S, D>,
    W: &Fields<S, D>,
    r: &mut Tested<S, D>,
) {
    if rule.quadrature.is_empty() {
        // The geometry of the old time is known.
        let of_old = super::kinematics::cofactor(&old.grad_u);
        r.grad_phi -= (1.0 - rule.theta) * of_old * W.p;
    }
    for (weight, tau) in rule.transport_points::<D>() {
        pressure(weight, new.p, &old.lerp(new, tau), &(tau * W.grad_u), W.p, r);
    }
}

/// Derivative of −(p J F⁻ᵀ, ∇φ) in the directions `grad_w` and `q`.
#[inline(always)]
fn pressure<S: Scalar<Value = S>, const D: usize>(
    weight: f64,
    p: S,
    at: &Fields<S, D>,
    grad_w: &Tensor<S, D>,
    q: S,
    r: &mut Tested<S, D>,
) {
    let Kinematics { F_inv, J, .. } = Kinematics::of(&at.grad_u);
    let F_inv_t = F_inv.t();
    let tr = (F_inv * *grad_w).trace();
    r.grad_phi -= weight * (F_inv_t * J) * q;
    r.grad_phi -= weight * ((F_inv_t * tr - F_inv_t * grad_w.t() * F_inv_t) * (J * p));
}

/// Derivative of (J F⁻¹ : ∇vᵀ, ξ).
#[inline(always)]
fn divergence<S: Scalar<Value = S>, const D: usize>(
    new: &Fields<S, D>,
    W: &Fields<S, D>,
    r: &mut Tested<S, D>,
) {
    let Kinematics { F_inv, J, .. } = Kinematics::of(&new.grad_u);
    let tr = (F_inv * W.grad_u).trace();
    let grad_v_t = new.grad_v.t();
    r.xi += J
        * (F_inv.ddot(W.grad_v.t()) + tr * F_inv.ddot(grad_v_t) - (F_inv * W.grad_u * F_inv).ddot(grad_v_t));
}

/// (5.14) in the solid, Lemma 5.5, with damping, and with pressure and volume of an incompressible one.
#[inline(always)]
pub fn solid<S: Scalar<Value = S>, const D: usize>(
    form: &Solid,
    rule: &StepRule,
    place: &Place<S, D>,
    new: &Fields<S, D>,
    old: &Fields<S, D>,
    W: &Fields<S, D>,
) -> Tested<S, D> {
    let mut r = Tested {
        phi: rule.per_k * form.rho * W.v,
        psi: rule.per_k * W.u - rule.theta * W.v,
        ..Tested::zero()
    };
    for (weight, tau) in rule.transport_points::<D>() {
        let at = old.lerp(new, tau);
        let fabric = &place.fabric;
        let (total, along) = (form.total(fabric, &at.grad_u), form.total_along(fabric, tau * W.grad_u));
        let dP = form.material.derivative_at(&fabric.fibre, &total, &along);
        r.grad_phi += weight * form.carried(fabric, &at.grad_u, dP);
        r.phi += weight * form.rho * form.damping.mass * tau * W.v;
        if form.damping.has_stress() {
            let (fields, directions) = ((&at.grad_v, &at.grad_u), (&(tau * W.grad_v), &(tau * W.grad_u)));
            r.grad_phi += weight * form.damping.derivative(form.is_linear(), fields, directions);
        }
    }
    let Some(compliance) = form.material.compliance() else { return r };
    pressures(rule, new, old, W, &mut r);
    let Kinematics { F_inv, J, .. } = Kinematics::of(&new.grad_u);
    let F_inv_t = F_inv.t();
    let tr = (F_inv * W.grad_u).trace();
    r.xi = if compliance == 0.0 {
        let dcofactor = (F_inv_t * tr - F_inv_t * W.grad_u.t() * F_inv_t) * J;
        let flux = F_inv_t.ddot(W.grad_v) * J + dcofactor.ddot(new.grad_v);
        let (rate, share) = rule.volume();
        J * tr * rate + flux * share
    } else {
        let [_, ratio] = form.gain(&place.fabric, &new.grad_u);
        (J * tr * rule.theta + W.p * compliance * ratio) * rule.compression()
    };
    r
}

/// Derivative of the do-nothing correction −⟨ρν J (F⁻ᵀ∇vᵀ − tr(∇v F⁻¹) I) F⁻ᵀ n, φ⟩, absent from the printed
/// theorem.
#[inline(always)]
pub fn outflow<S: Scalar<Value = S>, const D: usize>(
    form: &Outflow,
    theta: f64,
    at: &Fields<S, D>,
    normal: &Vector<S, D>,
    W: &Fields<S, D>,
) -> Vector<S, D> {
    let Kinematics { F_inv, J, .. } = Kinematics::of(&at.grad_u);
    let F_inv_t = F_inv.t();
    let tr = (F_inv * W.grad_u).trace();
    let n = F_inv_t * *normal;
    let dn = -(F_inv_t * (W.grad_u.t() * n));
    let t = F_inv_t * (at.grad_v.t() * n);
    let dt = F_inv_t * (W.grad_v.t() * n + at.grad_v.t() * dn) - F_inv_t * (W.grad_u.t() * t);
    let (grad_v, grad_z) = (at.grad_v * F_inv, W.grad_v * F_inv);
    let trace = grad_v.trace();
    let dtrace = grad_z.trace() - (grad_v * (W.grad_u * F_inv)).trace();
    let (q, dq) = (t - n * trace, dt - n * dtrace - dn * trace);
    let newtonian = -theta * form.viscosity * (q * tr + dq) * J;
    let Some(law) = form.thinning else { return newtonian };
    let (twice, change) = (grad_v + grad_v.t(), grad_z - grad_v * (W.grad_u * F_inv));
    let dfactor = law.derivative(&twice, &(change + change.t()));
    newtonian * law.factor(&twice) - theta * form.viscosity * q * (dfactor * J)
}

/// Derivative of the directional term −⟨½ ρ min(0, (v − ∂_t u)·J F⁻ᵀ n) v, φ⟩ or of its tangential part, absent from the
/// printed theorem; `at.u` and `W.u` are ∂_t u and its direction.
#[inline(always)]
pub fn backflow<S: Scalar<Value = S>, const D: usize>(
    form: &Backflow,
    theta: f64,
    at: &Fields<S, D>,
    normal: &Vector<S, D>,
    W: &Fields<S, D>,
) -> Vector<S, D> {
    let Kinematics { F_inv, J, .. } = Kinematics::of(&at.grad_u);
    let F_inv_t = F_inv.t();
    let n = F_inv_t * *normal;
    let dn = n * (F_inv * W.grad_u).trace() - F_inv_t * (W.grad_u.t() * n);
    let relative = at.v - at.u;
    let flow = relative.dot(n) * J;
    let dflow = ((W.v - W.u).dot(n) + relative.dot(dn)) * J;
    let (mut carried, mut change) = (at.v, W.v);
    if form.tangential {
        let square = n.dot(n);
        let share = n.dot(at.v) / square;
        let dshare = (dn.dot(at.v) + n.dot(W.v) - share * S::constant(2.0) * n.dot(dn)) / square;
        carried -= n * share;
        change -= dn * share + n * dshare;
    }
    (carried * dflow + change * flow) * (flow.below_zero() * (-0.5 * theta * form.density))
}

/// Derivative of a pressure that follows its boundary, ⟨p J F⁻ᵀ n, φ⟩: p (tr(F⁻¹ ∇w) I − F⁻ᵀ ∇wᵀ) J F⁻ᵀ n.
#[inline(always)]
pub fn pressure_load<S: Scalar<Value = S>, const D: usize>(
    form: &Pressure,
    weight: f64,
    at: &Fields<S, D>,
    normal: &Vector<S, D>,
    W: &Fields<S, D>,
) -> Vector<S, D> {
    if !form.follows {
        return Vector::zero();
    }
    let Kinematics { F_inv, J, .. } = Kinematics::of(&at.grad_u);
    let n = F_inv.t() * *normal;
    weight * form.pressure * (n * (F_inv * W.grad_u).trace() - F_inv.t() * (W.grad_u.t() * n)) * J
}

/// Derivative of an elastic and viscous bed, which is linear.
#[inline(always)]
pub fn spring<S: Scalar<Value = S>, const D: usize>(
    form: &Spring,
    weight: f64,
    _: &Fields<S, D>,
    normal: &Vector<S, D>,
    W: &Fields<S, D>,
) -> Vector<S, D> {
    let force = form.stiffness * W.u + form.damping * W.v;
    weight * if form.normal { *normal * normal.dot(force) } else { force }
}
