//! Constitutive laws of the solid.
//!
//! Every law but the linear one is hyperelastic: P = F Σ = ∂W/∂F with the stored energy W per reference
//! volume. In two dimensions all of them mean plane strain: F is extended by 1 in the third direction, so
//! that I₁ = tr C + 1, I₂ = ½ (I₁² − C:C − 1) and J are those of the extended one.

use super::fibres::{Artery, Muscle};
use super::isochoric::IsochoricNeoHookean;
use super::kinematics::{Kinematics, volume_change};
use super::law;
use super::ogden::Ogden;
use super::stored_energy::{Deformation, OwnLaw, StoredEnergy};
use crate::math::{Scalar, Tensor, Vector};

/// Stress as a function of the deformation. At rest compressible laws agree with Hooke's law of the same
/// μ and λ.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Material {
    /// Hooke's law P = 2 μ ε + λ tr(ε) I, ε = ½ (∇u + ∇uᵀ): small strains and rotations only.
    Linear {
        /// Shear modulus \[Pa\].
        mu: f64,
        /// First Lamé parameter \[Pa\].
        lambda: f64,
    },
    /// Σ = 2 μ E + λ tr(E) I, E = ½ (FᵀF − I), (5.6).
    StVenantKirchhoff {
        /// Shear modulus \[Pa\].
        mu: f64,
        /// First Lamé parameter \[Pa\].
        lambda: f64,
    },
    /// W = ½ μ (I₁ − 3) − μ ln J + ½ λ (J − 1)², Σ = μ (I − C⁻¹) + λ (J − 1) J C⁻¹. Polyconvex.
    NeoHookean {
        /// Shear modulus \[Pa\].
        mu: f64,
        /// First Lamé parameter \[Pa\].
        lambda: f64,
    },
    /// W = ½ μ (J^(−2/3) I₁ − 3) + ¼ κ (J² − 1 − 2 ln J), κ = λ + ⅔ μ.
    Isochoric(IsochoricNeoHookean),
    /// W = c₁ (I₁ − 3) + c₂ (I₂ − 3) − 2 (c₁ + 2 c₂) ln J + ½ (λ − 4 c₂) (J − 1)²; μ = 2 (c₁ + c₂).
    /// Polyconvex for c₁, c₂ ≥ 0 and λ ≥ 4 c₂.
    MooneyRivlin {
        /// Half of the shear modulus that goes with I₁ \[Pa\].
        c1: f64,
        /// Half of the shear modulus that goes with I₂ \[Pa\].
        c2: f64,
        /// First Lamé parameter at rest \[Pa\].
        lambda: f64,
    },
    /// Mooney-Rivlin with J = 1 and its own pressure p; neo-Hookean with c₂ = 0:
    /// W = c₁ (I₁ − 3) + c₂ (I₂ − 3) − 2 (c₁ + 2 c₂) ln J − p (J − 1), so that p = 0 at rest and, with c₂ = 0, the
    /// Cauchy stress is −p I + μ (F Fᵀ − I).
    ///
    /// Where J = 1 the logarithm is nothing but a shift of p. With J − 1 in its place a dilatation would meet no
    /// resistance at rest and less than none under p > 0; those that a continuous pressure does not see would
    /// grow (Auricchio, Beirão da Veiga, Lovadina, Reali 2005 on such instabilities).
    ///
    /// With a finite λ the constraint is J − 1 + p/κ' = 0, κ' = λ − 4 c₂, as if ½ κ' (J − 1)² were added to W: the
    /// compressible law in mixed form.
    Incompressible {
        /// Half of the shear modulus that goes with I₁ \[Pa\].
        c1: f64,
        /// Half of the shear modulus that goes with I₂ \[Pa\].
        c2: f64,
        /// 1/κ' \[1/Pa\]; 0 for J = 1.
        compliance: f64,
    },
    /// W = Σ_p [μ_p/α_p (λ₁^α_p + λ₂^α_p + λ₃^α_p − 3) − μ_p ln J] + ½ λ (J − 1)², or with J = 1.
    Ogden(Ogden),
    /// A matrix with two families of fibres, after Holzapfel, Gasser and Ogden.
    Artery(Artery),
    /// Muscle after Guccione, with J = 1.
    Muscle(Muscle),
    /// A stored energy of another program, see [`Material::own`].
    Own(OwnLaw),
}

// Functions, not closures: a closure that is called twice is compiled apart, for the baseline processor.

/// Hooke's law, 2 μ E + λ tr(E) I.
#[inline(always)]
fn hooke<T: Scalar, const D: usize>(E: Tensor<T, D>, mu: f64, lambda: f64) -> Tensor<T, D> {
    2.0 * mu * E + Tensor::identity() * (E.trace() * lambda)
}

/// tr(E) I − E.
#[inline(always)]
fn cross<T: Scalar, const D: usize>(E: Tensor<T, D>) -> Tensor<T, D> {
    Tensor::identity() * E.trace() - E
}

/// c₁, c₂ and what stands before J⁻ᵀ: the laws of rubber are
/// P = 2 (c₁ + 2 c₂)(F − F⁻ᵀ) + 4 c₂ F (tr(E) I − E) + h (J − 1) F⁻ᵀ.
struct Rubber<T> {
    /// 2 (c₁ + 2 c₂) \[Pa\].
    shear: f64,
    /// 4 c₂ \[Pa\].
    second: f64,
    /// h \[Pa\].
    volume: T,
    /// Derivative of h (J − 1) with respect to J.
    slope: T,
}

/// The built-in laws by their energies; of a law with a pressure of its own that of the deformation alone.
impl StoredEnergy for Material {
    fn energy<T: Scalar, const D: usize>(&self, at: &Deformation<T, D>) -> T {
        Material::energy_at(self, &Vector(at.fibre.map(Scalar::constant)), &at.grad_u)
    }
}

impl Material {
    /// The incompressible law; with a finite `lambda` \[Pa\] above 4 c₂ only nearly so, and Hooke's law of
    /// μ = 2 (c₁ + c₂) and `lambda` at rest.
    pub fn incompressible(c1: f64, c2: f64, lambda: f64) -> Material {
        Material::Incompressible { c1, c2, compliance: 1.0 / (lambda - 4.0 * c2) }
    }

    /// The law of Ogden with the `terms` μ_p \[Pa\], α_p, at most three, and the first Lamé parameter `lambda` \[Pa\] at
    /// rest; with a pressure of its own if `incompressible`, exactly so if `lambda` is infinite.
    pub fn ogden(terms: &[[f64; 2]], lambda: f64, incompressible: bool) -> Material {
        let mut all = [[0.0, 1.0]; 3];
        all[..terms.len()].copy_from_slice(terms);
        let (lambda, compliance) = if incompressible { (0.0, Some(1.0 / lambda)) } else { (lambda, None) };
        Material::Ogden(Ogden { terms: all, lambda, compliance })
    }

    /// The law with the stored energy `energy`, see [`StoredEnergy`]. It is kept until the program ends.
    pub fn own(energy: impl StoredEnergy + 'static) -> Material {
        Material::Own(OwnLaw::new(energy))
    }

    /// First Piola-Kirchhoff stress P = F Σ \[Pa\] at ∇u.
    ///
    /// ```
    /// use undula::{Material, Tensor};
    /// let hooke = Material::Linear { mu: 2.0, lambda: 1.0 };
    /// let grad_u = Tensor([[0.5, 0.0], [0.0, 0.0]]);
    /// assert_eq!(hooke.stress(&grad_u).0, [[2.5, 0.0], [0.0, 0.5]]);
    /// assert_eq!(hooke.tangent(&Tensor::zero(), &grad_u), hooke.stress(&grad_u));
    /// ```
    pub fn stress<const D: usize>(&self, grad_u: &Tensor<f64, D>) -> Tensor<f64, D> {
        self.piola(grad_u, grad_u)
    }

    /// Derivative \[Pa\] of the stress P at ∇u in the direction ∇w.
    pub fn tangent<const D: usize>(
        &self,
        grad_u: &Tensor<f64, D>,
        grad_w: &Tensor<f64, D>,
    ) -> Tensor<f64, D> {
        self.derivative(grad_u, grad_w)
    }

    /// 1/κ' of a law with a pressure of its own; `None` for the others.
    pub fn compliance(&self) -> Option<f64> {
        match *self {
            Material::Incompressible { compliance, .. } => Some(compliance),
            Material::Ogden(Ogden { compliance, .. }) | Material::Artery(Artery { compliance, .. }) => {
                compliance
            }
            Material::Muscle(Muscle { compliance, .. }) => Some(compliance),
            _ => None,
        }
    }

    /// Whether the law has no meaning where J ≤ 0.
    pub fn needs_positive_volume(&self) -> bool {
        !matches!(self, Material::Linear { .. } | Material::StVenantKirchhoff { .. })
    }

    #[inline(always)]
    fn rubber<T: Scalar>(&self, J: T) -> Option<Rubber<T>> {
        let (c1, c2, lambda) = match *self {
            Material::Linear { .. }
            | Material::StVenantKirchhoff { .. }
            | Material::Isochoric(_)
            | Material::Ogden(_)
            | Material::Artery(_)
            | Material::Muscle(_)
            | Material::Own(_) => return None,
            Material::NeoHookean { mu, lambda } => (0.5 * mu, 0.0, lambda),
            Material::MooneyRivlin { c1, c2, lambda } => (c1, c2, lambda),
            Material::Incompressible { c1, c2, .. } => (c1, c2, 4.0 * c2),
        };
        Some(Rubber {
            shear: 2.0 * (c1 + 2.0 * c2),
            second: 4.0 * c2,
            volume: J * (lambda - 4.0 * c2),
            slope: (J + J - T::one()) * (lambda - 4.0 * c2),
        })
    }

    /// First Piola-Kirchhoff stress P = F Σ at ∇u, without −p J F⁻ᵀ of an incompressible law, in the form that
    /// a fixed-point iteration needs: linear in ∇u, with the rest kept in `lag`.
    ///
    /// That is E = ½ (∇u + ∇uᵀ + ∇u_lagᵀ ∇u) and, for the laws of rubber, F − F⁻ᵀ = 2 F_lag⁻ᵀ E and J − 1 as in
    /// [`volume_change`]. At rest the matrix of the iteration is that of Hooke's law, so that it converges
    /// for small strains, and what it converges to is the law.
    ///
    /// Erratum: section 5.2.1 prints ½ ∇u^(l−1) ∇u^(l)ᵀ, whose limit is ½ (F Fᵀ − I), another equation.
    #[inline(always)]
    pub fn piola<T: Scalar, const D: usize>(
        &self,
        grad_u: &Tensor<T, D>,
        lag: &Tensor<T, D>,
    ) -> Tensor<T, D> {
        self.piola_at(&Vector::zero(), grad_u, lag)
    }

    /// [`Material::piola`] where the fibres have the direction `fibre`; 0: that of the law.
    #[inline(always)]
    pub fn piola_at<T: Scalar, const D: usize>(
        &self,
        fibre: &Vector<T::Value, D>,
        grad_u: &Tensor<T, D>,
        lag: &Tensor<T, D>,
    ) -> Tensor<T, D> {
        if let Material::Linear { mu, lambda } = *self {
            return hooke(0.5 * (*grad_u + grad_u.t()), mu, lambda);
        }
        let E = 0.5 * (*grad_u + grad_u.t() + lag.t() * *grad_u);
        if let Material::StVenantKirchhoff { mu, lambda } = *self {
            return (Tensor::identity() + *lag) * hooke(E, mu, lambda);
        }
        let Kinematics { F, F_inv, J } = Kinematics::of(lag);
        let Some(Rubber { shear, second, volume, .. }) = self.rubber(J) else {
            return self.piola_by_number(fibre, grad_u);
        };
        let change = volume * volume_change(grad_u, lag);
        let mut P = F_inv.t() * (2.0 * shear * E + Tensor::identity() * change);
        if second != 0.0 {
            P += second * (F * cross(E));
        }
        P
    }

    /// The stress of a law that is evaluated number by number; a fixed-point iteration takes its whole derivative.
    #[inline(always)]
    fn piola_by_number<T: Scalar, const D: usize>(
        &self,
        fibre: &Vector<T::Value, D>,
        grad_u: &Tensor<T, D>,
    ) -> Tensor<T, D> {
        match self {
            Material::Own(law) => law.stress(fibre, grad_u),
            Material::Isochoric(law) => law::stress(law, fibre, grad_u),
            Material::Ogden(law) => law::stress(law, fibre, grad_u),
            Material::Artery(law) => law::stress(law, fibre, grad_u),
            Material::Muscle(law) => law::stress(law, fibre, grad_u),
            _ => Tensor::zero(),
        }
    }

    /// Its derivative.
    #[inline(always)]
    fn derivative_by_number<T: Scalar, const D: usize>(
        &self,
        fibre: &Vector<T::Value, D>,
        grad_u: &Tensor<T, D>,
        grad_w: &Tensor<T, D>,
    ) -> Tensor<T, D> {
        match self {
            Material::Own(law) => law.derivative(fibre, grad_u, grad_w),
            Material::Isochoric(law) => law::derivative(law, fibre, grad_u, grad_w),
            Material::Ogden(law) => law::derivative(law, fibre, grad_u, grad_w),
            Material::Artery(law) => law::derivative(law, fibre, grad_u, grad_w),
            Material::Muscle(law) => law::derivative(law, fibre, grad_u, grad_w),
            _ => Tensor::zero(),
        }
    }

    /// Derivative of [`Material::piola`] at ∇u in the direction ∇w by hand, Lemma 5.5.
    #[inline(always)]
    pub fn derivative<T: Scalar, const D: usize>(
        &self,
        grad_u: &Tensor<T, D>,
        grad_w: &Tensor<T, D>,
    ) -> Tensor<T, D> {
        self.derivative_at(&Vector::zero(), grad_u, grad_w)
    }

    /// [`Material::derivative`] where the fibres have the direction `fibre`; 0: that of the law.
    #[inline(always)]
    pub fn derivative_at<T: Scalar, const D: usize>(
        &self,
        fibre: &Vector<T::Value, D>,
        grad_u: &Tensor<T, D>,
        grad_w: &Tensor<T, D>,
    ) -> Tensor<T, D> {
        if let Material::Linear { .. } = self {
            return self.piola(grad_w, grad_w);
        }
        let Kinematics { F, F_inv, J } = Kinematics::of(grad_u);
        let E = 0.5 * (*grad_u + grad_u.t() + grad_u.t() * *grad_u);
        let dE = 0.5 * (grad_w.t() * F + F.t() * *grad_w);
        if let Material::StVenantKirchhoff { mu, lambda } = *self {
            return *grad_w * hooke(E, mu, lambda) + F * hooke(dE, mu, lambda);
        }
        let Some(Rubber { shear, second, volume, slope }) = self.rubber(J) else {
            return self.derivative_by_number(fibre, grad_u, grad_w);
        };
        let F_inv_t = F_inv.t();
        let turned = F_inv_t * grad_w.t() * F_inv_t;
        shear * (*grad_w + turned)
            + second * (*grad_w * cross(E) + F * cross(dE))
            + F_inv_t * (slope * J * (F_inv * *grad_w).trace())
            - turned * (volume * volume_change(grad_u, grad_u))
    }

    /// Stored energy W per reference volume \[J/m³\]; of a law with J = 1 that of the deformation alone.
    pub fn energy<T: Scalar, const D: usize>(&self, grad_u: &Tensor<T, D>) -> T {
        self.energy_at(&Vector::zero(), grad_u)
    }

    /// [`Material::energy`] where the fibres have the direction `fibre`; 0: that of the law.
    pub fn energy_at<T: Scalar, const D: usize>(
        &self,
        fibre: &Vector<T::Value, D>,
        grad_u: &Tensor<T, D>,
    ) -> T {
        let of_hooke =
            |E: Tensor<T, D>, mu: f64, lambda: f64| E.ddot(E) * mu + E.trace() * E.trace() * (0.5 * lambda);
        let E = 0.5 * (*grad_u + grad_u.t() + grad_u.t() * *grad_u);
        let J = (Tensor::identity() + *grad_u).det();
        let change = volume_change(grad_u, grad_u);
        let squared = |c1: f64, c2: f64| {
            E.trace() * (2.0 * c1 + 4.0 * c2) + (E.trace() * E.trace() - E.ddot(E)) * (2.0 * c2)
        };
        let compressible = |c1: f64, c2: f64, lambda: f64| {
            squared(c1, c2) - J.ln() * (2.0 * (c1 + 2.0 * c2)) + change * change * (0.5 * (lambda - 4.0 * c2))
        };
        let bulk = |compliance: Option<f64>| {
            let modulus = compliance.filter(|c| *c > 0.0).map_or(0.0, |c| 1.0 / c);
            change * change * (0.5 * modulus)
        };
        match *self {
            Material::Linear { mu, lambda } => of_hooke(0.5 * (*grad_u + grad_u.t()), mu, lambda),
            Material::StVenantKirchhoff { mu, lambda } => of_hooke(E, mu, lambda),
            Material::NeoHookean { mu, lambda } => compressible(0.5 * mu, 0.0, lambda),
            Material::MooneyRivlin { c1, c2, lambda } => compressible(c1, c2, lambda),
            Material::Incompressible { c1, c2, compliance } => {
                let bulk = if compliance > 0.0 { 1.0 / compliance } else { 0.0 };
                compressible(c1, c2, bulk + 4.0 * c2)
            }
            Material::Isochoric(law) => law::energy(&law, fibre, grad_u),
            Material::Ogden(law) => law::energy(&law, fibre, grad_u),
            Material::Artery(law) => law::energy(&law, fibre, grad_u) + bulk(law.compliance),
            Material::Muscle(law) => law::energy(&law, fibre, grad_u) + bulk(Some(law.compliance)),
            Material::Own(law) => law.energy(fibre, grad_u),
        }
    }
}
