//! The functionals of a case and their names.

use crate::choice::{Choice, choice};
use crate::functional::body_energy::Part;
use crate::functional::energy::Integral;
use crate::functional::quantity::{Component, Take, WALL_SHEAR_STRESS};

/// Where a field is looked at.
#[derive(Clone, Debug, PartialEq)]
pub enum Site {
    /// A material point.
    Point {
        /// Reference coordinates \[m\].
        point: Vec<f64>,
        /// Region of the body that is meant where two meet.
        region: Option<String>,
    },
    /// Boundaries of the fluid.
    Boundaries(Vec<String>, Take),
    /// The region of a body.
    Region(String, Take),
}

impl Site {
    const NOWHERE: Site = Site::Boundaries(Vec::new(), Take::Mean);
}

/// One number of interest.
#[derive(Clone, Debug, PartialEq)]
pub enum FunctionalSpec {
    /// Force of the fluid on boundaries \[N/m\], or its coefficient.
    Force {
        /// Boundary names; `interface` is allowed.
        on: Vec<String>,
        /// 0: x, 1: y, 2: z.
        component: usize,
        /// By the fluid residual (default) or by the surface integral.
        surface_integral: bool,
        /// Multiply by 2/(ρ_f v̄² L) with v̄ \[m/s\], L \[m\] if given.
        coefficient: Option<[f64; 2]>,
    },
    /// Moment of the force of the fluid on boundaries \[N\].
    Moment {
        /// Boundary names; `interface` is allowed.
        on: Vec<String>,
        /// The point in space that it is about \[m\].
        about: Vec<f64>,
        /// In space the direction of the axis, 2: z; `None` in the plane.
        axis: Option<usize>,
    },
    /// Deformation of a material point \[m\].
    Displacement {
        /// Reference coordinates \[m\].
        point: Vec<f64>,
        /// 0: x, 1: y, 2: z.
        component: usize,
    },
    /// p(a) − p(b) \[Pa\].
    PressureDifference {
        /// First point.
        a: Vec<f64>,
        /// Second point.
        b: Vec<f64>,
    },
    /// An energy or power per unit depth.
    Energy(Integral),
    /// Average rotation (1/|S|) ∫_S x × u dx \[m²\].
    Rotation {
        /// In space the component; `None` in the plane.
        axis: Option<usize>,
    },
    /// ∫ v · n da out of the fluid \[m²/s\].
    Flux {
        /// Boundary names; `interface` is allowed.
        on: Vec<String>,
    },
    /// Power of the force of the fluid on boundaries where the velocity is not free \[W/m\].
    Power {
        /// Boundary names; `interface` is allowed.
        on: Vec<String>,
    },
    /// p \[Pa\].
    Pressure(Site),
    /// A component of v \[m/s\].
    Velocity {
        /// Which.
        component: Component,
        /// Where.
        at: Site,
    },
    /// A component of the Cauchy stress \[Pa\].
    Stress {
        /// Which.
        component: Component,
        /// Where; not on boundaries.
        at: Site,
    },
    /// The tangential part of the force of the fluid per area \[Pa\].
    WallShearStress {
        /// Which: the norm, or along the tangent.
        component: Component,
        /// Boundary names; `interface` is allowed.
        on: Vec<String>,
        /// What is taken of it.
        take: Take,
    },
    /// A part of the balance of energy of a body.
    Balance {
        /// A region of the body.
        region: String,
        /// Which part.
        part: Part,
    },
    /// Current area of a body \[m²\].
    Volume {
        /// The region of the body.
        region: String,
    },
}

/// Their names in a case, in the order of the messages.
pub static FUNCTIONALS: [Choice<FunctionalSpec>; 14] = [
    choice(
        "force",
        FunctionalSpec::Force { on: Vec::new(), component: 0, surface_integral: false, coefficient: None },
        "force of the fluid on boundaries [N/m], or its coefficient",
    ),
    choice(
        "moment",
        FunctionalSpec::Moment { on: Vec::new(), about: Vec::new(), axis: None },
        "moment of the force of the fluid on boundaries about `point` [N]",
    ),
    choice(
        "displacement",
        FunctionalSpec::Displacement { point: Vec::new(), component: 0 },
        "displacement of a material point [m]",
    ),
    choice(
        "pressure-difference",
        FunctionalSpec::PressureDifference { a: Vec::new(), b: Vec::new() },
        "p(a) − p(b) [Pa]",
    ),
    choice("energy", FunctionalSpec::Energy(Integral::FluidKinetic), "energy or power per unit depth"),
    choice("rotation", FunctionalSpec::Rotation { axis: None }, "average rotation of the solid [m²]"),
    choice(
        "flux",
        FunctionalSpec::Flux { on: Vec::new() },
        "flow ∫ v·n out of the fluid through boundaries [m²/s]",
    ),
    choice(
        "power",
        FunctionalSpec::Power { on: Vec::new() },
        "power of the force of the fluid on walls, inlets, the interface [W/m]",
    ),
    choice(
        "pressure",
        FunctionalSpec::Pressure(Site::NOWHERE),
        "pressure at a point, on boundaries or in a region [Pa]",
    ),
    choice(
        "velocity",
        FunctionalSpec::Velocity { component: Component::Magnitude, at: Site::NOWHERE },
        "velocity at a point, on boundaries or in a region [m/s]",
    ),
    choice(
        "stress",
        FunctionalSpec::Stress { component: Component::VonMises, at: Site::NOWHERE },
        "Cauchy stress at a point or in a region [Pa]",
    ),
    choice(
        WALL_SHEAR_STRESS,
        FunctionalSpec::WallShearStress { component: Component::Magnitude, on: Vec::new(), take: Take::Mean },
        "tangential force of the fluid per area of boundaries [Pa]",
    ),
    choice(
        "balance",
        FunctionalSpec::Balance { region: String::new(), part: Part::Residual },
        "energy of a body: what it has, gets and dissipates in a step",
    ),
    choice("volume", FunctionalSpec::Volume { region: String::new() }, "current area of a region [m²]"),
];

impl FunctionalSpec {
    /// Whether it belongs to the time t⁻ + θ k of the pressure instead of the new time.
    pub fn at_force_time(&self) -> bool {
        let of_step = matches!(self, FunctionalSpec::Balance { part, .. } if part.is_of_step());
        of_step
            || matches!(
                self,
                FunctionalSpec::Force { .. }
                    | FunctionalSpec::Moment { .. }
                    | FunctionalSpec::PressureDifference { .. }
                    | FunctionalSpec::Power { .. }
                    | FunctionalSpec::Pressure(_)
                    | FunctionalSpec::Stress { .. }
            )
    }

    /// Names of its boundaries.
    pub fn on(&self) -> &[String] {
        match self {
            FunctionalSpec::Force { on, .. }
            | FunctionalSpec::Moment { on, .. }
            | FunctionalSpec::Flux { on }
            | FunctionalSpec::Power { on }
            | FunctionalSpec::WallShearStress { on, .. } => on,
            _ => match self.site() {
                Some(Site::Boundaries(on, _)) => on,
                _ => &[],
            },
        }
    }

    /// The region of the mesh that it names.
    pub fn region(&self) -> Option<&str> {
        match (self, self.site()) {
            (FunctionalSpec::Volume { region } | FunctionalSpec::Balance { region, .. }, _)
            | (_, Some(Site::Region(region, _))) => Some(region),
            (_, Some(Site::Point { region, .. })) => region.as_deref(),
            _ => None,
        }
    }

    fn site(&self) -> Option<&Site> {
        match self {
            FunctionalSpec::Pressure(at)
            | FunctionalSpec::Velocity { at, .. }
            | FunctionalSpec::Stress { at, .. } => Some(at),
            _ => None,
        }
    }

    /// The body without which it has no meaning, `true`: the fluid; `None`: it is that of a point or of a region.
    /// `solid_pressure`: whether a solid has a pressure.
    pub(super) fn needs_fluid(&self, solid_pressure: bool) -> Option<bool> {
        let pressure = !solid_pressure;
        match self {
            FunctionalSpec::PressureDifference { .. } => Some(pressure),
            FunctionalSpec::Energy(integral) => Some(integral.is_of_fluid()),
            FunctionalSpec::Displacement { .. } | FunctionalSpec::Rotation { .. } => Some(false),
            FunctionalSpec::Pressure(Site::Point { region: None, .. }) => pressure.then_some(true),
            _ => (!self.on().is_empty()).then_some(true),
        }
    }
}
