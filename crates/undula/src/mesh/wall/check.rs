//! Whether a wall folds, meets itself or meets the mesh that it was grown from.

use super::{Growth, place, refuse};
use crate::mesh::{Locator, Mesh, MeshError};

/// Steps by which the thickness that would do is sought.
const STEPS: i32 = 7;
/// Points looked at lie outside of the wall by this part of its thickness.
const BEYOND: f64 = 0.02;

impl Growth<'_> {
    /// Refuses a wall, as it is `alone`, that folds.
    pub(super) fn check_folds(&self, alone: &Mesh<3>) -> Result<(), MeshError> {
        let Err(MeshError::Inverted(cells, least)) = alone.check_orientation() else { return Ok(()) };
        let at = place(alone, std::array::from_fn(|d| least.at[d]));
        let (mut good, mut bad) = (0.0, 1.0);
        for _ in 0..STEPS {
            let middle = 0.5 * (good + bad);
            match self.alone(middle).check_orientation() {
                Ok(()) => good = middle,
                Err(_) => bad = middle,
            }
        }
        let way_out = match good {
            0.0 => "even a much thinner one would fold: round the corner there, as by a fillet".to_string(),
            _ => format!("{:.2} of the thickness would do", (100.0 * good).floor() / 100.0),
        };
        let reason = format!(
            "the wall folds in {} cells, most at {at}: the surface is bent outwards there with a radius below the \
             thickness, or the wall leans too far beside an oblique opening; {way_out}",
            cells.count
        );
        refuse("thickness", reason)
    }

    /// Refuses a wall of `mesh` that meets itself or another part of the mesh.
    pub(super) fn check_overlaps(&self, mesh: &Mesh<3>) -> Result<(), MeshError> {
        let locator = Locator::new(mesh);
        for (i, growth) in self.growth.iter().enumerate() {
            let x = mesh.nodes[self.surface.nodes[i] as usize];
            let beyond = std::array::from_fn(|d| x[d] + (1.0 + BEYOND) * growth[d]);
            // Points outside of all cells have no place.
            let Ok(found) = locator.find_where(beyond, 0.0, |_| true) else { continue };
            let region = &mesh.regions[mesh.cell_region[found.cell] as usize];
            let reason = format!(
                "the wall meets region `{region}` at {}: two parts of the surface are closer there than the thickness",
                place(mesh, beyond)
            );
            return refuse("thickness", reason);
        }
        Ok(())
    }
}
