//! A drawing with axes, ticks and curves that becomes SVG and PNG.

use super::colors::{GRID, INK, Rgb};
use anyhow::{Context, anyhow};
use kuva::backend::{raster::RasterBackend, svg::SvgBackend};
use kuva::render::color::Color;
use kuva::render::render::{Primitive, Scene, TextAnchor};
use std::io::Write;
use std::path::{Path, PathBuf};
use undula::output::write_atomic;

/// Pixels of a PNG per unit of a drawing.
pub const SCALE: usize = 2;

/// Size of tick labels.
const SMALL: u32 = 12;
/// Size of axis labels.
const NORMAL: u32 = 13;

/// Width of a character in units of the font size, on average over digits.
const CHARACTER: f64 = 0.63;

/// A drawing; x to the right, y down, in units of about a pixel.
pub struct Figure {
    scene: Scene,
    clips: usize,
    /// What the names of its clips begin with.
    id: String,
}

/// Where a text is held.
pub type Anchor = TextAnchor;

/// Pixels, three bytes each.
pub struct Image {
    /// Pixels per row.
    pub width: usize,
    /// Red, green, blue of all pixels, by rows.
    pub rgb: Vec<u8>,
}

fn color([r, g, b]: Rgb) -> Color {
    Color::Rgb(r, g, b)
}

impl Figure {
    /// An empty white drawing.
    pub fn new(width: f64, height: f64) -> Self {
        Self::named(width, height, "panel")
    }

    /// The same for a page with other drawings, none of which has this `id`.
    pub fn named(width: f64, height: f64, id: &str) -> Self {
        let mut scene = Scene::new(width.ceil(), height.ceil());
        scene.font_family = Some("DejaVu Sans, Verdana, Arial, sans-serif".into());
        Figure { scene, clips: 0, id: id.into() }
    }

    /// A straight line.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), ink: Rgb, width: f64) {
        self.scene.elements.push(Primitive::Line {
            x1: from.0,
            y1: from.1,
            x2: to.0,
            y2: to.1,
            stroke: color(ink),
            stroke_width: width,
            stroke_dasharray: None,
        });
    }

    /// A curve through points.
    pub fn curve(&mut self, points: Vec<(f64, f64)>, ink: Rgb, width: f64) {
        let stroke = color(ink);
        let curve = Primitive::PolyLine { points, stroke, stroke_width: width, stroke_dasharray: None };
        self.scene.elements.push(curve);
    }

    /// A filled rectangle.
    pub fn fill(&mut self, [x, y, width, height]: [f64; 4], ink: Rgb) {
        let fill = color(ink);
        let area =
            Primitive::Rect { x, y, width, height, fill, stroke: None, stroke_width: None, opacity: None };
        self.scene.elements.push(area);
    }

    /// A text with its baseline at `at`.
    pub fn text(&mut self, at: (f64, f64), content: &str, size: u32, anchor: Anchor, ink: Rgb) {
        let (x, y, color) = (at.0, at.1, Some(color(ink)));
        let content = content.to_string();
        let text = Primitive::Text { x, y, content, size, anchor, rotate: None, bold: false, color };
        self.scene.elements.push(text);
    }

    /// [`Figure::text`] that begins at `at`, or ends at the right edge where it would leave the drawing.
    pub fn text_within(&mut self, at: (f64, f64), content: &str, size: u32, ink: Rgb) {
        let (edge, width) = (self.scene.width - 4.0, width_of(content, size));
        if at.0 + width > edge {
            self.text((edge, at.1), content, size, Anchor::End, ink);
        } else {
            self.text(at, content, size, Anchor::Start, ink);
        }
    }

    /// Draws `inside` such that nothing leaves `panel`.
    pub fn clipped(&mut self, panel: &Panel, inside: impl FnOnce(&mut Self)) {
        let Panel { left: x, top: y, width, height, .. } = *panel;
        self.clips += 1;
        let id = format!("{}{}", self.id, self.clips);
        self.scene.defs.push(format!(
            "<clipPath id=\"{id}\"><rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"/></clipPath>"
        ));
        self.scene.elements.push(Primitive::ClipStart { x, y, width, height, id });
        inside(self);
        self.scene.elements.push(Primitive::ClipEnd);
    }

    /// The drawing as SVG.
    pub fn svg(&self) -> String {
        SvgBackend::new().render_scene(&self.scene)
    }

    /// Writes `stem.svg` and `stem.png`.
    pub fn save(&self, stem: &Path) -> anyhow::Result<Vec<PathBuf>> {
        let paths = vec![stem.with_extension("svg"), stem.with_extension("png")];
        write_atomic(&paths[0], |file| file.write_all(self.svg().as_bytes()))?;
        self.raster()?.save(&paths[1])?;
        Ok(paths)
    }

    /// The drawing in pixels.
    pub fn raster(&self) -> anyhow::Result<Image> {
        let encoded = RasterBackend::new().with_scale(SCALE as f32).render_scene(&self.scene);
        let encoded = encoded.map_err(|message| anyhow!("rendering: {message}"))?;
        let mut reader = png::Decoder::new(std::io::Cursor::new(encoded)).read_info()?;
        let mut pixels = vec![0; reader.output_buffer_size().context("picture too large")?];
        let info = reader.next_frame(&mut pixels)?;
        let samples = info.color_type.samples();
        let rgb =
            pixels[..info.buffer_size()].chunks_exact(samples).flat_map(|p| [p[0], p[1], p[2]]).collect();
        Ok(Image { width: info.width as usize, rgb })
    }
}

impl Image {
    /// Pixels per column.
    pub fn height(&self) -> usize {
        self.rgb.len() / 3 / self.width
    }

    /// Darkens a pixel: paints it under what is drawn there.
    pub fn multiply(&mut self, x: usize, y: usize, with: Rgb) {
        let at = 3 * (y * self.width + x);
        for (under, with) in self.rgb[at..at + 3].iter_mut().zip(with) {
            *under = (u32::from(*under) * u32::from(with) / 255) as u8;
        }
    }

    /// Writes a PNG.
    pub fn save(&self, path: &Path) -> anyhow::Result<()> {
        let bytes = self.png()?;
        write_atomic(path, |file| file.write_all(&bytes))?;
        Ok(())
    }

    /// The content of a PNG file.
    pub fn png(&self) -> anyhow::Result<Vec<u8>> {
        let mut bytes = vec![];
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height() as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::High);
        let density = (SCALE as f64 * 96.0 / 0.0254).round() as u32;
        let unit = png::Unit::Meter;
        encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: density, yppu: density, unit }));
        encoder.write_header()?.write_image_data(&self.rgb)?;
        Ok(bytes)
    }

    /// The picture at half its size, each pixel the average of four.
    pub fn halved(&self) -> Image {
        let (width, height) = (self.width / 2, self.height() / 2);
        let mut rgb = Vec::with_capacity(3 * width * height);
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            for c in 0..3 {
                let at = |dy: usize, dx: usize| {
                    u32::from(self.rgb[3 * ((2 * y + dy) * self.width + 2 * x + dx) + c])
                };
                rgb.push(((at(0, 0) + at(0, 1) + at(1, 0) + at(1, 1) + 2) / 4) as u8);
            }
        }
        Image { width, rgb }
    }
}

/// A rectangle of a figure with the ranges of its axes.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Left end in the figure.
    pub left: f64,
    /// Upper end in the figure.
    pub top: f64,
    /// Width in the figure.
    pub width: f64,
    /// Height in the figure.
    pub height: f64,
    /// First and last value of the horizontal axis.
    pub x: (f64, f64),
    /// Lowest and highest value of the vertical axis.
    pub y: (f64, f64),
    /// Whether the values are decimal logarithms, which ticks do not show.
    pub logarithmic: bool,
}

impl Panel {
    /// Where the point (x, y) is in the figure.
    pub fn at(&self, x: f64, y: f64) -> (f64, f64) {
        (
            self.left + (x - self.x.0) / (self.x.1 - self.x.0) * self.width,
            self.top + (self.y.1 - y) / (self.y.1 - self.y.0) * self.height,
        )
    }

    /// Ticks of the horizontal axis, as many as fit.
    fn x_ticks(&self) -> Vec<(f64, String)> {
        self.ticks(self.x, (self.width / 60.0).clamp(2.0, 12.0))
    }

    /// Ticks of the vertical axis, as many as fit.
    fn y_ticks(&self) -> Vec<(f64, String)> {
        self.ticks(self.y, (self.height / 26.0).clamp(2.0, 9.0))
    }

    fn ticks(&self, range: (f64, f64), count: f64) -> Vec<(f64, String)> {
        if self.logarithmic { decades(range) } else { ticks(range, count) }
    }

    /// Room needed on the left for tick labels.
    pub fn margin(&self) -> f64 {
        let longest = self.y_ticks().iter().map(|(_, label)| label.chars().count()).max().unwrap_or(0);
        12.0 + CHARACTER * f64::from(SMALL) * longest as f64
    }

    /// Horizontal grid lines; drawn before the curves.
    pub fn grid(&self, figure: &mut Figure) {
        for (y, _) in self.y_ticks() {
            figure.line(self.at(self.x.0, y), self.at(self.x.1, y), GRID, 1.0);
        }
    }

    /// Axes, ticks and labels; without `x_label` the horizontal axis has no numbers.
    pub fn axes(&self, figure: &mut Figure, x_label: Option<&str>, y_label: &str) {
        let (right, bottom) = (self.left + self.width, self.top + self.height);
        figure.line((self.left, self.top), (self.left, bottom), INK, 1.0);
        figure.line((self.left, bottom), (right, bottom), INK, 1.0);
        for (x, label) in self.x_ticks() {
            let (x, y) = self.at(x, self.y.0);
            figure.line((x, y), (x, y + 4.0), INK, 1.0);
            if x_label.is_some() {
                figure.text((x, y + 18.0), &label, SMALL, Anchor::Middle, INK);
            }
        }
        for (y, label) in self.y_ticks() {
            let (x, y) = self.at(self.x.0, y);
            figure.line((x - 4.0, y), (x, y), INK, 1.0);
            figure.text((x - 8.0, y + 4.0), &label, SMALL, Anchor::End, INK);
        }
        if let Some(label) = x_label {
            let at = (self.left + 0.5 * self.width, bottom + 38.0);
            figure.text(at, label, NORMAL, Anchor::Middle, INK);
        }
        figure.text((self.left, self.top - 9.0), y_label, NORMAL, Anchor::Start, INK);
    }

    /// A function of x, cut at the frame; of very many points the extremes of every column remain.
    pub fn graph(&self, figure: &mut Figure, x: &[f64], y: &[f64], ink: Rgb, width: f64) {
        let first = x.partition_point(|&x| x < self.x.0).saturating_sub(1);
        let end = (x.partition_point(|&x| x <= self.x.1) + 1).min(x.len());
        let points = thin_out(self.place(&x[first..end], &y[first..end]), 4 * self.width as usize);
        figure.clipped(self, |figure| figure.curve(points, ink, width));
    }

    /// A curve in the plane, cut at the frame.
    pub fn path(&self, figure: &mut Figure, x: &[f64], y: &[f64], ink: Rgb, width: f64) {
        let points = self.place(x, y);
        figure.clipped(self, |figure| figure.curve(points, ink, width));
    }

    fn place(&self, x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
        x.iter()
            .zip(y)
            .filter(|(x, y)| x.is_finite() && y.is_finite())
            .map(|(&x, &y)| self.at(x, y))
            .collect()
    }
}

/// Keeps first, lowest, highest and last point of every group if there are more than `most` points.
fn thin_out(points: Vec<(f64, f64)>, most: usize) -> Vec<(f64, f64)> {
    if points.len() <= most {
        return points;
    }
    let group = points.len().div_ceil(most / 4);
    let mut kept = Vec::with_capacity(most + 4);
    for chunk in points.chunks(group) {
        let by_y = |a: &usize, b: &usize| chunk[*a].1.total_cmp(&chunk[*b].1);
        let low = (0..chunk.len()).min_by(by_y).unwrap_or(0);
        let high = (0..chunk.len()).max_by(by_y).unwrap_or(0);
        let mut which = [0, low, high, chunk.len() - 1];
        which.sort_unstable();
        kept.extend(which.map(|i| chunk[i]));
    }
    kept
}

/// About `count` round numbers in a range, two at least, with their labels.
pub fn ticks((low, high): (f64, f64), count: f64) -> Vec<(f64, String)> {
    let raw = (high - low) / count;
    let power = 10.0_f64.powf(raw.log10().floor());
    let steps = [0.2, 0.5, 1.0, 2.0, 5.0, 10.0].map(|m| m * power);
    let within = |step: f64| ((low / step - 1e-6).ceil() as i64, (high / step + 1e-6).floor() as i64);
    let enough = steps.iter().position(|&s| s >= 0.999 * raw).unwrap_or(steps.len() - 1);
    // One number says nothing about a scale.
    let alone = |&at: &usize| at > 0 && within(steps[at]).1 <= within(steps[at]).0;
    let step = steps[if alone(&enough) { enough - 1 } else { enough }];
    let decimals = (-(step.log10() + 1e-9).floor()).clamp(0.0, 12.0) as usize;
    let (first, last) = within(step);
    (first..=last.min(first + 50))
        .map(|n| n as f64 * step)
        .map(|x| (x, format!("{x:.decimals$}").replace('-', "\u{2212}")))
        .collect()
}

/// Powers of ten whose logarithms are in a range; with 2 and 5 times them where they are few.
fn decades((low, high): (f64, f64)) -> Vec<(f64, String)> {
    let between: &[f64] = if high - low < 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let mut found = vec![];
    for power in low.floor() as i32..=high.ceil() as i32 {
        for times in between {
            let at = f64::from(power) + times.log10();
            if (low - 1e-9..=high + 1e-9).contains(&at) {
                let value = times * 10_f64.powi(power);
                let label = if (-3..=3).contains(&power) { value.to_string() } else { format!("{value:e}") };
                found.push((at, label.replace('-', "\u{2212}")));
            }
        }
    }
    found
}

/// Factor and unit that make numbers up to `size` readable: `(1e3, "mm")` for small lengths.
pub fn readable(size: f64, unit: &str) -> (f64, String) {
    if unit == "m" && (1e-6..0.5).contains(&size) {
        return (1e3, "mm".into());
    }
    if size == 0.0 || (1e-2..1e5).contains(&size) {
        return (1.0, unit.into());
    }
    let exponent = 3 * (size.log10() / 3.0).floor() as i32;
    let digits = exponent.to_string();
    let raised = digits.chars().map(|c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => char::from_u32(c as u32 - '0' as u32 + '⁰' as u32).unwrap_or(c),
    });
    let power = format!("10{}", raised.collect::<String>());
    (10.0_f64.powi(-exponent), format!("{power} {unit}").trim_end().to_string())
}

/// About how wide a text is.
fn width_of(content: &str, size: u32) -> f64 {
    CHARACTER * f64::from(size) * content.chars().count() as f64
}

/// `name [unit]`, or the name alone.
pub fn labelled(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_string() } else { format!("{name} [{unit}]") }
}
