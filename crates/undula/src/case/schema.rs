//! A checked case: every default resolved, every value valid.
//!
//! `Case` is what the TOML file means. It is made by [`Case::from_toml`] only, so that code further down
//! never meets an invalid one, and it is written back as `case.toml` into the output directory.

mod mesh;
mod solver;

use super::conditions::Components;
pub use super::conditions::Condition;
pub use super::element::{PressureElement, VelocityElement};
use super::error::Place;
pub use super::fibres::{FibreDirection, FibreSpec};
pub use super::functionals::{FUNCTIONALS, FunctionalSpec};
use super::initial::Initial;
pub use crate::algebra::{LinearSolverKind, Precision};
pub use crate::functional::energy::Integral;
use crate::physics::extension::MotionNumbers;
use crate::physics::{
    Artery, CarreauYasuda, Damping, Extension, Fluid, Material, OwnLaw, Reference, Solid, Stabilization,
};
pub use crate::physics::{MotionModel, SolidLaw};
use crate::space::{Against, Walls};
pub use crate::tangent::{Linearization, Tangent};
pub use crate::time::{AdaptiveSettings, DomainMotion, Scheme};
pub use mesh::{Extrude, GENERATORS, MeshSource, MeshSpec, OwnMesh, WallSpec};
pub use solver::{GMRES, KRYLOV, LinearSpec, NewtonSpec, OutputSpec, TimeSpec, WITH_MULTIGRID};
use std::collections::BTreeMap;

/// A complete, valid description of one computation.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Short name, also the name of the default output directory.
    pub name: String,
    /// One line for people.
    pub title: String,
    /// The built-in case whose published results may be set beside this one, as long as the problem is the same.
    pub reference: Option<String>,
    /// Geometry and cells.
    pub mesh: MeshSpec,
    /// Finite element spaces.
    pub space: SpaceSpec,
    /// Terms that pairs of equal order need, and terms against oscillations by transport.
    pub stabilization: Stabilization,
    /// The fluids; none leaves their region out and makes the interface traction-free.
    pub fluids: Vec<FluidSpec>,
    /// The elastic bodies; none leaves their region out and makes the interface a no-slip wall.
    pub solids: Vec<SolidSpec>,
    /// How the deformation is extended into the fluid.
    pub motion: MotionSpec,
    /// What holds on each named boundary (except `interface`).
    pub boundary: BTreeMap<String, Condition>,
    /// Terms against flow that comes in where they are not those of the condition, see [`Case::against`].
    pub backflow: BTreeMap<String, Against>,
    /// `None`: a stationary solution is sought.
    pub time: Option<TimeSpec>,
    /// Stationary cases only: the time \[s\] at which expressions are taken (`time.end`, else 0).
    pub at_time: f64,
    /// What the case begins with; `None`: it starts at rest.
    pub initial: Option<Initial>,
    /// The nonlinear solver.
    pub newton: NewtonSpec,
    /// The linear solver.
    pub linear: LinearSpec,
    /// Numbers of interest by name, in the order of the columns of `history.csv`.
    pub functional: Vec<(String, FunctionalSpec)>,
    /// What is written, and how often.
    pub output: OutputSpec,
    /// Where it was read from, for later messages; no part of its meaning.
    pub record: Record,
}

impl Case {
    /// Settings without effect and parts that are left out, in words.
    pub fn notes(&self) -> &[String] {
        &self.record.notes
    }

    /// θ of the first step; `None` if stationary.
    pub fn theta(&self) -> Option<f64> {
        self.time.as_ref().map(|time| time.scheme.rule(time.step.eval(&[0.0; 3], time.start)).theta)
    }
}

/// Where the parts of a case were written. All records are equal, so that cases are compared by meaning.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// The file, as named by the user.
    pub file_name: String,
    /// Place of every dotted key that was given.
    pub places: BTreeMap<String, Place>,
    /// Settings without effect and parts that are left out.
    pub notes: Vec<String>,
    /// `mesh.file` was given by a path relative to the case: the two are moved together.
    pub relative_mesh: bool,
}

impl PartialEq for Record {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Finite element spaces by name.
#[derive(Clone, Debug, PartialEq)]
pub struct SpaceSpec {
    /// Velocity and deformation.
    pub velocity: VelocityElement,
    /// Pressure.
    pub pressure: PressureElement,
    /// Gauss points per direction; on triangles and tetrahedra the rule exact to the same degree, 2 n − 1.
    pub quadrature: usize,
}

/// A fluid.
#[derive(Clone, Debug, PartialEq)]
pub struct FluidSpec {
    /// NAME of its table `[fluid.NAME]`; `None` of `[fluid]`.
    pub name: Option<String>,
    /// Regions of the mesh it fills, at least one.
    pub regions: Vec<String>,
    /// ρ_f \[kg/m³\].
    pub density: f64,
    /// ν_f \[m²/s\].
    pub kinematic_viscosity: f64,
    /// How it depends on the rate of shear, with `kinematic_viscosity` at rest; `None`: it is constant.
    pub thinning: Option<ThinningSpec>,
    /// Body force per mass, expressions of x, y, t \[m/s²\].
    pub body_force: Components,
    /// Take the body force at the current position x + u instead of the reference position x.
    pub force_at_current: bool,
}

/// The law of Carreau and Yasuda.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ThinningSpec {
    /// μ₀ \[Pa s\], at rest.
    pub zero: f64,
    /// μ_∞ \[Pa s\], at high rates of shear.
    pub infinity: f64,
    /// λ \[s\].
    pub time: f64,
    /// n.
    pub index: f64,
    /// a.
    pub transition: f64,
}

impl FluidSpec {
    /// The equations of the flow, with the extension of the displacement.
    pub fn physics(&self, extension: Extension) -> Fluid {
        let law = |law: ThinningSpec| CarreauYasuda {
            ratio: law.infinity / law.zero,
            time: law.time,
            index: law.index,
            transition: law.transition,
        };
        Fluid { rho: self.density, nu: self.kinematic_viscosity, thinning: self.thinning.map(law), extension }
    }
}

/// An elastic body.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidSpec {
    /// NAME of its table `[solid.NAME]`; `None` of `[solid]`.
    pub name: Option<String>,
    /// Regions of the mesh it fills, at least one.
    pub regions: Vec<String>,
    /// Constitutive law.
    pub law: SolidLaw,
    /// A stored energy of the program in place of `law`, see [`crate::CaseBuilder::material`]; `mu` and
    /// `lambda` are then those at rest.
    pub own: Option<OwnLaw>,
    /// ρ_s \[kg/m³\].
    pub density: f64,
    /// Shear modulus μ_s \[Pa\].
    pub mu: f64,
    /// First Lamé parameter λ_s \[Pa\]; infinite if the volume is kept exactly.
    pub lambda: f64,
    /// c₂ of Mooney-Rivlin \[Pa\], c₁ = ½ μ_s − c₂; else 0.
    pub c2: f64,
    /// μ_p \[Pa\] and α_p of Ogden, at most three terms; else none.
    pub ogden: Vec<[f64; 2]>,
    /// Fibres of the laws that have them.
    pub fibres: Option<FibreSpec>,
    /// Bulk modulus κ = λ_s + ⅔ μ_s \[Pa\] of a law that is only nearly incompressible.
    pub bulk: Option<f64>,
    /// Viscosity η \[Pa s\] of the stress η Ė.
    pub viscosity: f64,
    /// Rayleigh damping α \[1/s\] by the mass.
    pub damping_mass: f64,
    /// Rayleigh damping β \[s\] by the stiffness at rest.
    pub damping_stiffness: f64,
    /// Body force per mass, expressions of x, y, t \[m/s²\].
    pub body_force: Components,
    /// Whether the mesh is the shape without stress, or the one under the loads of the start.
    pub reference: Reference,
}

impl SolidSpec {
    /// The law with its constants.
    pub fn material(&self) -> Material {
        match self.own {
            Some(own) => Material::Own(own),
            None if self.law.is_of_arteries() => {
                let own = self.law.is_incompressible();
                let (lambda, compliance) =
                    if own { (0.0, Some(1.0 / self.lambda)) } else { (self.lambda, None) };
                Material::Artery(self.fibre_spec().artery(Artery::matrix(self.mu, lambda, compliance)))
            }
            None if self.law == SolidLaw::Guccione => {
                let compliance = self.bulk.map_or(0.0, |bulk| 1.0 / bulk);
                Material::Muscle(self.fibre_spec().muscle(compliance))
            }
            None if self.law.is_ogden() => {
                Material::ogden(&self.ogden, self.lambda, self.law.is_incompressible())
            }
            None => self.law.material(self.mu, self.lambda, self.c2),
        }
    }

    fn fibre_spec(&self) -> FibreSpec {
        self.fibres.clone().unwrap_or_default()
    }

    /// The expressions of the direction of the fibres, if it is a field.
    pub(crate) fn fibre_field(&self) -> Option<&Components> {
        self.fibres.as_ref().and_then(|fibres| fibres.direction.field())
    }

    /// The equations of the body.
    pub fn physics(&self) -> Solid {
        let (material, beta) = (self.material(), self.damping_stiffness);
        // The volume of an incompressible body has a pressure, not a stress of its own.
        let volume = if material.compliance().is_some() { 0.0 } else { beta * self.lambda };
        let shear = self.viscosity + 2.0 * beta * self.mu;
        let damping = Damping { mass: self.damping_mass, shear, volume };
        Solid { rho: self.density, material, damping, reference: self.reference }
    }
}

/// Extension of the deformation into the fluid.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionSpec {
    /// The operator.
    pub model: MotionModel,
    /// Poisson ratio ν_e of the pseudo-elastic models, in (−1, ½).
    pub poisson: f64,
    /// d_0 \[m\] of the stiffening (d_0 + d)^(−exponent), d the distance to the interface; `None`: from the extents of
    /// fluid and solid, see [`Case::motion_on`].
    pub offset: Option<f64>,
    /// Exponent of the stiffening; 0 switches it off.
    pub exponent: f64,
    /// L \[m\] of the stiffening 2 − erf(5 d/L) of the harmonic model; `None`: half the smaller extent of the mesh, see
    /// [`Case::motion_on`].
    pub scale: Option<f64>,
    /// Take J of the stiffening by J + 1/J from the last solution.
    pub lagged: bool,
    /// w = 0 instead of ∂_n u = 0 on the outer boundary (biharmonic).
    pub hinged: bool,
    /// What the deformation does on the outer boundary of the fluid.
    pub walls: Walls,
}

impl MotionSpec {
    /// The numbers of the model; lengths that are not known are 1 m, see [`Case::motion_on`].
    pub fn numbers(&self) -> MotionNumbers {
        MotionNumbers {
            poisson: self.poisson,
            lagged: self.lagged,
            hinged: self.hinged,
            offset: self.offset.unwrap_or(1.0),
            exponent: self.exponent,
            scale: self.scale.unwrap_or(1.0),
        }
    }
}
