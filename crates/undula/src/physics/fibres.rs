//! Soft tissue with fibres: arteries after Holzapfel, Gasser and Ogden, heart muscle after Guccione.

use super::stored_energy::{Deformation, StoredEnergy};
use crate::math::{Scalar, Tensor, Vector};

/// `a` divided by its length; `None` without a direction: 0, or not finite.
///
/// ```
/// use undula::physics::fibres::unit;
/// assert_eq!(unit([3.0, -4.0]), Some([0.6, -0.8]));
/// assert_eq!(unit([0.0, 0.0]), None);
/// ```
pub fn unit<const D: usize>(a: [f64; D]) -> Option<[f64; D]> {
    let length = a.iter().fold(0.0, |length: f64, x| length.hypot(*x));
    (length > 0.0 && length.is_finite()).then(|| a.map(|x| x / length))
}

/// (cos φ, sin φ) as [`unit()`] gives it: a field of the same values is the same to the last bit.
pub fn at_angle(angle: f64) -> [f64; 2] {
    unit([angle.cos(), angle.sin()]).unwrap_or([1.0, 0.0])
}

/// The direction at a point, else that of the law, in the space of dimension `D`.
fn direction<const D: usize>(at: &[f64; D], own: [f64; 2]) -> [f64; D] {
    if at.iter().any(|x| *x != 0.0) { *at } else { std::array::from_fn(|i| own.get(i).map_or(0.0, |x| *x)) }
}

/// `a` turned in the plane by the angle of this cosine and sine.
fn turned<T: Scalar, const D: usize>(a: &[f64; D], [cos, sin]: [f64; 2]) -> Vector<T, D> {
    let y = if D > 1 { a[1] } else { 0.0 };
    let mut turned = Vector(a.map(T::constant));
    for (component, x) in turned.0.iter_mut().zip([cos * a[0] - sin * y, sin * a[0] + cos * y]) {
        *component = T::constant(x);
    }
    turned
}

/// a · E b.
fn component<T: Scalar, const D: usize>(a: Vector<T, D>, E: &Tensor<T, D>, b: Vector<T, D>) -> T {
    a.dot(*E * b)
}

/// W = ½ μ (I₁ − 3) − μ ln J + ½ λ (J − 1)² + Σ_i k₁/(2 k₂) (exp(k₂ ⟨E_i⟩²) − 1) over two families of fibres, with
/// E_i = κ (I₁ − 3) + (1 − 3 κ)(a_i · C a_i − 1) and ⟨E⟩ = max(E, 0): fibres bear tension only (Gasser, Ogden and
/// Holzapfel 2006). C is not split into volume and shape in the part of the fibres.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Artery {
    /// Shear modulus μ of the matrix \[Pa\].
    pub mu: f64,
    /// First Lamé parameter λ of the matrix \[Pa\]; 0 if the law has a pressure of its own.
    pub lambda: f64,
    /// 1/κ' \[1/Pa\] of a law with a pressure of its own, 0 for J = 1.
    pub compliance: Option<f64>,
    /// Stiffness k₁ \[Pa\] of the fibres.
    pub k1: f64,
    /// Exponent k₂, above 0.
    pub k2: f64,
    /// Dispersion κ, 0: all fibres along their family, ⅓: in all directions.
    pub dispersion: f64,
    /// Angles of both families in the plane \[rad\], counted from the direction at the point.
    pub angles: [f64; 2],
    /// The direction, a unit vector in the plane, where the point has none.
    pub direction: [f64; 2],
}

impl Artery {
    /// The matrix without fibres.
    pub fn matrix(mu: f64, lambda: f64, compliance: Option<f64>) -> Artery {
        let direction = [1.0, 0.0];
        Artery { mu, lambda, compliance, k1: 0.0, k2: 1.0, dispersion: 0.0, angles: [0.0; 2], direction }
    }
}

impl StoredEnergy for Artery {
    fn energy<T: Scalar, const D: usize>(&self, at: &Deformation<T, D>) -> T {
        let (E, first, change) = (at.E(), at.I1_minus_3(), at.J_minus_1());
        let mut W = first * (0.5 * self.mu) - at.J().ln() * self.mu + change * change * (0.5 * self.lambda);
        let middle = direction(&at.fibre, self.direction);
        for angle in self.angles {
            let a = turned(&middle, [angle.cos(), angle.sin()]);
            let stretch = component(a, &E, a) * (2.0 * (1.0 - 3.0 * self.dispersion));
            let strain = first * self.dispersion + stretch;
            let tension = strain * (T::one() - strain.below_zero());
            W += ((tension * tension * self.k2).exp() - T::one()) * (0.5 * self.k1 / self.k2);
        }
        W
    }
}

/// W = ½ C (exp Q − 1) with J = 1, Q = b_f E_ff² + b_t (E_tt² + E_nn² + 2 E_tn²) + 2 b_fs (E_ft² + E_fn²): f along the
/// fibres, t and n across them (Guccione, McCulloch and Waldman 1991). All directions across the fibres are equal: that of
/// the sheets does not matter, so that |E f|² and E : E say all.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Muscle {
    /// C \[Pa\].
    pub stiffness: f64,
    /// b_f, b_t and b_fs.
    pub exponents: [f64; 3],
    /// 1/κ \[1/Pa\], 0 for J = 1.
    pub compliance: f64,
    /// Direction of the fibres, a unit vector in the plane, where the point has none.
    pub direction: [f64; 2],
}

impl StoredEnergy for Muscle {
    fn energy<T: Scalar, const D: usize>(&self, at: &Deformation<T, D>) -> T {
        let E = at.E();
        let f = Vector(direction(&at.fibre, self.direction).map(T::constant));
        // Sums over all directions: E_ff² + E_ft² + E_fn², and those of all components.
        let (row, stretch) = (E * f, f.dot(E * f));
        let (in_row, in_all, square) = (row.dot(row), E.ddot(E), stretch * stretch);
        let [along, across, shear] = self.exponents;
        let Q =
            square * along + (in_all - in_row * 2.0 + square) * across + (in_row - square) * (2.0 * shear);
        (Q.exp() - T::one()) * (0.5 * self.stiffness)
    }
}
