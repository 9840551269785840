//! A surface as a picture: title, bar of colours, directions and ranges of the coordinates.

use super::super::colors::{INK, PLASMA, Rgb, VIRIDIS};
use super::super::figure::{Anchor, Figure, Image, Panel, labelled, readable};
use super::super::picture::{frame, legend, limits, paint_bar};
use super::canvas::Canvas;
use super::{Surface, Vector, minus, seen};
use crate::args::SurfaceField;
use crate::digits::significant;

/// Width and height of a picture without margins at most.
const LARGEST: (f64, f64) = (900.0, 620.0);

/// Length of the arrows of the coordinates.
const AXIS: f64 = 38.0;

impl Surface {
    /// The name of its file.
    pub fn file(&self) -> &'static str {
        match self.field {
            SurfaceField::Displacement => "surface-displacement.png",
            SurfaceField::Stress => "surface-stress.png",
            SurfaceField::Pressure => "surface-pressure.png",
        }
    }

    /// The picture.
    ///
    /// # Errors
    /// As [`Figure::raster`].
    pub fn image(&self, title: &str) -> anyhow::Result<Image> {
        let panel = self.panel();
        let mut canvas = Canvas::new(&panel);
        self.triangles.iter().for_each(|triangle| canvas.triangle(triangle));
        let scale = panel.width / (panel.x.1 - panel.x.0);
        let length = |line: &Vec<Vector>| {
            let across = minus(line[0], line[line.len() - 1]);
            scale * across[0].hypot(across[1])
        };
        let mean = self.lines.mesh.iter().map(length).sum::<f64>() / self.lines.mesh.len().max(1) as f64;
        if self.lines.pieces * mean > 5.0 {
            self.lines.mesh.iter().for_each(|line| canvas.line(line, 0.4, false));
        }
        self.lines.sharp.iter().for_each(|line| canvas.line(line, 0.8, true));

        let (symbol, unit, map, is_size): (_, _, &[Rgb; 17], _) = match self.field {
            SurfaceField::Displacement => ("|u|", "m", &VIRIDIS, true),
            SurfaceField::Stress => ("von Mises", "Pa", &PLASMA, false),
            SurfaceField::Pressure => ("p", "Pa", &PLASMA, false),
        };
        let values = canvas.values();
        let size = values.iter().fold(0.0_f64, |size, v| size.max(f64::from(v.abs())));
        let (factor, unit) = readable(size, unit);
        let range = limits(values.iter().map(|v| (factor * f64::from(*v)) as f32).collect(), is_size);

        let right = panel.left + panel.width;
        let mut figure = Figure::new(right + 134.0, panel.top + panel.height + 98.0);
        figure.text((panel.left, 26.0), title, 15, Anchor::Start, INK);
        let bar = Panel { left: right + 24.0, width: 16.0, x: (0.0, 1.0), y: range, ..panel.clone() };
        frame(&mut figure, &panel);
        legend(&mut figure, &bar, &labelled(symbol, &unit));
        self.axes(&mut figure, &panel);
        let mut image = figure.raster()?;
        canvas.paint(&mut image, &panel, map, factor, range);
        paint_bar(&mut image, &bar, map);
        Ok(image)
    }

    /// Where the surface is, with some air around it.
    fn panel(&self) -> Panel {
        let range = |d: usize| {
            let all = self.triangles.iter().flat_map(|triangle| triangle.at.map(|x| x[d]));
            all.fold((f64::INFINITY, f64::NEG_INFINITY), |range, x| (range.0.min(x), range.1.max(x)))
        };
        let [x, y] = [range(0), range(1)];
        let air = 0.06 * (x.1 - x.0).max(y.1 - y.0);
        let [x, y] = [x, y].map(|range| (range.0 - air, range.1 + air));
        let scale = (LARGEST.0 / (x.1 - x.0)).min(LARGEST.1 / (y.1 - y.0));
        let size = |(low, high): (f64, f64)| (scale * (high - low)).round().max(120.0);
        let (width, height) = (size(x), size(y));
        // The same scale in both directions, though widths are whole numbers.
        let centred = |(low, high): (f64, f64), pixels: f64| {
            let middle = 0.5 * (low + high);
            (middle - 0.5 * pixels / scale, middle + 0.5 * pixels / scale)
        };
        let (x, y) = (centred(x, width), centred(y, height));
        Panel { left: 24.0, top: 60.0, width, height, x, y, logarithmic: false }
    }

    /// The directions of the coordinates, and the ranges in which the surface is.
    fn axes(&self, figure: &mut Figure, panel: &Panel) {
        let from = (panel.left + 32.0, panel.top + panel.height + 66.0);
        for (d, name) in ["x", "y", "z"].into_iter().enumerate() {
            let mut direction = [0.0; 3];
            direction[d] = 1.0;
            let along = seen(direction);
            let at = |length: f64| (from.0 + length * along[0], from.1 - length * along[1]);
            figure.line(from, at(AXIS), INK, 1.2);
            let (x, y) = at(AXIS + 9.0);
            figure.text((x, y + 4.0), name, 12, Anchor::Middle, INK);
        }
        let range = |(name, (low, high)): (&str, &(f64, f64))| {
            let size = 1e-4 * (high - low).abs().max(1e-300);
            let round = |x: f64| significant((x / size).round() * size, 4).replace('-', "\u{2212}");
            format!("{name} {} to {} m", round(*low), round(*high))
        };
        let ranges: Vec<String> = ["x", "y", "z"].into_iter().zip(&self.extents).map(range).collect();
        let at = |n: usize| (panel.left + 100.0, panel.top + panel.height + 36.0 + 20.0 * n as f64);
        for (n, range) in ranges.iter().enumerate() {
            figure.text(at(n), range, 13, Anchor::Start, INK);
        }
    }
}
