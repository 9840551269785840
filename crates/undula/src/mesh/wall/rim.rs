//! Where a surface ends: the openings beside it and their planes.

use super::surface::{Edge, Surface, edges};
use super::{place, refuse};
use crate::mesh::geometry::distance;
use crate::mesh::{Mesh, MeshError, Side};
use std::collections::{BTreeMap, HashMap};

/// Facets whose normals have at least this cosine lie in one plane, unless their nodes say else.
const TOGETHER: f64 = 0.95;
/// An opening may leave its plane by this part of its size.
const PLANE: f64 = 1e-3;
/// Planes with at least this cosine between their normals are one.
const SAME: f64 = 1.0 - 1e-6;

/// The rim of a surface.
pub(super) struct Rim {
    /// Boundaries of the openings, as numbers of the mesh, each once.
    pub names: Vec<u16>,
    /// For each edge of the rim its place in `names`.
    pub edges: HashMap<Edge, usize>,
    /// Normals of the planes in which a node lies, by its number in the mesh, and one of their boundaries.
    pub planes: BTreeMap<u32, (Vec<[f64; 3]>, u16)>,
}

impl Rim {
    pub fn new(mesh: &Mesh<3>, surface: &Surface) -> Result<Self, MeshError> {
        let mut at_edge: HashMap<Edge, (usize, Vec<u32>)> = HashMap::new();
        for (edge, nodes) in surface.facets.iter().flat_map(|f| edges(mesh, f.side)) {
            at_edge.entry(edge).or_insert((0, nodes)).0 += 1;
        }
        at_edge.retain(|_, (count, _)| *count == 1);
        let openings = Openings::new(mesh, surface);
        let mut rim = Rim { names: vec![], edges: HashMap::new(), planes: BTreeMap::new() };
        let mut planes: HashMap<usize, [f64; 3]> = HashMap::new();
        let mut sorted: Vec<_> = at_edge.into_iter().collect();
        sorted.sort_unstable();
        for (edge, (_, nodes)) in sorted {
            let Some(&facet) = openings.at_edge.get(&edge) else {
                let at = place(mesh, mesh.nodes[edge[0] as usize]);
                return refuse(
                    "surface",
                    format!("the surface ends at {at}, beside no boundary with a name"),
                );
            };
            let name = openings.names[facet];
            let part = openings.part[facet];
            let normal = match planes.get(&part) {
                Some(normal) => *normal,
                None => *planes.entry(part).or_insert(openings.plane(mesh, part)?),
            };
            let place = rim.names.iter().position(|n| *n == name).unwrap_or(rim.names.len());
            if place == rim.names.len() {
                rim.names.push(name);
            }
            rim.edges.insert(edge, place);
            for node in nodes {
                let (normals, _) = rim.planes.entry(node).or_insert((vec![], name));
                if normals.iter().all(|n| dot(*n, normal).abs() < SAME) {
                    normals.push(normal);
                }
            }
        }
        Ok(rim)
    }
}

/// Facets of the outer boundary beside the surface, in parts: those that hang together, have one name and lie in a plane.
struct Openings {
    sides: Vec<Side>,
    names: Vec<u16>,
    /// The first facet of the part of each facet.
    part: Vec<usize>,
    /// The facet at each edge of the surface.
    at_edge: HashMap<Edge, usize>,
}

impl Openings {
    fn new(mesh: &Mesh<3>, surface: &Surface) -> Self {
        let on_surface: HashMap<Side, ()> = surface.facets.iter().map(|f| (f.side, ())).collect();
        let named: HashMap<Side, u16> = mesh.facets.iter().rev().map(|f| (f.side(), f.boundary)).collect();
        let outer = mesh.facets_of_cells().outer.into_iter();
        let beside = outer.filter(|side| !on_surface.contains_key(side));
        let (sides, names): (Vec<Side>, Vec<u16>) =
            beside.filter_map(|side| Some((side, *named.get(&side)?))).unzip();
        let normals: Vec<[f64; 3]> = sides.iter().map(|&side| unit(area(mesh, side))).collect();
        let (mut part, mut at_edge): (Vec<usize>, HashMap<Edge, usize>) =
            ((0..sides.len()).collect(), HashMap::new());
        let first = |part: &[usize], mut i: usize| {
            while part[i] != i {
                i = part[i];
            }
            i
        };
        for (i, &side) in sides.iter().enumerate() {
            for (edge, _) in edges(mesh, side) {
                let Some(other) = at_edge.insert(edge, i) else { continue };
                if names[other] == names[i] && dot(normals[other], normals[i]) > TOGETHER {
                    let (a, b) = (first(&part, other), first(&part, i));
                    part[a.max(b)] = a.min(b);
                }
            }
        }
        let part = (0..part.len()).map(|i| first(&part, i)).collect();
        Openings { sides, names, part, at_edge }
    }

    /// The normal of the plane of a part.
    fn plane(&self, mesh: &Mesh<3>, part: usize) -> Result<[f64; 3], MeshError> {
        let of_part = || (0..self.sides.len()).filter(|&i| self.part[i] == part).map(|i| self.sides[i]);
        let mut sum = [0.0; 3];
        let (mut nodes, mut count) = ([0.0; 3], 0.0);
        let points: Vec<[f64; 3]> = of_part()
            .flat_map(|side| mesh.facet_nodes(side.cell as usize, side.local as usize))
            .map(|node| mesh.nodes[node as usize])
            .collect();
        for side in of_part() {
            let area = area(mesh, side);
            (0..3).for_each(|d| sum[d] += area[d]);
        }
        for x in &points {
            (0..3).for_each(|d| nodes[d] += x[d]);
            count += 1.0;
        }
        let (normal, middle) = (unit(sum), nodes.map(|x| x / count));
        let size = points.iter().map(|&x| distance(x, middle)).fold(0.0, f64::max);
        let off = |x: &[f64; 3]| dot(normal, std::array::from_fn(|d| x[d] - middle[d])).abs();
        let worst = points.iter().max_by(|a, b| off(a).total_cmp(&off(b)));
        match worst.filter(|x| off(x) > PLANE * size) {
            None => Ok(normal),
            Some(x) => {
                let name = &mesh.boundaries[self.names[part] as usize];
                let reason = format!(
                    "the surface ends at boundary `{name}`, which is not plane (at {} it is {:.2e} m off): walls end in \
                     the planes of openings; if it goes on there, add `{name}` to `surface`",
                    place(mesh, *x),
                    off(x)
                );
                refuse("surface", reason)
            }
        }
    }
}

/// The vector across the vertices of a facet, as long as its area, to either side.
fn area(mesh: &Mesh<3>, side: Side) -> [f64; 3] {
    let shape = mesh.shape;
    let vertices = mesh.cell_vertices(side.cell as usize);
    let on: Vec<[f64; 3]> = (0..vertices.len())
        .filter(|&v| shape.on_facet(1, v, side.local as usize))
        .map(|v| mesh.nodes[vertices[v] as usize])
        .collect();
    let to = |a: usize, b: usize| -> [f64; 3] { std::array::from_fn(|d| on[b][d] - on[a][d]) };
    let vector = if on.len() == 3 { cross(to(0, 1), to(0, 2)) } else { cross(to(0, 3), to(1, 2)) };
    // Away from the cell.
    let out: [f64; 3] = {
        let centre = mesh.centre(side.cell as usize);
        std::array::from_fn(|d| on[0][d] - centre[d])
    };
    let half = if dot(vector, out) < 0.0 { -0.5 } else { 0.5 };
    vector.map(|x| half * x)
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// `a` with length 1; 0 stays 0.
pub(super) fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = norm(a);
    if length > 0.0 { a.map(|x| x / length) } else { a }
}
