//! Pictures of one field at several times, with the same colours and the same frame.

use super::super::colors::Rgb;
use super::super::figure::Image;
use super::{Box2, View, content, draw, frame_of, limits};
use std::sync::OnceLock;

/// Values that the range of colours is taken from.
const VALUES: usize = 1_000_000;

/// What all pictures have in common.
pub struct Film {
    field: &'static str,
    /// Largest size of a value.
    size: f64,
    /// Some of all values where the field is shown.
    values: Vec<f32>,
    /// How many moments the values are of, at most.
    moments: usize,
    frame: Option<[Box2; 2]>,
    /// Least and greatest of the values, but for extremes.
    range: OnceLock<(f64, f64)>,
}

impl Film {
    /// A film of `moments` moments of `velocity`, `pressure` or `deformation`.
    pub fn new(field: &'static str, moments: usize) -> Self {
        Film { field, size: 0.0, values: vec![], moments, frame: None, range: OnceLock::new() }
    }

    /// Makes room for a moment; `false` if it does not have the field.
    pub fn include(&mut self, view: &View) -> bool {
        // In its own unit.
        let Some(content) = content(&view.fields, self.field, Some(1.0)) else { return false };
        let mut shown = vec![content.in_solid; content.values.len()];
        let n = view.fields.points_per_cell();
        for (cell, nodes) in view.fields.cells.chunks_exact(n).enumerate() {
            nodes.iter().for_each(|&p| shown[p as usize] |= !view.solid[cell]);
        }
        let every = (content.values.len() * self.moments / VALUES).max(1);
        let values = content.values.iter().zip(&shown).filter(|(_, shown)| **shown).map(|(v, _)| *v);
        self.size = values.clone().fold(self.size, |size, v| size.max(v.abs()));
        self.values.extend(values.step_by(every).map(|v| v as f32));
        let [whole, body] = frame_of(view);
        let wider =
            |a: Box2, b: Box2| ((a.0.0.min(b.0.0), a.0.1.max(b.0.1)), (a.1.0.min(b.1.0), a.1.1.max(b.1.1)));
        self.frame = Some(match self.frame {
            Some([former, inner]) => [wider(former, whole), wider(inner, body)],
            None => [whole, body],
        });
        true
    }

    /// The picture of a moment, half as fine as others.
    ///
    /// # Errors
    /// As [`Figure::raster`](super::super::figure::Figure::raster).
    pub fn image(&self, view: &View, title: &str) -> anyhow::Result<Option<Image>> {
        let (Some(mut shown), Some(frame)) = (content(&view.fields, self.field, Some(self.size)), self.frame)
        else {
            return Ok(None);
        };
        let (factor, _) = super::readable(self.size, super::look_of(self.field).2);
        let magnitude = shown.magnitude;
        let (low, high) = *self.range.get_or_init(|| limits(self.values.clone(), magnitude));
        shown.limits = Some((factor * low, factor * high));
        // Pixels are halved, below.
        shown.samples = 1;
        Ok(Some(draw(view, &shown, title, false, frame)?.halved()))
    }

    /// The colours of the field.
    pub fn map(&self) -> &'static [Rgb; 17] {
        super::look_of(self.field).3
    }
}
