//! Springs and dashpots on a boundary of the solid: J σ F⁻ᵀ N = −(k u + c v), or its normal part.

use super::facets::{FacetOperator, FacetTerm};
use super::{DataTime, End};
use crate::physics::Spring;
use crate::sampling::FacetPoint;
use crate::space::{FsiSpace, Region};

/// k(X, t) \[Pa/m\] and c(X, t) \[Pa s/m\] at a reference position \[m\] and a time \[s\].
pub type SpringData<const D: usize> = Box<dyn Fn(&[f64; D], f64) -> [f64; 2] + Send + Sync>;

/// The bed at the points of the facets of the solid at one boundary.
pub struct Bed<const D: usize> {
    data: SpringData<D>,
    normal: bool,
    /// k and c at the points, at the old and the new time.
    values: [Vec<[f64; 2]>; 2],
}

impl<const D: usize> FacetTerm<D> for Bed<D> {
    type Form = Spring;
    const DEPENDS: [bool; 2] = [true, true];

    fn form(&self, point: usize, end: End) -> Spring {
        let [stiffness, damping] = self.values[end as usize][point];
        Spring { stiffness, damping, normal: self.normal }
    }

    fn set_data<'a>(
        &mut self,
        at: &DataTime,
        points: impl Iterator<Item = &'a FacetPoint<D>>,
    ) -> Result<(), ([f64; D], [f64; D])> {
        for (value, point) in self.values[at.end as usize].iter_mut().zip(points) {
            *value = (self.data)(&point.x, at.time);
            if let Some(wrong) = value.iter().find(|x| !x.is_finite()) {
                return Err((point.x, [*wrong; D]));
            }
        }
        Ok(())
    }
}

/// The bed on the facets of the solid at `boundary`, `n` Gauss points per direction.
pub fn spring<const D: usize>(
    space: &FsiSpace<D>,
    boundary: u16,
    (data, normal): (SpringData<D>, bool),
    n: usize,
) -> FacetOperator<Bed<D>, D> {
    let bed = |points| Bed { data, normal, values: [vec![[0.0; 2]; points], vec![[0.0; 2]; points]] };
    FacetOperator::new(space, Region::Solid, |facet| facet.boundary == boundary, n, bed)
}
