//! A material of one's own: the stored energy is written, stress and tangent follow; both are checked by differences.
//!
//! `cargo run --release --features examples --example own_material`

use undula::{CaseBuilder, Deformation, Error, Material, Scalar, Simulation, StoredEnergy, Tensor};

/// A material that stiffens exponentially (Demiray 1972), ψ = I₁ − 3 − 2 ln J:
/// W = (μ/2b) (exp(b ψ) − 1) + ½ λ (J − 1)². With b → 0 it is neo-Hookean.
#[derive(Copy, Clone)]
pub struct Tissue {
    /// Shear modulus at rest \[Pa\].
    pub mu: f64,
    /// First Lamé parameter at rest \[Pa\].
    pub lambda: f64,
    /// Stiffening; 0 is neo-Hookean.
    pub b: f64,
}

impl StoredEnergy for Tissue {
    fn energy<T: Scalar, const D: usize>(&self, at: &Deformation<T, D>) -> T {
        let psi = at.I1_minus_3() - at.J().ln() * 2.0;
        let shear = match self.b {
            0.0 => psi * (0.5 * self.mu),
            b => ((psi * b).exp() - T::one()) * (0.5 * self.mu / b),
        };
        shear + at.J_minus_1() * at.J_minus_1() * (0.5 * self.lambda)
    }
}

/// Largest deviations of stress and tangent from central differences of energy and stress, relative to μ.
pub fn deviations(law: Tissue) -> [f64; 2] {
    let material = Material::own(law);
    let (grad_u, h) = (Tensor([[0.2, -0.1], [0.3, 0.1]]), 1e-6);
    let (mut of_stress, mut of_tangent) = (0.0, 0.0);
    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let mut direction = Tensor::<f64, 2>::zero();
        direction.0[i][j] = 1.0;
        let (plus, minus) = (grad_u + h * direction, grad_u + -h * direction);
        let slope = (material.energy(&plus) - material.energy(&minus)) / (2.0 * h);
        of_stress = f64::max(of_stress, (material.stress(&grad_u).0[i][j] - slope).abs());
        let difference = 1.0 / (2.0 * h) * (material.stress(&plus) - material.stress(&minus));
        let error = material.tangent(&grad_u, &direction) - difference;
        of_tangent = error.0.as_flattened().iter().fold(of_tangent, |most, e| f64::max(most, e.abs()));
    }
    [of_stress / law.mu, of_tangent / law.mu]
}

/// How far the tip of the beam of `csm1` sinks \[m\] with the law; with `None` for a built-in neo-Hookean one.
pub fn tip(law: Option<Tissue>, refine: u32) -> Result<f64, Error> {
    let case = CaseBuilder::load("csm1")?.set("mesh.refine", refine).set("newton.tolerance", 1e-12);
    let case = match law {
        Some(law) => case.material(law),
        None => case.set("solid.law", "neo-hookean"),
    };
    Ok(-Simulation::new(case.build()?, 1)?.step()?["uy_A"])
}

fn main() -> Result<(), Error> {
    let (mu, lambda) = (0.5e6, 2e6); // as csm1 has
    let [of_stress, of_tangent] = deviations(Tissue { mu, lambda, b: 2.0 });
    println!("deviation from differences: stress {of_stress:.1e}, tangent {of_tangent:.1e}");
    println!("built-in neo-Hookean: {:.6} mm", 1e3 * tip(None, 1)?);
    for b in [0.0, 2.0, 20.0] {
        println!("own law, b = {b:4}:    {:.6} mm", 1e3 * tip(Some(Tissue { mu, lambda, b }), 1)?);
    }
    Ok(())
}
