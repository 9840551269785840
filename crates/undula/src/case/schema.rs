//! A checked case: every default resolved, every value valid.
//!
//! `Case` is what the TOML file means. It is made by [`Case::from_toml`] only, so that code further down
//! never meets an invalid one, and it is written back as `case.toml` into the output directory.

mod solver;

use super::conditions::Components;
pub use super::conditions::Condition;
pub use super::element::{PressureElement, VelocityElement};
use super::error::Place;
use super::expression::Expression;
pub use super::fibres::{FibreDirection, FibreSpec};
pub use super::functionals::{FUNCTIONALS, FunctionalSpec};
use super::initial::Initial;
pub use crate::algebra::{LinearSolverKind, Precision};
use crate::choice::{Choice, choice};
pub use crate::functional::energy::Integral;
use crate::mesh::Mesh;
use crate::physics::extension::MotionNumbers;
use crate::physics::{
    Artery, CarreauYasuda, Damping, Extension, Fluid, Material, OwnLaw, Reference, Solid, Stabilization,
};
pub use crate::physics::{MotionModel, SolidLaw};
use crate::space::{Against, Coordinates, Walls};
pub use crate::tangent::{Linearization, Tangent};
pub use crate::time::{AdaptiveSettings, DomainMotion, Scheme};
pub use solver::{GMRES, KRYLOV, LinearSpec, NewtonSpec, OutputSpec, TimeSpec};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

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

/// Where the mesh comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshSpec {
    /// A built-in generator or a file.
    pub source: MeshSource,
    /// Factor of all coordinates of a file, such as 1e-3 for one in millimetres; 1 of built-in generators.
    pub scale: f64,
    /// Dimension of the mesh, 2 or 3.
    pub dimension: usize,
    /// How a plane mesh becomes one of space; `None`: it stays as it is.
    pub extrude: Option<Extrude>,
    /// What the coordinates mean.
    pub coordinates: Coordinates,
    /// Number of uniform refinements.
    pub refine: u32,
    /// Number of nested rings of half size around the singular corners of the generator.
    pub grading: u32,
    /// Regions defined by an expression of x, y that is positive inside (generators `box` and `annulus`).
    pub region: BTreeMap<String, Expression>,
    /// Regions that are not computed on; their sides are walls unless a condition names them.
    pub leave_out: Vec<String>,
    /// Regions of the bodies that a part of a case is without; no key, empty in a case as it is read.
    pub absent: Vec<String>,
}

/// The plane mesh, refined as it is, along z.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Extrude {
    /// z of the side `back` \[m\]; that of the side `front` is 0.
    pub depth: f64,
    /// Layers of cells, before those at the ends are halved.
    pub layers: usize,
    /// How often the first and the last layer are halved towards the sides.
    pub grading: usize,
}

impl Extrude {
    /// All layers.
    pub fn all_layers(&self) -> usize {
        self.layers + 2 * self.grading
    }
}

/// A built-in generator or a file.
#[derive(Clone, Debug, PartialEq)]
pub enum MeshSource {
    /// Channel 2.5 × 0.41 with cylinder and elastic beam (Turek and Hron 2006).
    TurekHron,
    /// Channel 2.2 × 0.41 with cylinder (Schäfer and Turek 1996).
    SchaeferTurek,
    /// Its section in space: channel 2.5 × 0.41, cylinder at (0.5, 0.2).
    Dfg3d,
    /// Square (−1, 1)² with a free bar in its middle (Richter 2017, section 5.3.5).
    Rotor,
    /// Channel (−3, 3) × (0, 4) with an elastic flap on its bottom (preCICE).
    Flap,
    /// Unit square over a flexible bottom (Valdés 2007).
    Cavity,
    /// Half of a section through an elastic tube (Gerbeau and Vidrascu 2003).
    Tube2d,
    /// Channel (−2, 6) × (−1, 1) cm with two elastic leaflets.
    Valve,
    /// Cook's membrane, 48 × 60 mm.
    Cook,
    /// Half of a channel of space with an elastic box (Richter 2012).
    FsiBox,
    /// A tube of space about the z axis.
    Tube {
        /// Length \[m\].
        length: f64,
        /// Inner and outer radius \[m\].
        radii: [f64; 2],
        /// Cells along, round (a multiple of 4) and through the wall before refinement.
        cells: [usize; 3],
    },
    /// The ring between two circles about the origin, boundaries `inner`, `outer`.
    Annulus {
        /// Radii of the circles \[m\].
        radii: [f64; 2],
        /// Cells round, a multiple of 4, and across before refinement.
        cells: [usize; 2],
    },
    /// A rectangle or a cuboid `lower..upper` \[m\] of `cells[0] × cells[1] (× cells[2])` cells, boundaries `left`, `right`,
    /// `bottom`, `top`, and in space `front`, `back`.
    Box {
        /// The corner where all coordinates are least \[m\].
        lower: Vec<f64>,
        /// The opposite corner \[m\].
        upper: Vec<f64>,
        /// Cells per direction before refinement.
        cells: Vec<usize>,
    },
    /// A Gmsh file with named physical groups.
    File(PathBuf),
    /// A mesh of the program, see [`crate::CaseBuilder::mesh`].
    Own(OwnMesh),
}

/// A mesh that a program gives; copies are one mesh.
#[derive(Clone, Debug)]
pub struct OwnMesh(pub Arc<Mesh<2>>);

/// Whether they are one object.
impl PartialEq for OwnMesh {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// Generators by their names in a case.
pub static GENERATORS: [Choice<MeshSource>; 13] = [
    choice("turek-hron", MeshSource::TurekHron, "channel with cylinder and beam"),
    choice("schaefer-turek", MeshSource::SchaeferTurek, "channel with cylinder"),
    choice(
        "dfg-3d",
        MeshSource::Dfg3d,
        "channel 2.5 m long with cylinder, the section of the benchmark in space",
    ),
    choice("rotor", MeshSource::Rotor, "square with a free bar"),
    choice("flap", MeshSource::Flap, "channel with an elastic flap"),
    choice("cavity", MeshSource::Cavity, "square over a flexible bottom"),
    choice("tube-2d", MeshSource::Tube2d, "half of a section through an elastic tube, in (r, z)"),
    choice("valve", MeshSource::Valve, "channel with two elastic leaflets"),
    choice("cook", MeshSource::Cook, "Cook's membrane"),
    choice("fsi-box", MeshSource::FsiBox, "half of a channel of space with an elastic box"),
    choice(
        "tube",
        MeshSource::Tube { length: 1.0, radii: [1.0, 2.0], cells: [1, 4, 1] },
        "tube of space with an elastic wall between the radii `radii`",
    ),
    choice(
        "annulus",
        MeshSource::Annulus { radii: [1.0, 2.0], cells: [4, 1] },
        "ring between two circles of the radii `radii`",
    ),
    choice(
        "box",
        MeshSource::Box { lower: vec![], upper: vec![], cells: vec![] },
        "rectangle or cuboid from `lower` to `upper`",
    ),
];

/// Finite element spaces by name.
#[derive(Clone, Debug, PartialEq)]
pub struct SpaceSpec {
    /// Velocity and deformation.
    pub velocity: VelocityElement,
    /// Pressure.
    pub pressure: PressureElement,
    /// Gauss points per direction; on triangles the rule exact to the same degree, 2 n − 1.
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
