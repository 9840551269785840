//! The table `[mesh]`.

use super::body::{NAME, names_something};
use super::resolve;
use crate::case::error::quoted;
use crate::case::expression::Expression;
use crate::case::read::{POSITIVE, Section, Vectors};
use crate::case::schema::{Extrude, GENERATORS, MeshSource, MeshSpec};
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
    refuse_section(&s, extrude.is_some());
    let radii = s.pair("radii", POSITIVE);
    let region = regions(s.section("region"));
    let leave_out = s.names("leave-out", "[\"rock\"]", 0).unwrap_or_default();
    let own = root.checker.mesh;
    if own.is_some() {
        refuse_source(&s);
    } else if !s.is_present() {
        root.missing("mesh", "add [mesh] with generator = \"turek-hron\" or file = \"own.msh\"");
    } else if s.has("generator") && s.has("file") {
        s.wrong("file", "give either `generator` or `file`");
    } else if !s.has("generator") && !s.has("file") && !s.means("file") {
        let generators = quoted(choice::names(&GENERATORS));
        s.missing("generator", &format!("give `generator` ({generators}) or `file`"));
    }
    sizes_belong(&s, generator.as_ref(), file.is_some());
    if s.has("scale") && file.is_none() {
        s.wrong("scale", "only for `file`: the generators make meshes in metres");
    }
    if let Some(MeshSource::Annulus { .. }) = generator {
        check_ring(&s, radii, corners.cells.as_deref());
    }
    let source = match (generator, file) {
        (Some(MeshSource::Annulus { .. }), _) => {
            MeshSource::Annulus { radii: radii?, cells: <[usize; 2]>::try_from(corners.cells?).ok()? }
        }
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
    let dimension = root.checker.vectors.get().len();
    Some(MeshSpec {
        source,
        dimension,
        scale,
        extrude,
        coordinates,
        refine,
        grading,
        region,
        leave_out,
        absent: vec![],
    })
}

/// Refuses to take a mesh of space for a section through a body of revolution.
fn refuse_section(s: &Section<'_, '_>, extruded: bool) {
    if s.checker.coordinates.get().is_axisymmetric() && s.checker.vectors.get().len() == 3 {
        let of_mesh = if extruded { "an extruded mesh" } else { "a mesh of space" };
        let message = format!("expected `cartesian`: {of_mesh} is no section through a body of revolution");
        s.wrong("coordinates", message);
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
    let in_space = matches!(generator, Some(MeshSource::Box { .. })) && given > 1;
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
        None => on_mesh.unwrap_or_default(),
    });
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
    s.finish();
    Some(Extrude { depth, layers: layers as usize })
}

/// Refuses sizes of another generator, and misses those of this one.
fn sizes_belong(s: &Section<'_, '_>, generator: Option<&MeshSource>, file: bool) {
    let is_box = matches!(generator, Some(MeshSource::Box { .. }));
    let is_ring = matches!(generator, Some(MeshSource::Annulus { .. }));
    for (key, of_box, of_ring) in [
        ("lower", true, false),
        ("upper", true, false),
        ("radii", false, true),
        ("cells", true, true),
        ("region", true, true),
    ] {
        let is_used = (is_box && of_box) || (is_ring && of_ring);
        if s.has(key) && !is_used && (generator.is_some() || file) {
            let generators = match (of_box, of_ring) {
                (true, true) => "\"box\" or \"annulus\"",
                (true, false) => "\"box\"",
                _ => "\"annulus\"",
            };
            s.wrong(key, format!("only for generator = {generators}"));
        } else if is_box && is_used && !s.has(key) && key != "region" {
            s.missing(key, "a box needs `lower` and `upper` corner [m] and `cells` per direction");
        } else if is_ring && is_used && !s.has(key) && key != "region" {
            s.missing(
                key,
                "an annulus needs `radii` [m], as [1, 2], and `cells` round and across, as [16, 4]",
            );
        }
    }
}

/// Refuses a ring that has no thickness, or that has no vertices on the axes.
fn check_ring(s: &Section<'_, '_>, radii: Option<[f64; 2]>, cells: Option<&[usize]>) {
    if radii.is_some_and(|[inner, outer]| inner >= outer) {
        s.wrong("radii", "expected the radius of the inner circle, then the larger one of the outer circle");
    }
    if cells.is_some_and(|cells| !cells[0].is_multiple_of(4)) {
        s.wrong("cells", "expected a multiple of 4 round, as [16, 4]");
    }
}

/// Keys that say where the mesh comes from, if the program gives it.
fn refuse_source(s: &Section<'_, '_>) {
    for key in ["generator", "file", "grading", "lower", "upper", "radii", "cells", "region"] {
        if s.has(key) {
            s.wrong(key, "the program gives the mesh");
        }
    }
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
