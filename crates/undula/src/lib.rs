//! Undula: monolithic fluid-structure interaction on a fixed reference domain.
//!
//! Undula solves an incompressible flow and an elastic solid as one nonlinear system in ALE coordinates. The method is
//! that of Th. Richter, *Fluid-structure Interactions*, Springer 2017, chapter 5. Numbers in parentheses are equation
//! numbers of this book. All unknowns are functions on the reference domain `Ω = F ∪ S` (fluid and solid). The mesh is
//! fixed: the displacement `u` describes the motion of the domain.
//!
//! # From a case to numbers
//!
//! A [`Case`] is a file or is set in a program; [`CaseBuilder::build`] checks it and tells all mistakes with their keys.
//! A [`Simulation`] computes it step by step. Each [`Row`] has the functionals by name, [`Fields`] the solution.
//!
//! ```
//! use undula::{CaseBuilder, Simulation};
//! let case = CaseBuilder::load("csm1")? // a built-in case, or the path of a file
//!     .set("mesh.refine", 0)
//!     .set("newton.tolerance", 1e-10)
//!     .build()?;
//! let mut simulation = Simulation::new(case, 1)?; // on one thread
//! let row = simulation.step()?;
//! assert!((row["uy_A"] / -66.1e-3 - 1.0).abs() < 0.02); // the tip of the beam sinks by 66 mm
//! let point = simulation.fields().at([0.6, 0.2])?; // a position on the reference domain
//! assert!((point.displacement[1] - row["uy_A"]).abs() < 1e-12);
//! # Ok::<(), undula::Error>(())
//! ```
//!
//! A loop of your own decides how long it goes on ([`Simulation::step`]):
//!
//! ```
//! # use undula::{CaseBuilder, Simulation};
//! let case = CaseBuilder::load("csm3")?.set("mesh.refine", 0).set("time.step", 0.02).build()?;
//! let mut simulation = Simulation::new(case, 1)?;
//! while simulation.time() < 0.2 && simulation.step()?["uy_A"] > -0.02 {}
//! assert!((simulation.time() - 0.12).abs() < 1e-9); // the tip has fallen by 20 mm
//! # Ok::<(), undula::Error>(())
//! ```
//!
//! A functional and a material of your own ([`Simulation::record`], [`StoredEnergy`]):
//!
//! ```
//! use undula::{CaseBuilder, Deformation, Scalar, Simulation, StoredEnergy};
//!
//! /// W = ½ μ (I₁ − 3) − μ ln J + ½ λ (J − 1)² with μ = 0.5 MPa, λ = 2 MPa.
//! struct Rubber;
//!
//! impl StoredEnergy for Rubber {
//!     fn energy<T: Scalar, const D: usize>(&self, at: &Deformation<T, D>) -> T {
//!         at.I1_minus_3() * 0.25e6 - at.J().ln() * 0.5e6 + at.J_minus_1() * at.J_minus_1() * 1e6
//!     }
//! }
//!
//! let case = CaseBuilder::load("csm1")?.set("mesh.refine", 0).material(Rubber).build()?;
//! let mut simulation = Simulation::new(case, 1)?;
//! simulation.record("area", "m²", |fields| fields.integrate(|point| point.jacobian()));
//! let row = simulation.step()?;
//! assert!((row["uy_A"] / -66.1e-3 - 1.0).abs() < 0.02);
//! assert!((row["area"] / (0.35 * 0.02) - 1.0).abs() < 0.01); // the bent beam
//! # Ok::<(), undula::Error>(())
//! ```
//!
//! A mesh of your own ([`Mesh::from_cells`]):
//!
//! ```
//! use undula::{CaseBuilder, Mesh, Simulation};
//! let corners = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]];
//! let side = |x: [f64; 2]| if x[1] == 0.0 { "foot" } else { "sides" };
//! let mesh = Mesh::from_cells(corners, &[[0, 1, 2], [0, 2, 3]], |_| "solid", side)?;
//! let case = CaseBuilder::new("block")
//!     .mesh(mesh)
//!     .set("mesh.refine", 2)
//!     .set("solid.density", 1.0)
//!     .set("solid.young", 1.0)
//!     .set("solid.poisson", 0.3)
//!     .set("solid.body-force", [0.0, -0.01])
//!     .set("boundary.foot.condition", "clamped")
//!     .set("boundary.sides.condition", "traction-free")
//!     .build()?;
//! let mut simulation = Simulation::new(case, 1)?;
//! simulation.step()?;
//! assert!(simulation.fields().at([0.5, 2.0])?.displacement[1] < 0.0); // it sinks under its weight
//! # Ok::<(), undula::Error>(())
//! ```
//!
//! Whole programs:
//!
//! | own | by | example |
//! | --- | --- | --- |
//! | time loop | [`Simulation::step`] | `examples/step_by_step.rs` |
//! | functional | [`Simulation::record`], a closure over [`Fields`] | `examples/own_functional.rs` |
//! | material | [`CaseBuilder::material`], a [`StoredEnergy`] | `examples/own_material.rs` |
//! | mesh | [`CaseBuilder::mesh`], a [`Mesh`] from [`Mesh::from_cells`] | `examples/own_mesh.rs` |
//! | many cases on all cores | threads, one [`Simulation`] each | `examples/sweep.rs` |
//!
//! The names at the root of the crate are for other programs. The modules are those of the program `undula`; they are
//! hidden here, but for the equations in [`physics`], and may change at any time.
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
//! to the solid: the test functions ψ of the extension vanish on the interface, (5.26), see `src/space`.
//!
//! # The modules
//!
//! | step | module |
//! | --- | --- |
//! | read and check a case | `src/case` |
//! | make its mesh, spaces, equations and solvers | `src/setup` |
//! | discretise a weak form in time | [`physics::step`], with the rules of `src/time` |
//! | differentiate the weak form | `src/tangent` by dual numbers, [`physics::theorem_5_2`] by hand |
//! | sum the terms over the cells | `src/operators`, by the loops of `src/loops` |
//! | assemble residual and Jacobian | `src/system` |
//! | iterate by Newton's method with a kept Jacobian (5.20) | `src/nonlinear` |
//! | solve the linear systems | `src/algebra` |
//! | run a case step by step, without files | [`Simulation`] |
//! | run a case with its output files | `src/run` |
//! | set its results beside others | `src/results` |
//! | check the program: manufactured solutions, Jacobians, inf-sup constants | `src/verification` |
//! | measure the time of a step | `src/bench` |
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

#[doc(hidden)]
pub mod algebra;
#[doc(hidden)]
pub mod bench;
#[doc(hidden)]
pub mod builder;
#[doc(hidden)]
pub mod case;
#[doc(hidden)]
pub mod choice;
#[doc(hidden)]
pub mod element;
#[doc(hidden)]
pub mod error;
#[doc(hidden)]
pub mod functional;
#[doc(hidden)]
pub mod linear;
mod loops;
#[doc(hidden)]
pub mod math;
#[doc(hidden)]
pub mod mesh;
#[doc(hidden)]
pub mod modes;
#[doc(hidden)]
pub mod multigrid;
#[doc(hidden)]
pub mod nonlinear;
#[doc(hidden)]
pub mod operators;
#[doc(hidden)]
pub mod output;
pub mod parallel;
pub mod physics;
#[doc(hidden)]
pub mod results;
#[doc(hidden)]
pub mod run;
#[doc(hidden)]
pub mod sampling;
#[doc(hidden)]
pub mod setup;
#[doc(hidden)]
pub mod simulation;
#[doc(hidden)]
pub mod space;
#[doc(hidden)]
pub mod study;
#[doc(hidden)]
pub mod system;
#[doc(hidden)]
pub mod tangent;
#[doc(hidden)]
pub mod time;
#[doc(hidden)]
pub mod verification;

pub use builder::{CaseBuilder, Setting};
pub use case::Case;
pub use case::expression::OwnFunction;
pub use error::Error;
pub use functional::fields::{Fields, PointFields};
pub use math::{Scalar, Tensor};
pub use mesh::{Located, Mesh, MeshError};
pub use physics::{Deformation, Material, StoredEnergy};
pub use simulation::{Row, Simulation};
