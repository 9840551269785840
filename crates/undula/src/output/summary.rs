//! `summary.json`: what a run was and what came out of it.

use super::{OutputError, Provenance, write_atomic};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::io::Write;
use std::path::Path;

/// Content of `summary.json`. Numbers that are not finite are written as `null` and read as NaN; what is missing is
/// read as its default.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Summary {
    /// How the run ended, or that it has not.
    pub status: Status,
    /// Name of the case.
    pub case: String,
    /// What the run began with; `None`: at rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<String>,
    /// Number of cells.
    pub cells: usize,
    /// Number of unknowns by field.
    pub unknowns: Unknowns,
    /// Time steps done.
    pub steps: u64,
    /// Steps that step-size control rejected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rejected_steps: Option<u64>,
    /// Newton iterations, summed over all steps.
    pub newton_steps: u64,
    /// Jacobians assembled.
    pub jacobians: u64,
    /// Factorizations of the matrix.
    pub factorizations: u64,
    /// Iterations of the linear solver: how often factors, or a cycle of multigrid, were applied.
    pub linear_iterations: u64,
    /// Steps that were begun anew with the whole Jacobian and a direct solver.
    pub direct_fallbacks: u64,
    /// Unknowns of the largest system that is factorised as a whole: with multigrid that of the coarsest level.
    #[serde(default)]
    pub largest_factor_unknowns: usize,
    /// Threads used, by each process.
    pub threads: usize,
    /// What each process has had to do, where several share the mesh.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ranks: Vec<RankSummary>,
    /// Processes, where there are several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub processes: Option<usize>,
    /// What has solved the linear systems, such as `PETSc 3.18.5 with Open MPI v4.1.4`, where it is not Undula.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub engine: Option<String>,
    /// Elapsed time \[s\].
    #[serde(with = "nullable")]
    pub wall_seconds: f64,
    /// Processor time of the process, of all that share the mesh, since the run began, or was resumed \[s\], where the system tells: with that of
    /// other runs of the process at the same time.
    pub cpu_seconds: Option<f64>,
    /// Where it went.
    pub phases: Phases,
    /// Largest resident memory \[B\], where the system tells.
    pub peak_memory_bytes: Option<u64>,
    /// Largest net flow through the boundaries of the fluid, relative to the largest flow; `None` where nothing
    /// crosses them.
    #[serde(default, with = "optional")]
    pub mass_balance: Option<f64>,
    /// Largest difference in a step between the change of the fluid's volume and what the flow at the interface
    /// sweeps, relative to the largest flow; `None` where nothing moves.
    #[serde(default, with = "optional")]
    pub swept_volume: Option<f64>,
    /// Statistics by functional.
    pub functionals: BTreeMap<String, FunctionalSummary>,
    /// Why it broke down.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub breakdown: Option<Breakdown>,
    /// Which program computed it, when, on which processor, from which input.
    #[serde(flatten)]
    pub provenance: Provenance,
}

impl Summary {
    /// Above this [`Summary::mass_balance`] something is wrong with the run.
    pub const BALANCED: f64 = 1e-6;
}

/// How a run ended.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Not yet, or the process was killed.
    #[default]
    Running,
    /// As the case asked.
    Completed,
    /// The solution could not be continued: cells degenerate or Newton's method fails at any step size.
    Breakdown,
    /// By an error.
    Failed,
    /// By the user.
    Interrupted,
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Status::Running => "running",
            Status::Completed => "completed",
            Status::Breakdown => "breakdown",
            Status::Failed => "failed",
            Status::Interrupted => "interrupted",
        })
    }
}

/// The part of one of several processes in a run.
#[derive(Copy, Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct RankSummary {
    /// Cells that it counts.
    pub cells: usize,
    /// Copies of cells of others.
    pub copies: usize,
    /// Largest resident memory \[B\], and what it was before there was a mesh.
    pub peak_memory_bytes: u64,
    pub base_memory_bytes: u64,
    /// Processor time \[s\].
    #[serde(with = "nullable")]
    pub cpu_seconds: f64,
    /// Time for residuals and matrices \[s\].
    #[serde(with = "nullable")]
    pub assembly_seconds: f64,
    /// Time in calls of MPI but for those of PETSc \[s\].
    #[serde(with = "nullable")]
    pub waiting_seconds: f64,
    /// Bytes that it sent for copies of unknowns, and in how many messages, but for those of PETSc.
    pub sent_bytes: u64,
    pub sent_messages: u64,
}

/// Number of unknowns by field.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Unknowns {
    /// v.
    pub velocity: usize,
    /// u.
    pub deformation: usize,
    /// p.
    pub pressure: usize,
    /// All.
    pub total: usize,
}

/// Elapsed time by phase \[s\].
#[derive(Copy, Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Phases {
    /// Residuals and matrices.
    #[serde(with = "nullable")]
    pub assembly: f64,
    /// Factorizations.
    #[serde(with = "nullable")]
    pub factorization: f64,
    /// Triangular solves.
    #[serde(with = "nullable")]
    pub solve: f64,
    /// Files.
    #[serde(with = "nullable")]
    pub output: f64,
}

/// One functional in numbers, all in `unit` except the frequency.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct FunctionalSummary {
    /// Last value.
    #[serde(with = "nullable")]
    pub last: f64,
    /// (max + min)/2 over the last period of the leading signal; `None` where steady or not periodic.
    #[serde(with = "optional")]
    pub mean: Option<f64>,
    /// (max − min)/2 over the last period of the leading signal; `None` where steady or not periodic.
    #[serde(with = "optional")]
    pub amplitude: Option<f64>,
    /// \[Hz\]; `None` where steady or not periodic.
    #[serde(with = "optional")]
    pub frequency: Option<f64>,
    /// Such as `N/m`; empty for a pure number.
    pub unit: String,
}

/// Where and why a run broke down.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Breakdown {
    /// Time of the step that failed \[s\].
    #[serde(with = "nullable")]
    pub time: f64,
    /// Smallest det F of that step.
    #[serde(rename = "min_J", with = "nullable")]
    pub min_j: f64,
    /// Where it occurs, for people.
    pub r#where: String,
    /// What happened, a sentence for people.
    pub reason: String,
    /// Its cause, a word for programs: `folding`, `divergence`, `slow`, `singular`, `not-finite`, `solver`.
    #[serde(default)]
    pub cause: String,
    /// What to try, for people; empty where nothing is known.
    #[serde(default)]
    pub remedy: String,
}

impl Summary {
    /// Writes the file, atomically.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), OutputError> {
        write_atomic(path, |file| {
            serde_json::to_writer_pretty(&mut *file, self)?;
            file.write_all(b"\n")
        })
    }

    /// Reads the file.
    ///
    /// # Errors
    /// [`OutputError::Io`], [`OutputError::Format`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, OutputError> {
        let path = path.as_ref();
        let text = fs::read_to_string(path).map_err(OutputError::io("read", path))?;
        let wrong = |e: serde_json::Error| OutputError::format(path, e.to_string());
        let value: serde_json::Value = serde_json::from_str(&text).map_err(wrong)?;
        if value.get("status").is_none() {
            return Err(OutputError::format(path, "it has no `status`, so it is not that of a run"));
        }
        serde_json::from_value(value).map_err(wrong)
    }
}

/// Largest resident memory of this process \[B\]; known on Linux only.
pub fn peak_memory() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

/// Units in which Linux tells programs their processor time, in a second.
const TICKS: f64 = 100.0;

/// Processor time of this process \[s\]; known on Linux only.
pub fn processor_seconds() -> Option<f64> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    let (_, fields) = stat.rsplit_once(')')?;
    let ticks = |n: usize| fields.split_whitespace().nth(n)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / TICKS)
}

/// A number that is `null` in the file where it is not finite.
mod nullable {
    use super::*;

    pub fn serialize<S: Serializer>(x: &f64, to: S) -> Result<S::Ok, S::Error> {
        optional::serialize(&Some(*x), to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
        Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::NAN))
    }
}

/// A number that may be missing, and is where it is not finite.
mod optional {
    use super::*;

    pub fn serialize<S: Serializer>(x: &Option<f64>, to: S) -> Result<S::Ok, S::Error> {
        x.filter(|x| x.is_finite()).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
        Option::<f64>::deserialize(from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::testing::scratch;

    fn example() -> Summary {
        let uy = FunctionalSummary {
            last: 0.1 + 0.2,
            mean: Some(1.0 / 3.0),
            amplitude: Some(f64::NAN),
            frequency: None,
            unit: "m".into(),
        };
        let breakdown = Breakdown { time: 4.8, min_j: f64::NEG_INFINITY, ..Breakdown::default() };
        Summary {
            status: Status::Breakdown,
            case: "fsi3".into(),
            wall_seconds: f64::INFINITY,
            peak_memory_bytes: peak_memory(),
            functionals: [("uy_A".to_string(), uy)].into(),
            breakdown: Some(breakdown),
            ..Summary::default()
        }
    }

    #[test]
    fn numbers_survive_and_those_not_finite_become_null() {
        let directory = scratch("summary");
        let path = directory.join("summary.json");
        let written = example();
        written.write(&path).unwrap();
        let read = Summary::read(&path).unwrap();
        let uy = &read.functionals["uy_A"];
        assert_eq!((uy.last, uy.mean, uy.amplitude), (0.1 + 0.2, Some(1.0 / 3.0), None));
        assert!(read.wall_seconds.is_nan() && read.breakdown.as_ref().unwrap().min_j.is_nan());
        let text = fs::read_to_string(&path).unwrap();
        for expected in
            ["\"status\": \"breakdown\"", "\"amplitude\": null", "\"min_J\": null", "\"where\": \"\""]
        {
            assert!(text.contains(expected), "{expected} in {text}");
        }
        assert!(!text.contains("NaN") && !text.contains("inf"));
    }

    #[test]
    fn the_keys_are_the_contract() {
        let value = serde_json::to_value(Summary::default()).unwrap();
        let keys: Vec<_> = value.as_object().unwrap().keys().map(String::as_str).collect();
        let mut contract = "status case cells unknowns steps newton_steps jacobians factorizations threads \
            wall_seconds cpu_seconds linear_iterations direct_fallbacks largest_factor_unknowns phases peak_memory_bytes mass_balance swept_volume functionals version commit date \
            processor case_hash mesh_hash"
            .split_whitespace()
            .collect::<Vec<_>>();
        contract.sort();
        assert_eq!(keys, contract);
        assert_eq!(value["status"], "running");
    }

    #[test]
    fn something_else_is_refused() {
        let directory = scratch("summary-else");
        let path = directory.join("summary.json");
        fs::write(&path, "{\"status\": \"great\"}").unwrap();
        assert!(Summary::read(&path).unwrap_err().to_string().contains("summary.json: unknown variant"));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn memory_is_known() {
        assert!(peak_memory().unwrap() > 100_000);
        assert!(processor_seconds().unwrap() >= 0.0);
    }
}
