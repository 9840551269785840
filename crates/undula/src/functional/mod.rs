//! Numbers of interest.

pub mod statistics;
