//! What a picture shows of fields: all of them where they are plane, a cut by a plane where they are not.

use super::super::cut::{Cut, Plane};
use super::super::space::{extents, size};
use super::WIDTH;
use super::edges::Edges;
use crate::args;
use crate::digits::among;
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
        let size = size(snapshot);
        let wrong = |what: &str| {
            let [at, low, high] = [at, low, high].map(|x| among(x, size, 6));
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
        let shown = among(at, size, 6);
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

#[cfg(test)]
mod tests {
    use super::super::super::cut::tests::{hexahedra, shell};
    use super::super::super::figure::Panel;
    use super::super::raster::{NOWHERE, Raster};
    use super::*;

    /// p = x y − z where 1 < r < 2, nothing elsewhere.
    #[test]
    fn samples_of_a_cut_have_the_field_at_their_place() {
        let mesh = hexahedra(2, [3, 6, 2], shell(0.1));
        for (mesh, tolerance) in [(mesh.clone(), 4e-3), (mesh.linear(), 2e-2)] {
            let view = View::cut(&mesh, args::Plane { axis: 2, at: Some(0.25) }).unwrap();
            assert_eq!((view.axes, view.place.as_deref()), (["x [m]", "y [m]"], Some("z = 0.25 m")));
            let ends = (0.0, 2.0);
            let panel = Panel {
                left: 7.0,
                top: 9.0,
                width: 100.0,
                height: 100.0,
                x: ends,
                y: ends,
                logarithmic: false,
            };
            let raster =
                Raster::new(&view.fields, &view.fields.at_points("pressure").unwrap().values, &panel, 2);
            for (n, sample) in raster.samples.iter().enumerate() {
                let [x, y] = [n % raster.width, raster.height - 1 - n / raster.width]
                    .map(|i| 2.0 * (i as f64 + 0.5) / raster.width as f64);
                let r = x.hypot(y);
                // Pieces have straight sides.
                if (r - 1.0).abs() > 0.03 && (r - 2.0).abs() > 0.03 {
                    let within = r > 1.0 && r < 2.0;
                    assert_eq!(sample.cell != NOWHERE, within, "({x}, {y})");
                    assert!(!within || (f64::from(sample.value) - (x * y - 0.25)).abs() < tolerance);
                }
            }
        }
    }

    #[test]
    fn the_middle_is_across_the_shortest_side_where_there_are_cells() {
        let flat = hexahedra(1, [2; 3], |[r, s, t]| [2.0 * r, 0.1 + 0.5 * s, t]);
        let view = View::middle(&flat).unwrap();
        assert_eq!((view.axes, view.suffix.as_str()), (["x [m]", "z [m]"], ""));
        assert_eq!(view.place.as_deref(), Some("y = 0.35 m"));
        let about = hexahedra(1, [2; 3], |[r, s, t]| [r, 0.2 * s - 0.1 - 2e-9, t]);
        assert_eq!(View::middle(&about).unwrap().place.as_deref(), Some("y = 0 m"), "rounding of the file");
        let mut apart = hexahedra(1, [2, 2, 3], |x| x);
        // Without the middle layer.
        apart.cells.drain(4 * 8..8 * 8);
        assert_eq!(View::middle(&apart).unwrap().place.as_deref(), Some("z = 0.25 m"));
        let error = View::cut(&apart, args::Plane { axis: 2, at: None }).err().unwrap();
        assert!(
            error.contains("z=0.5: the plane meets no cell; the domain reaches from z = 0 to 1 m"),
            "{error}"
        );
    }
}
