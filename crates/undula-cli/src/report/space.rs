//! What the player draws in space: the surfaces of the bodies, and a cut that moves with the mesh.

use super::layer::{Between, Layer, lines};
use crate::args::Plane;
use crate::digits::among;
use crate::plot::cube::{Cube, face_corners};
use crate::plot::space::{Face, extents, faces, size};
use std::collections::HashMap;
use undula::output::FieldSnapshot;

/// Names of the coordinates.
const NAMES: [&str; 3] = ["x", "y", "z"];

/// The layers of fields on straight hexahedra: bodies, if there are some, and cuts by `planes`, by default one across the
/// shortest side.
///
/// # Errors
/// A plane that meets nothing, in words.
pub fn layers(snapshot: &FieldSnapshot, solid: &[bool], planes: &[Plane]) -> Result<Vec<Layer>, String> {
    let mut found = vec![];
    if solid.iter().any(|&solid| solid) {
        found.push(surface(snapshot, solid));
    }
    if planes.is_empty() {
        found.extend(cut(snapshot, solid));
    }
    for &Plane { axis, at } in planes {
        let (low, high) = extents(snapshot)[axis];
        let at = at.unwrap_or(0.5 * (low + high));
        let layer = Cutter::new(snapshot, axis, at).cut(solid);
        if layer.cells.is_empty() {
            let [at, low, high] = [at, low, high].map(|x| among(x, size(snapshot), 6));
            let name = NAMES[axis];
            return Err(format!(
                "--cut {name}={at}: the plane meets no cell; the domain reaches from {name} = {low} to {high} m"
            ));
        }
        found.push(layer);
    }
    Ok(found)
}

/// The number of the curved cell of which a straight one is a part.
fn part(snapshot: &FieldSnapshot, cell: usize) -> f64 {
    snapshot.in_cells("cell").map_or(cell as f64, |field| field.values[cell])
}

/// Faces of the bodies with fluid or nothing beside them.
fn surface(snapshot: &FieldSnapshot, solid: &[bool]) -> Layer {
    let bodies = (0..solid.len()).filter(|&cell| solid[cell]);
    let others = (0..solid.len()).filter(|&cell| !solid[cell]);
    let corners: [[usize; 4]; 6] = std::array::from_fn(|facet| face_corners(1, facet));
    let (mut cells, mut parts) = (vec![], vec![]);
    for Face { cell, facet, other } in faces(snapshot, bodies.chain(others)) {
        if solid[cell] && other.is_none_or(|other| !solid[other]) {
            cells.extend(corners[facet].map(|corner| snapshot.cells[8 * cell + corner]));
            // The sides of a cell are apart.
            parts.push(6.0 * part(snapshot, cell) + facet as f64);
        }
    }
    let (inner, _) = lines(snapshot, &cells, 4, |face| (true, parts[face]));
    let mut numbers: HashMap<u32, u32> = HashMap::new();
    let mut points: Vec<Between> = vec![];
    let mut local = |point: &u32| {
        *numbers.entry(*point).or_insert_with(|| {
            points.push((*point, *point, 0.0));
            points.len() as u32 - 1
        })
    };
    let cells: Vec<u32> = cells.iter().map(&mut local).collect();
    let inner = inner.iter().map(|ends| [local(&ends[0]), local(&ends[1])]).collect();
    let solid = vec![true; cells.len() / 4];
    Layer { name: "bodies".into(), points, corners: 4, cells, solid, inner, outline: vec![] }
}

/// The cut across the shortest side of the domain, in its middle or where it meets cells.
fn cut(snapshot: &FieldSnapshot, solid: &[bool]) -> Option<Layer> {
    let ranges = extents(snapshot);
    let extent = |d: usize| ranges[d].1 - ranges[d].0;
    // Of equal sides the last one.
    let axis = (0..3).rev().min_by(|&a, &b| extent(a).total_cmp(&extent(b)))?;
    [0.5, 0.25, 0.75].into_iter().find_map(|part| {
        let at = ranges[axis].0 + part * extent(axis);
        let layer = Cutter::new(snapshot, axis, at).cut(solid);
        (!layer.cells.is_empty()).then_some(layer)
    })
}

/// Cuts hexahedra by the plane where a coordinate is `at`.
struct Cutter<'a> {
    snapshot: &'a FieldSnapshot,
    axis: usize,
    at: f64,
    /// Heights of all points above the plane; none is zero.
    heights: Vec<f64>,
    /// Numbers of the points of the cut by the edges that they lie on.
    numbers: HashMap<[u32; 2], u32>,
    points: Vec<Between>,
}

impl<'a> Cutter<'a> {
    fn new(snapshot: &'a FieldSnapshot, axis: usize, at: f64) -> Self {
        let (low, high) = extents(snapshot)[axis];
        // A point in the plane is a little above it, at the lower end of the domain below it: every edge is met within or
        // not at all.
        let least = 1e-9 * (high - low);
        let beside = if at - low < least { -least } else { least };
        let height = |x: &[f64; 3]| if (x[axis] - at).abs() < least { beside } else { x[axis] - at };
        let heights = snapshot.points.iter().map(height).collect();
        Cutter { snapshot, axis, at, heights, numbers: HashMap::new(), points: vec![] }
    }

    fn is_above(&self, point: u32) -> bool {
        self.heights[point as usize] > 0.0
    }

    /// The point of the cut on the edge from `a` to `b`.
    fn point(&mut self, a: u32, b: u32) -> u32 {
        let [a, b] = [a.min(b), a.max(b)];
        let [low, high] = [a, b].map(|p| self.heights[p as usize]);
        *self.numbers.entry([a, b]).or_insert_with(|| {
            self.points.push((a, b, low / (low - high)));
            self.points.len() as u32 - 1
        })
    }

    fn cut(mut self, solid: &[bool]) -> Layer {
        let corners = |cell: usize| -> [u32; 8] {
            std::array::from_fn(|corner| self.snapshot.cells[8 * cell + corner])
        };
        let meets = |cell: &usize| {
            let above = corners(*cell).into_iter().filter(|&p| self.is_above(p)).count();
            above > 0 && above < 8
        };
        let met: Vec<(usize, [u32; 8])> =
            (0..solid.len()).filter(meets).map(|cell| (cell, corners(cell))).collect();
        let mut layer = Layer { corners: 3, ..Layer::default() };
        for (cell, nodes) in &met {
            for tetrahedron in Cube::tetrahedra(std::array::from_fn(|corner| corner)) {
                let before = layer.cells.len();
                self.slice(tetrahedron.map(|corner| nodes[corner]), &mut layer.cells);
                let count = (layer.cells.len() - before) / 3;
                layer.solid.extend(std::iter::repeat_n(solid[*cell], count));
            }
        }
        let cube = Cube::new(1, 1);
        let triangles: [Vec<[usize; 3]>; 6] = std::array::from_fn(|facet| cube.face(facet));
        for Face { cell, facet, other } in faces(self.snapshot, met.iter().map(|(cell, _)| *cell)) {
            let inside = other.is_some_and(|other| solid[other] == solid[cell]);
            if other.is_some_and(|other| inside && part(self.snapshot, other) == part(self.snapshot, cell)) {
                continue;
            }
            let nodes: [u32; 8] = std::array::from_fn(|corner| self.snapshot.cells[8 * cell + corner]);
            for triangle in &triangles[facet] {
                let ends = self.trace(triangle.map(|corner| nodes[corner]));
                (if inside { &mut layer.inner } else { &mut layer.outline }).extend(ends);
            }
        }
        layer.name = format!("cut at {} = {} m", NAMES[self.axis], among(self.at, size(self.snapshot), 4));
        layer.points = self.points;
        layer
    }

    /// Adds the triangles in which the plane meets a tetrahedron.
    fn slice(&mut self, tetrahedron: [u32; 4], cells: &mut Vec<u32>) {
        let parts = tetrahedron.iter().partition(|&&p| self.is_above(p));
        let (above, below): (Vec<u32>, Vec<u32>) = parts;
        let ring: Vec<(u32, u32)> = match (&above[..], &below[..]) {
            (&[a], &[b, c, d]) | (&[b, c, d], &[a]) => vec![(a, b), (a, c), (a, d)],
            (&[a, b], &[c, d]) => vec![(a, c), (a, d), (b, d), (b, c)],
            _ => return,
        };
        let ring: Vec<u32> = ring.into_iter().map(|(a, b)| self.point(a, b)).collect();
        for n in 1..ring.len() - 1 {
            cells.extend([ring[0], ring[n], ring[n + 1]]);
        }
    }

    /// The line in which the plane meets a triangle.
    fn trace(&mut self, triangle: [u32; 3]) -> Option<[u32; 2]> {
        let parts = triangle.iter().partition(|&&p| self.is_above(p));
        let (above, below): (Vec<u32>, Vec<u32>) = parts;
        match (&above[..], &below[..]) {
            (&[a], &[b, c]) | (&[b, c], &[a]) => Some([self.point(a, b), self.point(a, c)]),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::layer::between;
    use super::*;
    use crate::plot::cut::tests::hexahedra;

    fn place(layer: &Layer, mesh: &FieldSnapshot, point: u32) -> [f64; 3] {
        std::array::from_fn(|d| between(&layer.points[point as usize], |p| mesh.points[p][d]))
    }

    fn length(layer: &Layer, mesh: &FieldSnapshot, lines: &[[u32; 2]]) -> f64 {
        let ends = lines.iter().map(|ends| ends.map(|p| place(layer, mesh, p)));
        ends.map(|[a, b]| (0..3).map(|d| (a[d] - b[d]).powi(2)).sum::<f64>().sqrt()).sum()
    }

    /// Through cells, and through their sides, of a cube of which one half is solid.
    #[test]
    fn cuts_are_flat_whole_and_have_the_lines_of_the_cells() {
        for n in [3, 4] {
            let mesh = hexahedra(1, [n; 3], |x| x);
            let solid: Vec<bool> = (0..n.pow(3)).map(|cell| 2 * (cell % n) < n).collect();
            let layer = cut(&mesh, &solid).unwrap();
            assert_eq!(layer.name, "cut at z = 0.5 m");
            assert_eq!(layer.cells.len(), 3 * layer.solid.len());
            let (mut area, mut of_solid) = (0.0, 0.0);
            for (corners, &solid) in layer.cells.chunks_exact(3).zip(&layer.solid) {
                let [a, b, c] = [0, 1, 2].map(|i| place(&layer, &mesh, corners[i]));
                assert!([a, b, c].iter().all(|x| (x[2] - 0.5).abs() < 1e-8));
                let part = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs();
                area += part;
                of_solid += if solid { part } else { 0.0 };
            }
            let half = n.div_ceil(2) as f64 / n as f64;
            assert!((area - 1.0).abs() < 1e-7 && (of_solid - half).abs() < 1e-7, "{area} {of_solid}");
            // All around, and between the halves; the others within.
            assert!((length(&layer, &mesh, &layer.outline) - 5.0).abs() < 1e-6);
            assert!((length(&layer, &mesh, &layer.inner) - (2 * n - 3) as f64).abs() < 1e-6);
        }
    }

    #[test]
    fn the_sides_of_the_domain_are_cuts() {
        let mesh = hexahedra(1, [3; 3], |x| x);
        for at in [0.0, 1.0] {
            let layers = layers(&mesh, &[false; 27], &[Plane { axis: 2, at: Some(at) }]).unwrap();
            assert!((length(&layers[0], &mesh, &layers[0].outline) - 4.0).abs() < 1e-6, "z = {at}");
        }
        assert!(layers(&mesh, &[false; 27], &[Plane { axis: 2, at: Some(1.01) }]).is_err());
    }

    #[test]
    fn surfaces_of_bodies_have_all_faces_and_edges_once() {
        let n = 4;
        let mesh = hexahedra(1, [n; 3], |x| x);
        let solid: Vec<bool> = (0..n.pow(3)).map(|cell| 2 * (cell % n) < n).collect();
        let layer = surface(&mesh, &solid);
        assert_eq!(layer.cells.len(), 4 * 2 * (4 * 4 + 2 * 4 + 2 * 4));
        // Corners of the faces of a box of 2 x 4 x 4 cells.
        assert_eq!(layer.points.len(), 3 * 5 * 5 - 3 * 3);
        // Each of the 64 faces has four edges, each edge two faces.
        assert_eq!((layer.inner.len(), layer.outline.len()), (128, 0));
    }
}
