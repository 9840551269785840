//! The contracts between an equation and everything else.

use super::{Dots, Fields, Place, StepRule, Tested};
use crate::math::{Scalar, Tensor, Vector};

/// What multiplies the time derivatives in the momentum equation: `mass ∂_t v − motion ∂_t u`.
///
/// In the fluid `mass = ρ_f J` and `motion = ρ_f G`, `G(u, v) = J ∇v F⁻¹` being the carrier of the
/// domain-motion term (5.4). The time scheme says at which times they are taken.
#[derive(Copy, Clone, Debug)]
pub struct Inertia<T, const D: usize> {
    /// Density on the reference domain \[kg/m³\].
    pub mass: T,
    /// Carrier of the domain motion \[kg/(m³ s)\].
    pub motion: Tensor<T, D>,
}

/// Which (test, trial) blocks of a form are not zero, and whether through values or gradients.
///
/// Sparsity and loops of assembly rest on it; a test compares it with the derivative itself.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Couplings {
    /// Momentum on velocity.
    pub phi_v: Block,
    /// Momentum on deformation.
    pub phi_u: Block,
    /// Momentum on pressure, and divergence on deformation.
    pub pressure: Block,
    /// Divergence on velocity.
    pub xi_v: Block,
    /// Divergence on pressure, through values.
    pub xi_p: bool,
    /// Extension or velocity-deformation relation on velocity.
    pub psi_v: Block,
    /// Extension or velocity-deformation relation on deformation.
    pub psi_u: Block,
}

/// One (test, trial) block at a point: which of value and gradient take part.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Block {
    /// Nothing.
    Zero,
    /// Values of test and trial function.
    Mass,
    /// Gradients of test and trial function.
    Stiffness,
    /// Everything.
    Full,
}

/// One set of equations, written once and generic over the number.
///
/// `at` is the state being linearised; `lag` is what a fixed-point iteration keeps from before.
/// Newton passes the same state twice, a fixed-point iteration passes `at.frozen()`: the residual is
/// the same either way, only the derivative differs.
pub trait WeakForm<const D: usize>: Sync {
    /// Blocks that are not zero.
    fn couplings(&self) -> Couplings;

    /// What multiplies the time derivatives, at one state.
    fn inertia<T: Scalar>(&self, at: &Fields<T, D>, lag: &Fields<T, D>) -> Inertia<T, D>;

    /// Terms with time derivatives.
    fn rate<T: Scalar>(&self, dots: &Dots<T, D>, inertia: &Inertia<T, D>, r: &mut Tested<T, D>);

    /// Terms that a θ-scheme weighs by θ and 1 − θ; `weight` multiplies them.
    fn transport<T: Scalar>(
        &self,
        place: &Place<T::Value, D>,
        at: &Fields<T, D>,
        lag: &Fields<T, D>,
        weight: f64,
        r: &mut Tested<T, D>,
    );

    /// The pressure `p` of the step; `cofactor` is J F⁻ᵀ weighted over the step.
    fn pressure<T: Scalar>(&self, p: T, cofactor: &Tensor<T, D>, r: &mut Tested<T, D>);

    /// What a step that begins with `old` sees at a place.
    #[inline(always)]
    fn place<S: Scalar<Value = S>>(&self, place: &Place<S, D>, _old: &Fields<S, D>) -> Place<S, D> {
        *place
    }

    /// Terms that hold at the new time alone.
    fn constraint<T: Scalar>(
        &self,
        place: &Place<T::Value, D>,
        at: &Fields<T, D>,
        lag: &Fields<T, D>,
        r: &mut Tested<T, D>,
    );

    /// What an equation says about the volume of the step; nothing unless it is incompressible without being
    /// a flow.
    #[inline(always)]
    fn volume<T: Scalar>(
        &self,
        _rule: &StepRule,
        _place: &Place<T::Value, D>,
        _new: &Fields<T, D>,
        _lag: &Fields<T, D>,
        _old: &Fields<T::Value, D>,
        _r: &mut Tested<T, D>,
    ) {
    }
}

/// A term on a boundary facet, weighed by θ and 1 − θ like transport.
///
/// `u` of the fields holds u, or ∂_t u \[m/s\] where the form says so.
pub trait FacetForm<const D: usize>: Sync {
    /// What stands before φ; `normal` is the outer unit normal n of the reference domain. A fixed-point iteration keeps
    /// the factors of `lag` from its last iterate, section 5.2.1; else `lag` is `at`.
    fn traction<T: Scalar>(
        &self,
        at: &Fields<T, D>,
        lag: &Fields<T, D>,
        normal: &Vector<T::Value, D>,
        weight: f64,
    ) -> Vector<T, D>;
}
