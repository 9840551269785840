//! Outflow conditions.

use super::kinematics::cofactor;
use super::{CarreauYasuda, FacetForm, Fields, Kinematics};
use crate::math::{Scalar, Vector};

/// Correction that turns the symmetric stress into the do-nothing condition `ρν ∇v n − p n = 0`:
/// −⟨ρ ν J (F⁻ᵀ ∇vᵀ − tr(∇v F⁻¹) I) F⁻ᵀ n, φ⟩ on the outflow boundary.
///
/// The trace is zero for the solution. With it only derivatives along the boundary are left, which can be
/// integrated by parts; without it the adjoint problem is another one, pressure and normal forces shift by
/// O(h²) instead of O(h⁴), and a coupled solution loses an order (`tests/it/convergence_space.rs`).
///
/// Without it the same boundary is traction-free. Its derivatives with respect to v and u are needed
/// too, or Newton turns linear.
#[derive(Copy, Clone, Debug)]
pub struct Outflow {
    /// Dynamic viscosity ρ_f ν_f \[Pa s\]; that at rest if it depends on the rate of shear.
    pub viscosity: f64,
    /// How it depends on the rate of shear.
    pub thinning: Option<CarreauYasuda>,
}

impl<const D: usize> FacetForm<D> for Outflow {
    #[inline(always)]
    fn traction<T: Scalar>(
        &self,
        at: &Fields<T, D>,
        _: &Fields<T, D>,
        normal: &Vector<T::Value, D>,
        weight: f64,
    ) -> Vector<T, D> {
        let Kinematics { F_inv, J, .. } = Kinematics::of(&at.grad_u);
        let F_inv_t = F_inv.t();
        let n = F_inv_t * normal.map(T::lift);
        let trace = F_inv_t.ddot(at.grad_v);
        let traction = -weight * self.viscosity * (F_inv_t * (at.grad_v.t() * n) - n * trace) * J;
        let Some(law) = self.thinning else { return traction };
        let grad_v = at.grad_v * F_inv;
        traction * law.factor(&(grad_v + grad_v.t()))
    }
}

/// Directional do-nothing term −⟨½ ρ min(0, (v − ∂_t u)·J F⁻ᵀ n) v, φ⟩ on the outflow boundary: the condition becomes
/// `ρν ∇v n − p n = ½ ρ min(0, (v − ∂_t u)·n) v` in the current domain (Braack and Mucha 2014).
///
/// The term vanishes where the flow leaves. Where the flow comes in, ½ ρ ((v − ∂_t u)·n) |v|² of kinetic energy comes
/// in through the boundary, which nothing bounds; the term takes exactly this energy away.
///
/// Its tangential part has t = v − n (n·v) in place of the last v, n the unit normal of the boundary in motion. It takes
/// ½ ρ ((v − ∂_t u)·n) |t|² away, and leaves flow alone that comes straight in.
#[derive(Copy, Clone, Debug)]
pub struct Backflow {
    /// ρ_f \[kg/m³\].
    pub density: f64,
    /// Whether it is the tangential part alone.
    pub tangential: bool,
}

impl<const D: usize> FacetForm<D> for Backflow {
    /// `u` holds ∂_t u. Normal and flow through the boundary are those of `lag`, the v that it carries that of `at`.
    #[inline(always)]
    fn traction<T: Scalar>(
        &self,
        at: &Fields<T, D>,
        lag: &Fields<T, D>,
        normal: &Vector<T::Value, D>,
        weight: f64,
    ) -> Vector<T, D> {
        let n = cofactor(&lag.grad_u) * normal.map(T::lift);
        let flow = (lag.v - lag.u).dot(n);
        let carried = if self.tangential { at.v - n * (n.dot(at.v) / n.dot(n)) } else { at.v };
        carried * (flow * flow.below_zero() * (-0.5 * weight * self.density))
    }
}
