//! What a step of a case costs, and its parts, beside what the machine can do.
//!
//! ```no_run
//! # use undula::{bench, case::Case, run, simulation::Simulation};
//! let case = Case::load("out/fsi3/case.toml", &[])?;
//! let mut simulation = Simulation::new(case, 2)?;
//! run::restore_latest(&mut simulation, "out/fsi3")?;
//! println!("{}", bench::measure(&mut simulation, &bench::Options::default())?);
//! # Ok::<(), undula::error::Error>(())
//! ```

mod kernels;
mod machine;
mod matrices;
mod steps;
mod table;

#[doc(hidden)]
pub use kernels::measure as measure_kernels;
pub use kernels::{Kernels, Timing};
pub use machine::{Machine, Rates};
pub use matrices::write_matrices;
#[doc(hidden)]
pub use steps::Start;
pub use steps::{CyclePart, Parts, Spread, Steps};

use crate::error::Error;
use crate::output::{Unknowns, peak_memory, processor};
use crate::simulation::Simulation;
use serde::Serialize;

/// What is measured.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Steps of a repetition; 0: none.
    pub steps: usize,
    /// Repetitions, all from the same state.
    pub repeat: usize,
    /// Whether kernels are measured one by one.
    pub kernels: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options { steps: 200, repeat: 5, kernels: true }
    }
}

/// What was measured, and on what.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Version of this library.
    pub version: &'static str,
    /// Name of the processor, where the system tells.
    pub processor: Option<String>,
    /// Threads.
    pub threads: usize,
    /// Cells side by side in a vector register.
    pub lanes: usize,
    /// Name of the case.
    pub case: String,
    /// Number of cells.
    pub cells: usize,
    /// Number of unknowns by field.
    pub unknowns: Unknowns,
    /// Time scheme, as in case files.
    pub scheme: String,
    /// Step k at the start \[s\].
    pub step: f64,
    /// Linearisation, as in case files.
    pub linearization: String,
    /// Linear solver, as in case files.
    pub solver: String,
    /// Precision of the factors, as in case files.
    pub precision: String,
    /// All settings of Newton's method, as in case files.
    pub newton: toml::Table,
    /// All settings of the linear solver, as in case files.
    pub linear: toml::Table,
    /// Steps; `None` if not asked for.
    pub steps: Option<Steps>,
    /// Kernels; `None` if not asked for.
    pub kernels: Option<Kernels>,
    /// The machine in the same minute.
    pub machine: Machine,
    /// Largest resident memory up to the end of the steps \[B\], where the system tells.
    pub peak_memory_bytes: Option<u64>,
}

/// Measure `simulation` from the state it is in, and leave it there; time may pass the end of its case.
///
/// # Errors
/// [`Error::Stationary`] without time steps, [`Error::Breakdown`], or if a matrix cannot be factorised.
pub fn measure<const D: usize>(simulation: &mut Simulation<D>, options: &Options) -> Result<Report, Error> {
    let name = simulation.case.name.clone();
    let time = simulation.case.time.as_mut().ok_or(Error::Stationary(name))?;
    let end = std::mem::replace(&mut time.end, f64::MAX);
    let start = Start::of(simulation);
    let steps = match options.steps {
        0 => None,
        n => Some(steps::measure(simulation, &start, n, options.repeat.max(1))?),
    };
    let peak_memory_bytes = peak_memory();
    let machine = simulation.install(|s| Machine::measure(s.threads()));
    start.restore(simulation)?;
    let step = start.step_length(simulation);
    let kernels =
        if options.kernels { Some(simulation.install(|s| kernels::measure(s, step))?) } else { None };
    // The kernels have replaced what the kept Jacobian needs.
    start.restore(simulation)?;
    if let Some(time) = &mut simulation.case.time {
        time.end = end;
    }
    Ok(describe(simulation, step, steps, kernels, machine, peak_memory_bytes))
}

fn describe<const D: usize>(
    simulation: &Simulation<D>,
    step: f64,
    steps: Option<Steps>,
    kernels: Option<Kernels>,
    machine: Machine,
    peak_memory_bytes: Option<u64>,
) -> Report {
    let case = &simulation.case;
    // The words of case files are those of the case written out.
    let written: toml::Table = case.to_toml().parse().unwrap_or_default();
    let table = |name: &str| written.get(name).and_then(toml::Value::as_table).cloned().unwrap_or_default();
    let word = |section: &str, key: &str| -> String {
        table(section).get(key).and_then(toml::Value::as_str).unwrap_or_default().into()
    };
    Report {
        version: env!("CARGO_PKG_VERSION"),
        processor: processor(),
        threads: simulation.threads(),
        lanes: crate::system::best_lanes(),
        case: case.name.clone(),
        cells: simulation.stepper.assembler.space.mesh.n_cells(),
        unknowns: simulation.unknowns(),
        scheme: word("time", "scheme"),
        step,
        linearization: word("newton", "linearization"),
        solver: word("linear", "solver"),
        precision: word("linear", "precision"),
        newton: table("newton"),
        linear: table("linear"),
        steps,
        kernels,
        machine,
        peak_memory_bytes,
    }
}

/// The middle one of `values`; NaN if there is none.
fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// The value below which the part `q` of `values` lies; NaN if there is none.
fn quantile(values: &[f64], q: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = (q * sorted.len() as f64) as usize;
    sorted.get(at.min(sorted.len().saturating_sub(1))).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!((quantile(&[3.0, 1.0, 2.0], 0.0), quantile(&[3.0, 1.0, 2.0], 1.0)), (1.0, 3.0));
        assert!(median(&[]).is_nan());
    }
}
