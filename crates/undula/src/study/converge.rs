//! Orders and extrapolated values.
