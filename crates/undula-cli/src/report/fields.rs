//! The fields of a run for the player: moments, quantities, and what they are drawn on.

use super::arrays::{film, size};
use super::layer::{Layer, between};
use super::quantity::Quantity;
use super::space;
use crate::args::{Plane, say_notes};
use crate::plot::tetrahedra::read_fields;
use crate::plot::{NotDrawn, solid_cells};
use serde_json::{Value, json};
use undula::output::{Collection, Field, FieldSnapshot, RunDirectory};

/// Bytes of all moments before they are deflated.
const RAW: usize = 10 << 20;

/// Characters of all fields within a page.
const LONGEST: usize = 9_000_000;

/// More moments than these are not worth the room.
const MOMENTS: usize = 400;

/// Points that a page shows at most.
const POINTS: usize = 700_000;

/// Points of a mesh in space whose surface a page shows.
const LARGEST: usize = 5_000_000;

/// Points of all moments that are read, for which a second or two is enough.
const READ: usize = 10_000_000;

/// Some moments of a run.
struct Film {
    /// Times \[s\].
    times: Vec<f64>,
    /// Fields at these times, at the points that are shown.
    moments: Vec<FieldSnapshot>,
    /// Moments that the run has written.
    written: usize,
    quantities: Vec<Quantity>,
    /// Whether files have the points of the reference domain.
    reference: bool,
}

/// The fields of a run on a page.
pub enum Scene {
    /// The run has written none.
    None,
    /// They do not fit; in words.
    TooLarge(String),
    /// For the player, and in words what is left out.
    Shown(Value, Option<String>),
}

/// The fields of the run in `run`, of as many of its moments as a page has room for; `reference` says that its files have
/// the points of the reference domain. Fields in space are cut by `planes`.
///
/// # Errors
/// If a file cannot be read; [`NotDrawn`] for a plane that meets nothing.
pub fn scene(run: &RunDirectory, reference: bool, planes: &[Plane]) -> anyhow::Result<Scene> {
    if !run.collection().is_file() {
        return Ok(Scene::None);
    }
    let collection = Collection::read(run.collection())?;
    let Some((_, last)) = collection.entries().last() else { return Ok(Scene::None) };
    let last = read_fields(collection.resolve(last))?.linear_cells();
    let (points, dim) = (last.points.len(), last.kind.dim());
    let limit = if dim == 2 { POINTS } else { LARGEST };
    let too_large = |points: usize, limit: usize| {
        let text =
            format!("The fields have {points} points, a page has room for {limit}: ParaView shows them.");
        Ok(Scene::TooLarge(text))
    };
    if points > limit {
        return too_large(points, limit);
    }
    let solid = solid_cells(&last);
    // Cuts are made there, so that they do not depend on the moment.
    let still = FieldSnapshot { points: undeformed(&last, reference), ..last.clone() };
    if dim == 2 && !planes.is_empty() {
        say_notes(&["--cut has no effect: the run is one of two dimensions".into()]);
    }
    let mut layers = match dim {
        2 => vec![Layer::plane(&still, &solid)],
        _ => space::layers(&still, &solid, planes).map_err(NotDrawn)?,
    };
    let shown: usize = layers.iter().map(|layer| layer.points.len()).sum();
    if shown == 0 {
        return Ok(Scene::None);
    }
    if shown > POINTS {
        return too_large(shown, POINTS);
    }
    let used = used_points(&mut layers);
    let quantities = Quantity::all(&last);
    let numbers: usize = quantities.iter().map(|quantity| quantity.components.len()).sum();
    let room = (RAW / (2 * shown * (numbers + 1)).max(1)).min(READ / points.max(1));
    let (times, moments) = read(&collection, &last, &used, room.clamp(1, MOMENTS))?;
    let written = collection.entries().len();
    fitted(Film { times, moments, written, quantities, reference }, &layers)
}

/// The positions \[m\] that `deformation` moves, where there is one; else those of the points. Files of `reference` have them.
fn undeformed(snapshot: &FieldSnapshot, reference: bool) -> Vec<[f64; 3]> {
    let Some(u) = snapshot.at_points("deformation").filter(|_| !reference) else {
        return snapshot.points.clone();
    };
    let moved = |(n, x): (usize, &[f64; 3])| {
        let at = |d: usize| u.values.get(u.components * n + d).filter(|_| d < u.components);
        std::array::from_fn(|d| x[d] - at(d).copied().unwrap_or(0.0))
    };
    snapshot.points.iter().enumerate().map(moved).collect()
}

/// The points that `layers` lie between, in order; the layers then have numbers among these.
fn used_points(layers: &mut [Layer]) -> Vec<u32> {
    let mut used: Vec<u32> = layers.iter().flat_map(|l| l.points.iter().flat_map(|p| [p.0, p.1])).collect();
    used.sort_unstable();
    used.dedup();
    let number = |point: u32| used.binary_search(&point).unwrap_or(0) as u32;
    for point in layers.iter_mut().flat_map(|layer| &mut layer.points) {
        (point.0, point.1) = (number(point.0), number(point.1));
    }
    used
}

/// Times and fields of at most `count` moments of `collection`, whose last one is `last`, at the points that are `used`.
fn read(
    collection: &Collection,
    last: &FieldSnapshot,
    used: &[u32],
    count: usize,
) -> anyhow::Result<(Vec<f64>, Vec<FieldSnapshot>)> {
    let (entries, mut found) = (collection.entries(), (vec![], vec![]));
    for n in spread(entries.len(), count) {
        let (time, file) = &entries[n];
        if n + 1 == entries.len() {
            found.0.push(*time);
            found.1.push(at_points(last, used));
            continue;
        }
        let moment = read_fields(collection.resolve(file))?.linear_cells();
        // A run that goes on with another case may have other cells; its last ones count.
        if moment.cells == last.cells && names(&moment) == names(last) {
            found.0.push(*time);
            found.1.push(at_points(&moment, used));
        }
    }
    Ok(found)
}

/// Fields at some of the points, without cells.
fn at_points(snapshot: &FieldSnapshot, used: &[u32]) -> FieldSnapshot {
    let of = |field: &Field| {
        let n = field.components;
        let values = used.iter().flat_map(|&p| &field.values[n * p as usize..n * (p as usize + 1)]);
        Field::new(field.name.clone(), n, values.copied().collect())
    };
    FieldSnapshot {
        kind: snapshot.kind,
        degree: snapshot.degree,
        points: used.iter().map(|&p| snapshot.points[p as usize]).collect(),
        point_data: snapshot.point_data.iter().map(of).collect(),
        ..FieldSnapshot::default()
    }
}

/// Leaves moments out until all fits.
fn fitted(mut film: Film, layers: &[Layer]) -> anyhow::Result<Scene> {
    loop {
        let value = film.to_json(layers)?;
        let moments = film.moments.len();
        if size(&value) <= LONGEST || moments == 1 {
            let left = (moments < film.written).then(|| {
                format!(
                    "The player has {moments} of the {} moments that the run has written; ParaView shows all of \
                     fields.pvd.",
                    film.written
                )
            });
            return Ok(Scene::Shown(value, left));
        }
        let kept = spread(moments, moments.div_ceil(2));
        film.times = kept.iter().map(|&n| film.times[n]).collect();
        film.moments = kept.iter().map(|&n| std::mem::take(&mut film.moments[n])).collect();
    }
}

/// `count` of the numbers below `n`, the last one among them, and the first one if there are two.
fn spread(n: usize, count: usize) -> Vec<usize> {
    match count {
        1 => vec![n - 1],
        _ if count >= n => (0..n).collect(),
        _ => (0..count).map(|i| (i * (n - 1) + (count - 1) / 2) / (count - 1)).collect(),
    }
}

impl Film {
    /// All for the player.
    fn to_json(&self, layers: &[Layer]) -> anyhow::Result<Value> {
        let first = &self.moments[0];
        let dim = first.kind.dim();
        let base = undeformed(first, self.reference);
        let quantities = &self.quantities;
        let moves = quantities.iter().position(|quantity| quantity.name == "deformation");
        let mut drawn = vec![];
        for layer in layers {
            let mut value = layer.to_json(&base, dim)?;
            let films = quantities.iter().map(|quantity| self.films(layer, quantity));
            value["quantities"] = Value::Array(films.collect::<anyhow::Result<Vec<_>>>()?);
            if moves.is_none() {
                value["motion"] = self.motion(layer, &base, dim)?;
            }
            drawn.push(value);
        }
        let mut about: Vec<Value> = quantities.iter().map(Quantity::to_json).collect();
        for (about, quantity) in about.iter_mut().zip(quantities) {
            let (factor, unit) = self.readable(quantity);
            about["factor"] = json!(factor);
            about["unit"] = json!(unit);
        }
        Ok(json!({
            "dimension": dim, "times": self.times, "written": self.written,
            "quantities": about, "moves": moves, "layers": drawn,
        }))
    }

    /// How far the points of a layer are from `base`, by coordinate; `null` if they do not move.
    fn motion(&self, layer: &Layer, base: &[[f64; 3]], dim: usize) -> anyhow::Result<Value> {
        if self.moments.iter().all(|moment| moment.points == base) {
            return Ok(Value::Null);
        }
        let along = |d: usize| {
            let of = |moment: &FieldSnapshot| {
                let moved = |p: usize| moment.points[p][d] - base[p][d];
                layer.points.iter().map(|point| between(point, moved)).collect()
            };
            film(&self.moments.iter().map(of).collect::<Vec<_>>())
        };
        Ok(Value::Array((0..dim).map(along).collect::<anyhow::Result<Vec<_>>>()?))
    }

    /// A quantity on a layer, by component.
    fn films(&self, layer: &Layer, quantity: &Quantity) -> anyhow::Result<Value> {
        let component = |&(c, _): &(usize, String)| {
            let of = |moment: &FieldSnapshot| -> Vec<f64> {
                let field = &moment.point_data[quantity.field];
                let value = |p: usize| field.values[field.components * p + c];
                layer.points.iter().map(|point| between(point, value)).collect()
            };
            film(&self.moments.iter().map(of).collect::<Vec<_>>())
        };
        let films = quantity.components.iter().map(component).collect::<anyhow::Result<Vec<_>>>()?;
        Ok(Value::Array(films))
    }

    /// Factor and unit that make a quantity readable.
    fn readable(&self, quantity: &Quantity) -> (f64, String) {
        let values = self.moments.iter().flat_map(|moment| &moment.point_data[quantity.field].values);
        let size = values.filter(|x| x.is_finite()).fold(0.0_f64, |size, x| size.max(x.abs()));
        crate::plot::figure::readable(size, quantity.unit)
    }
}

/// Names of the fields at points.
fn names(snapshot: &FieldSnapshot) -> Vec<&str> {
    snapshot.point_data.iter().map(|field| field.name.as_str()).collect()
}

/// Straight cells.
trait Straight {
    /// The same with straight cells, whatever the cells are.
    fn linear_cells(self) -> FieldSnapshot;
}

impl Straight for FieldSnapshot {
    fn linear_cells(self) -> FieldSnapshot {
        if self.degree > 1 { self.linear() } else { self }
    }
}
