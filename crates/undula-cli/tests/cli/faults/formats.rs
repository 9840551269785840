//! Meshes as Gmsh writes them.
