//! Whether a case takes multigrid, and what it must have for it.

use super::memory::{IN_SPACE, MANY, available_memory, size};
use crate::algebra::LinearSolverKind;
use crate::case::{Case, Linearization, MotionModel, Precision};
use crate::element::Shape;
use crate::error::Error;
use crate::multigrid;
use crate::space::FsiSpace;
use crate::time::Scheme;

/// Up to where the matrix of a step may be in single precision. Products with motions as a whole lose 6e-8 times this number
/// times the ratio of an entry of the stiffness to one of the mass, about 100.
const SINGLE: f64 = 1e4;

impl Case {
    /// Whether the condensed system on `space` is solved by multigrid.
    pub(super) fn takes_multigrid<const D: usize>(&self, space: &FsiSpace<D>) -> bool {
        match self.linear.solver {
            LinearSolverKind::Multigrid => true,
            LinearSolverKind::Automatic => {
                let fits =
                    !space.hierarchy.coarser().is_empty() && space.nodes.n_lagrange == space.nodes.len();
                let fits = fits && space.mesh.shape != Shape::Tetrahedron;
                let condensed = self.newton.linearization == Linearization::Condensed;
                // Without inertia it may fail on long cells.
                D == 3 && self.time.is_some() && condensed && fits && space.mesh.n_cells() >= MANY
            }
            _ => false,
        }
    }

    /// How cycles of multigrid are done, if it is taken.
    pub(super) fn levels<const D: usize>(&self, space: &FsiSpace<D>) -> Option<multigrid::Settings> {
        let double = self.linear.precision == Precision::Double;
        // Parts of a step that share factors need the matrix of the factors beside their own.
        let in_parts = self.time.as_ref().is_some_and(|time| time.scheme == Scheme::FractionalStepTheta);
        let single = !double && !in_parts && self.stiffness_of_steps(space) < SINGLE;
        self.takes_multigrid(space).then_some(multigrid::Settings { double, single, ..Default::default() })
    }

    /// The largest forces that hold cells together beside their inertia: k² E/(ρ h²) in the solid, k ν/h² in the fluid,
    /// h being the smallest size of a cell. Infinite at rest.
    fn stiffness_of_steps<const D: usize>(&self, space: &FsiSpace<D>) -> f64 {
        let Some(time) = &self.time else { return f64::INFINITY };
        // A step that changes with time may become any.
        let given = time.step.constant_value().unwrap_or(f64::INFINITY);
        let k = time.adaptive.as_ref().map_or(given, |adaptive| adaptive.max_step);
        let sizes = (0..space.mesh.n_cells()).flat_map(|cell| space.mesh.sizes(cell));
        let h = sizes.fold(f64::INFINITY, f64::min);
        let solid = self.solids.iter().map(|solid| k * k * solid.stiffness() / (solid.density * h * h));
        let fluid = self.fluids.iter().map(|fluid| k * fluid.kinematic_viscosity / (h * h));
        solid.chain(fluid).fold(0.0, f64::max)
    }

    /// Whether the extension has factors although the flow has multigrid.
    pub(super) fn factorises_extension(&self) -> bool {
        self.motion.model == MotionModel::Biharmonic && !self.solids.is_empty() && !self.fluids.is_empty()
    }

    /// Bytes of the factors of a direct solver in space.
    pub(super) fn bytes_of_factors(&self, cells: usize) -> f64 {
        let alike = self.alike(cells as f64);
        IN_SPACE[1] * alike.powf(4.0 / 3.0)
    }

    /// Whether there is memory for a run with the factors of the whole matrix, and of the condensed one.
    pub(super) fn direct_fits<const D: usize>(&self, space: &FsiSpace<D>) -> [bool; 2] {
        let at_hand = available_memory().unwrap_or(f64::INFINITY);
        [Linearization::Newton, Linearization::Condensed].map(|linearization| {
            let mut case = self.clone();
            (case.linear.solver, case.newton.linearization) = (LinearSolverKind::Multifrontal, linearization);
            let cells = space.mesh.n_cells();
            case.expected_bytes(cells, cells) <= at_hand
        })
    }

    /// What was chosen in place of `automatic`, if it is not the usual solver, and whether no other can take over.
    pub(super) fn note_on_solver<const D: usize>(&self, space: &FsiSpace<D>) -> Option<String> {
        if !self.takes_multigrid(space) {
            return None;
        }
        let cells = space.mesh.n_cells();
        let chosen = self.linear.solver == LinearSolverKind::Automatic;
        let chosen = chosen.then(|| {
            let factors = size(self.bytes_of_factors(cells));
            format!("multigrid is taken, factors of {cells} cells would need about {factors}")
        });
        let alone = (!self.direct_fits(space)[1]).then(|| {
            "the run ends where multigrid does not converge: factors do not fit the memory".to_string()
        });
        let parts: Vec<String> = chosen.into_iter().chain(alone).collect();
        (!parts.is_empty()).then(|| format!("linear.solver: {}", parts.join("; ")))
    }

    /// Multigrid that is asked for needs coarser meshes, and nodes that they have, too.
    pub(super) fn check_multigrid<const D: usize>(&self, space: &FsiSpace<D>) -> Result<(), Error> {
        if self.linear.solver != LinearSolverKind::Multigrid {
            return Ok(());
        }
        let message = if space.mesh.shape == Shape::Tetrahedron {
            "multigrid on tetrahedra is not yet available: give hexahedra"
        } else if space.hierarchy.coarser().is_empty() && self.mesh.refine == 0 {
            "multigrid needs the coarser meshes of a refined one: give mesh.refine of at least 1"
        } else if space.hierarchy.coarser().is_empty() {
            "multigrid needs coarser meshes, which are lost where cells are graded after mesh.refine and where a \
             tube has an axis"
        } else if space.nodes.n_lagrange < space.nodes.len() {
            "multigrid needs nodes of coarser meshes, and bubbles are none"
        } else {
            return Ok(());
        };
        Err(self.refuse("linear.solver", format!("{message}, or take `multifrontal`")))
    }
}
