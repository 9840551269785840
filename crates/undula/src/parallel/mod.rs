//! Processes that compute together: what they tell each other.
//!
//! [`Comm`] is what one process knows of the others; [`Alone`] is that of a process without others, [`World`] that of
//! processes that MPI has started, whose library is loaded at run time. Sums are added in the order of the ranks, on
//! every process alike: MPI promises that order for none of its own sums, and a run must repeat its bits. [`Team`] is what
//! the processes of a run agree on, [`Crew`] those of them that share a mesh, [`Halo`] the unknowns of a system that they
//! share.

mod alone;
mod comm;
mod crew;
pub(crate) mod halo;
pub(crate) mod library;
pub(crate) mod mpi;
mod team;
#[doc(hidden)]
pub mod threads;

pub use alone::Alone;
pub use comm::{Comm, Fault, Message, Reduce};
pub use crew::{Crew, Traffic};
pub use halo::{Halo, Shared};
pub use mpi::World;
pub use team::{Agreed, Team, Wish};
