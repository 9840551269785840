//! What a simulation was, for `summary.json`.

use super::identity::table_hashes;
use crate::algebra::{Engine, petsc};
use crate::functional::balance::Balance;
use crate::output::{Breakdown, Phases, Provenance, Status, Summary, peak_memory};
use crate::simulation::Simulation;

/// Elapsed times \[s\].
#[derive(Copy, Clone, Debug)]
pub struct Spent {
    /// From the start.
    pub wall: f64,
    /// For files.
    pub output: f64,
}

/// What solves the linear systems, if it is not our own.
fn engine_of<const D: usize>(simulation: &Simulation<D>) -> Option<String> {
    match simulation.case.linear.engine {
        Engine::Own => None,
        Engine::Petsc => petsc::engine().ok().map(petsc::Engine::title),
    }
}

/// The summary of `simulation`; hashes of files and the commit of the program are those of a run.
pub fn summary_of<const D: usize>(
    simulation: &Simulation<D>,
    status: Status,
    breakdown: Option<Breakdown>,
    spent: Spent,
) -> Summary {
    let newton = &simulation.stepper.newton;
    Summary {
        status,
        case: simulation.case.name.clone(),
        start: simulation.case.initial.as_ref().map(ToString::to_string),
        cells: simulation.cells(),
        unknowns: simulation.unknowns(),
        steps: simulation.steps,
        newton_steps: newton.counters.newton_steps as u64,
        jacobians: newton.counters.jacobians as u64,
        rejected_steps: simulation.adaptive.as_ref().map(|a| a.memory.rejected),
        factorizations: newton.counters.factorizations as u64,
        threads: simulation.threads(),
        ranks: vec![],
        processes: Some(petsc::processes_at_work()).filter(|&n| n > 1),
        engine: engine_of(simulation),
        wall_seconds: spent.wall,
        phases: Phases {
            assembly: newton.seconds.assembly,
            factorization: newton.seconds.factorization,
            solve: newton.seconds.solve,
            output: spent.output,
        },
        linear_iterations: newton.counters.linear_iterations as u64,
        direct_fallbacks: newton.counters.fallbacks as u64,
        largest_factor_unknowns: simulation.stepper.linear.largest_factor(),
        cpu_seconds: simulation.processor_seconds(),
        peak_memory_bytes: peak_memory(),
        mass_balance: simulation.balance.as_ref().and_then(Balance::mass),
        swept_volume: simulation.balance.as_ref().and_then(Balance::swept),
        functionals: simulation.statistics(),
        breakdown,
        provenance: Provenance { table_hashes: table_hashes(&simulation.case), ..Provenance::now(None) },
    }
}
