//! The table `[mesh]`.

use super::body::{NAME, names_something};
use super::resolve;
use crate::case::error::quoted;
use crate::case::expression::Expression;
use crate::case::read::{POSITIVE, Section, Vectors};
use crate::case::schema::{Extrude, GENERATORS, MeshSource, MeshSpec, WallSpec};
use crate::choice;
use crate::mesh::gmsh;
use crate::space::COORDINATES;
use std::collections::BTreeMap;
use std::path::Path;

pub(super) fn mesh(mut s: Section<'_, '_>, root: &Section<'_, '_>) -> Option<MeshSpec> {
    let generator = s.choice("generator", &GENERATORS, &[]);
    let file = s.string("file");
    let scale = s.number("scale", 1.0, POSITIVE);
    let coordinates = s.choice("coordinates", &COORDINATES, &[]).unwrap_or_default();
    root.checker.coordinates.set(coordinates);
    let refine = s.integer("refine", 0, 0..=10) as u32;
    let grading = s.integer("grading", 0, 0..=30) as u32;
    let (corners, extrude) = sizes(&mut s, root, generator.as_ref(), file.as_deref());
    let wall = wall(&mut s, root, extrude.is_some());
    let radii = s.pair("radii", POSITIVE);
    let length = s.has("length").then(|| s.number("length", 1.0, POSITIVE));
    let axis = axis(&mut s);
    let region = regions(s.section("region"));
    let leave_out = s.names("leave-out", "[\"rock\"]", 0).unwrap_or_default();
    let own = root.checker.mesh;
    check_source(&s, root);
    sizes_belong(&s, generator.as_ref(), file.is_some());
    if s.has("scale") && file.is_none() {
        s.wrong("scale", "only for `file`: the generators make meshes in metres");
    }
    match generator {
        Some(MeshSource::Annulus { .. }) => check_ring(&s, radii, corners.cells.as_deref(), 0),
        Some(MeshSource::Tube { .. }) => check_ring(&s, radii, corners.cells.as_deref(), 1),
        _ => {}
    }
    let source = match (generator, file) {
        (Some(MeshSource::Annulus { .. }), _) => {
            MeshSource::Annulus { radii: radii?, cells: <[usize; 2]>::try_from(corners.cells?).ok()? }
        }
        (Some(MeshSource::Tube { .. }), _) => MeshSource::Tube {
            length: length?,
            radii: radii?,
            cells: <[usize; 3]>::try_from(corners.cells?).ok()?,
            axis,
        },
        (Some(MeshSource::Box { .. }), _) => {
            MeshSource::Box { lower: corners.lower?, upper: corners.upper?, cells: corners.cells? }
        }
        (Some(generator), _) => generator,
        (None, Some(file)) => MeshSource::File(resolve(&s, "file", &file)),
        // A mistake was told; what follows is checked nevertheless.
        (None, None) => MeshSource::TurekHron,
    };
    let source = own.map_or(source, |mesh| MeshSource::Own(mesh.clone()));
    s.finish();
    Some(MeshSpec {
        source,
        dimension: root.checker.vectors.get().len(),
        scale,
        extrude,
        wall,
        coordinates,
        refine,
        grading,
        region,
        leave_out,
        absent: vec![],
    })
}

/// Refuses two sources of the mesh, and misses one.
fn check_source(s: &Section<'_, '_>, root: &Section<'_, '_>) {
    if root.checker.mesh.is_some() {
        refuse_source(s);
    } else if !s.is_present() {
        root.missing("mesh", "add [mesh] with generator = \"turek-hron\" or file = \"own.msh\"");
    } else if s.has("generator") && s.has("file") {
        s.wrong("file", "give either `generator` or `file`");
    } else if !s.has("generator") && !s.has("file") && !s.means("file") {
        let generators = quoted(choice::names(&GENERATORS));
        s.missing("generator", &format!("give `generator` ({generators}) or `file`"));
    }
}

/// Sizes of a box, or of a ring.
struct Corners {
    lower: Option<Vec<f64>>,
    upper: Option<Vec<f64>>,
    cells: Option<Vec<usize>>,
}

/// The sizes of the mesh, and how many components vectors have on it.
fn sizes(
    s: &mut Section<'_, '_>,
    root: &Section<'_, '_>,
    generator: Option<&MeshSource>,
    file: Option<&str>,
) -> (Corners, Option<Extrude>) {
    let extrude = extrude(s.section("extrude"));
    // One that has another number of components than the others is told.
    let given = ["lower", "upper", "cells"].into_iter().filter(|key| s.length(key) == Some(3)).count();
    let in_space = match generator {
        Some(MeshSource::Box { .. }) => given > 1,
        Some(MeshSource::FsiBox | MeshSource::Tube { .. }) => true,
        _ => false,
    };
    let generated = if in_space { Vectors::Space } else { Vectors::Plane };
    root.checker.vectors.set(generated);
    let corners = Corners { lower: s.point("lower"), upper: s.point("upper"), cells: s.counts("cells") };
    if let (Some(a), Some(b)) = (&corners.lower, &corners.upper)
        && a.iter().zip(b).any(|(a, b)| a >= b)
    {
        let place = if in_space { "right of, above and behind" } else { "right of and above" };
        let shown: Vec<String> = a.iter().map(f64::to_string).collect();
        s.wrong("upper", format!("expected a corner {place} `lower` = [{}]", shown.join(", ")));
    }
    let on_file = file.map(|file| of_file(&resolve(s, "file", file)));
    if extrude.is_some() && (in_space || on_file == Some(Some(Vectors::Space))) {
        s.wrong("extrude", "only for meshes of the plane: this one is of space");
    }
    let on_mesh = on_file.map_or(Some(generated), |on_file| on_file);
    root.checker.is_plane.set(extrude.is_none() && on_mesh == Some(Vectors::Plane));
    root.checker.vectors.set(match extrude {
        Some(extrude) => Vectors::Extruded { middle: 0.5 * extrude.depth },
        None => on_mesh.unwrap_or_else(|| meant(s, root)),
    });
    if root.checker.coordinates.get().is_axisymmetric() && root.checker.vectors.get() != Vectors::Plane {
        let of_mesh = if extrude.is_some() { "an extruded mesh" } else { "a mesh of space" };
        s.wrong(
            "coordinates",
            format!("expected `cartesian`: {of_mesh} is no section through a body of revolution"),
        );
    }
    (corners, extrude)
}

/// How many components vectors have on the mesh in a file; `None` if it cannot be read, which is told later.
fn of_file(path: &Path) -> Option<Vectors> {
    match gmsh::dimension(path) {
        Ok(3) => Some(Vectors::Space),
        Ok(_) => Some(Vectors::Plane),
        Err(_) => None,
    }
}

/// How many components vectors have where the mesh cannot be read, which is told later: as many as the case gives them.
fn meant(s: &Section<'_, '_>, root: &Section<'_, '_>) -> Vectors {
    let vectors = ["velocity", "displacement", "traction", "body-force", "point", "a", "b"];
    let in_space = s.has("wall") || root.checker.document.root.has_array(&vectors, 3);
    if in_space { Vectors::Space } else { Vectors::Plane }
}

/// How a plane mesh becomes one of space.
fn extrude(mut s: Section<'_, '_>) -> Option<Extrude> {
    if !s.is_present() {
        return None;
    }
    for (key, about) in
        [("depth", "the extent along z [m], such as 0.1"), ("layers", "the number of layers, such as 1")]
    {
        if !s.has(key) {
            s.missing(key, about);
        }
    }
    let (depth, layers) = (s.number("depth", 1.0, POSITIVE), s.integer("layers", 1, 1..=100_000));
    let grading = s.integer("grading", 0, 0..=30);
    if grading > 0 && layers == 1 && s.has("layers") {
        s.wrong("grading", "only for two layers or more: those at both ends are halved");
    }
    s.finish();
    Some(Extrude { depth, layers, grading })
}

/// The wall around a mesh of space.
fn wall(of: &mut Section<'_, '_>, root: &Section<'_, '_>, is_extruded: bool) -> Option<WallSpec> {
    let mut s = of.section("wall");
    if !s.is_present() {
        return None;
    }
    // Not where the file cannot be read.
    if root.checker.is_plane.get() {
        of.wrong("wall", "only for meshes of space: this one is of the plane");
    } else if is_extruded {
        of.wrong(
            "wall",
            "not for extruded meshes: expected a file with cells of space, or a generator of space",
        );
    }
    let surface = s.names("surface", "[\"lumen\"]", 1);
    let thickness = s.expression("thickness");
    for (key, about) in [
        ("surface", "the boundary that the wall grows from, such as \"lumen\""),
        ("thickness", "the thickness [m], a number or an expression of x, y, z"),
    ] {
        if !s.has(key) {
            s.missing(key, about);
        }
    }
    if thickness.as_ref().is_some_and(Expression::depends_on_time) {
        s.wrong("thickness", "it is that of the undeformed wall and cannot depend on t");
    }
    if thickness.as_ref().and_then(Expression::constant_value).is_some_and(|h| h <= 0.0) {
        s.wrong("thickness", "expected a number above 0");
    }
    let layers = s.integer("layers", 1, 1..=1000);
    s.finish();
    Some(WallSpec { surface: surface?, thickness: thickness?, layers })
}

/// Which generators take a key.
const SIZES: [(&str, &[&str]); 7] = [
    ("lower", &["box"]),
    ("upper", &["box"]),
    ("length", &["tube"]),
    ("axis", &["tube"]),
    ("radii", &["annulus", "tube"]),
    ("cells", &["box", "annulus", "tube"]),
    ("region", &["box", "annulus"]),
];

/// Refuses sizes of another generator, and misses those of this one.
fn sizes_belong(s: &Section<'_, '_>, generator: Option<&MeshSource>, file: bool) {
    let (this, needs) = match generator {
        Some(MeshSource::Box { .. }) => {
            ("box", "a box needs `lower` and `upper` corner [m] and `cells` per direction")
        }
        Some(MeshSource::Annulus { .. }) => {
            ("annulus", "an annulus needs `radii` [m], as [1, 2], and `cells` round and across, as [16, 4]")
        }
        Some(MeshSource::Tube { .. }) => (
            "tube",
            "a tube needs `length` and `radii` [m], as [1, 2], and `cells` along, round and through the wall, as [20, 16, 1]",
        ),
        _ => ("", ""),
    };
    for (key, generators) in SIZES {
        let is_used = generators.contains(&this);
        if s.has(key) && !is_used && (generator.is_some() || file) {
            let names: Vec<String> = generators.iter().map(|name| format!("{name:?}")).collect();
            let (last, before) = names.split_last().map_or(("", &[][..]), |(last, before)| (last, before));
            let or = if before.is_empty() { "" } else { " or " };
            s.wrong(key, format!("only for generator = {}{or}{last}", before.join(", ")));
        } else if is_used && !s.has(key) && !["region", "axis"].contains(&key) {
            s.missing(key, needs);
        }
    }
}

/// Refuses a ring that has no thickness, or that has no vertices on the axes; `round` is which of the cells are those
/// round it.
fn check_ring(s: &Section<'_, '_>, radii: Option<[f64; 2]>, cells: Option<&[usize]>, round: usize) {
    if radii.is_some_and(|[inner, outer]| inner >= outer) {
        s.wrong("radii", "expected the radius of the inner circle, then the larger one of the outer circle");
    }
    if cells.is_some_and(|cells| !cells[round].is_multiple_of(4)) {
        let example = if round == 0 { "[16, 4]" } else { "[20, 16, 1]" };
        s.wrong("cells", format!("expected a multiple of 4 round, as {example}"));
    }
}

/// Keys that say where the mesh comes from, if the program gives it.
fn refuse_source(s: &Section<'_, '_>) {
    for key in [
        "generator",
        "file",
        "grading",
        "lower",
        "upper",
        "length",
        "radii",
        "cells",
        "axis",
        "region",
        "wall",
    ] {
        if s.has(key) {
            s.wrong(key, "the program gives the mesh");
        }
    }
}

/// The curve that the axis of a tube follows, `[]` if it is straight.
fn axis(s: &mut Section<'_, '_>) -> Vec<Expression> {
    let axis = s.expressions("axis").unwrap_or_default();
    if axis.iter().any(|e| e.depends_on_time() || e.depends_across()) {
        s.wrong(
            "axis",
            "expected expressions of z, the coordinate along the straight tube, without x, y and t",
        );
    }
    axis
}

fn regions(mut s: Section<'_, '_>) -> BTreeMap<String, Expression> {
    let mut regions = BTreeMap::new();
    for key in s.keys() {
        if let Some(expression) = s.expression(&key) {
            if expression.depends_on_time() {
                s.wrong(&key, "a region cannot depend on t");
            }
            if !names_something(&key) {
                s.wrong(&key, NAME);
            }
            regions.insert(key, expression);
        }
    }
    regions
}
