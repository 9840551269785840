//! The ALE map: how the deformation of the solid is extended into the fluid, section 5.3.5.

use super::Kinematics;
use crate::choice::{Choice, choice};
use crate::math::{Scalar, Tensor, erf};

/// Operator of the extension; stiffening E_e(x) is a number at the point.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Extension {
    /// (E_e ∇u, ∇ψ), (5.37); harmonic with E_e = 1, stiffened with E_e = α(x).
    Harmonic,
    /// (μ_e (∇u + ∇uᵀ) + λ_e div u I, ∇ψ), μ_e = E_e / (2 (1 + ν_e)), λ_e = ν_e E_e / ((1 + ν_e)(1 − 2 ν_e)).
    PseudoElastic {
        /// Poisson ratio ν_e in (−1, ½); negative values are auxetic.
        poisson: f64,
    },
    /// The same with E_e (J + 1/J) in place of E_e: stiffer where cells have been stretched or squeezed.
    ///
    /// Erratum: section 5.3.5.3 prints E_e := E_e (J_e + 1/J_e), which has no solution E_e but 0; meant is the
    /// stiffness E_e(x) of the reference domain on the right.
    JacobianStiffened {
        /// Poisson ratio ν_e in (−1, ½).
        poisson: f64,
        /// J of the old time, which keeps the extension linear; else that of the solution itself.
        lagged: bool,
    },
    /// −Δu = w, −Δw = 0: a constant operator that assembly makes once for all, nothing at the points.
    Biharmonic {
        /// w = 0 on the outer boundary instead of ∂_n u = 0.
        hinged: bool,
    },
}

/// Model of the mesh motion: the operator of the extension and its stiffening.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum MotionModel {
    /// (∇u, ∇ψ), never stiffened.
    Harmonic,
    /// (α ∇u, ∇ψ) with α = 2 − erf(5 d/L).
    StiffenedHarmonic,
    /// (E_e (∇u + ∇uᵀ)/(2(1+ν_e)) + …, ∇ψ) with E_e stiffened near the interface.
    PseudoElastic,
    /// The same with E_e (J + 1/J).
    JacobianStiffened,
    /// −Δu = w, −Δw = 0.
    Biharmonic,
}

/// Their names in a case.
pub static MOTIONS: [Choice<MotionModel>; 5] = [
    choice("harmonic", MotionModel::Harmonic, "−Δu = 0"),
    choice(
        "stiffened-harmonic",
        MotionModel::StiffenedHarmonic,
        "−div(α ∇u) = 0, α = 2 − erf(5 d/scale), d the distance to the interface",
    ),
    choice(
        "pseudo-elastic",
        MotionModel::PseudoElastic,
        "linear elasticity, stiffened by (offset + d)^−exponent",
    ),
    choice(
        "jacobian-stiffened",
        MotionModel::JacobianStiffened,
        "pseudo-elastic, stiffened by J + 1/J as well",
    ),
    choice("biharmonic", MotionModel::Biharmonic, "Δ²u = 0 in mixed form; velocities of degree 2 or higher"),
];

/// Whether J of the stiffening by J + 1/J is that of the last step, by the names in a case.
pub static STIFFENING: [Choice<bool>; 2] =
    [choice("lagged", true, "J of the last step"), choice("implicit", false, "J of the solution itself")];

/// Whether w = 0 holds on the outer boundary, by the names in a case.
pub static OUTER: [Choice<bool>; 2] = [
    choice("clamped", false, "∂u/∂n = 0 on the outer boundary"),
    choice("hinged", true, "Δu = 0 on the outer boundary"),
];

/// The numbers that a model takes.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct MotionNumbers {
    /// Poisson ratio ν_e.
    pub poisson: f64,
    /// J of the stiffening by J + 1/J is that of the last step.
    pub lagged: bool,
    /// w = 0 instead of ∂_n u = 0 on the outer boundary.
    pub hinged: bool,
    /// d_0 \[m\].
    pub offset: f64,
    /// m of (d_0 + d)^−m.
    pub exponent: f64,
    /// L \[m\].
    pub scale: f64,
}

impl MotionModel {
    /// The operator.
    pub fn extension(self, with: &MotionNumbers) -> Extension {
        let &MotionNumbers { poisson, lagged, hinged, .. } = with;
        match self {
            MotionModel::Harmonic | MotionModel::StiffenedHarmonic => Extension::Harmonic,
            MotionModel::PseudoElastic => Extension::PseudoElastic { poisson },
            MotionModel::JacobianStiffened => Extension::JacobianStiffened { poisson, lagged },
            MotionModel::Biharmonic => Extension::Biharmonic { hinged },
        }
    }

    /// E_e at the distance d \[m\] to the interface: (d_0 + d)^−m of the elastic models, α = 2 − erf(5 d/L) of the
    /// stiffened harmonic one, 1 of the others.
    pub fn stiffness_at(self, with: &MotionNumbers, d: f64) -> f64 {
        match self {
            MotionModel::Harmonic | MotionModel::Biharmonic => 1.0,
            MotionModel::StiffenedHarmonic => 2.0 - erf(5.0 * d / with.scale),
            MotionModel::PseudoElastic | MotionModel::JacobianStiffened => {
                (with.offset + d).powf(-with.exponent)
            }
        }
    }

    /// Whether E_e depends on the distance to the interface.
    pub fn is_stiffened(self, with: &MotionNumbers) -> bool {
        match self {
            MotionModel::Harmonic | MotionModel::Biharmonic => false,
            MotionModel::StiffenedHarmonic => true,
            MotionModel::PseudoElastic | MotionModel::JacobianStiffened => with.exponent != 0.0,
        }
    }
}

impl Extension {
    /// Whether its operator is the same at all times.
    pub fn is_constant(&self) -> bool {
        !matches!(self, Extension::JacobianStiffened { .. })
    }

    /// E_e in a step that begins with the deformation gradient `old` = ∇u⁻.
    #[inline(always)]
    pub fn stiffness<S: Scalar, const D: usize>(&self, stiffness: S, old: &Tensor<S, D>) -> S {
        match *self {
            Extension::JacobianStiffened { lagged: true, .. } => stiffness * stretch(old),
            _ => stiffness,
        }
    }

    /// What stands before ∇ψ; `stiffness` is that of [`Extension::stiffness`].
    #[inline(always)]
    pub fn stress<T: Scalar, const D: usize>(&self, grad_u: &Tensor<T, D>, stiffness: T) -> Tensor<T, D> {
        match *self {
            Extension::Biharmonic { .. } => Tensor::zero(),
            Extension::Harmonic => *grad_u * stiffness,
            Extension::PseudoElastic { poisson } => elastic(poisson, grad_u) * stiffness,
            Extension::JacobianStiffened { poisson, lagged: true } => elastic(poisson, grad_u) * stiffness,
            Extension::JacobianStiffened { poisson, lagged: false } => {
                elastic(poisson, grad_u) * (stiffness * stretch(grad_u))
            }
        }
    }

    /// The derivative of [`Extension::stress`] in direction ∇w: by d(J + 1/J) = (J − 1/J) tr(F⁻¹∇w).
    #[inline(always)]
    pub fn derivative<S: Scalar, const D: usize>(
        &self,
        grad_u: &Tensor<S, D>,
        grad_w: &Tensor<S, D>,
        stiffness: S,
    ) -> Tensor<S, D> {
        let Extension::JacobianStiffened { poisson, lagged: false } = *self else {
            return self.stress(grad_w, stiffness);
        };
        let Kinematics { F_inv, J, .. } = Kinematics::of(grad_u);
        let slope = (J - S::one() / J) * (F_inv * *grad_w).trace();
        elastic(poisson, grad_w) * (stiffness * stretch(grad_u))
            + elastic(poisson, grad_u) * (stiffness * slope)
    }
}

/// The stress of unit stiffness.
#[inline(always)]
fn elastic<T: Scalar, const D: usize>(poisson: f64, grad_u: &Tensor<T, D>) -> Tensor<T, D> {
    let mu = 0.5 / (1.0 + poisson);
    let lambda = poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    mu * (*grad_u + grad_u.t()) + lambda * (Tensor::identity() * grad_u.trace())
}

/// J + 1/J, least where volumes are kept.
#[inline(always)]
fn stretch<T: Scalar, const D: usize>(grad_u: &Tensor<T, D>) -> T {
    let J = (Tensor::identity() + *grad_u).det();
    J + T::one() / J
}
