//! A run of processes that share a mesh: the first one tells the others what all do next, and has the files.

use super::together::settle;
use super::watch::Watch;
use super::{Flow, Observer, written_fields};
use crate::error::Error;
use crate::output::{
    FieldSnapshot, Precision, RankSummary, RunDirectory, Status, peak_memory, write_pvtu, write_vtu,
};
use crate::parallel::{Crew, Fault, Team};
use crate::simulation::{Memory, Simulation};
use crate::space::{Part, State};
use std::path::Path;

/// What all do next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    End,
    Step,
    Fields,
    Checkpoint,
    Settle,
    Account,
}

impl Order {
    const ALL: [Order; 6] =
        [Order::End, Order::Step, Order::Fields, Order::Checkpoint, Order::Settle, Order::Account];

    fn of(number: f64) -> Order {
        Order::ALL.into_iter().find(|order| f64::from(*order as u8) == number).unwrap_or(Order::End)
    }
}

/// Tells the others what all do next; nothing where there are none.
pub(super) fn order(crew: Option<&Crew>, order: Order) -> Result<(), Error> {
    crew.map_or(Ok(0.0), |crew| crew.told(f64::from(order as u8))).map(|_| ()).map_err(Error::Processes)
}

/// Does what the first process tells, until the run ends.
///
/// # Errors
/// What went wrong here.
pub(super) fn serve<const D: usize>(
    simulation: &mut Simulation<D>,
    directory: &Path,
    (observer, team): (&mut dyn Observer<D>, &mut Team),
) -> Result<Status, Error> {
    let Some(crew) = simulation.crew() else { return Ok(Status::Completed) };
    let mut outcome = Ok(Flow::Continue);
    let (mut status, mut result) = (Status::Completed, Ok(()));
    loop {
        // The first process may never come to tell what is next.
        let watch = outcome.as_ref().err().and_then(|error| Watch::of(team, error));
        let next = crew.told(0.0);
        drop(watch);
        match Order::of(next.map_err(Error::Processes)?) {
            Order::End => return outcome.and(result).map(|()| status),
            Order::Step => {
                outcome = simulation.step().map(|row| observer.after_step(simulation, &row));
                // Nobody reads them here.
                let rows = simulation.history.len();
                simulation.history.drain(..rows.saturating_sub(2));
            }
            Order::Fields => {
                let written = write_fields(simulation, directory);
                outcome = outcome.and_then(|flow| written.map(|_| flow));
            }
            Order::Checkpoint => {
                whole_memory(simulation)?;
            }
            Order::Account => {
                account(simulation)?;
            }
            Order::Settle => {
                let settled = settle(team, std::mem::replace(&mut outcome, Ok(Flow::Continue)));
                match settled {
                    Ok(Flow::Continue) => {}
                    Ok(Flow::Stop) => status = Status::Interrupted,
                    Err(error) => result = Err(error),
                }
            }
        }
    }
}

/// What each process has had to do; empty where none shares the mesh.
///
/// # Errors
/// If MPI fails.
pub(super) fn account<const D: usize>(simulation: &Simulation<D>) -> Result<Vec<RankSummary>, Error> {
    let space = &simulation.stepper.assembler.space;
    let Some(part) = &space.part else { return Ok(vec![]) };
    let (all, traffic) = (space.mesh.n_cells(), part.crew().traffic());
    let cells = (0..all).filter(|&cell| space.owns_cell(cell)).count();
    let own = [
        cells as f64,
        (all - cells) as f64,
        peak_memory().unwrap_or(0) as f64,
        part.memory_before() as f64,
        simulation.processor_seconds().unwrap_or(f64::NAN),
        simulation.stepper.newton.seconds.assembly,
        traffic.seconds,
        traffic.bytes,
        traffic.messages,
    ];
    let lists = part.crew().lists(&own).map_err(Error::Processes)?;
    let summary = |n: &Vec<f64>| RankSummary {
        cells: n[0] as usize,
        copies: n[1] as usize,
        peak_memory_bytes: n[2] as u64,
        base_memory_bytes: n[3] as u64,
        cpu_seconds: n[4],
        assembly_seconds: n[5],
        waiting_seconds: n[6],
        sent_bytes: n[7] as u64,
        sent_messages: n[8] as u64,
    };
    Ok(lists.iter().map(summary).collect())
}

/// Writes the piece of this process, and on the first one the file that names all; its name in the directory.
///
/// # Errors
/// What went wrong here; [`Error::Elsewhere`] where that happened to another process.
pub(super) fn write_fields<const D: usize>(
    simulation: &Simulation<D>,
    directory: &Path,
) -> Result<String, Error> {
    let space = &simulation.stepper.assembler.space;
    let name = RunDirectory::shared_field_name(simulation.steps);
    let Some(part) = &space.part else { return Ok(name) };
    let (crew, precision) = (part.crew(), precision(part));
    let piece = |rank: usize| RunDirectory::piece_name(simulation.steps, rank);
    let snapshot = own_fields(simulation);
    let written = write_vtu(directory.join(piece(crew.rank())), &snapshot, simulation.time(), precision);
    let failed = space.any(written.is_err());
    written.map_err(Error::Output)?;
    if failed {
        return Err(Error::Elsewhere { code: 1 });
    }
    if crew.rank() == 0 {
        let beside = |rank: usize| piece(rank).rsplit('/').next().unwrap_or_default().to_string();
        let pieces: Vec<String> = (0..crew.size()).map(beside).collect();
        write_pvtu(directory.join(&name), &snapshot, &pieces, precision)?;
    }
    Ok(name)
}

/// The same in all pieces.
fn precision<const D: usize>(part: &Part<D>) -> Precision {
    if part.all()[0] >= 100_000 { Precision::Single } else { Precision::Double }
}

/// The fields in the cells that this process counts.
fn own_fields<const D: usize>(simulation: &Simulation<D>) -> FieldSnapshot {
    let space = &simulation.stepper.assembler.space;
    let fields = written_fields(simulation);
    // Cells that were cut into straight ones follow each other.
    let per_cell = fields.n_cells() / space.mesh.n_cells();
    let mut own = fields.restricted(|cell| space.owns_cell(cell / per_cell));
    let numbers = own.cell_data.iter_mut().filter(|field| field.name == "cell");
    for number in numbers.flat_map(|field| &mut field.values) {
        *number = space.part.as_ref().map_or(*number, |part| part.cell(*number as usize) as f64);
    }
    own
}

/// What a checkpoint keeps of all processes, on the first one; what the others get is of no use.
///
/// # Errors
/// If MPI fails.
pub(super) fn whole_memory<const D: usize>(simulation: &Simulation<D>) -> Result<Memory, Error> {
    let mut memory = simulation.save();
    let space = &simulation.stepper.assembler.space;
    let Some(part) = &space.part else { return Ok(memory) };
    let gather = Gather::new(part).map_err(Error::Processes)?;
    let mut all = || -> Result<(), Fault> {
        let stepper = &mut memory.stepper;
        gather.state(&mut stepper.new)?;
        gather.state(&mut stepper.old)?;
        if let Some(point) = &mut stepper.point {
            gather.state(&mut point.new)?;
            gather.state(&mut point.old)?;
        }
        for (_, stage) in &mut stepper.stages {
            gather.state(stage)?;
        }
        let past = memory.adaptive.iter_mut().flat_map(|adaptive| &mut adaptive.past);
        past.flat_map(|(_, fields)| fields).try_for_each(|field| gather.nodal(field))
    };
    all().map_err(Error::Processes)?;
    Ok(memory)
}

/// Brings lists of numbers together on the first process.
struct Gather<'a, const D: usize> {
    part: &'a Part<D>,
    /// Numbers of the own nodes and pressures of all processes in the whole space, on the first one.
    nodes: Vec<Vec<f64>>,
    pressures: Vec<Vec<f64>>,
}

impl<'a, const D: usize> Gather<'a, D> {
    fn new(part: &'a Part<D>) -> Result<Gather<'a, D>, Fault> {
        let nodes = part.crew().collect(part.own_nodes().map(|(_, whole)| whole as f64).collect())?;
        let pressures = part.crew().collect(part.own_pressures().map(|(_, whole)| whole as f64).collect())?;
        Ok(Gather { part, nodes, pressures })
    }

    fn state(&self, state: &mut State) -> Result<(), Fault> {
        self.nodal(&mut state.v)?;
        self.nodal(&mut state.u)?;
        let own = self.part.own_pressures().map(|(here, _)| state.p[here as usize]).collect();
        self.put(&self.pressures, (1, self.part.all()[1]), own, &mut state.p)
    }

    /// D numbers for each node; none where there are none.
    fn nodal(&self, values: &mut Vec<f64>) -> Result<(), Fault> {
        if values.is_empty() {
            return Ok(());
        }
        let own = self.part.own_nodes().flat_map(|(here, _)| &values[here as usize * D..][..D]);
        let own = own.copied().collect();
        self.put(&self.nodes, (D, self.part.all()[0]), own, values)
    }

    fn put(
        &self,
        places: &[Vec<f64>],
        (k, n): (usize, usize),
        own: Vec<f64>,
        values: &mut Vec<f64>,
    ) -> Result<(), Fault> {
        let lists = self.part.crew().collect(own)?;
        if self.part.crew().rank() == 0 {
            values.clear();
            values.resize(k * n, 0.0);
            for (place, numbers) in
                places.iter().zip(&lists).flat_map(|(places, list)| places.iter().zip(list.chunks_exact(k)))
            {
                values[*place as usize * k..][..k].copy_from_slice(numbers);
            }
        }
        Ok(())
    }
}
