//! Cuts of hexahedra by planes: the fields in the plane, and the lines where the faces of the cells meet it.

use super::cube::{Cube, across};
use super::lines::{chains, simplified};
use super::space::{Face, extents, faces, size};
use std::collections::{BTreeMap, HashMap};
use undula::output::{CellKind, Field, FieldSnapshot};

/// Pieces of a cell per direction at most.
const FINEST: usize = 12;

/// How far lines may be from where they are \[pixels\].
const TOLERANCE: f64 = 0.05;

/// A plane across a coordinate.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Plane {
    /// The coordinate.
    pub axis: usize,
    /// Its value \[m\].
    pub at: f64,
}

/// What a plane meets. The two coordinates in the plane are the first ones of points and vectors.
pub struct Cut {
    /// Triangles.
    pub fields: FieldSnapshot,
    /// Lines between cells of one kind.
    pub inner: Vec<Vec<[f64; 2]>>,
    /// Lines at the boundary of the domain and of the solid.
    pub outline: Vec<Vec<[f64; 2]>>,
}

/// The part of a cell that is known.
struct Pieces<'a> {
    cube: &'a Cube,
    nodes: &'a [u32],
    /// Heights of the points of the cube above the plane.
    heights: Vec<f64>,
    /// Points of the cut on the edges between two points of the cube.
    known: HashMap<[usize; 2], u32>,
}

struct Cutter<'a> {
    snapshot: &'a FieldSnapshot,
    plane: Plane,
    /// Heights below are zero.
    unit: f64,
    /// Whether points in the plane are above it.
    zero_is_above: bool,
    /// The cut so far.
    fields: FieldSnapshot,
    /// Fields of the snapshot that the cut has.
    sources: Vec<&'a Field>,
}

impl Cut {
    /// The cut of the hexahedra of `snapshot`, of which `solid` says which are; `scale` are pixels per metre.
    ///
    /// Every cell that the plane meets is cut into little tetrahedra, which the plane meets in triangles.
    pub fn new(snapshot: &FieldSnapshot, solid: &[bool], plane: Plane, scale: f64) -> Cut {
        let mut cutter = Cutter::new(snapshot, plane);
        let parts: Option<&[f64]> = snapshot.in_cells("cell").map(|field| field.values.as_slice());
        let part_of = |cell: usize| parts.map_or(cell as f64, |parts| parts[cell]);
        let n = snapshot.points_per_cell();
        let near: Vec<usize> = (0..snapshot.n_cells()).filter(|&cell| cutter.may_meet(cell)).collect();
        let faces = faces(snapshot, near.iter().copied());
        let mut cubes: BTreeMap<usize, Cube> = BTreeMap::new();
        let (mut inner, mut outline, mut solids, mut numbers) = (vec![], vec![], vec![], vec![]);
        let mut faces = faces.iter().peekable();
        for cell in near {
            let fine = cutter.pieces(cell, scale);
            let cube = cubes.entry(fine).or_insert_with(|| Cube::new(snapshot.degree, fine));
            let mut pieces = cutter.locate(cube, &snapshot.cells[cell * n..(cell + 1) * n]);
            let count = cutter.slice(&mut pieces);
            solids.resize(solids.len() + count, f64::from(u8::from(solid[cell])));
            numbers.resize(numbers.len() + count, part_of(cell));
            while let Some(Face { facet, other, .. }) = faces.next_if(|face| face.cell == cell) {
                let inside = other.is_some_and(|other| solid[other] == solid[cell]);
                if !(inside && other.is_some_and(|other| part_of(other) == part_of(cell))) {
                    let lines = cutter.trace(&mut pieces, *facet).into_iter();
                    let lines = lines.map(|line| simplified(&line, TOLERANCE / scale));
                    (if inside { &mut inner } else { &mut outline }).extend(lines);
                }
            }
        }
        let mut fields = cutter.fields;
        fields.cell_data = vec![Field::new("solid", 1, solids), Field::new("cell", 1, numbers)];
        Cut { fields, inner, outline }
    }
}

impl<'a> Cutter<'a> {
    fn new(snapshot: &'a FieldSnapshot, plane: Plane) -> Self {
        let unit = 1e-9 * size(snapshot);
        let sources: Vec<&Field> =
            snapshot.point_data.iter().filter(|field| [1, 3].contains(&field.components)).collect();
        let point_data = sources.iter().map(|f| Field::new(f.name.clone(), f.components, vec![])).collect();
        let fields =
            FieldSnapshot { kind: CellKind::Triangle, degree: 1, point_data, ..FieldSnapshot::default() };
        // Of two layers that meet in the plane the lower one is seen, but at the lower end of the domain.
        let zero_is_above = plane.at > extents(snapshot)[plane.axis].0 + unit;
        Cutter { snapshot, plane, unit, zero_is_above, fields, sources }
    }

    fn height(&self, x: f64) -> f64 {
        let height = x - self.plane.at;
        if height.abs() < self.unit { 0.0 } else { height }
    }

    fn is_above(&self, height: f64) -> bool {
        height > 0.0 || (height == 0.0 && self.zero_is_above)
    }

    fn points(&self, cell: usize) -> impl Iterator<Item = [f64; 3]> {
        let n = self.snapshot.points_per_cell();
        self.snapshot.cells[cell * n..(cell + 1) * n].iter().map(|&p| self.snapshot.points[p as usize])
    }

    /// Whether the plane may meet a cell; a curved one reaches beyond its nodes a little.
    fn may_meet(&self, cell: usize) -> bool {
        let heights = self.points(cell).map(|x| self.height(x[self.plane.axis]));
        let (low, high) = heights.fold((f64::MAX, f64::MIN), |(low, high), h| (low.min(h), high.max(h)));
        let beyond = if self.snapshot.degree > 1 { 0.25 * (high - low) } else { 0.0 };
        low - beyond <= 0.0 && high + beyond >= 0.0
    }

    /// Pieces of a cell per direction, of four pixels each where it can be.
    fn pieces(&self, cell: usize, scale: f64) -> usize {
        let extent = |d: usize| {
            let range = self.points(cell).fold((f64::MAX, f64::MIN), |r, x| (r.0.min(x[d]), r.1.max(x[d])));
            range.1 - range.0
        };
        let widest = across(self.plane.axis).map(extent).into_iter().fold(0.0, f64::max);
        ((scale * widest / 4.0).ceil() as usize).clamp(2, FINEST)
    }

    fn locate<'b>(&self, cube: &'b Cube, nodes: &'b [u32]) -> Pieces<'b> {
        let values: Vec<f64> =
            nodes.iter().map(|&p| self.snapshot.points[p as usize][self.plane.axis]).collect();
        let at = |weights: &Vec<f64>| weights.iter().zip(&values).map(|(w, x)| w * x).sum();
        let heights = cube.weights.iter().map(at).map(|x| self.height(x)).collect();
        Pieces { cube, nodes, heights, known: HashMap::new() }
    }

    /// The point where the plane meets the edge from `a` to `b`.
    fn point(&mut self, pieces: &mut Pieces, a: usize, b: usize) -> u32 {
        // A point of the cube in the plane is one point of the cut, whatever edge leads there.
        let ends = match [a, b].into_iter().find(|&end| pieces.heights[end] == 0.0) {
            Some(end) => [end, end],
            None => [a.min(b), a.max(b)],
        };
        if let Some(&known) = pieces.known.get(&ends) {
            return known;
        }
        let [low, high] = ends.map(|end| pieces.heights[end]);
        let t = if low == high { 0.0 } else { low / (low - high) };
        let [from, to] = ends.map(|end| &pieces.cube.weights[end]);
        let weights: Vec<f64> = from.iter().zip(to).map(|(a, b)| (1.0 - t) * a + t * b).collect();
        let sum = |value: &dyn Fn(usize) -> f64| -> f64 {
            weights.iter().zip(pieces.nodes).map(|(w, &p)| w * value(p as usize)).sum()
        };
        let [u, v] = across(self.plane.axis);
        let [x, y] = [u, v].map(|d| sum(&|p| self.snapshot.points[p][d]));
        for (field, source) in self.fields.point_data.iter_mut().zip(&self.sources) {
            match source.components {
                1 => field.values.push(sum(&|p| source.values[p])),
                _ => field.values.extend([u, v, self.plane.axis].map(|d| sum(&|p| source.values[3 * p + d]))),
            }
        }
        let number = self.fields.points.len() as u32;
        self.fields.points.push([x, y, 0.0]);
        pieces.known.insert(ends, number);
        number
    }

    /// Adds the triangles of a cell and returns their number.
    fn slice(&mut self, pieces: &mut Pieces) -> usize {
        let before = self.fields.cells.len();
        for cube in pieces.cube.cubes() {
            let above = cube.iter().filter(|&&p| self.is_above(pieces.heights[p])).count();
            if above == 0 || above == 8 {
                continue;
            }
            for tetrahedron in Cube::tetrahedra(cube) {
                let parts = tetrahedron.iter().partition(|&&p| self.is_above(pieces.heights[p]));
                let (above, below): (Vec<usize>, Vec<usize>) = parts;
                let ring: Vec<(usize, usize)> = match (&above[..], &below[..]) {
                    (&[a], &[b, c, d]) | (&[b, c, d], &[a]) => vec![(a, b), (a, c), (a, d)],
                    (&[a, b], &[c, d]) => vec![(a, c), (a, d), (b, d), (b, c)],
                    _ => continue,
                };
                let mut ring: Vec<u32> = ring.into_iter().map(|(a, b)| self.point(pieces, a, b)).collect();
                ring.dedup();
                if ring.first() == ring.last() {
                    ring.pop();
                }
                for n in 1..ring.len().max(2) - 1 {
                    let corners = [ring[0], ring[n], ring[n + 1]];
                    if self.has_area(corners) {
                        self.fields.cells.extend(corners);
                    }
                }
            }
        }
        (self.fields.cells.len() - before) / 3
    }

    /// Whether a triangle is more than a line: pieces of collapsed cells may have no volume.
    fn has_area(&self, corners: [u32; 3]) -> bool {
        let [a, b, c] = corners.map(|p| self.fields.points[p as usize]);
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        twice.abs() > self.unit * self.unit
    }

    /// The lines in which the plane meets a face of a cell.
    fn trace(&mut self, pieces: &mut Pieces, facet: usize) -> Vec<Vec<[f64; 2]>> {
        let mut segments = vec![];
        for triangle in pieces.cube.face(facet) {
            let parts = triangle.iter().partition(|&&p| self.is_above(pieces.heights[p]));
            let (above, below): (Vec<usize>, Vec<usize>) = parts;
            if let (&[a], &[b, c]) | (&[b, c], &[a]) = (&above[..], &below[..]) {
                let ends = [(a, b), (a, c)].map(|(a, b)| self.point(pieces, a, b));
                if ends[0] != ends[1] {
                    segments.push(ends);
                }
            }
        }
        let place = |point: u32| {
            let [x, y, _] = self.fields.points[point as usize];
            [x, y]
        };
        chains(&segments).into_iter().map(|chain| chain.into_iter().map(place).collect()).collect()
    }
}

#[cfg(test)]
pub mod tests {
    use super::super::tetrahedra::as_hexahedra;
    use super::super::tetrahedra::tests::cube;
    use super::*;
    use std::f64::consts::PI;

    /// `n` hexahedra of the image of the unit cube.
    pub fn hexahedra(degree: usize, n: [usize; 3], map: impl Fn([f64; 3]) -> [f64; 3]) -> FieldSnapshot {
        let nodes = n.map(|n| degree * n + 1);
        let mut mesh = FieldSnapshot { kind: CellKind::Hexahedron, degree, ..FieldSnapshot::default() };
        let of = |i: usize, n: [usize; 3]| [i % n[0], i / n[0] % n[1], i / (n[0] * n[1])];
        for i in 0..nodes.iter().product() {
            let at = of(i, nodes);
            mesh.points.push(map([0, 1, 2].map(|d| at[d] as f64 / (nodes[d] - 1) as f64)));
        }
        for cell in 0..n.iter().product() {
            let from = of(cell, n).map(|i| degree * i);
            mesh.cells.extend((0..(degree + 1).pow(3)).map(|i| {
                let at = of(i, [degree + 1; 3]);
                (from[0] + at[0] + nodes[0] * (from[1] + at[1] + nodes[1] * (from[2] + at[2]))) as u32
            }));
        }
        let [x, f] = [|x: &[f64; 3]| *x, |&[x, y, z]: &[f64; 3]| [x * z, y - z, x * y]];
        mesh.point_data = vec![
            Field::new("deformation", 3, mesh.points.iter().flat_map(x).collect()),
            Field::new("velocity", 3, mesh.points.iter().flat_map(f).collect()),
            Field::new("pressure", 1, mesh.points.iter().map(|&[x, y, z]| x * y - z).collect()),
        ];
        mesh
    }

    /// A quarter of a hollow cylinder, 1 < r < 2, 0 < z < 0.7, sheared along z.
    pub fn shell(shear: f64) -> impl Fn([f64; 3]) -> [f64; 3] {
        move |[r, s, t]| {
            let (sin, cos) = (0.5 * PI * s).sin_cos();
            let [x, y] = [(1.0 + r) * cos, (1.0 + r) * sin];
            [x, y, 0.7 * t + shear * x * y]
        }
    }

    fn area(cut: &Cut) -> f64 {
        let size = |t: &[u32]| {
            let [a, b, c] = [t[0], t[1], t[2]].map(|p| cut.fields.points[p as usize]);
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs()
        };
        cut.fields.cells.chunks_exact(3).map(size).sum()
    }

    fn length(lines: &[Vec<[f64; 2]>]) -> f64 {
        let segments = lines.iter().flat_map(|line| line.windows(2));
        segments.map(|ends| (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1])).sum()
    }

    #[test]
    fn cuts_of_curved_cells_have_their_area_their_lines_and_their_fields() {
        let mesh = hexahedra(2, [3, 6, 2], shell(0.1));
        // No layer of cells ends in it.
        let plane = Plane { axis: 2, at: 0.25 };
        for (mesh, tolerance) in [(mesh.clone(), 2e-3), (mesh.linear(), 2e-2)] {
            let cut = Cut::new(&mesh, &vec![false; mesh.n_cells()], plane, 300.0);
            assert!((area(&cut) / (0.75 * PI) - 1.0).abs() < tolerance, "{}", area(&cut));
            let [outline, inner] = [2.0 + 1.5 * PI, 5.0 + 1.5 * PI];
            assert!((length(&cut.outline) / outline - 1.0).abs() < tolerance, "{}", length(&cut.outline));
            assert!((length(&cut.inner) / inner - 1.0).abs() < tolerance, "{}", length(&cut.inner));
            // One line for each face of a cell that the plane meets.
            let counts = (cut.outline.len(), cut.inner.len());
            assert!(mesh.degree == 1 || counts == (18, 12 + 15), "{counts:?}");
            for (p, &[x, y, _]) in cut.fields.points.iter().enumerate() {
                let at = |name: &str| &cut.fields.at_points(name).unwrap().values[3 * p..3 * p + 3];
                // x itself is in the space of the cells.
                let exact = [x, y, 0.25];
                assert!(at("deformation").iter().zip(exact).all(|(a, b)| (a - b).abs() < 2e-3));
                let velocity = [0.25 * x, y - 0.25, x * y];
                assert!(at("velocity").iter().zip(velocity).all(|(a, b)| (a - b).abs() < tolerance));
            }
        }
    }

    #[test]
    fn cuts_of_tetrahedra_are_those_of_their_cube() {
        for degree in 1..=3 {
            let mesh = as_hexahedra(cube(degree));
            for axis in 0..3 {
                let cut = Cut::new(&mesh, &[false; 6], Plane { axis, at: 0.3 }, 100.0);
                assert!((area(&cut) - 1.0).abs() < 1e-9, "{degree} {axis}: {}", area(&cut));
                assert!((length(&cut.outline) - 4.0).abs() < 1e-9, "{}", length(&cut.outline));
                // The planes x = y, y = z and x = z: a diagonal and two lines from side to side.
                let inner = 2f64.sqrt() + 2.0;
                assert!((length(&cut.inner) - inner).abs() < 1e-9, "{}", length(&cut.inner));
                let values = &cut.fields.at_points("pressure").unwrap().values;
                let [u, v] = across(axis);
                for (x, value) in cut.fields.points.iter().zip(values) {
                    let mut at = [0.3; 3];
                    (at[u], at[v]) = (x[0], x[1]);
                    let exact = (at[0] + 2.0 * at[1] - at[2]).powi(degree as i32);
                    // Linear between corners of pieces, along which s = x + 2 y - z changes by 7/12.
                    let within = [1e-9, 0.09, 0.8][degree - 1];
                    assert!((value - exact).abs() < within, "{value} {exact}");
                }
            }
        }
    }

    #[test]
    fn every_axis_can_be_cut_and_vectors_turn_with_the_plane() {
        let mesh = hexahedra(2, [3, 6, 2], shell(0.1));
        let right = 0.7 * ((4.0_f64 - 0.49).sqrt() - (1.0_f64 - 0.49).sqrt());
        for axis in [0, 1] {
            let cut = Cut::new(&mesh, &[false; 36], Plane { axis, at: 0.7 }, 300.0);
            assert!((area(&cut) / right - 1.0).abs() < 2e-3, "{} for {right}", area(&cut));
            let u = cut.fields.at_points("deformation").unwrap();
            for (point, u) in cut.fields.points.iter().zip(u.values.chunks_exact(3)) {
                assert!((u[0] - point[0]).abs() < 2e-3 && (u[1] - point[1]).abs() < 2e-3);
                assert!((u[2] - 0.7).abs() < 2e-3);
            }
        }
    }

    #[test]
    fn a_plane_between_layers_shows_one_of_them() {
        let mesh = hexahedra(1, [2, 2, 2], |x| x);
        let solid: Vec<bool> = (0..8).map(|cell| cell % 2 == 0).collect();
        for at in [0.0, 0.5, 1.0, 0.3] {
            let cut = Cut::new(&mesh, &solid, Plane { axis: 2, at }, 100.0);
            assert!((area(&cut) - 1.0).abs() < 1e-12, "z = {at}: {}", area(&cut));
            // The boundary, and the line between solid and fluid; cells of one kind meet in the other one.
            assert!((length(&cut.outline) - 5.0).abs() < 1e-12 && (length(&cut.inner) - 1.0).abs() < 1e-12);
            let kinds = &cut.fields.in_cells("solid").unwrap().values;
            for (triangle, kind) in cut.fields.cells.chunks_exact(3).zip(kinds) {
                let x: f64 = triangle.iter().map(|&p| cut.fields.points[p as usize][0]).sum();
                assert_eq!(*kind > 0.5, x < 1.5);
            }
        }
    }
}
