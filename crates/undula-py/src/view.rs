//! A simulation as a run shows it, whatever its dimension.

use undula::Error;
use undula::Simulation;
use undula::output::{Breakdown, FieldSnapshot, Status, Summary};
use undula::run::{Spent, summary_of, written_fields};

/// What is known of a run before its first step.
#[derive(Clone, Debug)]
pub struct Start {
    /// Names of the functionals.
    pub names: Vec<String>,
    /// Their units.
    pub units: Vec<String>,
    /// Cells of the mesh.
    pub cells: usize,
    /// Unknowns.
    pub unknowns: usize,
    /// Threads.
    pub threads: usize,
    /// Rows that a run has which goes on.
    pub rows: Vec<undula::Row>,
    /// What should be known.
    pub notes: Vec<String>,
}

/// The solution at one point.
#[derive(Clone, Debug)]
pub struct Point {
    pub is_solid: bool,
    pub velocity: Vec<f64>,
    pub velocity_gradient: Vec<Vec<f64>>,
    pub displacement: Vec<f64>,
    pub displacement_gradient: Vec<Vec<f64>>,
    pub pressure: f64,
}

/// A simulation between two steps.
pub trait View {
    /// What is known before the first step.
    fn start(&self) -> Start;
    /// The fields that its case writes.
    fn snapshot(&self) -> FieldSnapshot;
    /// Time of the solution \[s\].
    fn time(&self) -> f64;
    /// The solution at a position on the reference domain.
    ///
    /// # Errors
    /// If it lies in no cell, or has another number of coordinates.
    fn at(&self, x: &[f64]) -> Result<Point, String>;
    /// What a run would write into `summary.json`.
    fn summary(&self, status: Status, breakdown: Option<Breakdown>, wall: f64) -> Summary;
}

impl<const D: usize> View for Simulation<D> {
    fn start(&self) -> Start {
        let mut notes = self.case.notes().to_vec();
        notes.extend(self.case.notes_on(&self.stepper.assembler.space));
        Start {
            names: self.names(),
            units: self.units().into_iter().map(String::from).collect(),
            cells: self.stepper.assembler.space.mesh.n_cells(),
            unknowns: self.unknowns().total,
            threads: self.threads(),
            rows: self.history.clone(),
            notes,
        }
    }

    fn snapshot(&self) -> FieldSnapshot {
        written_fields(self)
    }

    fn time(&self) -> f64 {
        Simulation::time(self)
    }

    fn at(&self, x: &[f64]) -> Result<Point, String> {
        let x = <[f64; D]>::try_from(x)
            .map_err(|_| format!("expected a point of {D} coordinates, not {}", x.len()))?;
        let at = self.fields().at(x).map_err(|error| Error::from(error).to_string())?;
        let rows = |gradient: [[f64; D]; D]| gradient.iter().map(|row| row.to_vec()).collect();
        Ok(Point {
            is_solid: at.is_solid,
            velocity: at.velocity.to_vec(),
            velocity_gradient: rows(at.velocity_gradient),
            displacement: at.displacement.to_vec(),
            displacement_gradient: rows(at.displacement_gradient),
            pressure: at.pressure,
        })
    }

    fn summary(&self, status: Status, breakdown: Option<Breakdown>, wall: f64) -> Summary {
        summary_of(self, status, breakdown, Spent { wall, output: 0.0 })
    }
}
