//! The surface of the bodies in space, shaded.

mod canvas;
mod draw;

use super::cube::Cube;
use super::space::{Face, Place, Places, faces};
use crate::args::SurfaceField;
use std::collections::{BTreeMap, HashMap};
use undula::output::FieldSnapshot;

/// Towards the viewer: y is up, x goes to the right, z comes nearer.
const VIEWER: Vector = [0.45, 0.41, 0.8];

/// Towards a lamp, in the directions of the picture: above the viewer, to the left.
const LAMP: Vector = [-0.2, 0.35, 0.92];

/// Cosine of the angle between two faces from which on the edge between them is sharp.
const SHARP: f64 = 0.77;

/// Pieces of a curved face per direction.
const PIECES: usize = 6;

/// In space, or to the right, upwards and towards the viewer.
type Vector = [f64; 3];

/// A triangle of the surface, in the directions of the picture.
struct Triangle {
    at: [Vector; 3],
    values: [f64; 3],
    /// How bright the corners are, 0 to 1.
    light: [f64; 3],
}

/// Lines on the surface, in the directions of the picture.
#[derive(Default)]
struct Lines {
    /// Between cells.
    mesh: Vec<Vec<Vector>>,
    /// Where the surface has an edge.
    sharp: Vec<Vec<Vector>>,
    /// Lines that make one edge of a cell.
    pieces: f64,
}

/// The surface of the bodies.
pub struct Surface {
    triangles: Vec<Triangle>,
    lines: Lines,
    field: SurfaceField,
    /// Ranges of the coordinates \[m\].
    extents: [(f64, f64); 3],
}

impl Surface {
    /// The surface of the cells that are `solid`, with the values of `field`.
    ///
    /// # Errors
    /// What is missing, and what to do.
    pub fn new(snapshot: &FieldSnapshot, solid: &[bool], field: SurfaceField) -> Result<Surface, String> {
        let (name, key) = array_of(field);
        let outer = outer_faces(snapshot, solid);
        if outer.is_empty() {
            return Err("this run has no body whose surface could be drawn; --cut shows the flow".into());
        }
        if field == SurfaceField::Pressure && outer.iter().all(|face| face.other.is_none()) {
            return Err("no fluid is beside the bodies of this run, whose pressure could be drawn".into());
        }
        let Some(values) = snapshot.at_points(name) else {
            return Err(format!(
                "the fields of this run have no `{name}`: add \"{key}\" to output.fields and run the case again"
            ));
        };
        let sizes: Vec<f64> = values.values.chunks_exact(values.components).map(length).collect();
        let patches = patches(snapshot, &outer, &sizes, field == SurfaceField::Pressure);
        let extents = std::array::from_fn(|d| {
            let x = patches.iter().flat_map(|patch| patch.whole.iter().map(|x| x[d]));
            x.fold((f64::INFINITY, f64::NEG_INFINITY), |range, x| (range.0.min(x), range.1.max(x)))
        });
        let places = Places::new(snapshot);
        let lines = lines(snapshot, &outer, &patches, places);
        Ok(Surface { triangles: shaded(&patches, places), lines, field, extents })
    }
}

/// Faces of bodies with fluid or nothing beside them; their cell is that of the body.
fn outer_faces(snapshot: &FieldSnapshot, solid: &[bool]) -> Vec<Face> {
    let bodies = (0..solid.len()).filter(|&cell| solid[cell]);
    let others = (0..solid.len()).filter(|&cell| !solid[cell]);
    let of_body = |face: &Face| solid[face.cell] && face.other.is_none_or(|other| !solid[other]);
    faces(snapshot, bodies.chain(others)).into_iter().filter(of_body).collect()
}

/// Faces in pieces with `values` at points, those of the fluid beside them if they are `of_fluid`.
fn patches(snapshot: &FieldSnapshot, faces: &[Face], values: &[f64], of_fluid: bool) -> Vec<Patch> {
    let cube = Cube::new(snapshot.degree, if snapshot.degree > 1 { PIECES } else { 1 });
    let patch = |face: &Face| {
        let has_value = !of_fluid || face.other.is_some();
        Patch::new(snapshot, &cube, face, |p| if has_value { values[p] } else { f64::NAN })
    };
    faces.iter().map(patch).collect()
}

/// The array of a field file that a surface shows, and its name in a case.
fn array_of(field: SurfaceField) -> (&'static str, &'static str) {
    match field {
        SurfaceField::Displacement => ("deformation", "displacement"),
        SurfaceField::Stress => ("solid-von-mises", "von-mises"),
        SurfaceField::Pressure => ("pressure", "pressure"),
    }
}

/// A face in pieces.
struct Patch {
    /// Corners of triangles in the directions of the picture, their values and their outer normals.
    triangles: Vec<([Vector; 3], [f64; 3], Vector)>,
    /// Points along its four sides.
    sides: [Vec<Vector>; 4],
    /// Its points in space.
    whole: Vec<Vector>,
    normal: Vector,
}

impl Patch {
    fn new(snapshot: &FieldSnapshot, cube: &Cube, face: &Face, value: impl Fn(usize) -> f64) -> Patch {
        let n = snapshot.points_per_cell();
        let nodes = &snapshot.cells[face.cell * n..(face.cell + 1) * n];
        let sides = cube.sides(face.facet);
        let mut known: BTreeMap<usize, (Vector, f64)> = BTreeMap::new();
        let mut at = |point: usize| {
            *known.entry(point).or_insert_with(|| {
                let (mut x, mut size) = ([0.0; 3], 0.0);
                let weights = cube.weights[point].iter().zip(nodes).filter(|(w, _)| **w != 0.0);
                for (weight, &node) in weights {
                    (0..3).for_each(|d| x[d] += weight * snapshot.points[node as usize][d]);
                    size += weight * value(node as usize);
                }
                (x, size)
            })
        };
        // The triangles turn with (u, v), which is outward on the upper faces across x and z.
        let outward = if (face.facet % 2 == 1) == (face.facet / 2 != 1) { 1.0 } else { -1.0 };
        let triangles: Vec<_> = cube
            .face(face.facet)
            .into_iter()
            .map(|triangle| {
                let corners = triangle.map(&mut at);
                let [a, b, c] = corners.map(|(x, _)| seen(x));
                let normal = cross(minus(b, a), minus(c, a)).map(|n| outward * n);
                ([a, b, c], corners.map(|(_, value)| value), normal)
            })
            .collect();
        let normal = triangles.iter().fold([0.0; 3], |sum, (_, _, normal)| plus(sum, *normal));
        let sides = sides.map(|side| side.into_iter().map(|point| seen(at(point).0)).collect());
        Patch { triangles, sides, whole: known.into_values().map(|(x, _)| x).collect(), normal: unit(normal) }
    }
}

/// Triangles with the light at their corners: that of the mean normal of what meets there, but not across sharp edges.
fn shaded(patches: &[Patch], places: Places) -> Vec<Triangle> {
    let mut around: HashMap<Place, Vec<Vector>> = HashMap::new();
    for (corners, _, normal) in patches.iter().flat_map(|patch| &patch.triangles) {
        corners.iter().for_each(|&x| around.entry(places.of(x)).or_default().push(*normal));
    }
    let mut triangles = vec![];
    for &(at, values, normal) in patches.iter().flat_map(|patch| &patch.triangles) {
        let light = at.map(|x| {
            let own = unit(normal);
            let beside = around[&places.of(x)].iter().filter(|other| dot(own, unit(**other)) > SHARP);
            let mean = unit(beside.fold([0.0; 3], |sum, other| plus(sum, *other)));
            // Seen from behind it is lit from behind.
            let faces_viewer = if mean[2] < 0.0 { -1.0 } else { 1.0 };
            (faces_viewer * dot(mean, unit(LAMP))).max(0.0)
        });
        triangles.push(Triangle { at, values, light });
    }
    triangles
}

/// The edges of the cells on the surface.
fn lines(snapshot: &FieldSnapshot, outer: &[Face], patches: &[Patch], places: Places) -> Lines {
    let parts = snapshot.in_cells("cell");
    let part_of = |cell: usize| parts.map_or(cell as f64, |parts| parts.values[cell]);
    let mut numbers: HashMap<Place, usize> = HashMap::new();
    // An edge, and the patches beside it.
    let mut edges: Vec<(&Vec<Vector>, Vec<usize>)> = vec![];
    for (n, patch) in patches.iter().enumerate() {
        // Sides of triangular faces may be points.
        for side in patch.sides.iter().filter(|side| places.of(side[0]) != places.of(side[side.len() - 1])) {
            let middle = places.of(plus(side[0], side[side.len() - 1]).map(|x| 0.5 * x));
            let number = *numbers.entry(middle).or_insert(edges.len());
            if number == edges.len() {
                edges.push((side, vec![]));
            }
            edges[number].1.push(n);
        }
    }
    let mut lines = Lines::default();
    for (side, beside) in edges {
        let first = beside[0];
        let is_smooth = |&other: &usize| dot(patches[first].normal, patches[other].normal) > SHARP;
        let within = |&other: &usize| {
            part_of(outer[first].cell) == part_of(outer[other].cell)
                && outer[first].facet == outer[other].facet
        };
        if beside.len() == 1 || !beside.iter().all(is_smooth) {
            lines.sharp.push(side.clone());
        } else if !beside.iter().all(within) {
            lines.mesh.push(side.clone());
        }
    }
    let cells =
        parts.and_then(|parts| parts.values.last()).map_or(snapshot.n_cells() as f64, |last| last + 1.0);
    lines.pieces = (snapshot.n_cells() as f64 / cells).cbrt();
    lines
}

/// A vector of space in the directions of the picture.
fn seen(x: Vector) -> Vector {
    let near = unit(VIEWER);
    let right = unit(cross([0.0, 1.0, 0.0], near));
    [right, cross(near, right), near].map(|direction| dot(direction, x))
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(x: &[f64]) -> f64 {
    if let [x] = x { *x } else { x.iter().map(|x| x * x).sum::<f64>().sqrt() }
}

fn unit(x: Vector) -> Vector {
    let size = dot(x, x).sqrt();
    if size > 0.0 { x.map(|x| x / size) } else { x }
}

fn plus(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|d| a[d] + b[d])
}

fn minus(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|d| a[d] - b[d])
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::super::cut::tests::{hexahedra, shell};
    use super::*;
    use std::f64::consts::PI;

    /// By the divergence theorem, for which normals have to point outwards.
    #[test]
    fn surfaces_are_closed_and_around_their_volume() {
        for degree in [2, 3] {
            let mesh = hexahedra(degree, [3, 6, 2], shell(0.1));
            let outer = outer_faces(&mesh, &[true; 36]);
            assert_eq!(outer.len(), 2 * (18 + 6 + 12));
            let values = vec![1.0; mesh.points.len()];
            let patches = patches(&mesh, &outer, &values, false);
            let (mut volume, mut sum) = (0.0, [0.0; 3]);
            for (at, values, normal) in patches.iter().flat_map(|patch| &patch.triangles) {
                assert!(values.iter().all(|v| (v - 1.0).abs() < 1e-12));
                let middle = at.iter().fold([0.0; 3], |sum, x| plus(sum, x.map(|x| x / 3.0)));
                volume += dot(middle, *normal) / 6.0;
                sum = plus(sum, *normal);
            }
            assert!(dot(sum, sum).sqrt() < 1e-12, "{sum:?}");
            assert!((volume - 0.7 * 0.75 * PI).abs() < 2e-3, "degree {degree}: {volume}");
        }
    }

    #[test]
    fn edges_are_sharp_where_faces_meet_and_mesh_lines_are_those_of_whole_cells() {
        let total = |lines: &[Vec<Vector>]| -> f64 {
            let segments = lines.iter().flat_map(|line| line.windows(2));
            segments.map(|ends| minus(ends[1], ends[0])).map(|along| dot(along, along).sqrt()).sum()
        };
        let mesh = hexahedra(2, [3, 6, 2], shell(0.0));
        for mesh in [mesh.clone(), mesh.linear()] {
            let solid = vec![true; mesh.n_cells()];
            let surface = Surface::new(&mesh, &solid, SurfaceField::Displacement).unwrap();
            // Four upright edges, four across the shell, four round it.
            let sharp = 4.0 * 0.7 + 4.0 + 2.0 * 1.5 * PI;
            assert!((total(&surface.lines.sharp) - sharp).abs() < 2e-2 * sharp);
            // On the ends, the inner and outer side, bottom and top.
            let inner = 2.0 * (1.0 + 2.0 * 0.7) + 10.0 * 0.7 + 1.5 * PI + 2.0 * (5.0 + 1.5 * PI);
            let found = total(&surface.lines.mesh);
            assert!((found - inner).abs() < 1e-2 * inner, "{found} for {inner}");
            let is_light =
                |triangle: &Triangle| triangle.light.iter().all(|l| (0.0..=1.0 + 1e-12).contains(l));
            assert!(surface.triangles.iter().all(is_light));
            for (range, right) in surface.extents.iter().zip([2.0, 2.0, 0.7]) {
                assert!(range.0.abs() < 1e-9 && (range.1 - right).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn what_is_missing_is_named() {
        let mut mesh = hexahedra(1, [2; 3], shell(0.0));
        let error = |mesh: &FieldSnapshot, solid: bool, field| {
            Surface::new(mesh, &[solid; 8], field).err().unwrap_or_default()
        };
        assert!(error(&mesh, false, SurfaceField::Pressure).contains("no body"));
        assert!(error(&mesh, true, SurfaceField::Stress).contains("\"von-mises\" to output.fields"));
        assert!(error(&mesh, true, SurfaceField::Pressure).contains("no fluid"));
        mesh.point_data.clear();
        assert!(error(&mesh, true, SurfaceField::Displacement).contains("add \"displacement\" to"));
    }
}
