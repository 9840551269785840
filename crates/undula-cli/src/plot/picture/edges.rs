//! The edges of the cells of a picture.

use super::super::cell::{Reference, lagrange};
use super::super::colors::Rgb;
use super::super::figure::{Figure, Panel};
use super::bounds;
use std::collections::BTreeMap;
use undula::output::FieldSnapshot;

/// Mesh lines and outlines darken the colours beneath.
const MESH: Rgb = [150, 150, 150];

/// An edge: its nodes, and which of the cells beside it are solid.
struct Edge {
    nodes: Vec<[f64; 2]>,
    beside: Vec<bool>,
    /// The cell of which the first of them is a part.
    part_of: f64,
    /// Whether all cells beside it are parts of one.
    within: bool,
}

/// Edges of the cells as curves.
pub(super) struct Edges {
    /// Between cells of one kind.
    inner: Vec<Vec<[f64; 2]>>,
    /// At the boundary of the domain and of the solid.
    outline: Vec<Vec<[f64; 2]>>,
    /// Edges of pieces that make one edge of a cell.
    pieces: f64,
}

impl Edges {
    pub fn new(snapshot: &FieldSnapshot, solid: &[bool]) -> Self {
        // Edges meet by position, since discontinuous fields have points of their own in every cell.
        let (x, y) = bounds(snapshot, |_| true);
        let unit = 1e-8 * (x.1 - x.0).max(y.1 - y.0);
        let key = |p: [f64; 2]| p.map(|c| (c / unit).round() as i64);
        let (k, sides) = (snapshot.degree, Reference::of(snapshot).sides());
        let parts = snapshot.in_cells("cell");
        // In order, so that the picture is the same every time.
        let mut found: BTreeMap<[[i64; 2]; 2], Edge> = BTreeMap::new();
        for (n, cell) in snapshot.cells.chunks_exact(snapshot.points_per_cell()).enumerate() {
            for side in &sides {
                let at = |i: usize| snapshot.points[cell[i] as usize];
                let nodes: Vec<[f64; 2]> = side.iter().map(|&i| [at(i)[0], at(i)[1]]).collect();
                let (a, b) = (key(nodes[0]), key(nodes[k]));
                let part_of = parts.map_or(n as f64, |parts| parts.values[n]);
                let new = Edge { beside: Vec::new(), nodes, part_of, within: true };
                let edge = found.entry([a.min(b), a.max(b)]).or_insert(new);
                edge.beside.push(solid[n]);
                edge.within &= edge.part_of == part_of;
            }
        }
        let cells = parts.and_then(|parts| parts.values.last()).map_or(solid.len() as f64, |last| last + 1.0);
        let pieces = (solid.len() as f64 / cells).sqrt();
        let mut edges = Edges { inner: Vec::new(), outline: Vec::new(), pieces };
        for Edge { beside, nodes, within, .. } in found.into_values() {
            let inside = beside.len() > 1 && beside.iter().all(|&kind| kind == beside[0]);
            if inside && within {
                continue;
            }
            (if inside { &mut edges.inner } else { &mut edges.outline }).push(curve(&nodes));
        }
        edges
    }

    /// Lines of a cut through `fields`, which have three dimensions.
    pub fn of_cut(fields: &FieldSnapshot, inner: Vec<Vec<[f64; 2]>>, outline: Vec<Vec<[f64; 2]>>) -> Self {
        let last = fields.in_cells("cell").and_then(|parts| parts.values.last());
        let cells = last.map_or(fields.n_cells() as f64, |last| last + 1.0);
        Edges { inner, outline, pieces: (fields.n_cells() as f64 / cells).cbrt() }
    }

    /// Draws outlines, and the mesh if it is asked for and coarse enough to be seen.
    pub fn draw(&self, figure: &mut Figure, panel: &Panel, mesh: bool) {
        let place = |curve: &Vec<[f64; 2]>| curve.iter().map(|p| panel.at(p[0], p[1])).collect::<Vec<_>>();
        let visible = |points: &Vec<(f64, f64)>| {
            points.iter().any(|p| {
                let (x, y) = (p.0 - panel.left, p.1 - panel.top);
                (0.0..=panel.width).contains(&x) && (0.0..=panel.height).contains(&y)
            })
        };
        let inner: Vec<_> = self.inner.iter().map(place).filter(visible).collect();
        let length = |c: &Vec<(f64, f64)>| (c[0].0 - c[c.len() - 1].0).hypot(c[0].1 - c[c.len() - 1].1);
        let mean_length = inner.iter().map(length).sum::<f64>() / inner.len().max(1) as f64;
        let outline: Vec<_> = self.outline.iter().map(place).filter(visible).collect();
        figure.clipped(panel, |figure| {
            if mesh && self.pieces * mean_length > 5.0 {
                inner.into_iter().for_each(|points| figure.curve(points, MESH, 0.4));
            }
            outline.into_iter().for_each(|points| figure.curve(points, [0; 3], 1.2));
        });
    }
}

/// Points along the edge through `nodes`.
fn curve(nodes: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let degree = nodes.len() - 1;
    let pieces = if degree == 1 { 1 } else { 8 };
    (0..=pieces)
        .map(|i| {
            let weights = lagrange(degree, f64::from(i) / f64::from(pieces));
            let sum = |d: usize| weights.iter().zip(nodes).map(|(w, node)| w * node[d]).sum();
            [sum(0), sum(1)]
        })
        .collect()
}
