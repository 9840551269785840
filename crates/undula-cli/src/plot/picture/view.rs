//! What a picture shows of fields: all of them where they are plane, a cut by a plane where they are not.

use super::super::cut::{Cut, Plane};
use super::super::space::extents;
use super::WIDTH;
use super::edges::Edges;
use crate::args;
use crate::digits::significant;
use std::borrow::Cow;
use undula::output::FieldSnapshot;

/// Names of the coordinates.
const NAMES: [&str; 3] = ["x", "y", "z"];

/// Labels of their axes.
const LABELS: [&str; 3] = ["x [m]", "y [m]", "z [m]"];

/// Fields in a plane, and what is drawn with them.
pub struct View<'a> {
    /// The fields; the first two coordinates are those of the picture.
    pub fields: Cow<'a, FieldSnapshot>,
    /// Which of their cells are solid.
    pub solid: Vec<bool>,
    /// Edges of cells.
    pub(super) edges: Edges,
    /// Labels of the two coordinates.
    pub(super) axes: [&'static str; 2],
    /// Where a cut is, for titles.
    pub(super) place: Option<String>,
    /// What the names of files end with.
    pub(super) suffix: String,
}

impl<'a> View<'a> {
    /// All of plane fields.
    pub fn whole(snapshot: &'a FieldSnapshot) -> Self {
        let solid = solid_cells(snapshot);
        let edges = Edges::new(snapshot, &solid);
        let fields = Cow::Borrowed(snapshot);
        View { fields, solid, edges, axes: [LABELS[0], LABELS[1]], place: None, suffix: String::new() }
    }

    /// A cut of fields in space.
    ///
    /// # Errors
    /// If the plane meets nothing.
    pub fn cut(snapshot: &FieldSnapshot, plane: args::Plane) -> Result<View<'static>, String> {
        let name = NAMES[plane.axis];
        let (low, high) = extents(snapshot)[plane.axis];
        let at = plane.at.unwrap_or(0.5 * (low + high));
        let wrong = |what: &str| {
            let [at, low, high] = [at, low, high].map(|x| significant(x, 6));
            format!("--cut {name}={at}: {what}; the domain reaches from {name} = {low} to {high} m")
        };
        if !(low <= at && at <= high) {
            return Err(wrong("the plane is outside of the domain"));
        }
        let across: Vec<usize> = (0..3).filter(|&d| d != plane.axis).collect();
        let scale = across
            .iter()
            .map(|&d| extents(snapshot)[d])
            .fold(f64::INFINITY, |scale, (low, high)| scale.min(WIDTH / (high - low)));
        let Cut { fields, inner, outline } =
            Cut::new(snapshot, &solid_cells(snapshot), Plane { axis: plane.axis, at }, scale);
        if fields.cells.is_empty() {
            return Err(wrong("the plane meets no cell"));
        }
        let shown = significant(at, 6);
        Ok(View {
            solid: solid_cells(&fields),
            fields: Cow::Owned(fields),
            edges: Edges::of_cut(snapshot, inner, outline),
            axes: [LABELS[across[0]], LABELS[across[1]]],
            place: Some(format!("{name} = {} m", shown.replace('-', "\u{2212}"))),
            suffix: format!("-{name}={shown}"),
        })
    }

    /// The cut across the shortest side of the domain, in its middle or where it meets cells.
    ///
    /// # Errors
    /// If the plane meets nothing.
    pub fn middle(snapshot: &FieldSnapshot) -> Result<View<'static>, String> {
        let ranges = extents(snapshot);
        let extent = |d: usize| ranges[d].1 - ranges[d].0;
        // Of equal sides the last one.
        let axis = (0..3).rev().min_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(2);
        let at = |part: f64| args::Plane { axis, at: Some(ranges[axis].0 + part * extent(axis)) };
        let middle = Self::cut(snapshot, at(0.5));
        let view =
            middle.or_else(|_| Self::cut(snapshot, at(0.25))).or_else(|_| Self::cut(snapshot, at(0.75)))?;
        Ok(View { suffix: String::new(), ..view })
    }
}

/// Whether each cell is solid.
pub fn solid_cells(snapshot: &FieldSnapshot) -> Vec<bool> {
    match snapshot.in_cells("solid") {
        Some(field) => field.values.iter().map(|&s| s > 0.5).collect(),
        None => vec![false; snapshot.n_cells()],
    }
}
