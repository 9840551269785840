//! What boundary conditions mean to nodes of the solid: velocity data there must vanish, and where the solid is clamped
//! though its own conditions leave it free a note says so.

use super::functions::padded;
use crate::case::error::{CaseError, CaseErrors};
use crate::case::expression::Expression;
use crate::case::{Case, Condition, TimeSpec};
use crate::space::ends::{EndKind, ends};
use crate::space::{FsiSpace, PsiOwner, Region};

/// Steps at most at which data are looked at one by one; of more, as many instants of the same distance.
const INSTANTS: f64 = 2000.0;

/// Speed relative to the largest of the boundary that counts as 0: coordinates in mesh files are rounded.
const VANISHES: f64 = 1e-6;

/// Points that a note names at most.
const NAMED: usize = 4;

/// The largest speed of data on some nodes.
struct Largest {
    speed: f64,
    velocity: Vec<f64>,
    /// Its place in words.
    place: String,
    time: f64,
}

#[doc(hidden)]
impl Case {
    /// Refuses velocity data that would move the solid.
    pub(super) fn check_ends<const D: usize>(&self, space: &FsiSpace<D>) -> Result<(), CaseErrors> {
        let mut errors = vec![];
        for name in self.boundary.keys() {
            let nodes = self.driven(space, name, false);
            if let Some(found) = self.moving(space, name, &nodes) {
                let message = format!(
                    "the velocity is {} m/s at {}{}, a node of the solid, which does not move there: \
                     expected data that are 0 on the solid, or names of their own for the boundaries of fluid and solid",
                    vector(&found.velocity),
                    found.place,
                    self.when(found.time)
                );
                let key = format!("{}.velocity", crate::case::key::join("boundary", name));
                errors.push(CaseError { place: self.place_of(&key), key, value: None, message });
            }
        }
        if errors.is_empty() { Ok(()) } else { Err(CaseErrors(errors)) }
    }

    /// Where the solid is clamped by a condition of the fluid, and which outlets move.
    ///
    /// Empty without fluid or solid.
    pub fn notes_on<const D: usize>(&self, space: &FsiSpace<D>) -> Vec<String> {
        let mut notes = vec![];
        let ends = ends(space, &self.conditions(&space.mesh));
        for (boundary, name) in space.mesh.boundaries.iter().enumerate() {
            for kind in [EndKind::Free, EndKind::Inflow, EndKind::Wall] {
                let here = ends.iter().filter(|end| (end.boundary as usize, end.kind) == (boundary, kind));
                let nodes: Vec<u32> = here.map(|end| end.node).collect();
                if !nodes.is_empty() {
                    notes.push(note(kind, name, &places(space, &nodes)));
                }
            }
            if self.clamps(space, name) {
                notes
                    .push(format!("boundary.{name}: the velocity is 0 on the solid, which is clamped there"));
            }
            let nodes = self.driven(space, name, true);
            if let Some(found) = self.moving(space, name, &nodes) {
                notes.push(format!(
                    "boundary.{name}: the velocity is {} m/s at {}{}, where the solid is held; \
                     0 is taken there",
                    vector(&found.velocity),
                    found.place,
                    self.when(found.time)
                ));
            }
        }
        notes
    }

    /// Whether facets of the solid have velocity data beside facets of the fluid.
    fn clamps<const D: usize>(&self, space: &FsiSpace<D>, name: &str) -> bool {
        let driven = matches!(self.boundary.get(name), Some(Condition::Velocity(_)));
        let solid = |cell: u32| space.regions[cell as usize] == Region::Solid;
        let boundary = space.mesh.boundary(name);
        driven && space.mesh.facets.iter().any(|f| Some(f.boundary) == boundary && solid(f.cell))
    }

    /// Nodes of the solid with velocity data on the boundary `name`: those that another condition fixes anyway, or
    /// the others.
    fn driven<const D: usize>(&self, space: &FsiSpace<D>, name: &str, fixed: bool) -> Vec<u32> {
        if !space.deforms || !matches!(self.boundary.get(name), Some(Condition::Velocity(_))) {
            return vec![];
        }
        let mut other = vec![false; space.nodes.len()];
        let fixes = |boundary: u16| {
            let condition = self.boundary.get(&space.mesh.boundaries[boundary as usize]);
            matches!(condition, Some(Condition::NoSlip | Condition::Clamped))
        };
        for facet in space.mesh.facets.iter().filter(|f| fixes(f.boundary)) {
            space.facet_nodes(facet).into_iter().for_each(|node| other[node as usize] = true);
        }
        let on_solid =
            |&node: &u32| space.owner[node as usize] == PsiOwner::Relation && other[node as usize] == fixed;
        space.boundary_nodes(name).into_iter().filter(on_solid).collect()
    }

    /// Where and when the velocity data of the boundary `name` are largest on `nodes`, if they do not vanish there.
    fn moving<const D: usize>(&self, space: &FsiSpace<D>, name: &str, nodes: &[u32]) -> Option<Largest> {
        let Some(Condition::Velocity(data)) = self.boundary.get(name) else { return None };
        let times = self.instants(data);
        let found = largest(space, data, nodes, &times)?;
        let coarse: Vec<f64> =
            times.iter().copied().step_by(times.len().div_ceil(20)).chain([found.time]).collect();
        let all = largest(space, data, &space.boundary_nodes(name), &coarse)?;
        (found.speed > VANISHES * all.speed).then_some(found)
    }

    /// Times at which `data` are looked at.
    fn instants(&self, data: &[Expression]) -> Vec<f64> {
        let Some(time) = self.time.as_ref().filter(|_| data.iter().any(Expression::depends_on_time)) else {
            return vec![self.time.as_ref().map_or(self.at_time, |time| time.start)];
        };
        let TimeSpec { start, end, .. } = *time;
        let steps = time.step.constant_value().map_or(INSTANTS, |k| ((end - start) / k).ceil());
        let n = if steps.is_finite() { steps.clamp(1.0, INSTANTS) } else { INSTANTS };
        (0..=n as usize).map(|i| start + (end - start) * i as f64 / n).collect()
    }

    /// ` at t = 0.2 s`; nothing for a stationary case.
    fn when(&self, time: f64) -> String {
        if self.time.is_some() { format!(" at t = {time} s") } else { String::new() }
    }
}

fn note(kind: EndKind, name: &str, places: &str) -> String {
    match kind {
        EndKind::Free => {
            format!("boundary.{name}: the solid ends free at {places}, and the outlet moves along with it")
        }
        EndKind::Inflow => {
            format!("boundary.{name} with given velocity ends at the solid: the solid is clamped at {places}")
        }
        EndKind::Wall => {
            format!(
                "boundary.{name} is a fixed wall that ends at the solid: the solid is clamped at {places}"
            )
        }
    }
}

/// The largest speed of `data` on `nodes` at `times`; `None` if there is none above 0.
fn largest<const D: usize>(space: &FsiSpace<D>, data: &[Expression], nodes: &[u32], times: &[f64]) -> Option<Largest> {
    let mut found: Option<Largest> = None;
    for &node in nodes {
        let point = space.nodes.points[node as usize];
        let x = padded(&point);
        for &time in times {
            let velocity: Vec<f64> = data.iter().map(|v| v.eval(&x, time)).collect();
            let speed = velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
            if speed > found.as_ref().map_or(0.0, |found| found.speed) {
                found = Some(Largest { speed, velocity, place: at(&point), time });
            }
        }
    }
    found
}

fn vector(v: &[f64]) -> String {
    format!("({})", v.iter().map(|v| format!("{v:.4e}")).collect::<Vec<_>>().join(", "))
}

fn at<const D: usize>(point: &[f64; D]) -> String {
    format!("({})", point.map(|x| format!("{x:.6}")).join(", "))
}

/// The places of `nodes` in words.
fn places<const D: usize>(space: &FsiSpace<D>, nodes: &[u32]) -> String {
    let shown = nodes.iter().take(NAMED).map(|&node| at(&space.nodes.points[node as usize]));
    let shown = shown.collect::<Vec<_>>().join(", ");
    match nodes.len() {
        n if n > NAMED => format!("{shown} and {} more nodes", n - NAMED),
        _ => shown,
    }
}
