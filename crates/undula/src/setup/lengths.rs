//! Numbers that a case leaves open because they come from its mesh, and the scales of its equations.

use crate::case::{Case, MotionModel, MotionSpec, SolidSpec};
use crate::linear::Scales;
use crate::math::rounded;
use crate::mesh::Mesh;
use crate::space::FsiSpace;

/// d_0 as a part of the smaller extent of the fluid or of the larger one of the solid, whichever is less. Where d_0
/// is much smaller, a few cells far away take all of the motion; where it is larger than the body is thick, those at
/// its corners fold.
const OFFSET: f64 = 0.05;

/// L as a part of the smaller extent of the mesh.
const SCALE: f64 = 0.5;

#[doc(hidden)]
impl Case {
    /// `[motion]` with the lengths that it leaves open, for spaces of this case: d_0 is a twentieth of the smaller extent
    /// of the fluid or of the larger one of the solid, whichever is less; L is half the smaller extent of both.
    ///
    /// Extents are those of the mesh before `mesh.refine`, so that refinement does not change the problem. What has no
    /// effect stays open.
    pub fn motion_on<const D: usize>(&self, space: &FsiSpace<D>) -> MotionSpec {
        let mut motion = self.motion.clone();
        let (fluids, solids) = (self.fluid_regions(), self.solid_regions());
        if fluids.is_empty() || solids.is_empty() {
            return motion;
        }
        let elastic = matches!(motion.model, MotionModel::PseudoElastic | MotionModel::JacobianStiffened);
        let offset = elastic && motion.exponent != 0.0 && motion.offset.is_none();
        let scale = motion.model == MotionModel::StiffenedHarmonic && motion.scale.is_none();
        if !offset && !scale {
            return motion;
        }
        // Cells before refinement that are too large for the regions are straight, and refinement leaves their extents.
        let coarser = space.hierarchy.coarser();
        let mesh = coarser.first().filter(|_| coarser.len() == self.mesh.refine as usize);
        let mesh = mesh.unwrap_or(&space.mesh);
        // An extruded plane has the lengths of the plane.
        let along = if self.mesh.extrude.is_some() { 2 } else { D };
        let of = |names: &[&str]| extents(mesh, names, along);
        let [fluid, solid, both] = [of(&fluids), of(&solids), of(&self.regions())];
        if offset {
            motion.offset = Some(decimal(OFFSET * fluid[0].min(solid[1])));
        } else {
            motion.scale = Some(decimal(SCALE * both[0]));
        }
        motion
    }

    /// The case with the numbers that come from its mesh written out; as it is where that cannot be had.
    #[must_use]
    pub fn resolved(&self) -> Case {
        let motion = match self.mesh.dimension {
            3 => self.space_in::<3>().map(|space| self.motion_on(&space)),
            _ => self.space_in::<2>().map(|space| self.motion_on(&space)),
        };
        let motion = motion.unwrap_or_else(|_| self.motion.clone());
        Case { motion, ..self.clone() }
    }

    /// The largest density of a fluid, without fluid that of a solid \[kg/m³\].
    pub(super) fn largest_density(&self) -> Option<f64> {
        let largest = |densities: &mut dyn Iterator<Item = f64>| densities.reduce(f64::max);
        let fluid = largest(&mut self.fluids.iter().map(|f| f.density));
        fluid.or_else(|| largest(&mut self.solids.iter().map(|s| s.density)))
    }

    /// The scales of the equations on `space`, of several bodies with the largest density, viscosity and modulus;
    /// `stiffness` is the largest E_e.
    pub(super) fn scales<const D: usize>(&self, space: &FsiSpace<D>, stiffness: f64) -> Scales {
        let size = space.node_distance();
        // The operator of fourth order has the unit 1/m² besides.
        let fourth = self.motion.model == MotionModel::Biharmonic;
        let stiffness = if fourth { 1.0 / (size * size) } else { stiffness };
        let density = self.largest_density().unwrap_or(1.0);
        let modulus = self.solids.iter().map(SolidSpec::stiffness).fold(0.0, f64::max);
        let viscosity = self.fluids.iter().map(|f| f.kinematic_viscosity).fold(0.0, f64::max);
        Scales::new(space, density, viscosity, modulus, stiffness)
    }
}

/// `x` without the rounding of a difference of coordinates: 0.01, not 0.010000000000000002.
fn decimal(x: f64) -> f64 {
    rounded(x, x, 12)
}

/// The smallest and the largest side of the box around the cells of `regions` \[m\], along the first `along` coordinates.
fn extents<const D: usize>(mesh: &Mesh<D>, regions: &[&str], along: usize) -> [f64; 2] {
    let inside = |cell: &usize| regions.contains(&mesh.regions[mesh.cell_region[*cell] as usize].as_str());
    let (mut lower, mut upper) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
    for cell in (0..mesh.n_cells()).filter(inside) {
        for &node in mesh.cell(cell) {
            for d in 0..D {
                lower[d] = lower[d].min(mesh.nodes[node as usize][d]);
                upper[d] = upper[d].max(mesh.nodes[node as usize][d]);
            }
        }
    }
    let sides = (0..along).map(|d| upper[d] - lower[d]);
    [sides.clone().fold(f64::INFINITY, f64::min), sides.fold(0.0, f64::max)]
}
