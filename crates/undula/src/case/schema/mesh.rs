//! Where the mesh of a case comes from.

use crate::case::expression::Expression;
use crate::choice::{Choice, choice};
use crate::mesh::Mesh;
use crate::space::Coordinates;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

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
    /// A wall that is grown outward from a surface of a mesh of space, before it is refined; `None`: none.
    pub wall: Option<WallSpec>,
    /// What the coordinates mean.
    pub coordinates: Coordinates,
    /// Number of uniform refinements.
    pub refine: u32,
    /// Number of nested rings of half size around the singular corners of the generator, or at the wall of a tube.
    pub grading: u32,
    /// Regions defined by an expression of x, y that is positive inside (generators `box` and `annulus`).
    pub region: BTreeMap<String, Expression>,
    /// Regions that are not computed on; their sides are walls unless a condition names them.
    pub leave_out: Vec<String>,
    /// Regions of the bodies that a part of a case is without; no key, empty in a case as it is read.
    pub absent: Vec<String>,
}

impl MeshSpec {
    /// Where the axis of a tube goes, `[]` if it is straight, or of other meshes.
    pub fn axis(&self) -> &[Expression] {
        match &self.source {
            MeshSource::Tube { axis, .. } => axis,
            _ => &[],
        }
    }
}

/// A wall around a mesh of space.
#[derive(Clone, Debug, PartialEq)]
pub struct WallSpec {
    /// The boundaries that it grows from.
    pub surface: Vec<String>,
    /// Its thickness \[m\] above a point of the surface.
    pub thickness: Expression,
    /// Layers of cells through it, before refinement.
    pub layers: usize,
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
    /// A tube of space about the z axis, or about a curve.
    Tube {
        /// Length \[m\].
        length: f64,
        /// Inner and outer radius \[m\].
        radii: [f64; 2],
        /// Cells along, round (a multiple of 4) and through the wall before refinement.
        cells: [usize; 3],
        /// Where the axis goes, as expressions of z along the straight tube; empty: it is straight.
        axis: Vec<Expression>,
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
        MeshSource::Tube { length: 1.0, radii: [1.0, 2.0], cells: [1, 4, 1], axis: vec![] },
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
