//! Undula: monolithic fluid-structure interaction on a fixed reference domain.
//!
//! Undula solves an incompressible flow and an elastic solid as one nonlinear system in ALE coordinates. The method is
//! that of Th. Richter, *Fluid-structure Interactions*, Springer 2017, chapter 5. Numbers in parentheses are equation
//! numbers of this book. All unknowns are functions on the reference domain `Ω = F ∪ S` (fluid and solid). The mesh is
//! fixed: the displacement `u` describes the motion of the domain.
//!
//! ```
//! # use undula::{problem::case::Case, simulation::Simulation};
//! let small = ["mesh.refine=0".to_string(), "newton.tolerance=1e-10".to_string()];
//! let case = Case::load("csm1", &small)?; // the name of a built-in case, or the path of a file
//! let mut simulation = Simulation::new(case, 1)?;
//! let row = simulation.step()?;
//! assert!((row.values[1] / -66.1e-3 - 1.0).abs() < 0.02); // the tip of the beam sinks by 66 mm
//! # Ok::<(), undula::error::Error>(())
//! ```
//!
//! # The equations
//!
//! | equation | for all | weak form | code |
//! | --- | --- | --- | --- |
//! | fluid momentum (5.15) | φ on F | (ρ J (∂ₜv + ∇v F⁻¹(v − ∂ₜu)), φ) + (J σ F⁻ᵀ, ∇φ) = (ρ J f, φ) | [`physics::fluid`], [`physics::outflow`] |
//! | divergence (5.16) | ξ on F | (J F⁻¹ : ∇vᵀ, ξ) = 0 | [`physics::fluid`] |
//! | solid momentum (5.17) | φ on S | (ρ ∂ₜv, φ) + (F Σ, ∇φ) = (ρ f, φ) | [`physics::solid`], [`physics::material`] |
//! | constraint of an incompressible solid | ξ on S | (J − 1, ξ) = 0, and −(p J F⁻ᵀ, ∇φ) in the solid momentum | [`physics::solid`] |
//! | velocity-deformation (5.17) | ψ on S | (∂ₜu − v, ψ) = 0 | [`physics::solid`] |
//! | extension (5.18) | ψ on F | (σₑ(u), ∇ψ) = 0, u prescribed on the interface | [`physics::extension`] |
//!
//! The velocity v and its test function φ are continuous across the interface. The kinematic and the dynamic interface
//! condition (equal velocities, equal forces) therefore hold without further terms. The ψ rows of the interface belong
//! to the solid: the test functions ψ of the extension vanish on the interface, (5.26), see [`space`].
//!
//! # The modules
//!
//! | step | module |
//! | --- | --- |
//! | discretise a weak form in time | [`physics::step`], with the rules of [`time`] |
//! | differentiate the weak form | [`tangent`] by dual numbers, [`physics::theorem_5_2`] by hand |
//! | assemble residual and Jacobian | [`assembly`] |
//! | iterate by Newton's method with a kept Jacobian (5.20) | [`nonlinear`] |
//! | solve the linear systems | [`algebra`] |
//! | run a case step by step, without files | [`simulation`] |
//! | run a case with its output files | [`run`] |
//! | measure the time of a step | [`mod@bench`] |
//!
//! # Symbols
//!
//! | book | code | meaning | unit |
//! | --- | --- | --- | --- |
//! | v, u, p | `v`, `u`, `p` | velocity, displacement (`deformation` in output files and in the book), pressure | m/s, m, Pa |
//! | z, w, q | `z`, `w`, `q` | directions of derivatives with respect to v, u, p | those of v, u, p |
//! | φ, ψ, ξ | `phi`, `psi`, `xi` | test functions of momentum, of u, of divergence | |
//! | F = I + ∇u, J | `F`, `J`; `F_inv` | deformation gradient `F[i][j]` = δᵢⱼ + ∂uᵢ/∂xⱼ, its determinant | 1 |
//! | J F⁻ᵀ | `cofactor` | cofactor matrix of F, in the pressure and divergence terms | 1 |
//! | σ_f | `sigma` | viscous Cauchy stress ρν(∇v F⁻¹ + F⁻ᵀ∇vᵀ) | Pa |
//! | E, Σ | `E`, `Sigma` | Green-Lagrange strain, second Piola-Kirchhoff stress | 1, Pa |
//! | ρ_f, ρ_s | `rho` of [`physics::Fluid`], [`physics::Solid`] | densities | kg/m³ |
//! | ν_f | `nu` | kinematic viscosity | m²/s |
//! | μ_s, λ_s | `mu`, `lambda` | Lamé constants | Pa |
//! | ν_e, E_e | `poisson`, `stiffness` | Poisson ratio and Young's modulus of the extension | 1, any |
//! | k, θ | `k`, `theta`; `per_k` = 1/k | time step size, weight of the new time level | s, 1 |
//! | γ_nt | `rate_max` | largest convergence rate at which a Jacobian is kept | 1 |

pub mod algebra;
pub mod assembly;
pub mod bench;
pub mod choice;
pub mod element;
pub mod error;
pub mod functional;
pub mod jacobian;
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
