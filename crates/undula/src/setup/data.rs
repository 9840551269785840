//! Data that are not finite somewhere: told with key, place and time, before anything is computed where possible.

use super::functions::padded;
use crate::case::error::{CaseError, CaseErrors};
use crate::case::expression::Expression;
use crate::case::{Case, Condition, Load, SolidSpec, TimeSpec};
use crate::element::Quadrature;
use crate::error::Error;
use crate::math::{rounded, shortest};
use crate::space::{FsiSpace, Region};
use crate::time::{DataFault, DataKind};

/// Times between the start and the end at which data are looked at in advance.
const TIMES: usize = 50;

/// Displacement at the start relative to the extent of its boundary that is rounding.
pub(super) const STARTS: f64 = 1e-9;

/// Places at which body forces are looked at, at times other than the first one.
const PLACES: usize = 2000;

#[doc(hidden)]
impl Case {
    /// Looks at the velocities of boundaries at their nodes, and at body forces at nodes and centres of cells, at the start,
    /// the end and some times between.
    ///
    /// # Errors
    /// [`Error::Case`] with one mistake for each key whose value is not finite somewhere.
    pub fn check_data<const D: usize>(&self, space: &FsiSpace<D>) -> Result<(), Error> {
        let mut errors = vec![];
        for (name, condition) in &self.boundary {
            for (key, data) in condition.expressions() {
                let nodes = space.boundary_nodes(name);
                let places: Vec<[f64; D]> = nodes.iter().map(|&n| space.nodes.points[n as usize]).collect();
                if matches!(condition, Condition::Displacement(_)) {
                    errors.extend(self.starts_elsewhere(&data_key(name, key), &data, &places));
                }
                let times = self.times(&data, true);
                errors.extend(self.negative_in_circuit(condition, (name, key), &data[0], &times));
                let fault = find(&data, &places, &times);
                errors.extend(fault.map(|f| self.not_finite(space, &data_key(name, key), &data, f)));
            }
        }
        for Load { body, material, key, force } in self.loads() {
            let here = |cell: usize| space.regions[cell] == body && space.material[cell] == material;
            let fault = find(force, &places(space, here), &self.times(force, self.takes_old_forces()));
            errors.extend(fault.map(|f| self.not_finite(space, &key, force, f)));
        }
        errors.extend((0..).zip(&self.solids).filter_map(|(n, solid)| self.no_direction(space, n, solid)));
        errors.extend(self.check_fields(space));
        errors.extend(self.check_repeated(space));
        if errors.is_empty() { Ok(()) } else { Err(Error::Case(CaseErrors(errors))) }
    }

    /// The mistake that a displacement is not 0 at the beginning, where u is.
    fn starts_elsewhere<const D: usize>(
        &self,
        key: &str,
        data: &[Expression],
        places: &[[f64; D]],
    ) -> Option<CaseError> {
        let time = self.time.as_ref().filter(|_| self.starts_undeformed())?;
        let extent = |d: usize| {
            let along = places.iter().map(|x| x[d]);
            along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
        };
        let tolerance = STARTS * (0..D).map(extent).fold(0.0, f64::max);
        let moved = |at: &&[f64; D]| values(data, at, time.start).iter().any(|u| u.abs() > tolerance);
        let at = places.iter().find(moved)?;
        let value: Vec<String> =
            values(data, at, time.start).iter().map(|&u| shortest(rounded(u, u, 4))).collect();
        let message = format!(
            "expected a displacement that is 0 at the start t = {} s, where all is at rest, or initial.static = true, or \
             initial.displacement with the same values; it is {} m at ({})",
            shortest(time.start),
            value.join(", "),
            at.map(|x| shortest(rounded(x, x, 6))).join(", ")
        );
        Some(CaseError { place: self.place_of(key), key: key.into(), value: None, message })
    }

    /// The mistake that fibres have no direction at a quadrature point of the solid `material`.
    fn no_direction<const D: usize>(
        &self,
        space: &FsiSpace<D>,
        material: u16,
        solid: &SolidSpec,
    ) -> Option<CaseError> {
        let (data, t) = (solid.fibre_field()?, self.time.as_ref().map_or(0.0, |time| time.start));
        let here = |&c: &usize| space.regions[c] == Region::Solid && space.material[c] == material;
        let rule = Quadrature::cell(space.mesh.shape, self.space.quadrature);
        let mut points = (0..space.mesh.n_cells()).filter(here).flat_map(|cell| {
            rule.points.iter().map(move |xi| space.mesh.map(cell, std::array::from_fn(|d| xi[d])))
        });
        let spreads = solid.fibres.as_ref().is_some_and(|fibres| fibres.angle.sin() != 0.0);
        let leaves = |value: &[f64]| spreads && value.get(2).is_some_and(|z| *z != 0.0);
        let is_wrong = |value: &[f64]| !has_direction(value) || leaves(value);
        let at = points.find(|x| is_wrong(&values(data, x, t)))?;
        let key = format!("{}.fibre-direction", solid.table());
        let value = values(data, &at, t);
        let found = Found { at: at.to_vec(), time: t, value: value.clone() };
        if !is_finite(&value) {
            return Some(self.not_finite(space, &key, data, found));
        }
        let shown = space.mesh.shown(&at);
        let message = if leaves(&value) {
            format!(
                "the families of fibres are turned by `fibre-angle` around the z axis: expected a direction in the plane \
                 (x, y), or fibre-angle = 0; its z is {} at {shown}",
                shortest(rounded(value[2], value[2], 4))
            )
        } else {
            format!("expected a direction everywhere; it is ({}) at {shown}", ["0"; D].join(", "))
        };
        Some(CaseError { message, ..self.not_finite(space, &key, data, found) })
    }

    /// The mistake behind data that turned out not to be finite in the course of a computation.
    pub fn blame_data<const D: usize>(&self, space: &FsiSpace<D>, fault: &DataFault) -> Error {
        let at: [f64; D] = std::array::from_fn(|d| fault.at[d]);
        let is_wrong = |data: &[Expression]| !is_finite(&values(data, &at, fault.time));
        let of_condition = |name: &str, condition: &Condition| {
            let (key, data) = condition.expressions().into_iter().find(|(_, data)| is_wrong(data))?;
            Some((data_key(name, key), data))
        };
        let data = match fault.kind {
            DataKind::Force { body, material } => {
                let mut loads = self.loads().into_iter();
                let found = loads.find(|load| load.body == body && load.material == material);
                found.map(|load| (load.key, load.force.to_vec()))
            }
            DataKind::Velocity { node } => {
                let here = |name: &str| space.boundary_nodes(name).contains(&node);
                let mut given = self.boundary.iter().filter(|(name, c)| c.is_given() && here(name));
                given.find_map(|(name, condition)| of_condition(name, condition))
            }
            DataKind::Elsewhere => None,
            DataKind::Condition { boundary } => {
                let name = &space.mesh.boundaries[usize::from(boundary)];
                self.boundary.get(name).and_then(|condition| of_condition(name, condition))
            }
        };
        let value =
            data.as_ref().map_or_else(|| fault.value.to_vec(), |(_, data)| values(data, &at, fault.time));
        let found = Found { at: at.to_vec(), time: fault.time, value };
        let error = match data {
            Some((key, data)) => self.not_finite(space, &key, &data, found),
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

    /// Whether a step takes the forces of its beginning, too.
    fn takes_old_forces(&self) -> bool {
        self.time.as_ref().is_none_or(|time| time.scheme.takes_old_forces())
    }

    /// Times \[s\] at which `data` are looked at.
    pub(super) fn times(&self, data: &[Expression], start: bool) -> Vec<f64> {
        let Some(time) = &self.time else { return vec![self.at_time] };
        if !data.iter().any(Expression::depends_on_time) {
            return vec![time.start];
        }
        let n = TIMES + 1;
        let of = |i: usize| time.start + (time.end - time.start) * i as f64 / n as f64;
        (0..=n).skip(usize::from(!start)).map(of).collect()
    }

    fn not_finite<const D: usize>(
        &self,
        space: &FsiSpace<D>,
        key: &str,
        data: &[Expression],
        found: Found,
    ) -> CaseError {
        let in_time = data.iter().any(Expression::depends_on_time);
        CaseError {
            place: self.place_of(key),
            key: key.into(),
            value: Some(match data {
                [one] => text(one),
                all => format!("[{}]", all.iter().map(text).collect::<Vec<_>>().join(", ")),
            }),
            message: found.message(self, space, in_time) + &found.gap(data),
        }
    }
}

/// A value that is not finite.
struct Found {
    at: Vec<f64>,
    time: f64,
    value: Vec<f64>,
}

impl Found {
    /// Which table has no value there, if one has none.
    fn gap(&self, data: &[Expression]) -> String {
        let wrong = data.iter().zip(&self.value).find(|(_, value)| !value.is_finite());
        wrong.map_or(String::new(), |(data, _)| data.gap(&place(&self.at), self.time))
    }

    fn message<const D: usize>(&self, case: &Case, space: &FsiSpace<D>, in_time: bool) -> String {
        let value: Vec<String> = self.value.iter().map(|&x| shortest(rounded(x, x, 4))).collect();
        let value = if let [one] = &value[..] { one.clone() } else { format!("({})", value.join(", ")) };
        let mut message = format!(
            "expected finite values; it is {value} at {}",
            space.mesh.shown(&std::array::from_fn(|d| self.at[d]))
        );
        if in_time || case.time.is_some() {
            message += &format!(", t = {} s", shortest(self.time));
        }
        message
    }
}

/// The first value of `data` that is not finite.
fn find<const D: usize>(data: &[Expression], places: &[[f64; D]], times: &[f64]) -> Option<Found> {
    if data.iter().all(Expression::is_constant) {
        return None;
    }
    let stride = places.len().div_ceil(PLACES).max(1);
    times.iter().enumerate().find_map(|(i, &time)| {
        let mut some = places.iter().step_by(if i == 0 { 1 } else { stride });
        some.find_map(|&at| {
            let value = values(data, &at, time);
            (!is_finite(&value)).then_some(Found { at: at.to_vec(), time, value })
        })
    })
}

pub(super) fn values<const D: usize>(data: &[Expression], at: &[f64; D], time: f64) -> Vec<f64> {
    data.iter().map(|e| e.eval(&padded(at), time)).collect()
}

/// A position as expressions take it.
fn place(at: &[f64]) -> [f64; 3] {
    std::array::from_fn(|d| at.get(d).copied().unwrap_or(0.0))
}

fn has_direction(value: &[f64]) -> bool {
    is_finite(value) && value.iter().any(|x| *x != 0.0)
}

fn is_finite(value: &[f64]) -> bool {
    value.iter().all(|x| x.is_finite())
}

/// Nodes and centres of the cells `here`.
fn places<const D: usize>(space: &FsiSpace<D>, here: impl Fn(usize) -> bool) -> Vec<[f64; D]> {
    let cells = || (0..space.mesh.n_cells()).filter(|&c| here(c));
    let mut nodes: Vec<u32> = cells().flat_map(|c| space.nodes.cell(c).iter().copied()).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let points = nodes.iter().map(|&n| space.nodes.points[n as usize]);
    points.chain(cells().map(|c| space.mesh.centre(c))).collect()
}

fn data_key(name: &str, key: &str) -> String {
    format!("boundary.{name}.{key}")
}

/// An expression as in a case file.
fn text(e: &Expression) -> String {
    if e.source().parse::<f64>().is_ok() { e.source().into() } else { format!("\"{}\"", e.source()) }
}
