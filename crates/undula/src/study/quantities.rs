//! What a study computes besides histories of runs.

use crate::case::Case;
use crate::error::Error;
use crate::modes;
use crate::simulation::Simulation;
use crate::verification::matrix::{COLUMNS, ROWS, portrait};
use crate::verification::newmark::newmark;
use crate::verification::stability::{conditions, constants};
use crate::verification::unit_square::errors;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Numbers by name.
pub type Numbers = BTreeMap<String, f64>;

/// What is computed of a case.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Compute {
    /// A run.
    #[default]
    Run,
    /// The lowest eigenfrequencies of its solid, as `undula modes`.
    Modes,
    /// The errors of a known solution on the unit square or cube.
    Errors,
    /// The largest difference of Newmark's method from the Crank-Nicolson scheme.
    Newmark,
}

/// What is computed of the last state of a run.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Also {
    /// The inf-sup constants (5.24) and (5.25).
    InfSup,
    /// The coupled matrix (5.35).
    Matrix,
}

/// Modes of each kind.
const MODES: usize = 40;

fn named<const N: usize>(pairs: [(&str, f64); N]) -> Numbers {
    pairs.into_iter().map(|(name, number)| (name.to_string(), number)).collect()
}

/// `numbers` with NaN for those of `names` that are missing.
fn complete(names: Vec<String>, mut numbers: Numbers) -> Numbers {
    for name in names {
        numbers.entry(name).or_insert(f64::NAN);
    }
    numbers
}

fn owned<const N: usize>(names: [&str; N]) -> Vec<String> {
    names.map(String::from).into()
}

impl Compute {
    /// Names of its numbers; a run has those of `known`.
    pub fn names(self) -> Vec<String> {
        match self {
            Compute::Run => vec![],
            Compute::Modes => {
                let of = |kind: &str| (1..=MODES).map(|n| format!("{kind}_{n}")).collect::<Vec<_>>();
                [of("vacuum"), of("fluid")].concat()
            }
            Compute::Errors => owned(["error_v", "error_u", "error_p", "size"]),
            Compute::Newmark => owned(["difference", "count"]),
        }
    }

    /// Its numbers; NaN where the case does not have one of them.
    ///
    /// # Errors
    /// A case that has none, or that cannot be computed.
    pub fn numbers(self, case: &Case, threads: usize) -> Result<Numbers, Error> {
        Ok(complete(self.names(), self.found(case, threads)?))
    }

    /// What stands for the numbers of a computation that failed.
    pub(super) fn without_numbers(self) -> Numbers {
        complete(self.names(), Numbers::new())
    }

    fn found(self, case: &Case, threads: usize) -> Result<Numbers, Error> {
        Ok(match self {
            Compute::Run => Numbers::new(),
            Compute::Modes => {
                let (_, modes) = modes::of_case(case, MODES, threads)?;
                let with_fluid = modes.with_fluid.unwrap_or_default();
                let of = |kind: &'static str, modes: Vec<modes::Mode>| {
                    let named =
                        |(n, mode): (usize, modes::Mode)| (format!("{kind}_{}", n + 1), mode.frequency);
                    modes.into_iter().enumerate().map(named).collect::<Vec<_>>()
                };
                [of("vacuum", modes.vacuum), of("fluid", with_fluid)].concat().into_iter().collect()
            }
            Compute::Errors => {
                let found = errors(case)?;
                let size = found.unknowns as f64;
                named([("error_v", found.v), ("error_u", found.u), ("error_p", found.p), ("size", size)])
            }
            Compute::Newmark => {
                let beside = newmark(case, threads)?;
                named([("difference", beside.difference), ("count", beside.steps as f64)])
            }
        })
    }
}

impl Also {
    /// Names of its numbers.
    pub fn names(self) -> Vec<String> {
        match self {
            Also::InfSup => owned(["inf_sup", "inf_sup_moved", "present_J"]),
            Also::Matrix => {
                let plain =
                    ["condition", "condition_scaled", "asymmetry", "zero_diagonal", "dominant", "lu_error"];
                let rows =
                    ROWS.iter().flat_map(|row| COLUMNS.map(|column| format!("entries_{row}_{column}")));
                let columns = COLUMNS.iter().map(|column| format!("unknowns_{column}"));
                owned(plain).into_iter().chain(rows).chain(columns).collect()
            }
        }
    }

    /// Its numbers at the present state of `simulation`; NaN where it does not have one of them.
    ///
    /// # Errors
    /// A matrix that cannot be factorised.
    pub fn numbers(self, simulation: &mut Simulation) -> Result<Numbers, Error> {
        Ok(complete(self.names(), self.found(simulation)?))
    }

    fn found(self, simulation: &mut Simulation) -> Result<Numbers, Error> {
        simulation.install(|simulation| match self {
            Also::InfSup => {
                let Some(found) = constants(simulation, true)? else { return Ok(Numbers::new()) };
                Ok(named([
                    ("inf_sup", found.reference.constant),
                    ("inf_sup_moved", found.moved.constant),
                    ("present_J", found.min_j),
                ]))
            }
            Also::Matrix => {
                let portrait = portrait(simulation)?;
                let mut numbers = named([
                    ("asymmetry", portrait.asymmetry),
                    ("zero_diagonal", portrait.zero_diagonal as f64),
                    ("dominant", portrait.dominant),
                    ("lu_error", portrait.plain_lu_error),
                ]);
                for (row, entries) in ROWS.iter().zip(portrait.entries) {
                    for (column, count) in COLUMNS.iter().zip(entries) {
                        numbers.insert(format!("entries_{row}_{column}"), count as f64);
                    }
                }
                for (column, count) in COLUMNS.iter().zip(portrait.unknowns) {
                    numbers.insert(format!("unknowns_{column}"), count as f64);
                }
                let coupled = conditions(simulation)?.into_iter().next();
                if let Some((_, condition)) = coupled {
                    numbers.extend(named([
                        ("condition", condition.plain),
                        ("condition_scaled", condition.scaled),
                    ]));
                }
                Ok(numbers)
            }
        })
    }
}
