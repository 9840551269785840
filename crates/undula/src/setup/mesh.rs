//! The mesh of a case: made or read, refined, with its regions and the names of their sides.

use super::dimension::{Dimension, Refined};
use super::names::MeshNames;
use super::regions::mesh_key;
use crate::case::error::{CaseError, CaseErrors};
use crate::case::expression::Expression;
use crate::case::schema::{Extrude, WallSpec};
use crate::case::{Case, MeshSource, OwnMesh};
use crate::error::Error;
use crate::mesh::gmsh::AnyMesh;
use crate::mesh::{Curve, Extrusion, Hierarchy, INTERFACE, Mesh, MeshError, Wall, generate, gmsh};
use crate::system::Dim;

/// The components of a position, or numbers along its coordinates.
fn first<T: Copy, const D: usize>(all: &[T]) -> [T; D] {
    std::array::from_fn(|d| all[d])
}

/// A made mesh of hexahedra in tetrahedra, their nodes on the same curves.
fn in_tetrahedra(mesh: &Mesh<3>, curves: &[Curve<3>]) -> Mesh<3> {
    let mut mesh = mesh.in_tetrahedra();
    mesh.project_boundaries(curves);
    mesh
}

/// The complete mesh of a case, with its regions and the names of their sides.
pub(super) struct Marked<const D: usize> {
    pub mesh: Mesh<D>,
    /// The meshes that it was refined from, as far as they have the same regions.
    pub hierarchy: Hierarchy<D>,
    /// What should be known of it.
    pub notes: Vec<String>,
}

#[doc(hidden)]
impl Case {
    /// The complete mesh of the plane with its interface and the sides of regions that are left out marked, checked against
    /// the case.
    ///
    /// # Errors
    /// A mesh that cannot be made or read, that does not match, or that does not have the names in the case.
    pub fn build_mesh(&self) -> Result<Mesh<2>, Error> {
        self.mesh_in()
    }

    /// The same in `D` dimensions.
    pub(crate) fn mesh_in<const D: usize>(&self) -> Result<Mesh<D>, Error>
    where
        Dim<D>: Dimension<D>,
    {
        Ok(self.marked_mesh()?.mesh)
    }

    /// The same in `D` dimensions, with its hierarchy and with what should be known of it.
    pub(super) fn marked_mesh<const D: usize>(&self) -> Result<Marked<D>, Error>
    where
        Dim<D>: Dimension<D>,
    {
        self.check_dimension(D)?;
        self.check_memory::<D>(None)?;
        let (mut mesh, hierarchy, curves) = Dim::<D>::refined(self)?;
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

    /// Refuses to compute in `dim` dimensions what has others.
    fn check_dimension(&self, dim: usize) -> Result<(), Error> {
        if self.mesh.dimension == dim {
            return Ok(());
        }
        let (is, takes) = if dim == 2 { ("space", "the plane") } else { ("the plane", "space") };
        Err(self.refuse("mesh", format!("the mesh is one of {is}, and this is for meshes of {takes}")))
    }

    /// The mesh of the plane before it is refined, as it is made or read, with the curves that its boundaries follow.
    fn unrefined(&self) -> Result<(Mesh<2>, Vec<Curve<2>>), Error> {
        let spec = &self.mesh;
        let grading = spec.grading as usize;
        let (mesh, curves): (Mesh<2>, Vec<Curve<2>>) = match &spec.source {
            MeshSource::TurekHron => (generate::turek_hron(0, grading), vec![generate::cylinder()]),
            MeshSource::SchaeferTurek => (generate::schaefer_turek(0), vec![generate::cylinder()]),
            MeshSource::Dfg3d => (generate::dfg_3d(0), vec![generate::cylinder_of_dfg_3d()]),
            MeshSource::Cook => (generate::cook(0), vec![]),
            MeshSource::Rotor => (generate::rotor(0, grading), vec![]),
            MeshSource::Flap => (generate::flap(0, grading), vec![]),
            MeshSource::Cavity => (generate::cavity(0), vec![]),
            MeshSource::Tube2d => (generate::tube_2d(0), vec![]),
            MeshSource::Valve => (generate::valve(0, grading), vec![]),
            MeshSource::Annulus { radii, cells } => {
                (generate::annulus(*radii, *cells, 0)?, generate::circles(*radii))
            }
            MeshSource::Box { lower, upper, cells } => {
                let mesh = generate::rectangle(first(lower), first(upper), first(cells), 0)?;
                (mesh, vec![])
            }
            MeshSource::FsiBox | MeshSource::Tube { .. } => {
                return Err(self.refuse("mesh.generator", "there is no such mesh in the plane".into()));
            }
            MeshSource::File(path) => {
                let mesh = gmsh::read(path).map_err(|e| self.blame("mesh.file", e))?;
                return Ok((self.scaled(mesh)?, vec![]));
            }
            MeshSource::Own(OwnMesh(mesh)) => {
                self.check_memory(Some(mesh))?;
                return Ok((Mesh::clone(mesh), vec![]));
            }
        };
        // Triangles are refined after they are made; what is extruded becomes tetrahedra.
        let triangles = self.space.velocity.is_simplicial() && spec.extrude.is_none();
        Ok((if triangles { mesh.triangulated() } else { mesh }, curves))
    }

    /// A mesh from a file with its coordinates in metres.
    fn scaled<const D: usize>(&self, mut mesh: Mesh<D>) -> Result<Mesh<D>, Error> {
        self.check_memory(Some(&mesh))?;
        mesh.nodes.iter_mut().flatten().for_each(|x| *x *= self.mesh.scale);
        if mesh.nodes.iter().flatten().any(|x| !x.is_finite()) {
            return Err(self.refuse("mesh.scale", "coordinates times this are too large".into()));
        }
        Ok(mesh)
    }

    /// The mesh of the plane, refined.
    pub(super) fn refined_plane(&self) -> Result<Refined<2>, Error> {
        let (mesh, curves) = self.unrefined()?;
        let (mesh, hierarchy) = Hierarchy::refine(mesh, self.mesh.refine as usize, &curves);
        Ok((mesh, hierarchy, curves))
    }

    /// The mesh of space, refined.
    pub(super) fn refined_space(&self) -> Result<Refined<3>, Error> {
        if let Some(Extrude { depth, layers, grading }) = self.mesh.extrude {
            let (plane, hierarchy, _) = self.refined_plane()?;
            let simplicial = self.space.velocity.is_simplicial();
            if !simplicial {
                self.check_shape(&plane)?;
            }
            let halved = self.needs_patches();
            let whole = hierarchy.extruded(&plane, Extrusion { depth, layers, grading, halved });
            let (mesh, hierarchy) = whole.map_err(|e| self.blame("mesh.extrude", e))?;
            if simplicial {
                return Ok((mesh.in_tetrahedra(), Hierarchy::default(), vec![]));
            }
            return Ok((mesh, hierarchy, vec![]));
        }
        let mut curves = vec![];
        let mesh = match &self.mesh.source {
            MeshSource::Box { lower, upper, cells } => {
                generate::hexahedra(first(lower), first(upper), first(cells), 0)?
            }
            MeshSource::FsiBox => generate::fsi_box(0, self.mesh.grading as usize)?,
            MeshSource::Tube { length, radii: [inner, outer], cells, .. } => {
                let size = [*length, *inner, outer - inner];
                curves = generate::cylinders(size);
                generate::tube_graded(size, *cells, self.mesh.grading as usize, 0)?
            }
            MeshSource::File(path) => match gmsh::read_any(path).map_err(|e| self.blame("mesh.file", e))? {
                AnyMesh::Space(mesh) => self.scaled(mesh)?,
                AnyMesh::Plane(_) => return Err(self.refuse("mesh.file", "it is a plane mesh".into())),
            },
            _ => return Err(self.refuse("mesh", "there is no such mesh in space".into())),
        };
        // Tetrahedra are refined after they are made; those of a file are as they are.
        let is_made = !matches!(self.mesh.source, MeshSource::File(_));
        let mesh =
            if is_made && self.space.velocity.is_simplicial() { in_tetrahedra(&mesh, &curves) } else { mesh };
        let mesh = self.walled(mesh)?;
        let (mesh, hierarchy) = Hierarchy::refine(mesh, self.mesh.refine as usize, &curves);
        match self.mesh.axis() {
            [] => Ok((mesh, hierarchy, curves)),
            axis => self.bent(mesh, axis),
        }
    }

    /// The mesh with the wall that the case asks for.
    fn walled(&self, mesh: Mesh<3>) -> Result<Mesh<3>, Error> {
        let Some(WallSpec { surface, thickness, layers }) = &self.mesh.wall else { return Ok(mesh) };
        let gap = std::cell::RefCell::new(String::new());
        let at = |x: [f64; 3]| {
            let value = thickness.eval(&x, 0.0);
            if value.is_nan() && gap.borrow().is_empty() {
                gap.replace(thickness.gap(&x, 0.0));
            }
            value
        };
        let blame = |e| match e {
            MeshError::Wall { key, .. } => {
                self.refuse(&format!("mesh.wall.{key}"), format!("{e}{}", gap.borrow()))
            }
            MeshError::UnknownName { .. } => self.blame("mesh.wall.surface", e),
            _ => self.blame(mesh_key(self), e),
        };
        let mesh = mesh.with_wall(&Wall { surface, thickness: &at, layers: *layers }).map_err(blame)?;
        self.check_memory(Some(&mesh))?;
        Ok(mesh)
    }

    /// A straight tube along the curve that its axis follows.
    fn bent(&self, mut mesh: Mesh<3>, axis: &[Expression]) -> Result<Refined<3>, Error> {
        let mut lost = None;
        generate::bend(&mut mesh, |z| {
            let along = |e: &Expression| {
                let (value, gradient) = e.eval_with_gradient(&[0.0, 0.0, z], 0.0);
                [value, gradient[2]]
            };
            let [a, b, c] = std::array::from_fn(|d| along(&axis[d]));
            let at = [[a[0], b[0], c[0]], [a[1], b[1], c[1]]];
            let slope = at[1].iter().map(|t| t * t).sum::<f64>().sqrt();
            let turns = at[1][2] > -0.999 * slope;
            if !(at.iter().flatten().all(|x| x.is_finite()) && slope > 0.0 && turns) {
                lost.get_or_insert(z);
            }
            at
        });
        match lost {
            // Nodes are on other places than those of coarser meshes, and on no cylinders.
            None => Ok((mesh, Hierarchy::default(), vec![])),
            Some(z) => Err(self.refuse(
                "mesh.axis",
                format!("at z = {z}: expected finite numbers that change with z, and a curve that does not run against z"),
            )),
        }
    }

    /// Refuses cells on which the velocity does not live.
    fn check_shape<const D: usize>(&self, mesh: &Mesh<D>) -> Result<(), Error> {
        let velocity = self.space.velocity;
        let needed = velocity.shape(D);
        if mesh.shape == needed {
            return Ok(());
        }
        let other = if mesh.shape.is_simplex() { "P2" } else { "Q2" };
        let reason = format!(
            "space.velocity = {} needs {}, the mesh has {}: take {other}, or a mesh of {}",
            velocity.name(),
            needed.name(),
            mesh.shape.name(),
            needed.name()
        );
        Err(self.blame("space.velocity", MeshError::WrongCells(reason)))
    }

    /// An error of the mesh, told with the place of the `key` of the case that is to blame.
    pub(super) fn blame(&self, key: &str, error: MeshError) -> Error {
        self.refuse(key, error.to_string())
    }

    /// An error of the input with the place of the `key` that is to blame.
    #[doc(hidden)]
    pub fn refuse(&self, key: &str, message: String) -> Error {
        let place = self.place_of(key);
        Error::Case(CaseErrors(vec![CaseError { place, key: key.into(), value: None, message }]))
    }
}
