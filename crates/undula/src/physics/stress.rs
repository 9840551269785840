//! Cauchy stress of either body, and the scalars that are made of it.
//!
//! In the plane both bodies are in plane strain: ∇u and ∇v are zero along the third direction, σ_zz is not.

use super::kinematics::cofactor;
use super::{Fabric, Fields, Fluid, Kinematics, Solid};
use crate::math::{Tensor, Vector};

impl Fluid {
    /// σ = ρ ν (∇v F⁻¹ + F⁻ᵀ ∇vᵀ) − p I \[Pa\], with σ_zz = −p in the plane.
    pub fn cauchy<const D: usize>(&self, at: &Fields<f64, D>) -> Tensor<f64, 3> {
        let Kinematics { F_inv, .. } = Kinematics::of(&in_space(&at.grad_u));
        let grad_v = in_space(&at.grad_v) * F_inv;
        self.friction(grad_v, grad_v) - Tensor::identity() * at.p
    }
}

impl Solid {
    /// σ = J⁻¹ P Fᵀ \[Pa\], the stress of the damping included, and −p I where the law has a pressure; of Hooke's law,
    /// which does not distinguish the two stresses, P itself.
    pub fn cauchy<const D: usize>(&self, fabric: &Fabric<f64, D>, at: &Fields<f64, D>) -> Tensor<f64, 3> {
        let grad_u = in_space(&at.grad_u);
        let mut fibre = Vector::zero();
        fibre.0[..D].copy_from_slice(&fabric.fibre.0);
        let fabric = Fabric { fibre, unloading: in_space(&fabric.unloading), hoop: fabric.hoop };
        let total = self.total(&fabric, &grad_u);
        let mut P = self.carried(&fabric, &grad_u, self.material.piola_at(&fabric.fibre, &total, &total));
        if self.damping.has_stress() {
            P += self.damping.piola(self.is_linear(), &in_space(&at.grad_v), &grad_u);
        }
        if self.is_linear() {
            return P;
        }
        if self.material.compliance().is_some() {
            P -= cofactor(&grad_u) * at.p;
        }
        let Kinematics { F, J, .. } = Kinematics::of(&grad_u);
        P * F.t() * (1.0 / J)
    }
}

impl Solid {
    /// What the damping dissipates per volume of the reference domain, P_v : ∇v + α ρ |v|² \[W/m³\].
    pub fn dissipated<const D: usize>(&self, at: &Fields<f64, D>) -> f64 {
        let stress = self.damping.piola(self.is_linear(), &at.grad_v, &at.grad_u);
        stress.ddot(at.grad_v) + self.rho * self.damping.mass * at.v.dot(at.v)
    }
}

/// Green-Lagrange strain E = ½ (FᵀF − I).
pub fn green_lagrange<const D: usize>(grad_u: &Tensor<f64, D>) -> Tensor<f64, D> {
    0.5 * (*grad_u + grad_u.t() + grad_u.t() * *grad_u)
}

/// √(3/2 s : s) \[Pa\] with the deviator s = σ − ⅓ tr(σ) I, after von Mises.
pub fn von_mises(sigma: &Tensor<f64, 3>) -> f64 {
    let s = *sigma - Tensor::identity() * (sigma.trace() / 3.0);
    (1.5 * s.ddot(s)).sqrt()
}

/// Principal stresses \[Pa\], ascending: the eigenvalues of σ, in the plane (`D` = 2) of its part in the plane.
pub fn principal<const D: usize>(sigma: &Tensor<f64, 3>) -> [f64; D] {
    let mut a: [[f64; D]; D] = std::array::from_fn(|i| std::array::from_fn(|j| sigma.0[i][j]));
    // Jacobi's method; in the plane one rotation is all.
    for _ in 0..20 {
        for (i, j) in (0..D).flat_map(|j| (0..j).map(move |i| (i, j))) {
            rotate(&mut a, i, j);
        }
    }
    let mut values = std::array::from_fn(|i| a[i][i]);
    values.sort_by(f64::total_cmp);
    values
}

/// The rotation in the plane of axes `i` and `j` after which the symmetric `a` has no entry there.
fn rotate<const D: usize>(a: &mut [[f64; D]; D], i: usize, j: usize) {
    if a[i][j] == 0.0 {
        return;
    }
    let slope = 0.5 * (a[j][j] - a[i][i]) / a[i][j];
    let tan = slope.signum() / (slope.abs() + slope.hypot(1.0));
    let cos = 1.0 / tan.hypot(1.0);
    let sin = tan * cos;
    for k in 0..D {
        (a[k][i], a[k][j]) = (cos * a[k][i] - sin * a[k][j], sin * a[k][i] + cos * a[k][j]);
    }
    for k in 0..D {
        (a[i][k], a[j][k]) = (cos * a[i][k] - sin * a[j][k], sin * a[i][k] + cos * a[j][k]);
    }
}

/// The same gradient, with a third direction in which nothing changes and nothing moves.
pub fn in_space<const D: usize>(a: &Tensor<f64, D>) -> Tensor<f64, 3> {
    let entry = |i: usize, j: usize| if i < D && j < D { a.0[i][j] } else { 0.0 };
    Tensor(std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))))
}
