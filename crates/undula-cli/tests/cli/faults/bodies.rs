//! Regions, interfaces and enclosed parts of the fluid.
