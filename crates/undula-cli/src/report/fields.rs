//! The fields of a run for the player: moments, quantities, and what they are drawn on.

use super::arrays::{film, size};
use super::layer::{Layer, between};
use super::quantity::Quantity;
use super::space;
use crate::plot::solid_cells;
use serde_json::{Value, json};
use undula::output::{Collection, FieldSnapshot, RunDirectory, read_vtu};

/// Bytes of all moments before they are deflated.
const RAW: usize = 10 << 20;

/// Characters of all fields within a page.
const LONGEST: usize = 9_000_000;

/// More moments than these are not worth the room.
const MOMENTS: usize = 400;

/// Points of fields that are too large for a page.
const POINTS: usize = 700_000;

/// Some moments of a run.
pub struct Film {
    /// Times \[s\].
    pub times: Vec<f64>,
    /// Fields at these times, all on straight cells and on the same ones.
    pub moments: Vec<FieldSnapshot>,
    /// Moments that the run has written.
    pub written: usize,
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

/// The fields of the run in `run`, of as many of its moments as a page has room for.
///
/// # Errors
/// If a file cannot be read.
pub fn scene(run: &RunDirectory) -> anyhow::Result<Scene> {
    if !run.collection().is_file() {
        return Ok(Scene::None);
    }
    let collection = Collection::read(run.collection())?;
    let Some((_, last)) = collection.entries().last() else { return Ok(Scene::None) };
    let last = read_vtu(collection.resolve(last))?.0.linear_cells();
    let points = last.points.len();
    if points > POINTS {
        let limit = format!("a page has room for {POINTS}");
        return Ok(Scene::TooLarge(format!(
            "The fields have {points} points, {limit}: ParaView shows them."
        )));
    }
    let solid = solid_cells(&last);
    let layers = match last.kind.dim() {
        2 => vec![Layer::plane(&last, &solid)],
        _ => space::layers(&last, &solid),
    };
    let shown: usize = layers.iter().map(|layer| layer.points.len()).sum();
    let numbers: usize = Quantity::all(&last).iter().map(|quantity| quantity.components.len()).sum();
    let room = RAW / (2 * shown * (numbers + 1)).max(1);
    let film = Film::read(&collection, last, room.clamp(1, MOMENTS))?;
    fitted(film, &layers)
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
    /// At most `count` moments of `collection`, whose last one is `last`.
    fn read(collection: &Collection, last: FieldSnapshot, count: usize) -> anyhow::Result<Film> {
        let entries = collection.entries();
        let mut film = Film { times: vec![], moments: vec![], written: entries.len() };
        for n in spread(entries.len(), count) {
            let (time, file) = &entries[n];
            let moment = match n + 1 == entries.len() {
                true => last.clone(),
                false => read_vtu(collection.resolve(file))?.0.linear_cells(),
            };
            // A run that goes on with another case may have other cells; its last ones count.
            if moment.cells == last.cells && names(&moment) == names(&last) {
                film.times.push(*time);
                film.moments.push(moment);
            }
        }
        Ok(film)
    }

    /// All for the player.
    fn to_json(&self, layers: &[Layer]) -> anyhow::Result<Value> {
        let first = &self.moments[0];
        let dim = first.kind.dim();
        let base = self.base();
        let quantities = Quantity::all(first);
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
        for (about, quantity) in about.iter_mut().zip(&quantities) {
            let (factor, unit) = self.readable(quantity);
            about["factor"] = json!(factor);
            about["unit"] = json!(unit);
        }
        Ok(json!({
            "dimension": dim, "times": self.times, "written": self.written,
            "quantities": about, "moves": moves, "layers": drawn,
        }))
    }

    /// The positions \[m\] that `deformation` moves, where there is one; else those of the first moment.
    fn base(&self) -> Vec<[f64; 3]> {
        let first = &self.moments[0];
        let Some(u) = first.at_points("deformation") else { return first.points.clone() };
        // Files with a mesh that is not deformed have the same points at all times.
        if self.moments.len() > 1 && self.moments.iter().all(|moment| moment.points == first.points) {
            return first.points.clone();
        }
        let moved = |(n, x): (usize, &[f64; 3])| {
            let at = |d: usize| u.values.get(u.components * n + d).filter(|_| d < u.components);
            std::array::from_fn(|d| x[d] - at(d).copied().unwrap_or(0.0))
        };
        first.points.iter().enumerate().map(moved).collect()
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
