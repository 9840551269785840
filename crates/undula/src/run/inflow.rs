//! Flow that comes back in through an outlet, the usual cause of a breakdown there.

use crate::case::{Case, Condition};
use crate::math::Vector;
use crate::physics::kinematics::cofactor;
use crate::sampling::{facet_points, fields_at};
use crate::space::{FsiSpace, Region, State};
use crate::time::StepFailure;

/// Part of the largest speed from which on flow that comes in is named as the cause.
const SHARE: f64 = 0.5;

/// If the mesh folded: how many times the root mean square of the speeds the flow that comes in must be, for that is its
/// mark, and how near the fold must be in parts of the diameter of the mesh.
const BURST: f64 = 5.0;
/// See [`BURST`].
const NEAR: f64 = 0.1;

/// Gauss points per facet.
const POINTS: usize = 3;

/// The fastest flow into the fluid through an outlet.
#[derive(Clone, Debug, PartialEq)]
pub struct Inflow {
    /// Name of the outlet.
    pub boundary: String,
    /// −v·n in the current domain \[m/s\].
    pub speed: f64,
    /// Where, in the current domain \[m\].
    pub point: Vec<f64>,
}

/// The fastest flow in `state` that comes in through an outlet of `case` without directional term; `None` if it leaves
/// through all of them.
pub fn inflow<const D: usize>(case: &Case, space: &FsiSpace<D>, state: &State) -> Option<Inflow> {
    let mut found: Option<Inflow> = None;
    for facet in space.mesh.facets.iter().filter(|f| space.regions[f.cell as usize] == Region::Fluid) {
        let name = &space.mesh.boundaries[facet.boundary as usize];
        let outlet = case.boundary.get(name).is_some_and(Condition::is_natural);
        if !outlet || case.directional.contains(name) {
            continue;
        }
        let nodes = space.nodes.cell(facet.cell as usize);
        for point in facet_points(space, facet, POINTS) {
            let at = fields_at(nodes, &point.value, &point.grad, state);
            let normal = cofactor(&at.grad_u) * point.normal;
            let speed = -at.v.dot(normal) / normal.dot(normal).sqrt();
            if speed > found.as_ref().map_or(0.0, |found| found.speed) {
                let Vector(x) = Vector(point.x) + at.u;
                found = Some(Inflow { boundary: name.clone(), speed, point: x.to_vec() });
            }
        }
    }
    found
}

/// The flow through an outlet that explains a breakdown after `state`: hardly anywhere is the flow faster than where it
/// comes in, and the mesh did not fold, or only beside a burst of such flow.
pub(super) fn explains<const D: usize>(
    case: &Case,
    space: &FsiSpace<D>,
    state: &State,
    failure: &StepFailure,
) -> Option<Inflow> {
    let speeds = || state.v.chunks_exact(D).map(|v| v.iter().map(|v| v * v).sum::<f64>().sqrt());
    let largest = speeds().fold(0.0, f64::max);
    let mean = (speeds().map(|v| v * v).sum::<f64>() / (state.v.len() / D).max(1) as f64).sqrt();
    let folded = failure.worst.min_j <= 0.0;
    let reach = NEAR * space.mesh.diameter();
    let beside = |found: &Inflow| {
        let centres = failure.worst.cells.iter().map(|&cell| space.mesh.centre(cell as usize));
        let gap = |x: [f64; D]| x.iter().zip(&found.point).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        centres.map(gap).any(|gap| gap < reach)
    };
    let burst = |found: &Inflow| found.speed >= BURST * mean && beside(found);
    inflow(case, space, state).filter(|found| found.speed >= SHARE * largest && (!folded || burst(found)))
}
