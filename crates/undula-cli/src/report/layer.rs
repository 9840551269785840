//! What the player draws: points that move, cells with three or four corners between them, lines.

use super::arrays::{bytes, integers, singles};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use undula::output::{CellKind, FieldSnapshot};

/// A point between two points of the run, at this part of the way from the first to the second.
pub type Between = (u32, u32, f64);

/// The value at a point, from those at the points of the run.
pub fn between(&(a, b, t): &Between, value: impl Fn(usize) -> f64) -> f64 {
    if a == b { value(a as usize) } else { (1.0 - t) * value(a as usize) + t * value(b as usize) }
}

/// Cells of one kind and their lines, by numbers of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layer {
    /// What it is called.
    pub name: String,
    /// Its points: each lies between two points of the run, at this part of the way.
    pub points: Vec<Between>,
    /// Corners of a cell: three, or four in lexicographic order.
    pub corners: usize,
    /// Corners of all cells.
    pub cells: Vec<u32>,
    /// Which cells are solid.
    pub solid: Vec<bool>,
    /// Ends of the edges between cells of one kind; an edge within a curved cell is none.
    pub inner: Vec<[u32; 2]>,
    /// Ends of the edges at the boundary of the domain and of the solid.
    pub outline: Vec<[u32; 2]>,
}

impl Layer {
    /// Plane fields with straight cells, see [`FieldSnapshot::linear`].
    pub fn plane(snapshot: &FieldSnapshot, solid: &[bool]) -> Layer {
        let corners = if snapshot.kind == CellKind::Triangle { 3 } else { 4 };
        let parts = snapshot.in_cells("cell").map(|field| field.values.as_slice());
        let part = |cell: usize| parts.map_or(cell as f64, |parts| parts[cell]);
        let kind = |cell: usize| (solid[cell], part(cell));
        let (inner, outline) = lines(snapshot, &snapshot.cells, corners, kind);
        Layer {
            name: "fields".into(),
            points: (0..snapshot.points.len() as u32).map(|p| (p, p, 0.0)).collect(),
            corners,
            cells: snapshot.cells.clone(),
            solid: solid.to_vec(),
            inner,
            outline,
        }
    }

    /// The layer with the points `base` \[m\], of which `dim` coordinates count.
    ///
    /// # Errors
    /// None in practice: packing writes into memory.
    pub fn to_json(&self, base: &[[f64; 3]], dim: usize) -> anyhow::Result<Value> {
        let ends = |lines: &[[u32; 2]]| integers(lines.as_flattened());
        let axis = |d: usize| singles(self.points.iter().map(move |point| between(point, |p| base[p][d])));
        Ok(json!({
            "name": self.name,
            "corners": self.corners,
            "points": (0..dim).map(axis).collect::<anyhow::Result<Vec<_>>>()?,
            "cells": integers(&self.cells)?,
            "solid": bytes(self.solid.iter().map(|&solid| u8::from(solid)))?,
            "inner": ends(&self.inner)?,
            "outline": ends(&self.outline)?,
        }))
    }
}

/// Ends of edges: those between cells of one kind, and all others that separate something.
type Lines = (Vec<[u32; 2]>, Vec<[u32; 2]>);

/// The edges of `cells`, whose `kind` is whether a cell is solid and which curved cell it is part of.
pub fn lines(
    snapshot: &FieldSnapshot,
    cells: &[u32],
    corners: usize,
    kind: impl Fn(usize) -> (bool, f64),
) -> Lines {
    /// An edge: its ends, the cells beside it, whether all are solid or fluid alike, and parts of one.
    struct Edge {
        ends: [u32; 2],
        first: (bool, f64),
        beside: usize,
        alike: bool,
        within: bool,
    }
    let sides: &[[usize; 2]] =
        if corners == 3 { &[[0, 1], [1, 2], [0, 2]] } else { &[[0, 1], [0, 2], [1, 3], [2, 3]] };
    let places = Places::new(snapshot);
    // In order, so that the page is the same every time.
    let mut found: BTreeMap<[[i64; 3]; 2], Edge> = BTreeMap::new();
    for (n, cell) in cells.chunks_exact(corners).enumerate() {
        let kind = kind(n);
        for side in sides {
            let ends = side.map(|i| cell[i]);
            let [a, b] = ends.map(|point| places.of(snapshot.points[point as usize]));
            let new = Edge { ends, first: kind, beside: 0, alike: true, within: true };
            let edge = found.entry([a.min(b), a.max(b)]).or_insert(new);
            edge.beside += 1;
            edge.alike &= edge.first.0 == kind.0;
            edge.within &= edge.first.1 == kind.1;
        }
    }
    let (mut inner, mut outline) = (vec![], vec![]);
    for edge in found.into_values() {
        match (edge.beside > 1 && edge.alike, edge.within) {
            (true, true) => {}
            (true, false) => inner.push(edge.ends),
            (false, _) => outline.push(edge.ends),
        }
    }
    (inner, outline)
}

/// Rounds places: points meet by place, since discontinuous fields have points of their own in every cell.
struct Places {
    unit: f64,
}

impl Places {
    fn new(snapshot: &FieldSnapshot) -> Self {
        let mut size = 0.0_f64;
        for d in 0..3 {
            let along = snapshot.points.iter().map(|x| x[d]);
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |r, x| (r.0.min(x), r.1.max(x)));
            size = size.max(high - low);
        }
        Places { unit: 1e-8 * size.max(f64::MIN_POSITIVE) }
    }

    fn of(&self, x: [f64; 3]) -> [i64; 3] {
        x.map(|c| (c / self.unit).round() as i64)
    }
}
