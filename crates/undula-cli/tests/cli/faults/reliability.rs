//! Files, signals, checkpoints.
