//! Block-structured meshes: points, edges between them, and four-sided blocks of cells.
//!
//! Blocks that share an edge share its nodes, so nothing has to be merged afterwards.

use crate::element::Shape;
use crate::mesh::topology::Side;
use crate::mesh::{Facet, Mesh};
use std::collections::HashMap;

/// Number of a point; its node in the mesh.
pub(super) type Point = u32;

/// The course of an edge.
#[derive(Copy, Clone, Debug)]
pub(super) enum Path {
    /// The straight segment.
    Line,
    /// The shorter arc around a centre; the radius changes linearly between those of the two ends.
    Arc([f64; 2]),
}

impl Path {
    /// The point at fraction `s` of the way from `a` to `b`.
    fn at(self, a: [f64; 2], b: [f64; 2], s: f64) -> [f64; 2] {
        let mix = |x: f64, y: f64| x + s * (y - x);
        match self {
            Path::Line => [mix(a[0], b[0]), mix(a[1], b[1])],
            Path::Arc(c) => {
                let polar =
                    |x: [f64; 2]| ((x[0] - c[0]).hypot(x[1] - c[1]), (x[1] - c[1]).atan2(x[0] - c[0]));
                let ((r_a, angle_a), (r_b, angle_b)) = (polar(a), polar(b));
                let turn = (angle_b - angle_a + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
                    - std::f64::consts::PI;
                let (r, angle) = (mix(r_a, r_b), angle_a + s * turn);
                [c[0] + r * angle.cos(), c[1] + r * angle.sin()]
            }
        }
    }
}

/// A sampled edge: the vertices and mid nodes of its cells and where they are along it.
#[derive(Clone, Debug)]
struct Edge {
    nodes: Vec<u32>,
    fractions: Vec<f64>,
    boundary: Option<u16>,
}

impl Edge {
    fn reversed(&self) -> Edge {
        Edge {
            nodes: self.nodes.iter().rev().copied().collect(),
            fractions: self.fractions.iter().rev().map(|s| 1.0 - s).collect(),
            boundary: self.boundary,
        }
    }
}

/// A mesh in the making; geometry of degree 2.
pub(super) struct Blocks {
    mesh: Mesh<2>,
    edges: HashMap<(Point, Point), Edge>,
}

impl Blocks {
    /// Nothing yet, with the names of the regions in order.
    pub(super) fn new(regions: &[&str]) -> Self {
        let mesh = Mesh {
            shape: Shape::Quadrilateral,
            degree: 2,
            nodes: vec![],
            cell_nodes: vec![],
            cell_region: vec![],
            regions: regions.iter().map(|r| r.to_string()).collect(),
            facets: vec![],
            boundaries: vec![],
            parts: vec![],
        };
        Blocks { mesh, edges: HashMap::new() }
    }

    /// Adds a point.
    pub(super) fn point(&mut self, x: f64, y: f64) -> Point {
        self.mesh.nodes.push([x, y]);
        self.mesh.nodes.len() as u32 - 1
    }

    /// Where a point is.
    pub(super) fn x(&self, point: Point) -> [f64; 2] {
        self.mesh.nodes[point as usize]
    }

    /// Adds an edge from `a` to `b`, divided at the fractions `breaks` from 0 to 1.
    pub(super) fn edge(&mut self, a: Point, b: Point, path: Path, breaks: &[f64]) {
        let (x_a, x_b) = (self.mesh.nodes[a as usize], self.mesh.nodes[b as usize]);
        let last = 2 * (breaks.len() - 1);
        let (mut nodes, mut fractions) = (vec![a], vec![0.0]);
        for i in 1..last {
            let s = 0.5 * (breaks[i / 2] + breaks[i.div_ceil(2)]);
            let [x, y] = path.at(x_a, x_b, s);
            nodes.push(self.point(x, y));
            fractions.push(s);
        }
        nodes.push(b);
        fractions.push(1.0);
        let known = self.edges.insert((a, b), Edge { nodes, fractions, boundary: None });
        assert!(known.is_none() && !self.edges.contains_key(&(b, a)), "edge {a}-{b} is there already");
    }

    /// Number of the boundary called `name`, a new one if there is none.
    pub(super) fn boundary(&mut self, name: &str) -> u16 {
        self.mesh.boundary_number(name)
    }

    /// Calls the edge between `a` and `b` part of boundary `name`; before the blocks at it are added.
    pub(super) fn name(&mut self, a: Point, b: Point, name: &str) {
        let boundary = self.boundary(name);
        let key = if self.edges.contains_key(&(a, b)) { (a, b) } else { (b, a) };
        if let Some(edge) = self.edges.get_mut(&key) {
            edge.boundary = Some(boundary);
        }
    }

    /// The edge from `a` to `b`, whichever way it was given.
    fn directed(&self, a: Point, b: Point) -> Edge {
        match self.edges.get(&(a, b)) {
            Some(edge) => edge.clone(),
            None => self.edges.get(&(b, a)).expect("blocks are made of edges given before").reversed(),
        }
    }

    /// Adds the block with counter-clockwise corners `[a, b, c, d]`, cells running along `a b` first.
    pub(super) fn block(&mut self, region: u16, [a, b, c, d]: [Point; 4]) {
        let [bottom, right] = [self.directed(a, b), self.directed(b, c)];
        let [top, left] = [self.directed(d, c), self.directed(a, d)];
        let (n, m) = (bottom.nodes.len(), left.nodes.len());
        assert!(top.nodes.len() == n && right.nodes.len() == m, "opposite edges have equal divisions");
        let coons = Coons { x: &self.mesh.nodes, bottom: &bottom, right: &right, top: &top, left: &left };
        let inside: Vec<_> =
            (1..m - 1).map(|j| (1..n - 1).map(|i| coons.at(i, j)).collect::<Vec<_>>()).collect();
        let mut grid = vec![bottom.nodes.clone()];
        for (row, j) in inside.into_iter().zip(1..) {
            let mut numbers = vec![left.nodes[j]];
            numbers.extend(row.into_iter().map(|[x, y]| self.point(x, y)));
            numbers.push(right.nodes[j]);
            grid.push(numbers);
        }
        grid.push(top.nodes.clone());
        let names = [left.boundary, right.boundary, bottom.boundary, top.boundary];
        self.cells(region, &grid, names);
    }

    /// Adds the cells between the nodes `grid[j][i]` and the facets on the named sides of the block.
    fn cells(&mut self, region: u16, grid: &[Vec<u32>], names: [Option<u16>; 4]) {
        let (n, m) = (grid[0].len() / 2, grid.len() / 2);
        for j in 0..m {
            for i in 0..n {
                let cell = self.mesh.n_cells() as u32;
                let nodes = (0..9).map(|k| grid[2 * j + k / 3][2 * i + k % 3]);
                self.mesh.cell_nodes.extend(nodes);
                self.mesh.cell_region.push(region);
                let at_side = [i == 0, i + 1 == n, j == 0, j + 1 == m];
                for (local, (boundary, _)) in names.iter().zip(at_side).enumerate().filter(|(_, (_, at))| *at)
                {
                    let facet = |&boundary| Facet { cell, local: local as u8, boundary };
                    self.mesh.facets.extend(boundary.iter().map(facet));
                }
            }
        }
    }

    /// The finished mesh.
    ///
    /// A facet that two blocks named is kept once, as the cell of the first region sees it.
    pub(super) fn finish(self) -> Mesh<2> {
        let mut mesh = self.mesh;
        let beyond = mesh.neighbours();
        let rank = |side: Side| (mesh.cell_region[side.cell as usize], side);
        let facets = mesh
            .facets
            .iter()
            .copied()
            .filter(|f| beyond.get(&f.side()).is_none_or(|&other| rank(f.side()) < rank(other)));
        mesh.facets = facets.collect();
        mesh
    }
}

/// Transfinite interpolation between four sampled edges, all running in the direction of the indices.
struct Coons<'a> {
    x: &'a [[f64; 2]],
    bottom: &'a Edge,
    right: &'a Edge,
    top: &'a Edge,
    left: &'a Edge,
}

impl Coons<'_> {
    /// `(1−t) B(s) + t T(s) + (1−s) L(t) + s R(t)` less the bilinear map of the corners, at index `(i, j)`.
    ///
    /// `(s, t)` is where the segment between the fractions of column `i` on bottom and top meets the one
    /// between those of row `j` on left and right, so that opposite edges may be divided differently.
    fn at(&self, i: usize, j: usize) -> [f64; 2] {
        let (b, t) = (self.bottom.fractions[i], self.top.fractions[i]);
        let (l, r) = (self.left.fractions[j], self.right.fractions[j]);
        let u = (b + l * (t - b)) / (1.0 - (t - b) * (r - l));
        let v = l + u * (r - l);
        let n = self.bottom.nodes.len() - 1;
        let x = |edge: &Edge, k: usize| self.x[edge.nodes[k] as usize];
        std::array::from_fn(|d| {
            let edges = (1.0 - v) * x(self.bottom, i)[d]
                + v * x(self.top, i)[d]
                + (1.0 - u) * x(self.left, j)[d]
                + u * x(self.right, j)[d];
            let corners = (1.0 - v) * ((1.0 - u) * x(self.bottom, 0)[d] + u * x(self.bottom, n)[d])
                + v * ((1.0 - u) * x(self.top, 0)[d] + u * x(self.top, n)[d]);
            edges - corners
        })
    }
}

/// Fractions of `n` equal parts.
pub(super) fn even(n: usize) -> Vec<f64> {
    (0..=n).map(|i| i as f64 / n as f64).collect()
}

/// Fractions of parts that grow by `ratio` from one to the next.
pub(super) fn growing(n: usize, ratio: f64) -> Vec<f64> {
    let sizes: Vec<f64> = (0..n).map(|i| ratio.powi(i as i32)).collect();
    parts(&sizes)
}

/// Fractions of parts in the proportion of `sizes`.
pub(super) fn parts(sizes: &[f64]) -> Vec<f64> {
    let total: f64 = sizes.iter().sum();
    let mut breaks = vec![0.0];
    let mut sum = 0.0;
    for size in sizes {
        sum += size;
        breaks.push(sum / total);
    }
    if let Some(last) = breaks.last_mut() {
        *last = 1.0;
    }
    breaks
}

/// Fractions between those of `a` and of `b`: `(1 − share) a + share b`.
pub(super) fn mixed(a: &[f64], b: &[f64], share: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + share * (b - a)).collect()
}
