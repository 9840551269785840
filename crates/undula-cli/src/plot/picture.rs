//! Fields on the deformed mesh.

mod streamlines;

use super::cell::{Pieces, Reference, lagrange};
use super::colors::{self, INK, PLASMA, Rgb, SOLID, VIRIDIS};
use super::figure::{Anchor, Figure, Image, Panel, SCALE, labelled, readable, ticks};
use crate::digits::fixed;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use undula::output::{FieldSnapshot, Summary};

/// Samples per pixel and direction.
const SAMPLES: usize = 2;
/// Width of a picture without margins.
const WIDTH: f64 = 1000.0;
/// Mesh lines and outlines darken the colours beneath.
const MESH: Rgb = [150, 150, 150];

/// What a picture shows.
struct Content {
    file: &'static str,
    label: String,
    /// One number per point, readable.
    values: Vec<f64>,
    map: &'static [Rgb; 17],
    /// Whether the solid has values.
    in_solid: bool,
    /// Whether the colours begin at zero and end at the largest value.
    magnitude: bool,
}

/// Writes `speed.png` and `pressure.png`, or `deformation.png` if all is solid.
pub fn plot(
    snapshot: &FieldSnapshot,
    time: Option<f64>,
    summary: &Summary,
    into: &Path,
) -> anyhow::Result<Vec<PathBuf>> {
    let solid = solid_cells(snapshot);
    let mut title = summary.case.clone();
    if let Some(time) = time {
        title += &format!(",  t = {} s", fixed(time, time, 3));
    }
    let edges = Edges::new(snapshot, &solid);
    let mut written = Vec::new();
    for content in contents(snapshot, &solid) {
        let path = into.join(content.file);
        draw(snapshot, &solid, &edges, &content, &title, false)?.save(&path)?;
        written.push(path);
    }
    Ok(written)
}

fn contents(snapshot: &FieldSnapshot, solid: &[bool]) -> Vec<Content> {
    let all_solid = solid.iter().all(|&s| s);
    let fields: &[&str] = if all_solid { &["deformation"] } else { &["velocity", "pressure"] };
    fields.iter().filter_map(|field| content(snapshot, field)).collect()
}

/// The field of this name; `None` where there is none, or where it is not finite.
fn content(snapshot: &FieldSnapshot, name: &str) -> Option<Content> {
    let (file, symbol, unit, map, in_solid): (_, _, _, &'static [Rgb; 17], _) = match name {
        "velocity" => ("speed.png", "|v|", "m/s", &VIRIDIS, true),
        "pressure" => ("pressure.png", "p", "Pa", &PLASMA, false),
        _ => ("deformation.png", "|u|", "m", &VIRIDIS, true),
    };
    let field = snapshot.at_points(name)?;
    let tuples = field.values.chunks_exact(field.components.max(1));
    let mut values: Vec<f64> = tuples
        .map(|t| if t.len() == 1 { t[0] } else { t.iter().map(|x| x * x).sum::<f64>().sqrt() })
        .collect();
    let size = values.iter().fold(0.0_f64, |size, v| size.max(v.abs()));
    let (factor, unit) = readable(size, unit);
    values.iter_mut().for_each(|v| *v *= factor);
    let magnitude = field.components > 1;
    let finite = values.iter().all(|v| v.is_finite());
    let content = Content { file, label: labelled(symbol, &unit), values, map, in_solid, magnitude };
    finite.then_some(content)
}

/// One field, with the streamlines of the velocity where they are asked for; `None` where there is no such field.
///
/// # Errors
/// As [`Figure::raster`].
pub fn image(
    snapshot: &FieldSnapshot,
    field: &str,
    title: &str,
    with_streamlines: bool,
) -> anyhow::Result<Option<Image>> {
    let solid = solid_cells(snapshot);
    let Some(content) = content(snapshot, field) else { return Ok(None) };
    let edges = Edges::new(snapshot, &solid);
    draw(snapshot, &solid, &edges, &content, title, with_streamlines).map(Some)
}

/// Whether each cell is solid.
fn solid_cells(snapshot: &FieldSnapshot) -> Vec<bool> {
    match snapshot.in_cells("solid") {
        Some(field) => field.values.iter().map(|&s| s > 0.5).collect(),
        None => vec![false; snapshot.n_cells()],
    }
}

/// The whole domain, and below it the surroundings of the solid if that is small.
fn draw(
    snapshot: &FieldSnapshot,
    solid: &[bool],
    edges: &Edges,
    content: &Content,
    title: &str,
    with_streamlines: bool,
) -> anyhow::Result<Image> {
    let whole = bounds(snapshot, |_| true);
    let mut views = vec![whole];
    views.extend(surroundings(whole, bounds(snapshot, |cell| solid[cell])));
    let air = 0.01 * (whole.0.1 - whole.0.0).max(whole.1.1 - whole.1.0);
    views[0] = ((whole.0.0 - air, whole.0.1 + air), (whole.1.0 - air, whole.1.1 + air));

    let mut top = 60.0;
    let mut panels = Vec::new();
    for (x, y) in views {
        let scale = (WIDTH / (x.1 - x.0)).min(640.0 / (y.1 - y.0));
        let (width, height) =
            ((scale * (x.1 - x.0)).round().max(4.0), (scale * (y.1 - y.0)).round().max(4.0));
        panels.push(Panel { left: 0.0, top, width, height, x, y, logarithmic: false });
        top += height + 72.0;
    }
    let margin = (12.0 + panels.iter().map(Panel::margin).fold(0.0, f64::max)).round();
    panels.iter_mut().for_each(|panel| panel.left = margin);
    let widest = panels.iter().map(|panel| panel.width).fold(0.0, f64::max);
    let mut figure = Figure::new(margin + widest + 110.0, top - 16.0);
    figure.text((margin, 26.0), title, 15, Anchor::Start, INK);

    let rasters: Vec<Raster> =
        panels.iter().map(|panel| Raster::new(snapshot, &content.values, panel)).collect();
    let range = range(content, &rasters[0], solid);
    let bar =
        Panel { left: margin + widest + 24.0, width: 16.0, x: (0.0, 1.0), y: range, ..panels[0].clone() };
    for (n, panel) in panels.iter().enumerate() {
        edges.draw(&mut figure, panel, n > 0 || panels.len() == 1);
        if with_streamlines {
            let lines = streamlines::trace(snapshot, solid, panel);
            figure.clipped(panel, |figure| {
                lines.into_iter().for_each(|line| figure.curve(line, INK, 0.7));
            });
        }
        panel.axes(&mut figure, Some("x [m]"), "y [m]");
        frame(&mut figure, panel);
    }
    frame(&mut figure, &bar);
    for (value, label) in ticks(range, (bar.height / 40.0).clamp(3.0, 8.0)) {
        let (x, y) = bar.at(1.0, value);
        figure.line((x, y), (x + 4.0, y), INK, 1.0);
        figure.text((x + 8.0, y + 4.0), &label, 12, Anchor::Start, INK);
    }
    figure.text((bar.left, bar.top - 9.0), &content.label, 13, Anchor::Start, INK);

    let mut image = figure.raster()?;
    for (panel, raster) in panels.iter().zip(&rasters) {
        raster.paint(&mut image, panel, content, range, solid);
    }
    let (left, width) = (bar.left as usize * SCALE, bar.width as usize * SCALE);
    for y in 0..bar.height as usize * SCALE {
        let color = colors::at(content.map, 1.0 - (y as f64 + 0.5) / (bar.height * SCALE as f64));
        (left..left + width).for_each(|x| image.multiply(x, bar.top as usize * SCALE + y, color));
    }
    Ok(image)
}

fn frame(figure: &mut Figure, panel: &Panel) {
    let (x, y) = (panel.left, panel.top);
    let (right, bottom) = (x + panel.width, y + panel.height);
    figure.curve(vec![(x, y), (right, y), (right, bottom), (x, bottom), (x, y)], INK, 1.0);
}

/// Ranges of x and y of the points of some cells; infinite if there are none.
fn bounds(snapshot: &FieldSnapshot, include: impl Fn(usize) -> bool) -> ((f64, f64), (f64, f64)) {
    let empty = (f64::INFINITY, f64::NEG_INFINITY);
    let cells = snapshot.cells.chunks_exact(snapshot.points_per_cell()).enumerate();
    let points = cells.filter(|(n, _)| include(*n)).flat_map(|(_, cell)| cell);
    points
        .map(|&p| snapshot.points[p as usize])
        .fold((empty, empty), |(x, y), [px, py, _]| ((x.0.min(px), x.1.max(px)), (y.0.min(py), y.1.max(py))))
}

type Box2 = ((f64, f64), (f64, f64));

/// A view of the solid `inner` and what is around it, if that is much smaller than the domain.
fn surroundings(whole: Box2, inner: Box2) -> Option<Box2> {
    let length = (inner.0.1 - inner.0.0).max(inner.1.1 - inner.1.0);
    let width = 2.0 * length;
    if !(length > 0.0 && width < 0.5 * (whole.0.1 - whole.0.0)) {
        return None;
    }
    let centred = |middle: f64, size: f64, (low, high): (f64, f64)| {
        let size = size.min(high - low);
        let from = (middle - 0.5 * size).clamp(low, high - size);
        (from, from + size)
    };
    let x = centred(0.5 * (inner.0.0 + inner.0.1), width, whole.0);
    Some((
        x,
        centred(0.5 * (inner.1.0 + inner.1.1), (0.45 * width).max(1.4 * (inner.1.1 - inner.1.0)), whole.1),
    ))
}

/// Colour limits: magnitudes from zero to the maximum; else all but the most extreme 0.2 % on either side, which
/// leaves out singular corners.
fn range(content: &Content, raster: &Raster, solid: &[bool]) -> (f64, f64) {
    let shown =
        raster.samples.iter().filter(|s| s.cell != NOWHERE && (content.in_solid || !solid[s.cell as usize]));
    let mut values: Vec<f32> = shown.map(|s| s.value).collect();
    values.sort_by(f32::total_cmp);
    let tail = if content.magnitude { 0 } else { values.len() / 500 };
    let Some(high) = values.len().checked_sub(1 + tail).map(|n| f64::from(values[n])) else {
        return (0.0, 1.0);
    };
    let low = if content.magnitude { 0.0 } else { f64::from(values[tail]) };
    if high - low > 1e-9 * high.abs().max(low.abs()) { (low, high) } else { (low - 0.5, low + 0.5) }
}

/// No cell.
const NOWHERE: u32 = u32::MAX;

/// What a sample of a picture meets.
#[derive(Copy, Clone)]
struct Sample {
    value: f32,
    cell: u32,
}

/// A field sampled on a fine grid.
struct Raster {
    width: usize,
    height: usize,
    samples: Vec<Sample>,
}

impl Raster {
    /// Every cell is cut into small straight-sided triangles, as fine as the picture needs.
    fn new(snapshot: &FieldSnapshot, values: &[f64], panel: &Panel) -> Self {
        let fine = SCALE * SAMPLES;
        let (width, height) = (panel.width as usize * fine, panel.height as usize * fine);
        let mut raster =
            Raster { width, height, samples: vec![Sample { value: 0.0, cell: NOWHERE }; width * height] };
        let reference = Reference::of(snapshot);
        let mut tables: HashMap<usize, Pieces> = HashMap::new();
        for (number, cell) in snapshot.cells.chunks_exact(snapshot.points_per_cell()).enumerate() {
            let nodes: Vec<[f64; 3]> = cell
                .iter()
                .map(|&p| {
                    let [x, y, _] = snapshot.points[p as usize];
                    let (x, y) = panel.at(x, y);
                    [(x - panel.left) * fine as f64, (y - panel.top) * fine as f64, values[p as usize]]
                })
                .collect();
            let extent = |d: usize| {
                let range =
                    nodes.iter().map(|n| n[d]).fold((f64::MAX, f64::MIN), |r, x| (r.0.min(x), r.1.max(x)));
                range.1 - range.0
            };
            let pieces = ((extent(0).max(extent(1)) / (4 * fine) as f64).ceil() as usize).clamp(2, 32);
            let table = tables.entry(pieces).or_insert_with(|| reference.pieces(pieces));
            let corner = |weights: &Vec<f64>| {
                let mut at = [0.0; 3];
                for (weight, node) in weights.iter().zip(&nodes) {
                    (0..3).for_each(|d| at[d] += weight * node[d]);
                }
                at
            };
            let corners: Vec<[f64; 3]> = table.weights.iter().map(corner).collect();
            for triangle in &table.triangles {
                raster.triangle(triangle.map(|corner| corners[corner]), number as u32);
            }
        }
        raster.close();
        raster
    }

    /// Fills the cracks between curved cells that were cut into different numbers of pieces.
    fn close(&mut self) {
        for row in self.samples.chunks_exact_mut(self.width) {
            for i in 1..row.len().saturating_sub(1) {
                if row[i].cell == NOWHERE && row[i - 1].cell != NOWHERE && row[i + 1].cell != NOWHERE {
                    row[i] = row[i - 1];
                }
            }
        }
        let w = self.width;
        for i in w..self.samples.len().saturating_sub(w) {
            let beside = [self.samples[i - w], self.samples[i + w]];
            if self.samples[i].cell == NOWHERE && beside.iter().all(|s| s.cell != NOWHERE) {
                self.samples[i] = beside[0];
            }
        }
    }

    /// Fills the samples in a triangle, its sides included, with linear interpolation.
    fn triangle(&mut self, [a, b, c]: [[f64; 3]; 3], cell: u32) {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let rows = (a[1].min(b[1]).min(c[1]), a[1].max(b[1]).max(c[1]));
        let columns = (a[0].min(b[0]).min(c[0]), a[0].max(b[0]).max(c[0]));
        let samples = |(low, high): (f64, f64), n: usize| {
            ((low - 0.5).ceil().max(0.0) as usize)
                ..(((high - 0.5).floor() + 1.0).clamp(0.0, n as f64) as usize)
        };
        for j in samples(rows, self.height) {
            for i in samples(columns, self.width) {
                let (x, y) = (i as f64 + 0.5, j as f64 + 0.5);
                let at_b = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / area;
                let at_c = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / area;
                if at_b >= -1e-9 && at_c >= -1e-9 && at_b + at_c <= 1.0 + 1e-9 {
                    let value = (a[2] + at_b * (b[2] - a[2]) + at_c * (c[2] - a[2])) as f32;
                    self.samples[j * self.width + i] = Sample { value, cell };
                }
            }
        }
    }

    /// Paints the field beneath what is drawn in `panel`, each pixel the average of its samples.
    fn paint(&self, image: &mut Image, panel: &Panel, content: &Content, range: (f64, f64), solid: &[bool]) {
        let color = |sample: &Sample| match sample.cell {
            NOWHERE => [255; 3],
            cell if solid[cell as usize] && !content.in_solid => SOLID,
            _ => colors::at(content.map, (f64::from(sample.value) - range.0) / (range.1 - range.0)),
        };
        let (left, top) = (panel.left as usize * SCALE, panel.top as usize * SCALE);
        for y in 0..self.height / SAMPLES {
            for x in 0..self.width / SAMPLES {
                let mut sum = [0u32; 3];
                for n in 0..SAMPLES * SAMPLES {
                    let at = (SAMPLES * y + n / SAMPLES) * self.width + SAMPLES * x + n % SAMPLES;
                    let rgb = color(&self.samples[at]);
                    (0..3).for_each(|c| sum[c] += u32::from(rgb[c]));
                }
                let mean = sum.map(|s| ((s as f64) / (SAMPLES * SAMPLES) as f64).round() as u8);
                image.multiply(left + x, top + y, mean);
            }
        }
    }
}

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
struct Edges {
    /// Between cells of one kind.
    inner: Vec<Vec<[f64; 2]>>,
    /// At the boundary of the domain and of the solid.
    outline: Vec<Vec<[f64; 2]>>,
    /// Edges of pieces that make one edge of a cell.
    pieces: f64,
}

impl Edges {
    fn new(snapshot: &FieldSnapshot, solid: &[bool]) -> Self {
        // Edges meet by position, since discontinuous fields have points of their own in every cell.
        let (x, y) = bounds(snapshot, |_| true);
        let unit = 1e-8 * (x.1 - x.0).max(y.1 - y.0);
        let key = |p: [f64; 2]| p.map(|c| (c / unit).round() as i64);
        let (k, sides) = (snapshot.degree, Reference::of(snapshot).sides());
        let parts = snapshot.in_cells("cell");
        let mut found: HashMap<[[i64; 2]; 2], Edge> = HashMap::new();
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

    /// Draws outlines, and the mesh if it is asked for and coarse enough to be seen.
    fn draw(&self, figure: &mut Figure, panel: &Panel, mesh: bool) {
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
