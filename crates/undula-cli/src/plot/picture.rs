//! Fields on the deformed mesh.

mod edges;
mod film;
mod raster;
mod streamlines;
mod view;

use super::colors::{self, INK, PLASMA, Rgb, VIRIDIS};
use super::figure::{Anchor, Figure, Image, Panel, SCALE, labelled, readable, ticks};
pub use film::Film;
use raster::{NOWHERE, Raster, SAMPLES};
use std::path::{Path, PathBuf};
use undula::output::FieldSnapshot;
pub use view::{View, solid_cells};

/// Width of a picture without margins.
const WIDTH: f64 = 1000.0;
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
    /// The least and the greatest colour where they do not follow from the picture.
    limits: Option<(f64, f64)>,
    /// Samples per pixel and direction.
    samples: usize,
}

/// Writes `speed.png` and `pressure.png`, or `deformation.png` if all is solid.
pub fn plot(view: &View, title: &str, into: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut written = Vec::new();
    for content in contents(&view.fields, &view.solid) {
        let path = into.join(format!("{}{}.png", content.file, view.suffix));
        draw(view, &content, title, false, frame_of(view))?.save(&path)?;
        written.push(path);
    }
    Ok(written)
}

fn contents(snapshot: &FieldSnapshot, solid: &[bool]) -> Vec<Content> {
    let all_solid = solid.iter().all(|&s| s);
    let fields: &[&str] = if all_solid { &["deformation"] } else { &["velocity", "pressure"] };
    fields.iter().filter_map(|field| content(snapshot, field, None)).collect()
}

/// The field of this name in a unit for numbers up to `size`, by default its own; `None` where there is none, or where it
/// is not finite.
fn content(snapshot: &FieldSnapshot, name: &str, size: Option<f64>) -> Option<Content> {
    let (file, symbol, unit, map, in_solid) = look_of(name);
    let field = snapshot.at_points(name)?;
    let tuples = field.values.chunks_exact(field.components.max(1));
    let mut values: Vec<f64> = tuples
        .map(|t| if t.len() == 1 { t[0] } else { t.iter().map(|x| x * x).sum::<f64>().sqrt() })
        .collect();
    let size = size.unwrap_or_else(|| values.iter().fold(0.0_f64, |size, v| size.max(v.abs())));
    let (factor, unit) = readable(size, unit);
    values.iter_mut().for_each(|v| *v *= factor);
    let magnitude = field.components > 1;
    let finite = values.iter().all(|v| v.is_finite());
    let label = labelled(symbol, &unit);
    let content = Content { file, label, values, map, in_solid, magnitude, limits: None, samples: SAMPLES };
    finite.then_some(content)
}

/// Name of the file, symbol, unit, colours of a field, and whether the solid has values.
fn look_of(name: &str) -> (&'static str, &'static str, &'static str, &'static [Rgb; 17], bool) {
    match name {
        "velocity" => ("speed", "|v|", "m/s", &VIRIDIS, true),
        "pressure" => ("pressure", "p", "Pa", &PLASMA, false),
        _ => ("deformation", "|u|", "m", &VIRIDIS, true),
    }
}

/// One field, with the streamlines of the velocity where they are asked for; `None` where there is no such field.
///
/// # Errors
/// As [`Figure::raster`].
pub fn image(view: &View, field: &str, title: &str, with_streamlines: bool) -> anyhow::Result<Option<Image>> {
    let Some(content) = content(&view.fields, field, None) else { return Ok(None) };
    draw(view, &content, title, with_streamlines, frame_of(view)).map(Some)
}

/// Ranges of x and y of all that a picture shows, and of the solid in it.
fn frame_of(view: &View) -> [Box2; 2] {
    [bounds(&view.fields, |_| true), bounds(&view.fields, |cell| view.solid[cell])]
}

/// The whole domain, and below it the surroundings of the solid if that is small.
fn draw(
    view: &View,
    content: &Content,
    title: &str,
    with_streamlines: bool,
    [whole, body]: [Box2; 2],
) -> anyhow::Result<Image> {
    let (snapshot, solid): (&FieldSnapshot, &[bool]) = (&view.fields, &view.solid);
    let mut views = vec![whole];
    views.extend(surroundings(whole, body));
    let air = 0.01 * (whole.0.1 - whole.0.0).max(whole.1.1 - whole.1.0);
    views[0] = ((whole.0.0 - air, whole.0.1 + air), (whole.1.0 - air, whole.1.1 + air));

    let mut panels = panels(views);
    let margin = (12.0 + panels.iter().map(Panel::margin).fold(0.0, f64::max)).round();
    panels.iter_mut().for_each(|panel| panel.left = margin);
    let widest = panels.iter().map(|panel| panel.width).fold(0.0, f64::max);
    let below = panels.last().map_or(0.0, |panel| panel.top + panel.height);
    let mut figure = Figure::new(margin + widest + 110.0, below + 56.0);
    let title = view.place.iter().fold(title.to_string(), |title, place| format!("{title},  {place}"));
    figure.text((margin, 26.0), &title, 15, Anchor::Start, INK);

    let rasters: Vec<Raster> =
        panels.iter().map(|panel| Raster::new(snapshot, &content.values, panel, content.samples)).collect();
    let range = content.limits.unwrap_or_else(|| range(content, &rasters[0], solid));
    let bar =
        Panel { left: margin + widest + 24.0, width: 16.0, x: (0.0, 1.0), y: range, ..panels[0].clone() };
    for (n, panel) in panels.iter().enumerate() {
        view.edges.draw(&mut figure, panel, n > 0 || panels.len() == 1);
        if with_streamlines {
            let lines = streamlines::trace(snapshot, solid, panel);
            figure.clipped(panel, |figure| {
                lines.into_iter().for_each(|line| figure.curve(line, INK, 0.7));
            });
        }
        panel.axes(&mut figure, Some(view.axes[0]), view.axes[1]);
        frame(&mut figure, panel);
    }
    legend(&mut figure, &bar, &content.label);

    let mut image = figure.raster()?;
    for (panel, raster) in panels.iter().zip(&rasters) {
        raster.paint(&mut image, panel, content, range, solid);
    }
    paint_bar(&mut image, &bar, content.map);
    Ok(image)
}

/// Panels for the views, one below the other.
fn panels(views: Vec<Box2>) -> Vec<Panel> {
    let mut top = 60.0;
    let mut panels = Vec::new();
    for (x, y) in views {
        let scale = (WIDTH / (x.1 - x.0)).min(640.0 / (y.1 - y.0));
        let (width, height) =
            ((scale * (x.1 - x.0)).round().max(4.0), (scale * (y.1 - y.0)).round().max(4.0));
        panels.push(Panel { left: 0.0, top, width, height, x, y, logarithmic: false });
        top += height + 72.0;
    }
    panels
}

/// Frame and numbers of the bar of colours, whose values are those of y.
pub(super) fn legend(figure: &mut Figure, bar: &Panel, label: &str) {
    frame(figure, bar);
    for (value, label) in ticks(bar.y, (bar.height / 40.0).clamp(3.0, 8.0)) {
        let (x, y) = bar.at(1.0, value);
        figure.line((x, y), (x + 4.0, y), INK, 1.0);
        figure.text((x + 8.0, y + 4.0), &label, 12, Anchor::Start, INK);
    }
    figure.text_within((bar.left, bar.top - 9.0), label, 13, INK);
}

/// The colours of the bar, from below.
pub(super) fn paint_bar(image: &mut Image, bar: &Panel, map: &[Rgb; 17]) {
    let (left, width) = (bar.left as usize * SCALE, bar.width as usize * SCALE);
    for y in 0..bar.height as usize * SCALE {
        let color = colors::at(map, 1.0 - (y as f64 + 0.5) / (bar.height * SCALE as f64));
        (left..left + width).for_each(|x| image.multiply(x, bar.top as usize * SCALE + y, color));
    }
}

pub(super) fn frame(figure: &mut Figure, panel: &Panel) {
    let (x, y) = (panel.left, panel.top);
    let (right, bottom) = (x + panel.width, y + panel.height);
    figure.curve(vec![(x, y), (right, y), (right, bottom), (x, bottom), (x, y)], INK, 1.0);
}

/// Ranges of x and y.
type Box2 = ((f64, f64), (f64, f64));

/// Ranges of x and y of the points of some cells; infinite if there are none.
fn bounds(snapshot: &FieldSnapshot, include: impl Fn(usize) -> bool) -> Box2 {
    let empty = (f64::INFINITY, f64::NEG_INFINITY);
    let cells = snapshot.cells.chunks_exact(snapshot.points_per_cell()).enumerate();
    let points = cells.filter(|(n, _)| include(*n)).flat_map(|(_, cell)| cell);
    points
        .map(|&p| snapshot.points[p as usize])
        .fold((empty, empty), |(x, y), [px, py, _]| ((x.0.min(px), x.1.max(px)), (y.0.min(py), y.1.max(py))))
}

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
    limits(shown.map(|s| s.value).collect(), content.magnitude)
}

/// The same of these values.
pub(super) fn limits(mut values: Vec<f32>, magnitude: bool) -> (f64, f64) {
    values.sort_by(f32::total_cmp);
    let tail = if magnitude { 0 } else { values.len() / 500 };
    let Some(high) = values.len().checked_sub(1 + tail).map(|n| f64::from(values[n])) else {
        return (0.0, 1.0);
    };
    let low = if magnitude { 0.0 } else { f64::from(values[tail]) };
    if high - low > 1e-9 * high.abs().max(low.abs()) { (low, high) } else { (low - 0.5, low + 0.5) }
}
