//! Uniform refinement of curved meshes.

use super::geometry::distance;
use super::topology::Side;
use super::{Curve, Facet, Mesh};
use crate::element::Shape;
use std::collections::HashMap;

/// Identity of a point on the facets of cells: the vertices it depends on and the weights there in a
/// multilinear (on simplices: linear) interpolation. Cells that share a facet agree on both.
type PointKey = [(u32, u32); 8];

impl<const D: usize> Mesh<D> {
    /// Splits each cell into `2^D`: cell `2^D c + i` is child `i` of cell `c`, children in lexicographic order; of
    /// simplices those at the vertices, then those in the middle, see [`Shape::child_number`]. In a tetrahedron they share
    /// the shortest diagonal between middles of opposite edges, so that angles stay away from 0.
    ///
    /// New geometry nodes come from the map of the parent, so that the finer mesh is the same domain
    /// and contains all nodes of the coarser one. Only nodes on boundaries that follow one of `curves`
    /// are moved onto it, and the nodes behind them within the same cell by a share that fades to zero
    /// at the opposite facet. Names are kept.
    pub fn refine(&self, curves: &[Curve<D>]) -> Mesh<D> {
        self.refine_along(&self.diagonals(), curves)
    }

    /// The diagonal that the children in the middle of each tetrahedron share; empty for other shapes.
    pub(super) fn diagonals(&self) -> Vec<u8> {
        if self.shape != Shape::Tetrahedron {
            return vec![];
        }
        let middle = |cell: usize, v: usize, w: usize| {
            let at = |i: usize, d: usize| if i == d + 1 { 0.5 } else { 0.0 };
            self.map(cell, std::array::from_fn(|d| at(v, d) + at(w, d)))
        };
        let length = |cell: usize, diagonal: usize| {
            let (end, [v, w]) = (diagonal + 1, [[2, 3], [1, 3], [1, 2]][diagonal]);
            distance(middle(cell, 0, end), middle(cell, v, w))
        };
        let shortest = |cell: usize| {
            let lengths = [0, 1, 2].map(|diagonal| length(cell, diagonal));
            // Equal but for rounding counts as equal.
            let least = (1.0 + 1e-9) * lengths.iter().copied().fold(f64::INFINITY, f64::min);
            lengths.iter().position(|length| *length <= least).unwrap_or(0) as u8
        };
        (0..self.n_cells()).map(shortest).collect()
    }

    /// As [`Mesh::refine`], with given diagonals of tetrahedra.
    pub(super) fn refine_along(&self, diagonals: &[u8], curves: &[Curve<D>]) -> Mesh<D> {
        let lattice = FineLattice::<D>::new(self);
        let on_curves = self.sides_on_curves(curves);
        let mut nodes = NodePool { nodes: Vec::new(), known: HashMap::new() };
        let mut cell_nodes = Vec::with_capacity(self.cell_nodes.len() << D);
        for cell in 0..self.n_cells() {
            let mut points: Vec<_> = lattice.at.iter().map(|&at| self.map(cell, lattice.xi(at))).collect();
            for &(local, curve) in on_curves.get(&(cell as u32)).into_iter().flatten() {
                lattice.move_onto(&curves[curve], local as usize, &mut points);
            }
            let vertices = self.cell_vertices(cell);
            let numbers: Vec<_> = points
                .iter()
                .zip(&lattice.at)
                .map(|(&x, &at)| nodes.number(lattice.key(at, &vertices), x))
                .collect();
            let diagonal = diagonals.get(cell).copied().unwrap_or(0);
            for place in 0..1 << D {
                let child = self.shape.child_number(place, diagonal);
                cell_nodes.extend(lattice.child_nodes(self, child).map(|n| numbers[n]));
            }
        }
        let mut mesh = Mesh {
            shape: self.shape,
            degree: self.degree,
            nodes: nodes.nodes,
            cell_nodes,
            cell_region: self.cell_region.iter().flat_map(|&region| vec![region; 1 << D]).collect(),
            regions: self.regions.clone(),
            facets: self.facets.iter().flat_map(|&f| child_facets::<D>(self.shape, f)).collect(),
            boundaries: self.boundaries.clone(),
            parts: self.parts.iter().flat_map(|&f| child_facets::<D>(self.shape, f)).collect(),
        };
        mesh.project_boundaries(curves);
        mesh
    }

    /// Refines `times` times; [`Hierarchy::refine`](super::Hierarchy::refine) keeps the coarser meshes.
    pub fn refined(self, times: usize, curves: &[Curve<D>]) -> Mesh<D> {
        (0..times).fold(self, |mesh, _| mesh.refine(curves))
    }

    /// Moves all nodes of boundaries that follow one of `curves` onto it.
    pub fn project_boundaries(&mut self, curves: &[Curve<D>]) {
        for curve in curves {
            let followed: Vec<_> = curve.boundaries().iter().filter_map(|b| self.boundary(b)).collect();
            for i in 0..self.facets.len() {
                let facet = self.facets[i];
                if followed.contains(&facet.boundary) {
                    for node in self.facet_nodes(facet.cell as usize, facet.local as usize) {
                        let x = &mut self.nodes[node as usize];
                        *x = curve.project(*x);
                    }
                }
            }
        }
    }

    /// For each cell at a curve its facets there and the number of the curve, from both sides of facets
    /// inside the mesh.
    fn sides_on_curves(&self, curves: &[Curve<D>]) -> HashMap<u32, Vec<(u8, usize)>> {
        let mut sides: HashMap<u32, Vec<(u8, usize)>> = HashMap::new();
        let mut named: HashMap<Side, usize> = HashMap::new();
        for (number, curve) in curves.iter().enumerate() {
            let followed: Vec<_> = curve.boundaries().iter().filter_map(|b| self.boundary(b)).collect();
            for f in self.facets.iter().filter(|f| followed.contains(&f.boundary)) {
                named.insert(f.side(), number);
                sides.entry(f.cell).or_default().push((f.local, number));
            }
        }
        if named.is_empty() {
            return sides;
        }
        // In the order of the cells, so that sums of displacements do not depend on chance.
        for (here, beyond) in self.facets_of_cells().inner.into_iter().flat_map(|[a, b]| [(a, b), (b, a)]) {
            if let Some(&number) = named.get(&here) {
                sides.entry(beyond.cell).or_default().push((beyond.local, number));
            }
        }
        sides
    }
}

/// Nodes of the finer mesh as they are met.
struct NodePool<const D: usize> {
    nodes: Vec<[f64; D]>,
    known: HashMap<PointKey, u32>,
}

impl<const D: usize> NodePool<D> {
    /// Number of the node at `x`, a new one unless `key` is known; points inside a cell have no key.
    fn number(&mut self, key: Option<PointKey>, x: [f64; D]) -> u32 {
        let next = self.nodes.len() as u32;
        let number = key.map_or(next, |key| *self.known.entry(key).or_insert(next));
        if number == next {
            self.nodes.push(x);
        }
        number
    }
}

/// The geometry nodes of all children within their parent: the nodes of degree `2 degree`.
struct FineLattice<const D: usize> {
    shape: Shape,
    /// Intervals per direction.
    n: usize,
    /// Positions, the first coordinate running fastest.
    at: Vec<[usize; D]>,
}

impl<const D: usize> FineLattice<D> {
    fn new(mesh: &Mesh<D>) -> Self {
        let n = 2 * mesh.degree;
        let at = (0..mesh.shape.n_nodes(n)).map(|i| {
            let at = mesh.shape.lattice(n, i);
            std::array::from_fn(|d| at[d])
        });
        FineLattice { shape: mesh.shape, n, at: at.collect() }
    }

    /// Reference coordinates of lattice position `at`.
    fn xi(&self, at: [usize; D]) -> [f64; D] {
        at.map(|i| i as f64 / self.n as f64)
    }

    /// Index of lattice position `at`.
    fn index(&self, at: [usize; D]) -> usize {
        self.shape.number(self.n, std::array::from_fn(|d| if d < D { at[d] } else { 0 }))
    }

    /// Identity of position `at` in a cell with these vertices; none inside of the cell.
    fn key(&self, at: [usize; D], vertices: &[u32]) -> Option<PointKey> {
        let node = self.index(at);
        if self.shape.is_inner(self.n, node) {
            return None;
        }
        let mut key = [(u32::MAX, 0); 8];
        let weights = self.shape.vertex_weights(self.n, node);
        for ((&vertex, weight), entry) in vertices.iter().zip(weights).zip(&mut key) {
            if weight > 0 {
                *entry = (vertex, weight);
            }
        }
        key.sort_unstable();
        Some(key)
    }

    /// Lattice indices of the geometry nodes of child `child`, in the order of the shape.
    fn child_nodes<'a>(&'a self, mesh: &'a Mesh<D>, child: usize) -> impl Iterator<Item = usize> + 'a {
        let (shape, degree) = (mesh.shape, mesh.degree);
        let place = move |local| shape.in_parent(degree, child, shape.lattice(degree, local));
        (0..shape.n_nodes(degree)).map(move |local| shape.number(self.n, place(local)))
    }

    /// Mean of the parent's nodes next to `at` on the facet across `axis`: projected, it lies in the
    /// middle of them, where the map of the parent would be off by `O(h³)` along the curve.
    fn straight(&self, at: [usize; D], axis: usize, points: &[[f64; D]]) -> [f64; D] {
        let odd = |d: usize| d != axis && at[d] % 2 == 1;
        let mut mean = [0.0; D];
        for corner in 0..1 << D {
            let beside = std::array::from_fn(|d| match (odd(d), corner >> d & 1) {
                (true, 0) => at[d] - 1,
                (true, _) => at[d] + 1,
                _ => at[d],
            });
            for d in 0..D {
                mean[d] += points[self.index(beside)][d] / (1 << D) as f64;
            }
        }
        mean
    }

    /// Moves the points on facet `facet` of a triangle onto `curve`, those with an odd number along the facet next to
    /// the middle of their neighbours. The map keeps its second derivatives up to `O(h³)`, since the points move
    /// by no more, so that those inside may stay.
    fn move_edge_onto(&self, curve: &Curve<D>, facet: usize, points: &mut [[f64; D]]) {
        let nodes = self.shape.facet_nodes(self.n, facet);
        let beside = |i: usize| if i % 2 == 1 { [nodes[i - 1], nodes[i + 1]] } else { [nodes[i]; 2] };
        let mean = |[a, b]: [usize; 2]| std::array::from_fn(|d| 0.5 * (points[a][d] + points[b][d]));
        let targets: Vec<_> = (0..nodes.len()).map(|i| curve.project(mean(beside(i)))).collect();
        nodes.iter().zip(targets).for_each(|(&node, target)| points[node] = target);
    }

    /// The same on facet `facet` of a tetrahedron: points with two odd barycentric coordinates lie between two others.
    fn move_face_onto(&self, curve: &Curve<D>, facet: usize, points: &mut [[f64; D]]) {
        let nodes = self.shape.facet_nodes(self.n, facet);
        let mean = |node: usize| {
            let weights = self.shape.vertex_weights(self.n, node);
            let odd: Vec<usize> = (0..=D).filter(|&v| weights[v] % 2 == 1).collect();
            let [v, w] = odd[..] else { return points[node] };
            let beside = |v: usize, w: usize| {
                let mut at = weights.clone();
                (at[v], at[w]) = (at[v] + 1, at[w] - 1);
                points[self.index(std::array::from_fn(|d| at[d + 1] as usize))]
            };
            let ends = [beside(v, w), beside(w, v)];
            std::array::from_fn(|d| 0.5 * (ends[0][d] + ends[1][d]))
        };
        let targets: Vec<_> = nodes.iter().map(|&node| curve.project(mean(node))).collect();
        nodes.iter().zip(targets).for_each(|(&node, target)| points[node] = target);
    }

    /// Moves the points on facet `facet` onto `curve`, and those behind the inside of the facet by
    /// `1 − t` of the same, `t ∈ [0, 1]` being their place between the facet and the opposite one.
    fn move_onto(&self, curve: &Curve<D>, facet: usize, points: &mut [[f64; D]]) {
        if self.shape == Shape::Triangle {
            return self.move_edge_onto(curve, facet, points);
        }
        if self.shape == Shape::Tetrahedron {
            return self.move_face_onto(curve, facet, points);
        }
        let (axis, side) = (facet / 2, facet % 2);
        for &at in self.at.iter().filter(|at| at[axis] == side * self.n) {
            let here = points[self.index(at)];
            let target = curve.project(self.straight(at, axis, points));
            let inside = (0..D).all(|d| d == axis || (at[d] != 0 && at[d] != self.n));
            for depth in 0..if inside { self.n } else { 1 } {
                let share = 1.0 - depth as f64 / self.n as f64;
                let mut behind = at;
                behind[axis] = if side == 0 { depth } else { self.n - depth };
                let x = &mut points[self.index(behind)];
                for d in 0..D {
                    x[d] += share * (target[d] - here[d]);
                }
            }
        }
    }
}

/// The `2^(D−1)` parts of a facet.
fn child_facets<const D: usize>(shape: Shape, facet: Facet) -> impl Iterator<Item = Facet> {
    (0..1_usize << D)
        .filter(move |&child| shape.child_on_facet(child, facet.local as usize))
        .map(move |child| Facet { cell: (facet.cell << D) + child as u32, ..facet })
}
