//! What the mesh of a body of revolution must be.

use super::regions::mesh_key;
use crate::case::{Case, Condition};
use crate::error::Error;
use crate::mesh::{Facet, Mesh};

/// Part of the radius that is rounding.
const ROUNDING: f64 = 1e-9;

#[doc(hidden)]
impl Case {
    /// Refuses a mesh around an axis for `what`, which is written for the plane alone.
    ///
    /// # Errors
    /// [`Error::Case`] with the key of the coordinates.
    pub fn needs_plane(&self, what: &str) -> Result<(), Error> {
        if self.mesh.coordinates.is_axisymmetric() {
            let message = format!("{what} around an axis are not yet available; expected `cartesian`");
            return Err(self.refuse("mesh.coordinates", message));
        }
        Ok(())
    }

    /// Refuses a mesh around an axis that lies on both sides of it, and conditions on the axis that let the flow or the body
    /// leave it.
    ///
    /// # Errors
    /// [`Error::Case`] with the place.
    pub(super) fn check_axis(&self, mesh: &Mesh<2>) -> Result<(), Error> {
        if !self.mesh.coordinates.is_axisymmetric() {
            return Ok(());
        }
        let radii = || mesh.nodes.iter().map(|x| x[0]);
        let (least, largest) = radii().fold((f64::INFINITY, 0.0f64), |(a, b), r| (a.min(r), b.max(r.abs())));
        if least < -ROUNDING * largest {
            let message = format!(
                "the mesh reaches r = {least}: with mesh.coordinates = \"axisymmetric\" its first coordinate is the \
                 distance to the axis; expected a mesh in r ≥ 0, half of the section"
            );
            return Err(self.refuse(mesh_key(self), message));
        }
        let on_axis = |facet: &&Facet| {
            let nodes = mesh.facet_nodes(facet.cell as usize, facet.local as usize);
            nodes.iter().all(|&node| mesh.nodes[node as usize][0].abs() <= ROUNDING * largest)
        };
        for facet in mesh.facets.iter().filter(on_axis) {
            let name = &mesh.boundaries[usize::from(facet.boundary)];
            let stays = matches!(
                self.boundary.get(name),
                Some(Condition::Symmetry | Condition::Slip | Condition::NoSlip | Condition::Clamped)
            );
            if !stays {
                let message = "a part of this boundary is the axis r = 0, where nothing moves along r: expected a \
                               boundary of its own with condition = \"symmetry\"";
                return Err(self.refuse(&format!("boundary.{name}.condition"), message.into()));
            }
        }
        Ok(())
    }
}
