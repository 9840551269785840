//! The keys of `[mesh]`.

use super::key::{Key, number, text, word};
use super::schema::GENERATORS;
use crate::space::COORDINATES;

/// The keys of `[mesh]`.
pub(super) static MESH: [Key; 20] = [
    word("mesh.generator", &GENERATORS, "none", "built-in mesh, instead of `file`"),
    text("mesh.file", "none", "Gmsh file (formats 2.2 and 4.1) or VTU file, relative to the case file"),
    number("mesh.scale", "m", "1", "length of one unit of the coordinates in the file"),
    word("mesh.coordinates", &COORDINATES, "cartesian", "what the coordinates of the mesh mean"),
    number("mesh.refine", "", "0", "uniform refinements"),
    number(
        "mesh.grading",
        "",
        "0",
        "nested rings of half cell size at the singular corners, or at the wall of a tube",
    ),
    number("mesh.lower", "m", "box: required", "least corner of the box, as [0, 0], in space as [0, 0, 0]"),
    number("mesh.upper", "m", "box: required", "opposite corner of the box, as [2, 1]"),
    number("mesh.length", "m", "tube: required", "length of the tube"),
    number(
        "mesh.radii",
        "m",
        "annulus, tube: required",
        "radii of the inner and the outer circle, as [1, 2]",
    ),
    number(
        "mesh.cells",
        "",
        "box, annulus, tube: required",
        "cells before refinement: x, y (and z); round, across; along, round, through the wall",
    ),
    text(
        "mesh.axis",
        "straight",
        "tube: expressions of z, the place of the axis at z of the straight tube, as [\"0\", \"0\", \"z\"]",
    ),
    text("mesh.leave-out", "[]", "regions of the mesh that are left out of the computation"),
    number("mesh.extrude.depth", "m", "none", "a plane mesh becomes one of space, 0 < z < depth"),
    number("mesh.extrude.layers", "", "required with depth", "layers of cells along z"),
    number(
        "mesh.extrude.grading",
        "",
        "0",
        "halvings of the first and the last layer towards front and back",
    ),
    text(
        "mesh.wall.surface",
        "none",
        "boundaries in space that a wall grows from: region `wall`, boundaries `outer`, `wall-OPENING`",
    ),
    number(
        "mesh.wall.thickness",
        "m",
        "required with surface",
        "thickness of the wall: a number or an expression of x, y, z on the surface",
    ),
    number("mesh.wall.layers", "", "1", "layers of cells through the wall, before refinement"),
    text("mesh.region.NAME", "none", "box, annulus: expression of x, y that is positive inside the region"),
];
