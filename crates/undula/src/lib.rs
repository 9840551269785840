//! Undula: monolithic fluid-structure interaction on a fixed reference domain.
//!
//! One flow, one elastic solid, one nonlinear system in strict ALE coordinates, after Th. Richter,
//! *Fluid-structure Interactions*, Springer 2017, chapter 5, to which the numbers in parentheses refer.
//! Everything lives on the reference domain `Ω = F ∪ S`; no mesh is ever moved.
//!
//! ```
//! # use undula::{problem::case::Case, simulation::Simulation};
//! let small = ["mesh.refine=0".to_string(), "newton.tolerance=1e-10".to_string()];
//! let case = Case::load("csm1", &small)?; // a built-in case, or a file
//! let mut simulation = Simulation::new(case, 1)?;
//! let row = simulation.step()?;
//! assert!((row.values[1] / -66.1e-3 - 1.0).abs() < 0.02); // the end of the beam sinks by 66 mm
//! # Ok::<(), undula::error::Error>(())
//! ```
//!
//! # The equations
//!
//! | | for all | in words | |
//! | --- | --- | --- | --- |
//! | fluid momentum (5.15) | φ on F | (ρ J (∂ₜv + ∇v F⁻¹(v − ∂ₜu)), φ) + (J σ F⁻ᵀ, ∇φ) = (ρ J f, φ) | [`physics::fluid`], [`physics::outflow`] |
//! | divergence (5.16) | ξ on F | (J F⁻¹ : ∇vᵀ, ξ) = 0 | [`physics::fluid`] |
//! | solid momentum (5.17) | φ on S | (ρ ∂ₜv, φ) + (F Σ, ∇φ) = (ρ f, φ) | [`physics::solid`], [`physics::material`] |
//! | volume of an incompressible solid | ξ on S | (J − 1, ξ) = 0, with −(p J F⁻ᵀ, ∇φ) in its momentum | [`physics::solid`] |
//! | velocity-deformation (5.17) | ψ on S | (∂ₜu − v, ψ) = 0 | [`physics::solid`] |
//! | extension (5.18) | ψ on F | (σₑ(u), ∇ψ) = 0, u given on the interface | [`physics::extension`] |
//!
//! One test function φ runs over both momentum equations, so that velocities and forces are equal on both
//! sides of the interface by construction. The ψ rows of the interface belong to the solid: there the
//! extension is tested with functions that vanish, (5.26), see [`space`].
//!
//! From an equation to a step: [`physics::step`] composes the forms in time with the rules of [`time`];
//! [`tangent`] differentiates them, by dual numbers or by hand (Theorem 5.2, [`physics::theorem_5_2`]);
//! [`assembly`] sums over cells; [`nonlinear`] is Newton's method with a kept Jacobian (5.20);
//! [`algebra`] solves; [`simulation`] and [`run`] are the front doors; [`mod@bench`] measures.
//!
//! # Symbols
//!
//! | book | code | | unit |
//! | --- | --- | --- | --- |
//! | v, u, p | `v`, `u`, `p` | velocity, deformation, pressure | m/s, m, Pa |
//! | z, w, q | `z`, `w`, `q` | directions of derivatives of v, u, p | as these |
//! | φ, ψ, ξ | `phi`, `psi`, `xi` | test functions of momentum, of u, of divergence | |
//! | F = I + ∇u, J | `F`, `J`; `F_inv` | deformation gradient `F[i][j]` = δᵢⱼ + ∂uᵢ/∂xⱼ, its determinant | 1 |
//! | J F⁻ᵀ | `cofactor` | for pressure and divergence | 1 |
//! | σ_f | `sigma` | viscous Cauchy stress ρν(∇v F⁻¹ + F⁻ᵀ∇vᵀ) | Pa |
//! | E, Σ | `E`, `Sigma` | Green-Lagrange strain, second Piola-Kirchhoff stress | 1, Pa |
//! | ρ_f, ρ_s | `rho` of [`physics::Fluid`], [`physics::Solid`] | densities | kg/m³ |
//! | ν_f | `nu` | kinematic viscosity | m²/s |
//! | μ_s, λ_s | `mu`, `lambda` | Lamé constants | Pa |
//! | ν_e, E_e | `poisson`, `stiffness` | of the extension | 1, any |
//! | k, θ | `k`, `theta`; `per_k` = 1/k | time step, weight of its new end | s, 1 |
//! | γ_nt | `rate_max` | worst rate with which a Jacobian is kept | 1 |

pub mod algebra;
pub mod assembly;
pub mod bench;
pub mod element;
pub mod error;
pub mod functional;
pub mod math;
pub mod mesh;
pub mod nonlinear;
pub mod output;
pub mod physics;
pub mod problem;
pub mod run;
pub mod simulation;
pub mod space;
pub mod stability;
pub mod tangent;
pub mod time;
