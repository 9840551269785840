//! A given pressure on a boundary, as a load that follows the boundary or as a dead one.
//!
//! J σ F⁻ᵀ N = −p(X, t) J F⁻ᵀ N on the boundary in motion, or −p(X, t) N.

use super::facets::{FacetOperator, FacetTerm};
use super::{DataTime, End};
use crate::physics::Pressure;
use crate::sampling::FacetPoint;
use crate::space::{FsiSpace, Region};

/// p(X, t) \[Pa\] at a reference position \[m\] and a time \[s\].
pub type PressureData<const D: usize> = Box<dyn Fn(&[f64; D], f64) -> f64 + Send + Sync>;

/// The pressure at the points of the facets of one body at one boundary.
pub struct PressureLoad<const D: usize> {
    data: PressureData<D>,
    follows: bool,
    /// p at the points, at the old and the new time.
    values: [Vec<f64>; 2],
}

impl<const D: usize> PressureLoad<D> {
    /// The same pressure at all points and times.
    pub(super) fn set(&mut self, pressure: f64) {
        self.values.iter_mut().for_each(|values| values.fill(pressure));
    }
}

impl<const D: usize> FacetTerm<D> for PressureLoad<D> {
    type Form = Pressure;
    const DEPENDS: [bool; 2] = [false, true];

    fn form(&self, point: usize, end: End) -> Pressure {
        Pressure { pressure: self.values[end as usize][point], follows: self.follows }
    }

    fn set_data<'a>(
        &mut self,
        at: &DataTime,
        points: impl Iterator<Item = &'a FacetPoint<D>>,
    ) -> Result<(), ([f64; D], [f64; D])> {
        for (value, point) in self.values[at.end as usize].iter_mut().zip(points) {
            let p = (self.data)(&point.x, at.time);
            if !p.is_finite() {
                return Err((point.x, [p; D]));
            }
            *value = p * at.load;
        }
        Ok(())
    }
}

/// The load on the facets of `body` at `boundary`, `n` Gauss points per direction; it follows the boundary in its motion,
/// or acts on the reference boundary. Zero until data are set.
pub fn pressure<const D: usize>(
    space: &FsiSpace<D>,
    body: Region,
    boundary: u16,
    (data, follows): (PressureData<D>, bool),
    n: usize,
) -> FacetOperator<PressureLoad<D>, D> {
    let load = |points| PressureLoad { data, follows, values: [vec![0.0; points], vec![0.0; points]] };
    FacetOperator::new(space, body, |facet| facet.boundary == boundary, n, load)
}
