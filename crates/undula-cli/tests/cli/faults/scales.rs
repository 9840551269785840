//! Small geometries and other units.
