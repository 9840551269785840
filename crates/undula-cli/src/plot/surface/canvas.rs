//! What is nearest at the samples of a picture.

use super::super::colors::{self, Rgb, SOLID};
use super::super::figure::{Image, Panel, SCALE};
use super::{Triangle, Vector};

/// Samples per pixel and direction.
const SAMPLES: usize = 2;

/// Samples per unit of the figure.
const FINE: usize = SCALE * SAMPLES;

/// How bright a surface is that no light of the lamp reaches.
const SHADE: f64 = 0.58;

/// Lines of the mesh darken the colours beneath; sharp edges are black.
const MESH: f64 = 0.59;

/// What a sample of a picture meets.
#[derive(Copy, Clone)]
struct Sample {
    /// Towards the viewer; far away where there is nothing.
    near: f32,
    value: f32,
    light: f32,
    /// The factor of a line.
    line: f32,
}

/// A picture by samples.
pub(super) struct Canvas {
    width: usize,
    height: usize,
    samples: Vec<Sample>,
    /// Samples per metre.
    scale: f64,
    left: f64,
    top: f64,
}

impl Canvas {
    /// A picture of what `panel` shows, with as many pixels per metre in both directions.
    pub fn new(panel: &Panel) -> Self {
        let (width, height) = (panel.width as usize * FINE, panel.height as usize * FINE);
        let nothing = Sample { near: f32::NEG_INFINITY, value: 0.0, light: 1.0, line: 1.0 };
        let scale = panel.width * FINE as f64 / (panel.x.1 - panel.x.0);
        Canvas {
            width,
            height,
            samples: vec![nothing; width * height],
            scale,
            left: panel.x.0,
            top: panel.y.1,
        }
    }

    fn place(&self, x: Vector) -> [f64; 3] {
        [(x[0] - self.left) * self.scale, (self.top - x[1]) * self.scale, x[2]]
    }

    /// Samples with their middle between two numbers.
    fn between(low: f64, high: f64, n: usize) -> std::ops::Range<usize> {
        ((low - 0.5).ceil().max(0.0) as usize)..(((high - 0.5).floor() + 1.0).clamp(0.0, n as f64) as usize)
    }

    /// Draws a triangle over what is behind it.
    pub fn triangle(&mut self, triangle: &Triangle) {
        let [a, b, c] = triangle.at.map(|x| self.place(x));
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let range = |d: usize| (a[d].min(b[d]).min(c[d]), a[d].max(b[d]).max(c[d]));
        let [columns, rows] = [range(0), range(1)];
        for j in Self::between(rows.0, rows.1, self.height) {
            for i in Self::between(columns.0, columns.1, self.width) {
                let (x, y) = (i as f64 + 0.5, j as f64 + 0.5);
                let at_b = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / area;
                let at_c = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / area;
                if at_b < -1e-9 || at_c < -1e-9 || at_b + at_c > 1.0 + 1e-9 {
                    continue;
                }
                let mean = |of: [f64; 3]| (of[0] + at_b * (of[1] - of[0]) + at_c * (of[2] - of[0])) as f32;
                let near = mean([a[2], b[2], c[2]]);
                let sample = &mut self.samples[j * self.width + i];
                if near > sample.near {
                    *sample =
                        Sample { near, value: mean(triangle.values), light: mean(triangle.light), line: 1.0 };
                }
            }
        }
    }

    /// Draws what can be seen of a line: that which is not behind the surface by more than some samples.
    pub fn line(&mut self, points: &[Vector], width: f64, is_sharp: bool) {
        let behind = 0.004 * self.width as f64 / self.scale;
        let thick = width * FINE as f64;
        for ends in points.windows(2) {
            let [a, b] = [ends[0], ends[1]].map(|x| self.place(x));
            let steps = ((b[0] - a[0]).hypot(b[1] - a[1]) * 2.0).ceil().max(1.0);
            for step in 0..=steps as usize {
                let t = step as f64 / steps;
                let at: [f64; 3] = std::array::from_fn(|d| a[d] + t * (b[d] - a[d]));
                let ranges = [0, 1].map(|d| (at[d] - 0.5 * thick, at[d] + 0.5 * thick));
                for j in Self::between(ranges[1].0, ranges[1].1, self.height) {
                    for i in Self::between(ranges[0].0, ranges[0].1, self.width) {
                        let sample = &mut self.samples[j * self.width + i];
                        if f64::from(sample.near) <= at[2] + behind {
                            sample.line = if is_sharp { 0.0 } else { sample.line.min(MESH as f32) };
                        }
                    }
                }
            }
        }
    }

    /// The values that can be seen, but for those that are none.
    pub fn values(&self) -> Vec<f32> {
        let seen = self.samples.iter().filter(|s| s.near > f32::NEG_INFINITY && s.value.is_finite());
        seen.map(|s| s.value).collect()
    }

    /// Paints the picture beneath what is drawn in `panel`.
    pub fn paint(&self, image: &mut Image, panel: &Panel, map: &[Rgb; 17], factor: f64, range: (f64, f64)) {
        let color = |sample: &Sample| -> [f64; 3] {
            let value = (factor * f64::from(sample.value) - range.0) / (range.1 - range.0);
            let (rgb, light) = if sample.near == f32::NEG_INFINITY {
                ([255; 3], 1.0)
            } else {
                let rgb = if value.is_finite() { colors::at(map, value) } else { SOLID };
                (rgb, SHADE + (1.0 - SHADE) * f64::from(sample.light))
            };
            rgb.map(|c| f64::from(c) * light * f64::from(sample.line))
        };
        let (left, top) = (panel.left as usize * SCALE, panel.top as usize * SCALE);
        for y in 0..self.height / SAMPLES {
            for x in 0..self.width / SAMPLES {
                let mut sum = [0.0; 3];
                for n in 0..SAMPLES * SAMPLES {
                    let at = (SAMPLES * y + n / SAMPLES) * self.width + SAMPLES * x + n % SAMPLES;
                    let rgb = color(&self.samples[at]);
                    (0..3).for_each(|c| sum[c] += rgb[c]);
                }
                let mean = sum.map(|s| (s / (SAMPLES * SAMPLES) as f64).round() as u8);
                image.multiply(left + x, top + y, mean);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of the panel at this distance, with the value of its distance.
    fn square(from: f64, to: f64, near: f64) -> [Triangle; 2] {
        let triangle = |corners: [[f64; 2]; 3]| Triangle {
            at: corners.map(|[x, y]| [x, y, near]),
            values: [near; 3],
            light: [1.0; 3],
        };
        let [a, b, c, d] = [[from, from], [to, from], [to, to], [from, to]];
        [triangle([a, b, c]), triangle([a, c, d])]
    }

    #[test]
    fn what_is_nearer_is_seen_and_lines_behind_it_are_not() {
        let panel = Panel {
            left: 0.0,
            top: 0.0,
            width: 20.0,
            height: 20.0,
            x: (0.0, 1.0),
            y: (0.0, 1.0),
            logarithmic: false,
        };
        for nearest_first in [true, false] {
            let mut canvas = Canvas::new(&panel);
            let mut triangles: Vec<Triangle> =
                [square(0.5, 1.0, 2.0), square(0.0, 0.8, 1.0)].into_iter().flatten().collect();
            if !nearest_first {
                triangles.reverse();
            }
            triangles.iter().for_each(|triangle| canvas.triangle(triangle));
            canvas.line(&[[0.0, 0.7, 1.0], [1.0, 0.7, 1.0]], 0.5, true);
            let at = |x: f64, y: f64| {
                let [i, j] = [x, 1.0 - y].map(|s| (s * canvas.width as f64) as usize);
                canvas.samples[j * canvas.width + i]
            };
            assert_eq!([at(0.2, 0.2), at(0.6, 0.6), at(0.9, 0.9)].map(|s| s.value), [1.0, 2.0, 2.0]);
            assert_eq!(at(0.9, 0.2).near, f32::NEG_INFINITY);
            // Above the square that is behind, behind the other one, above nothing.
            assert_eq!([at(0.2, 0.7), at(0.6, 0.7)].map(|s| s.line), [0.0, 1.0]);
            assert_eq!([at(0.2, 0.5), at(0.9, 0.3)].map(|s| s.line), [1.0, 1.0]);
            assert_eq!(canvas.values().len(), canvas.samples.len() * (64 + 25 - 9) / 100);
        }
    }
}
