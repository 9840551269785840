//! Data that are not finite somewhere: told with key, place and time, before anything is computed where possible.

use crate::case::conditions::Pair;
use crate::case::error::{CaseError, CaseErrors};
use crate::case::expression::Expression;
use crate::case::{Case, Condition, TimeSpec};
use crate::error::Error;
use crate::math::{rounded, shortest};
use crate::space::{FsiSpace, Region};
use crate::time::{DataFault, DataKind};

/// Times between the start and the end at which data are looked at in advance.
const TIMES: usize = 50;

/// Places at which body forces are looked at, at times other than the first one.
const PLACES: usize = 2000;

#[doc(hidden)]
impl Case {
    /// Looks at the velocities of boundaries at their nodes, and at body forces at nodes and centres of cells, at the start,
    /// the end and some times between.
    ///
    /// # Errors
    /// [`Error::Case`] with one mistake for each key whose value is not finite somewhere.
    pub fn check_data(&self, space: &FsiSpace<2>) -> Result<(), Error> {
        let mut errors = vec![];
        for (name, condition) in &self.boundary {
            if let Some(data) = condition.data() {
                let nodes = space.boundary_nodes(name);
                let places: Vec<[f64; 2]> = nodes.iter().map(|&n| space.nodes.points[n as usize]).collect();
                let fault = find(data, &places, &self.times(data, true));
                errors.extend(fault.map(|f| self.not_finite(space, &data_key(name, condition), data, f)));
            }
        }
        for region in [Region::Fluid, Region::Solid] {
            if let Some((key, data)) = self.force(region) {
                let fault = find(data, &places(space, region), &self.times(data, self.takes_old_forces()));
                errors.extend(fault.map(|f| self.not_finite(space, key, data, f)));
            }
        }
        if errors.is_empty() { Ok(()) } else { Err(Error::Case(CaseErrors(errors))) }
    }

    /// The mistake behind data that turned out not to be finite in the course of a computation.
    pub fn blame_data(&self, space: &FsiSpace<2>, fault: &DataFault) -> Error {
        let at = [fault.at[0], fault.at[1]];
        let is_wrong = |data: &Pair| !is_finite(&values(data, &at, fault.time));
        let data = match fault.kind {
            DataKind::Force(region) => self.force(region).map(|(key, data)| (key.to_string(), data)),
            DataKind::Velocity { node } => {
                let mut given = self.boundary.iter().filter(|(_, condition)| condition.is_given());
                let here = |name: &str| space.boundary_nodes(name).contains(&node);
                given.find_map(|(name, condition)| {
                    let data = condition.data().filter(|data| here(name) && is_wrong(data))?;
                    Some((data_key(name, condition), data))
                })
            }
            DataKind::Condition { boundary } => {
                let name = &space.mesh.boundaries[usize::from(boundary)];
                self.boundary.get(name).and_then(|c| Some((data_key(name, c), c.data()?)))
            }
        };
        let found = Found { at, time: fault.time, value: [fault.value[0], fault.value[1]] };
        let error = match data {
            Some((key, data)) => self.not_finite(space, &key, data, found),
            None => {
                let (place, message) = (self.place_of("boundary"), found.message(self, space, true));
                CaseError { place, key: "boundary".into(), value: None, message }
            }
        };
        Error::Case(CaseErrors(vec![error]))
    }

    /// The length of a step that begins at `t` \[s\].
    ///
    /// # Errors
    /// [`Error::Case`] if it is not above 0.
    pub fn step_at(&self, time: &TimeSpec, t: f64) -> Result<f64, Error> {
        let k = time.step.eval(&[0.0; 3], t);
        if k > 0.0 && k.is_finite() {
            return Ok(k);
        }
        let key = "time.step";
        let message = format!("expected a value above 0 at all times, it is {k} at t = {t} s");
        let message = message + &time.step.gap(&[0.0; 3], t);
        let value = Some(text(&time.step));
        Err(Error::Case(CaseErrors(vec![CaseError {
            place: self.place_of(key),
            key: key.into(),
            value,
            message,
        }])))
    }

    fn force(&self, region: Region) -> Option<(&'static str, &Pair)> {
        match region {
            Region::Fluid => self.fluid.as_ref().map(|f| ("fluid.body-force", &f.body_force)),
            Region::Solid => self.solid.as_ref().map(|s| ("solid.body-force", &s.body_force)),
        }
    }

    /// Whether a step takes the forces of its beginning, too.
    fn takes_old_forces(&self) -> bool {
        self.time.as_ref().is_none_or(|time| time.scheme.takes_old_forces())
    }

    /// Times \[s\] at which `data` are looked at.
    fn times(&self, data: &Pair, start: bool) -> Vec<f64> {
        let Some(time) = &self.time else { return vec![self.at_time] };
        if !data.iter().any(Expression::depends_on_time) {
            return vec![time.start];
        }
        let n = TIMES + 1;
        let of = |i: usize| time.start + (time.end - time.start) * i as f64 / n as f64;
        (0..=n).skip(usize::from(!start)).map(of).collect()
    }

    fn not_finite(&self, space: &FsiSpace<2>, key: &str, data: &Pair, found: Found) -> CaseError {
        let in_time = data.iter().any(Expression::depends_on_time);
        CaseError {
            place: self.place_of(key),
            key: key.into(),
            value: Some(format!("[{}, {}]", text(&data[0]), text(&data[1]))),
            message: found.message(self, space, in_time) + &found.gap(data),
        }
    }
}

/// A value that is not finite.
struct Found {
    at: [f64; 2],
    time: f64,
    value: [f64; 2],
}

impl Found {
    /// Which table has no value there, if one has none.
    fn gap(&self, data: &Pair) -> String {
        let wrong = data.iter().zip(self.value).find(|(_, value)| !value.is_finite());
        wrong.map_or(String::new(), |(data, _)| data.gap(&[self.at[0], self.at[1], 0.0], self.time))
    }

    fn message(&self, case: &Case, space: &FsiSpace<2>, in_time: bool) -> String {
        let value = self.value.map(|x| shortest(rounded(x, x, 4))).join(", ");
        let mut message =
            format!("expected finite values; it is ({value}) at {}", space.mesh.shown(&self.at));
        if in_time || case.time.is_some() {
            message += &format!(", t = {} s", shortest(self.time));
        }
        message
    }
}

/// The first value of `data` that is not finite.
fn find(data: &Pair, places: &[[f64; 2]], times: &[f64]) -> Option<Found> {
    if data.iter().all(Expression::is_constant) {
        return None;
    }
    let stride = places.len().div_ceil(PLACES).max(1);
    times.iter().enumerate().find_map(|(i, &time)| {
        let mut some = places.iter().step_by(if i == 0 { 1 } else { stride });
        some.find_map(|&at| {
            let value = values(data, &at, time);
            (!is_finite(&value)).then_some(Found { at, time, value })
        })
    })
}

fn values(data: &Pair, at: &[f64; 2], time: f64) -> [f64; 2] {
    let x = [at[0], at[1], 0.0];
    [data[0].eval(&x, time), data[1].eval(&x, time)]
}

fn is_finite(value: &[f64; 2]) -> bool {
    value.iter().all(|x| x.is_finite())
}

/// Nodes and centres of the cells of `region`.
fn places(space: &FsiSpace<2>, region: Region) -> Vec<[f64; 2]> {
    let cells = || (0..space.mesh.n_cells()).filter(|&c| space.regions[c] == region);
    let mut nodes: Vec<u32> = cells().flat_map(|c| space.nodes.cell(c).iter().copied()).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let points = nodes.iter().map(|&n| space.nodes.points[n as usize]);
    points.chain(cells().map(|c| space.mesh.centre(c))).collect()
}

fn data_key(name: &str, condition: &Condition) -> String {
    format!("boundary.{name}.{}", condition.name())
}

/// An expression as in a case file.
fn text(e: &Expression) -> String {
    if e.source().parse::<f64>().is_ok() { e.source().into() } else { format!("\"{}\"", e.source()) }
}
