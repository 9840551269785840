//! Statistics, comparisons, and what `check` tells.
