//! What is made in one way in the plane and in another in space; all else is generic in the dimension.

use super::mesh::Refined;
use crate::case::Case;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::system::{Dim, Kernels};

/// A dimension in which cases are computed.
pub trait Dimension<const D: usize>: Kernels<D> {
    /// The mesh of a case, refined as it asks.
    ///
    /// # Errors
    /// A mesh that cannot be made or read, or that needs more memory than there is.
    fn refined(case: &Case) -> Result<Refined<D>, Error>;

    /// Refuses a mesh that cannot be that of a body of revolution if the case takes it for one.
    ///
    /// # Errors
    /// [`Error::Case`] with the place.
    fn check_axis(case: &Case, mesh: &Mesh<D>) -> Result<(), Error>;
}

impl Dimension<2> for Dim<2> {
    fn refined(case: &Case) -> Result<Refined<2>, Error> {
        case.refined_plane()
    }

    fn check_axis(case: &Case, mesh: &Mesh<2>) -> Result<(), Error> {
        case.check_axis(mesh)
    }
}

impl Dimension<3> for Dim<3> {
    fn refined(case: &Case) -> Result<Refined<3>, Error> {
        case.refined_space()
    }

    fn check_axis(_: &Case, _: &Mesh<3>) -> Result<(), Error> {
        Ok(())
    }
}
