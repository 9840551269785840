//! Parts of the fluid that nothing opens, and whether the velocity data on their boundary are in balance.

use super::bodies::{extent, short};
use crate::case::Case;
use crate::error::Error;
use crate::space::{Constraints, Enclosed, FsiSpace, State, enclosed};

/// Part of the flow through a closed boundary that is rounding where the data are in balance, and what a body that
/// gives way does not feel.
const BALANCED: f64 = 1e-12;
const FELT: f64 = 1e-9;

/// Times at which the data are looked at.
const SAMPLES: u32 = 50;

/// What must not be, by the way out of it.
const OPEN: &str = "one boundary needs condition = `do-nothing` or `traction-free`";

#[doc(hidden)]
impl Case {
    /// What should be known of the parts of the fluid that are closed in.
    ///
    /// # Errors
    /// Parts into which their velocity data let more flow in than out, if no body gives way.
    pub(super) fn check_enclosed<const D: usize>(&self, space: &FsiSpace<D>) -> Result<Vec<String>, Error> {
        let conditions = self.conditions(&space.mesh);
        let parts = enclosed(space, &conditions);
        if parts.is_empty() {
            return Ok(vec![]);
        }
        let constraints = Constraints::new(space, &conditions);
        let whole = is_whole(space, &parts);
        let mut notes = vec![];
        for part in &parts {
            let subject = subject(part, whole);
            let inflow = self.worst_inflow(space, &constraints, part, tolerance(part));
            match (inflow, part.touches_solid) {
                (Some((t, inflow)), false) => {
                    let when = self.time.as_ref().map_or(String::new(), |_| format!(" at t = {t} s"));
                    let excess = excess(inflow);
                    let message = format!(
                        "{subject} is closed in on all sides, but its velocity data let {excess}{when}: {OPEN}"
                    );
                    return Err(self.refuse("fluid", message));
                }
                (Some((t, inflow)), true) => notes.push(format!(
                    "{subject} is closed in on all sides, but its velocity data let {} at t = {t} s: only the body can \
                     make room, until it cannot",
                    excess(inflow)
                )),
                (None, false) if part.shares_pressures(space) => {
                    let message = format!(
                        "{subject} is closed in on all sides, so its pressure is determined up to a constant only, \
                         but it touches another part in a point, where a continuous pressure has one value: take a \
                         discontinuous one, such as `P1dc`"
                    );
                    return Err(self.refuse("space.pressure", message));
                }
                (None, false) => notes.push(format!(
                    "{subject} is closed in on all sides, so its pressure is determined up to a constant only: its \
                     mean is set to 0"
                )),
                (None, true) => {}
            }
        }
        Ok(notes)
    }

    /// Why no solution can be expected at time `t` \[s\]: parts of the fluid that are closed in, and into which the
    /// velocity data let more flow in than out.
    pub fn overfilled<const D: usize>(
        &self,
        space: &FsiSpace<D>,
        constraints: &Constraints<D>,
        t: f64,
    ) -> Option<String> {
        if space.part.is_some() {
            // What a process has of the fluid ends at others.
            return None;
        }
        let parts = enclosed(space, &self.conditions(&space.mesh));
        let whole = is_whole(space, &parts);
        parts.iter().find_map(|part| {
            let (net, size) = net(space, constraints, part, t);
            (net.abs() > tolerance(part) * size).then(|| {
                format!(
                    "{} is closed in on all sides, but its velocity data let {}: {OPEN}",
                    subject(part, whole),
                    excess(-net)
                )
            })
        })
    }

    /// The time \[s\] at which most flows into `part`, or out of it, and how much \[m²/s\]; `None` if that is no more
    /// than `tolerance` of what its data move.
    fn worst_inflow<const D: usize>(
        &self,
        space: &FsiSpace<D>,
        constraints: &Constraints<D>,
        part: &Enclosed<D>,
        tolerance: f64,
    ) -> Option<(f64, f64)> {
        let times: Vec<f64> = match &self.time {
            None => vec![self.at_time],
            Some(time) => {
                let at = |i: u32| time.start + (time.end - time.start) * f64::from(i) / f64::from(SAMPLES);
                (0..=SAMPLES).map(at).chain([time.start + time.step.eval(&[0.0; 3], time.start)]).collect()
            }
        };
        let at = |t: f64| (t, net(space, constraints, part, t));
        // The first of equal ones.
        let beyond = times.into_iter().rev().map(at).filter(|(_, (net, size))| net.abs() > tolerance * size);
        let most = beyond.max_by(|a, b| a.1.0.abs().total_cmp(&b.1.0.abs()));
        most.map(|(t, (net, _))| (short(t, t.abs()), -net))
    }
}

/// ∫ v·n of the data of `part` at time `t` \[s\], and the size of what it is the sum of.
fn net<const D: usize>(
    space: &FsiSpace<D>,
    constraints: &Constraints<D>,
    part: &Enclosed<D>,
    t: f64,
) -> (f64, f64) {
    let State { mut v, mut u, .. } = State::zero(space.n_v(), space.n_u(), 0);
    let whole = Constraints { load: 1.0, ..constraints.clone() };
    whole.apply(space, t, &mut v, &mut u);
    part.flux(&v, |node| constraints.v[node])
}

fn tolerance<const D: usize>(part: &Enclosed<D>) -> f64 {
    if part.touches_solid { FELT } else { BALANCED }
}

/// Whether `parts` is all of the fluid in one piece.
fn is_whole<const D: usize>(space: &FsiSpace<D>, parts: &[Enclosed<D>]) -> bool {
    let fluid = space.regions.iter().filter(|&&region| region == crate::space::Region::Fluid).count();
    matches!(parts, [part] if part.cells.len() == fluid)
}

fn subject<const D: usize>(part: &Enclosed<D>, whole: bool) -> String {
    if whole {
        "the fluid".into()
    } else {
        format!("the part of the fluid in {}", extent(&part.lower, &part.upper))
    }
}

fn excess(inflow: f64) -> String {
    let (from, to) = if inflow > 0.0 { ("in", "out") } else { ("out", "in") };
    format!("{:.4e} m²/s more flow {from} than {to}", inflow.abs())
}
