//! A field as samples, and as pixels.

use super::super::cell::{Pieces, Reference};
use super::super::colors::{self, SOLID};
use super::super::figure::{Image, Panel, SCALE};
use super::Content;
use std::collections::HashMap;
use undula::output::FieldSnapshot;

/// Samples per pixel and direction of a picture.
pub(super) const SAMPLES: usize = 2;

/// No cell.
pub(super) const NOWHERE: u32 = u32::MAX;

/// What a sample of a picture meets.
#[derive(Copy, Clone)]
pub(super) struct Sample {
    pub value: f32,
    pub cell: u32,
}

/// A field sampled on a fine grid.
pub(super) struct Raster {
    pub width: usize,
    pub height: usize,
    pub samples: Vec<Sample>,
    /// Samples per pixel and direction.
    per_pixel: usize,
}

impl Raster {
    /// Every cell is cut into small straight-sided triangles, as fine as the picture needs.
    pub fn new(snapshot: &FieldSnapshot, values: &[f64], panel: &Panel, per_pixel: usize) -> Self {
        let fine = SCALE * per_pixel;
        let (width, height) = (panel.width as usize * fine, panel.height as usize * fine);
        let samples = vec![Sample { value: 0.0, cell: NOWHERE }; width * height];
        let mut raster = Raster { width, height, samples, per_pixel };
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
    pub fn paint(
        &self,
        image: &mut Image,
        panel: &Panel,
        content: &Content,
        range: (f64, f64),
        solid: &[bool],
    ) {
        let color = |sample: &Sample| match sample.cell {
            NOWHERE => [255; 3],
            cell if solid[cell as usize] && !content.in_solid => SOLID,
            _ => colors::at(content.map, (f64::from(sample.value) - range.0) / (range.1 - range.0)),
        };
        let per = self.per_pixel;
        let (left, top) = (panel.left as usize * SCALE, panel.top as usize * SCALE);
        for y in 0..self.height / per {
            for x in 0..self.width / per {
                let mut sum = [0u32; 3];
                for n in 0..per * per {
                    let at = (per * y + n / per) * self.width + per * x + n % per;
                    let rgb = color(&self.samples[at]);
                    (0..3).for_each(|c| sum[c] += u32::from(rgb[c]));
                }
                let mean = sum.map(|s| ((s as f64) / (per * per) as f64).round() as u8);
                image.multiply(left + x, top + y, mean);
            }
        }
    }
}
