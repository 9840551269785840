//! How to run over cells: batches of cells in vector lanes, chunks of batches for threads, interpolation, testing,
//! and sums at fixed places of vectors and matrices.
//!
//! Nothing here knows an equation. Cells are processed `L` at a time, one per vector lane, in chunks that threads share
//! out. Every sum has one order, so that the result does not depend on the number of threads. After the first call
//! nothing is allocated.
//!
//! The loops are of this crate alone: vectors of several lanes are for processors that have the instructions, which
//! `operators` looks after.
// Unit tests have no kernels, see `operators::region`.
#![cfg_attr(test, allow(dead_code))]

pub(crate) mod batch;
pub(crate) mod chunks;
pub(crate) mod evaluate;
pub(crate) mod scatter;
pub(crate) mod slots;
pub(crate) mod tensor;
pub(crate) mod test_functions;
pub(crate) mod width;
