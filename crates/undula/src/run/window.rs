//! Means over a window of time, `output.window`.

use super::fields::snapshot;
use crate::functional::averages::{Averages, oscillatory_shear_index};
use crate::functional::fields::nodal_pressure;
use crate::functional::nodal::WallShear;
use crate::output::{Array, Checkpoint, Field, FieldSnapshot};
use crate::simulation::Simulation;
use crate::space::{Region, State};

/// Times that differ by this part of the window are one.
const SLACK: f64 = 1e-9;

/// Names of the arrays of a checkpoint.
const ARRAYS: [&str; 3] = ["window_weight", "window_mean", "window_squares"];

/// Means of the fields at the nodes over the steps that lie in a window of time.
///
/// A step of length k counts with k; v, u and the wall shear stress with the trapezoidal rule, the pressure, which
/// belongs to the step, as it is.
pub(super) struct Window<const D: usize> {
    /// First and last time \[s\].
    times: [f64; 2],
    averages: Averages,
    shear: WallShear<D>,
    /// What was there at the end of the last step.
    last: Sample,
}

/// `[v, u, τ, |τ|, p]` at the nodes, `[D, D, D, 1, 1]` numbers for each.
struct Sample {
    time: f64,
    values: Vec<f64>,
}

impl<const D: usize> Window<D> {
    /// Where |τ| and p begin, and the numbers of all, as multiples of the number of nodes.
    const MAGNITUDE: usize = 3 * D;
    const PRESSURE: usize = 3 * D + 1;
    const ALL: usize = 3 * D + 2;

    /// Of a simulation whose case has one; it begins with its present state.
    pub fn new(simulation: &Simulation<D>) -> Option<Window<D>> {
        let times = simulation.case.output.window.filter(|_| simulation.case.time.is_some())?;
        let space = &simulation.stepper.assembler.space;
        let shear = WallShear::new(space, &simulation.case.smooth());
        let last = sample(simulation, &shear);
        Some(Window { times, averages: Averages::new(Self::ALL * space.nodes.n_lagrange), shear, last })
    }

    /// Look at the end of a step.
    pub fn observe(&mut self, simulation: &Simulation<D>) {
        let now = simulation.time();
        let [start, end] = self.times;
        let (k, slack) = (now - self.last.time, SLACK * (end - start));
        if now < start - slack || self.last.time > end {
            self.last.time = now;
            return;
        }
        let new = sample(simulation, &self.shear);
        if self.last.time >= start - slack && now <= end + slack {
            let at = Self::PRESSURE * (new.values.len() / Self::ALL);
            self.last.values[at..].copy_from_slice(&new.values[at..]);
            self.averages.add(&self.last.values, 0.5 * k);
            self.averages.add(&new.values, 0.5 * k);
        }
        self.last = new;
    }

    /// Put the sums into a checkpoint.
    pub fn save(&self, checkpoint: &mut Checkpoint) {
        let Averages { weight, mean, squares } = &self.averages;
        for (name, values) in ARRAYS.into_iter().zip([&vec![*weight], mean, squares]) {
            checkpoint.arrays.insert(name.into(), Array::F64(values.clone()));
        }
    }

    /// Go on from the sums of a checkpoint, if it has them.
    pub fn restore(&mut self, checkpoint: &Checkpoint) {
        let [weight, mean, squares] = ARRAYS.map(|name| checkpoint.f64s(name).unwrap_or_default());
        let n = self.averages.mean.len();
        if let ([weight], true) = (weight, mean.len() == n && squares.len() == n) {
            self.averages = Averages { weight: *weight, mean: mean.to_vec(), squares: squares.to_vec() };
        }
    }

    /// Means and deviations on the mesh at the mean displacement; `None` if no step lies in the window.
    pub fn fields(&self, simulation: &Simulation<D>) -> Option<FieldSnapshot> {
        if self.averages.weight <= 0.0 {
            return None;
        }
        let space = &simulation.stepper.assembler.space;
        let n = space.nodes.n_lagrange;
        let (mean, rms) = (&self.averages.mean, self.averages.rms());
        let mut state = State::zero(space.n_v(), space.n_u(), space.n_p());
        if space.deforms {
            state.u[..D * n].copy_from_slice(&mean[D * n..2 * D * n]);
        }
        let output = &simulation.case.output;
        let mut fields = snapshot(space, &state, output.deformed);
        let list = |from: usize, components: usize, values: &[f64]| {
            space.at_places(&values[from * n..(from + components) * n], components)
        };
        let (tau, magnitude) = (list(2 * D, D, mean), list(Self::MAGNITUDE, 1, mean));
        let index =
            tau.chunks_exact(D).zip(&magnitude).map(|(tau, &size)| oscillatory_shear_index(tau, size));
        fields.point_data = vec![
            Field::new("mean-velocity", D, list(0, D, mean)),
            Field::new("rms-velocity", D, list(0, D, &rms)),
        ];
        if space.deforms {
            fields.point_data.push(Field::new("mean-deformation", D, list(D, D, mean)));
            fields.point_data.push(Field::new("rms-deformation", D, list(D, D, &rms)));
        }
        if !simulation.case.fluids.is_empty() {
            fields.point_data.extend([
                Field::new("mean-pressure", 1, list(Self::PRESSURE, 1, mean)),
                Field::new("rms-pressure", 1, list(Self::PRESSURE, 1, &rms)),
                Field::new("mean-wall-shear-stress", D, tau.clone()),
                Field::new("mean-wall-shear-magnitude", 1, magnitude.clone()),
                Field::new("oscillatory-shear-index", 1, index.collect()),
            ]);
        }
        Some(if output.curved { fields } else { fields.linear() })
    }

    /// Middle of the window \[s\].
    pub fn time(&self) -> f64 {
        0.5 * (self.times[0] + self.times[1])
    }
}

/// The present fields at the nodes.
fn sample<const D: usize>(simulation: &Simulation<D>, shear: &WallShear<D>) -> Sample {
    let (assembler, state) = (&simulation.stepper.assembler, &simulation.stepper.new);
    let space = &assembler.space;
    let n = space.nodes.n_lagrange;
    let mut values = state.v[..D * n].to_vec();
    match state.u.get(..D * n) {
        Some(u) => values.extend(u),
        None => values.resize(2 * D * n, 0.0),
    }
    let tau = shear.at_nodes(space, &assembler.physics, state);
    values.extend(&tau);
    values.extend(tau.chunks_exact(D).map(|tau| tau.iter().map(|t| t * t).sum::<f64>().sqrt()));
    values.extend(nodal_pressure(space, state, Region::Fluid).into_iter().map(|p| p.unwrap_or(0.0)));
    Sample { time: simulation.time(), values }
}
