//! The law of Ogden (1972), in principal stretches.

use super::kinematics::{cofactor, volume_change};
use super::law::{Law, in_space, write};
use crate::math::{Dual, Tensor};

/// W = Σ_p [μ_p/α_p (λ₁^α_p + λ₂^α_p + λ₃^α_p − 3) − μ_p ln J] + ½ λ (J − 1)², μ = ½ Σ μ_p α_p at rest.
///
/// With α = 2 it is the neo-Hookean law. Stress and derivative are those of the eigenvalues of C, divided differences
/// where two of them meet.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Ogden {
    /// μ_p \[Pa\] and α_p, of one sign; terms that are not there have μ_p = 0.
    pub terms: [[f64; 2]; 3],
    /// First Lamé parameter λ \[Pa\]; 0 if the law has a pressure of its own.
    pub lambda: f64,
    /// 1/κ' \[1/Pa\] of a law with a pressure of its own, 0 for J = 1.
    pub compliance: Option<f64>,
}

/// (x^γ − b^γ)/(x − b) at x = (1 + t) b, the derivative where they meet.
fn divided(b: f64, t: f64, gamma: f64) -> f64 {
    let ratio = if t == 0.0 { gamma } else { (gamma * t.ln_1p()).exp_m1() / t };
    b.powf(gamma - 1.0) * ratio
}

impl Ogden {
    /// Shear modulus at rest \[Pa\], ½ Σ μ_p α_p.
    pub fn shear_modulus(&self) -> f64 {
        self.active().map(|[mu, alpha]| 0.5 * mu * alpha).sum()
    }

    fn active(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.terms.iter().copied().filter(|[mu, _]| *mu != 0.0)
    }

    /// Σ_p μ_p (x^(α_p/2) − 1)/x, the principal stress of Σ without the volume, at x = 1 + e.
    fn principal(&self, e: f64) -> f64 {
        self.active().map(|[mu, alpha]| mu * (0.5 * alpha * e.ln_1p()).exp_m1()).sum::<f64>() / (1.0 + e)
    }

    /// Divided difference of [`Ogden::principal`] between e_a and e_b.
    fn slope(&self, a: f64, b: f64) -> f64 {
        let (base, t) = (1.0 + b, (a - b) / (1.0 + b));
        self.active()
            .map(|[mu, alpha]| mu * (divided(base, t, 0.5 * alpha - 1.0) - divided(base, t, -1.0)))
            .sum()
    }

    /// Σ and its derivative without the volume, at 2 E.
    fn second(&self, twice: &Tensor<Dual<f64>, 3>) -> Tensor<Dual<f64>, 3> {
        let (value, change) = (twice.map(|x| x.re), twice.map(|x| x.eps));
        let (e, N) = eigen(&value);
        let turned = N.t() * change * N;
        let (mut S, mut dS) = (Tensor::zero(), Tensor::zero());
        for a in 0..3 {
            S.0[a][a] = self.principal(e[a]);
            for b in 0..=a {
                let slope = self.slope(e[a], e[b]);
                dS.0[a][b] = slope * turned.0[a][b];
                dS.0[b][a] = slope * turned.0[b][a];
            }
        }
        let (S, dS) = (N * S * N.t(), N * dS * N.t());
        let mut both = Tensor::zero();
        for i in 0..3 {
            for j in 0..3 {
                both.0[i][j] = Dual { re: S.0[i][j], eps: dS.0[i][j] };
            }
        }
        both
    }

    fn piola(&self, grad_u: &Tensor<Dual<f64>, 3>) -> Tensor<Dual<f64>, 3> {
        let F = Tensor::identity() + *grad_u;
        let twice = *grad_u + grad_u.t() + grad_u.t() * *grad_u;
        F * self.second(&twice) + self.lambda * (cofactor(grad_u) * volume_change(grad_u, grad_u))
    }

    fn energy(&self, grad_u: &Tensor<f64, 3>) -> f64 {
        if (Tensor::identity() + *grad_u).det() <= 0.0 {
            return f64::NAN;
        }
        let (e, _) = eigen(&(*grad_u + grad_u.t() + grad_u.t() * *grad_u));
        let of = |l: f64| -> f64 {
            self.active().map(|[mu, alpha]| mu * ((0.5 * alpha * l).exp_m1() / alpha - 0.5 * l)).sum()
        };
        let change = volume_change(grad_u, grad_u);
        let bulk = self.compliance.filter(|c| *c > 0.0).map_or(self.lambda, |c| 1.0 / c);
        e.iter().map(|e| of(e.ln_1p())).sum::<f64>() + 0.5 * bulk * change * change
    }
}

impl Law for Ogden {
    fn energy_at(&self, _: &[f64], grad_u: &[[f64; 2]]) -> [f64; 2] {
        let at = in_space(grad_u);
        let (value, change) = (at.map(|x| x.re), at.map(|x| x.eps));
        let mut P = self.piola(&at).map(|x| x.re);
        if let Some(c) = self.compliance.filter(|c| *c > 0.0) {
            P += 1.0 / c * (cofactor(&value) * volume_change(&value, &value));
        }
        [self.energy(&value), P.ddot(change)]
    }

    fn stress_at(&self, _: &[f64], grad_u: &[[f64; 2]], stress: &mut [[f64; 2]]) {
        write(&self.piola(&in_space(grad_u)), stress);
    }
}

/// Eigenvalues of a symmetric tensor, and its eigenvectors as columns, by Jacobi's method.
fn eigen(a: &Tensor<f64, 3>) -> ([f64; 3], Tensor<f64, 3>) {
    let (mut a, mut N) = (*a, Tensor::<f64, 3>::identity());
    for (i, j) in [(0, 1), (0, 2), (1, 2)].into_iter().cycle().take(30) {
        if a.0[i][j] == 0.0 {
            continue;
        }
        let half = 0.5 * (a.0[j][j] - a.0[i][i]) / a.0[i][j];
        let tan = half.signum() / (half.abs() + half.hypot(1.0));
        let cos = 1.0 / tan.hypot(1.0);
        let sin = tan * cos;
        let mut turn = Tensor::identity();
        (turn.0[i][i], turn.0[j][j], turn.0[i][j], turn.0[j][i]) = (cos, cos, sin, -sin);
        a = turn.t() * a * turn;
        // Rounding would come back as another rotation.
        (a.0[i][j], a.0[j][i]) = (0.0, 0.0);
        N = N * turn;
    }
    ([a.0[0][0], a.0[1][1], a.0[2][2]], N)
}
