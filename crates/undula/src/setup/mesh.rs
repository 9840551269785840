//! The mesh of a case: made or read, refined, with its regions and the names of their sides.

use super::names::MeshNames;
use super::regions::mesh_key;
use crate::case::error::{CaseError, CaseErrors};
use crate::case::{Case, MeshSource, OwnMesh};
use crate::element::Shape;
use crate::error::Error;
use crate::mesh::{Curve, Hierarchy, INTERFACE, Mesh, MeshError, generate, gmsh};

/// The complete mesh of a case, with its regions and the names of their sides.
pub(super) struct Marked {
    pub mesh: Mesh<2>,
    /// The meshes that it was refined from, as far as they have the same regions.
    pub hierarchy: Hierarchy<2>,
    /// What should be known of it.
    pub notes: Vec<String>,
}

#[doc(hidden)]
impl Case {
    /// The complete mesh with its interface and the sides of regions that are left out marked, checked against the case.
    ///
    /// # Errors
    /// A mesh that cannot be made or read, that does not match, or that does not have the names in the case.
    pub fn build_mesh(&self) -> Result<Mesh<2>, Error> {
        Ok(self.marked_mesh()?.mesh)
    }

    /// The same with its hierarchy and with what should be known of it.
    pub(super) fn marked_mesh(&self) -> Result<Marked, Error> {
        self.check_memory(None)?;
        let (mesh, curves) = self.unrefined()?;
        let (mut mesh, hierarchy) = Hierarchy::refine(mesh, self.mesh.refine as usize, &curves);
        self.check_shape(&mesh)?;
        let mut notes = self.assign_regions(&mut mesh)?;
        let unfit = self.check_regions(&mesh.regions);
        if !unfit.is_empty() {
            return Err(Error::Case(CaseErrors(unfit)));
        }
        notes.extend(self.mark_sides(&mut mesh)?);
        let names = MeshNames::of(&mesh);
        self.check_mesh(&names)?;
        notes.extend(self.outer_interface(&names));
        let blame = |e| self.blame(mesh_key(self), e);
        mesh.check_kept(&self.regions()).map_err(blame)?;
        let (fluids, solids) = (self.fluid_regions(), self.solid_regions());
        if !fluids.is_empty() && !solids.is_empty() && mesh.boundary(INTERFACE).is_some() {
            mesh.check_interface_of(&fluids, &solids).map_err(blame)?;
        }
        mesh.check_curves(&curves).map_err(blame)?;
        Ok(Marked { hierarchy: hierarchy.named_as(&mesh), mesh, notes })
    }

    /// The mesh before it is refined, as it is made or read, with the curves that its boundaries follow.
    fn unrefined(&self) -> Result<(Mesh<2>, Vec<Curve<2>>), Error> {
        let spec = &self.mesh;
        let grading = spec.grading as usize;
        let (mesh, curves): (Mesh<2>, Vec<Curve<2>>) = match &spec.source {
            MeshSource::TurekHron => (generate::turek_hron(0, grading), vec![generate::cylinder()]),
            MeshSource::SchaeferTurek => (generate::schaefer_turek(0), vec![generate::cylinder()]),
            MeshSource::Rotor => (generate::rotor(0, grading), vec![]),
            MeshSource::Flap => (generate::flap(0, grading), vec![]),
            MeshSource::Cavity => (generate::cavity(0), vec![]),
            MeshSource::Tube2d => (generate::tube_2d(0), vec![]),
            MeshSource::Valve => (generate::valve(0, grading), vec![]),
            MeshSource::Annulus { radii, cells } => {
                (generate::annulus(*radii, *cells, 0)?, generate::circles(*radii))
            }
            MeshSource::Box { lower, upper, cells } => {
                (generate::rectangle(*lower, *upper, *cells, 0)?, vec![])
            }
            MeshSource::File(path) => {
                let mut mesh = gmsh::read(path).map_err(|e| self.blame("mesh.file", e))?;
                self.check_memory(Some(&mesh))?;
                mesh.nodes.iter_mut().flatten().for_each(|x| *x *= spec.scale);
                if mesh.nodes.iter().flatten().any(|x| !x.is_finite()) {
                    return Err(self.refuse("mesh.scale", "coordinates times this are too large".into()));
                }
                return Ok((mesh, vec![]));
            }
            MeshSource::Own(OwnMesh(mesh)) => {
                self.check_memory(Some(mesh))?;
                return Ok((Mesh::clone(mesh), vec![]));
            }
        };
        // Triangles are refined after they are made.
        let triangles = self.space.velocity.shape() == Shape::Triangle;
        Ok((if triangles { mesh.triangulated() } else { mesh }, curves))
    }

    /// Refuses cells on which the velocity does not live.
    fn check_shape(&self, mesh: &Mesh<2>) -> Result<(), Error> {
        let velocity = self.space.velocity;
        if mesh.shape == velocity.shape() {
            return Ok(());
        }
        let other = if mesh.shape == Shape::Triangle { "P2" } else { "Q2" };
        let reason = format!(
            "space.velocity = {} needs {}, the mesh has {}: take {other}, or a mesh of {}",
            velocity.name(),
            velocity.shape().name(),
            mesh.shape.name(),
            velocity.shape().name()
        );
        Err(self.blame("space.velocity", MeshError::WrongCells(reason)))
    }

    /// An error of the mesh, told with the place of the `key` of the case that is to blame.
    pub(super) fn blame(&self, key: &str, error: MeshError) -> Error {
        self.refuse(key, error.to_string())
    }

    /// An error of the input with the place of the `key` that is to blame.
    pub(crate) fn refuse(&self, key: &str, message: String) -> Error {
        let place = self.place_of(key);
        Error::Case(CaseErrors(vec![CaseError { place, key: key.into(), value: None, message }]))
    }
}
