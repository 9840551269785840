//! How long a step takes, before anything is computed.

use crate::case::{Case, Linearization};
use crate::space::FsiSpace;

/// Nanoseconds of a processor for an unknown and a step of a typical machine, with the elements of degree 2: the
/// condensed system in the plane, the same in space without the factors, by multigrid in the plane and in space.
const PLANE: f64 = 450.0;
const SPACE: f64 = 1000.0;
const MULTIGRID: [f64; 2] = [5000.0, 13_000.0];

/// Nanoseconds for a byte of factors in space: what five iterations read of them, which are larger in cubes than
/// elsewhere.
const FACTORS: f64 = 0.25;

/// The whole Jacobian of a body that moves takes so many times as long.
const WHOLE: f64 = 4.0;

impl Case {
    /// Seconds of a processor for a step on `space`; `None` where there are no steps. Of sixteen cases they were from 0.6 to
    /// 3.3 times what was measured, the most for a thin layer in space.
    pub(super) fn expected_seconds<const D: usize>(&self, space: &FsiSpace<D>) -> Option<f64> {
        self.time.as_ref()?;
        let unknowns = space.n_field_unknowns() as f64;
        let nanoseconds = if self.takes_multigrid(space) {
            MULTIGRID[D - 2] * unknowns
        } else if D == 2 {
            PLANE * unknowns
        } else {
            SPACE * unknowns + FACTORS * self.bytes_of_factors(space.mesh.n_cells())
        };
        let moves = !self.solids.is_empty() && self.newton.linearization != Linearization::Condensed;
        Some(1e-9 * nanoseconds * if moves { WHOLE } else { 1.0 })
    }
}
