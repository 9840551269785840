//! Given forces at the nodes of a solid, raised with the load.

use super::{DataTime, End, NotFinite, Operator, StepView};
use crate::space::Region;

/// What stands in the rows of φ, times the part of the load that acts.
pub struct NodalLoad {
    /// `[node][component]` \[N/m\], with the sign of the residual.
    rows: Vec<f64>,
    load: f64,
}

impl NodalLoad {
    /// The residual `rows`, none of which acts until data are set.
    pub fn new(rows: Vec<f64>) -> NodalLoad {
        NodalLoad { rows, load: 0.0 }
    }
}

impl<const D: usize> Operator<D> for NodalLoad {
    fn body(&self) -> Region {
        Region::Solid
    }

    fn set_data(&mut self, at: &DataTime) -> Result<(), NotFinite<D>> {
        if at.end == End::New {
            self.load = at.load;
        }
        Ok(())
    }

    fn residual(&mut self, _: &StepView<'_>, out: &mut [f64]) -> f64 {
        out.iter_mut().zip(&self.rows).for_each(|(out, row)| *out += self.load * row);
        f64::INFINITY
    }
}
