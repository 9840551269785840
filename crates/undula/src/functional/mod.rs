//! Numbers of interest.
