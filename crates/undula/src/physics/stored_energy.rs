//! Materials of other programs: the stored energy is written, stress and tangent follow by dual numbers.

use super::kinematics::volume_change;
use super::law::{self, Law};
use crate::math::{HyperDual, Scalar, Tensor, Vector};
use std::fmt;

/// A hyperelastic law by its stored energy W per reference volume \[J/m³\].
///
/// The stress P = ∂W/∂F = F Σ and its derivative follow from it. W must vanish at rest together with its first
/// derivative. In two dimensions the law means plane strain, see [`Deformation`].
///
/// ```
/// use undula::{Deformation, Material, Scalar, StoredEnergy, Tensor};
///
/// /// W = ½ μ (I₁ − 3) − μ ln J + ½ λ (ln J)².
/// struct Rubber { mu: f64, lambda: f64 }
///
/// impl StoredEnergy for Rubber {
///     fn energy<T: Scalar, const D: usize>(&self, at: &Deformation<T, D>) -> T {
///         let ln_J = at.J().ln();
///         at.I1_minus_3() * (0.5 * self.mu) - ln_J * self.mu + ln_J * ln_J * (0.5 * self.lambda)
///     }
/// }
///
/// let material = Material::own(Rubber { mu: 2e6, lambda: 8e6 });
/// let grad_u = Tensor([[0.0, 1e-6], [0.0, 0.0]]);
/// let P = material.stress(&grad_u); // a small shear: P₁₂ = μ γ
/// assert!((P.0[0][1] - 2.0).abs() < 1e-6 && P.0[0][0].abs() < 1e-5);
/// ```
pub trait StoredEnergy: Send + Sync {
    /// W \[J/m³\] at a deformation; written once for every kind of number.
    fn energy<T: Scalar, const D: usize>(&self, at: &Deformation<T, D>) -> T;
}

/// What a stored energy may depend on, from ∇u at a point.
///
/// In two dimensions F is extended by 1 in the third direction (plane strain), so that the invariants are those of
/// three dimensions.
#[derive(Copy, Clone, Debug)]
pub struct Deformation<T, const D: usize> {
    /// ∇u, `(∇u)_ij = ∂u_i/∂x_j`.
    pub grad_u: Tensor<T, D>,
    /// Direction of the fibres at the point, a unit vector; 0 where a case gives none by `solid.fibre-direction`.
    pub fibre: [f64; D],
}

impl<T: Scalar, const D: usize> Deformation<T, D> {
    /// Deformation gradient F = I + ∇u.
    pub fn F(&self) -> Tensor<T, D> {
        Tensor::identity() + self.grad_u
    }

    /// Green-Lagrange strain E = ½ (∇u + ∇uᵀ + ∇uᵀ ∇u), without cancellation at small strains.
    pub fn E(&self) -> Tensor<T, D> {
        0.5 * (self.grad_u + self.grad_u.t() + self.grad_u.t() * self.grad_u)
    }

    /// J = det F.
    pub fn J(&self) -> T {
        self.F().det()
    }

    /// J − 1 without cancellation at small strains.
    pub fn J_minus_1(&self) -> T {
        volume_change(&self.grad_u, &self.grad_u)
    }

    /// I₁ − 3 = 2 tr E, without cancellation at small strains; I₁ = tr C, C = FᵀF.
    pub fn I1_minus_3(&self) -> T {
        self.E().trace() * 2.0
    }

    /// I₂ − 3 = 4 tr E + 2 ((tr E)² − E:E), without cancellation at small strains; I₂ = ½ (I₁² − C:C).
    pub fn I2_minus_3(&self) -> T {
        let E = self.E();
        let trace = E.trace();
        trace * 4.0 + (trace * trace - E.ddot(E)) * 2.0
    }
}

/// Components of ∇u as hyper-dual numbers: the second direction is that of the pairs, the first one moves component
/// `moved`.
fn seeded<const D: usize>(
    fibre: &[f64],
    grad_u: &[[f64; 2]],
    moved: Option<usize>,
) -> Deformation<HyperDual, D> {
    let mut at = Deformation { grad_u: Tensor::zero(), fibre: std::array::from_fn(|i| fibre[i]) };
    for (n, &[re, b]) in grad_u.iter().enumerate() {
        let a = if moved == Some(n) { 1.0 } else { 0.0 };
        at.grad_u.0[n / D][n % D] = HyperDual { re, a, b, ab: 0.0 };
    }
    at
}

/// W and its derivatives, component `moved` of ∇u moving in the first direction.
fn evaluate(law: &impl StoredEnergy, fibre: &[f64], grad_u: &[[f64; 2]], moved: Option<usize>) -> HyperDual {
    match grad_u.len() {
        4 => law.energy(&seeded::<2>(fibre, grad_u, moved)),
        9 => law.energy(&seeded::<3>(fibre, grad_u, moved)),
        _ => law.energy(&seeded::<1>(fibre, grad_u, moved)),
    }
}

impl<E: StoredEnergy> Law for E {
    fn energy_at(&self, fibre: &[f64], grad_u: &[[f64; 2]]) -> [f64; 2] {
        let W = evaluate(self, fibre, grad_u, None);
        [W.re, W.b]
    }

    fn stress_at(&self, fibre: &[f64], grad_u: &[[f64; 2]], stress: &mut [[f64; 2]]) {
        for (n, component) in stress.iter_mut().enumerate() {
            let W = evaluate(self, fibre, grad_u, Some(n));
            *component = [W.a, W.ab];
        }
    }
}

/// A law of another program. It is kept until the program ends, because every copy of the equations refers to it.
#[derive(Copy, Clone)]
pub struct OwnLaw(&'static dyn Law);

impl fmt::Debug for OwnLaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("OwnLaw")
    }
}

/// Whether they are one object.
impl PartialEq for OwnLaw {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::addr_eq(self.0, other.0)
    }
}

impl OwnLaw {
    /// The law with the stored energy `energy`.
    pub fn new(energy: impl StoredEnergy + 'static) -> Self {
        OwnLaw(Box::leak(Box::new(energy)))
    }

    /// W at ∇u.
    #[inline(always)]
    pub(super) fn energy<T: Scalar, const D: usize>(
        self,
        fibre: &Vector<T::Value, D>,
        grad_u: &Tensor<T, D>,
    ) -> T {
        law::energy(self.0, fibre, grad_u)
    }

    /// P at ∇u, with its derivative if `T` has one.
    #[inline(always)]
    pub(super) fn stress<T: Scalar, const D: usize>(
        self,
        fibre: &Vector<T::Value, D>,
        grad_u: &Tensor<T, D>,
    ) -> Tensor<T, D> {
        law::stress(self.0, fibre, grad_u)
    }

    /// Derivative of P at ∇u in the direction ∇w.
    #[inline(always)]
    pub(super) fn derivative<T: Scalar, const D: usize>(
        self,
        fibre: &Vector<T::Value, D>,
        grad_u: &Tensor<T, D>,
        grad_w: &Tensor<T, D>,
    ) -> Tensor<T, D> {
        law::derivative(self.0, fibre, grad_u, grad_w)
    }

    /// Lamé constants μ and λ at rest \[Pa\], and the largest component of the stress there \[Pa\].
    pub fn at_rest(self) -> [f64; 3] {
        let (none, rest) = (Vector::zero(), Tensor::<f64, 2>::zero());
        let (mut stretch, mut shear) = (rest, rest);
        stretch.0[0][0] = 1.0;
        shear.0[0][1] = 1.0;
        let (of_stretch, of_shear) =
            (self.derivative(&none, &rest, &stretch), self.derivative(&none, &rest, &shear));
        let stress =
            self.stress(&none, &rest).0.as_flattened().iter().fold(0.0, |most, x| f64::max(most, x.abs()));
        [of_shear.0[0][1], of_stretch.0[1][1], stress]
    }
}
