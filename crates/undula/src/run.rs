//! A computation with its files: history, fields, checkpoints, summary.

use crate::element::Shape;
use crate::error::Error;
use crate::nonlinear::Age;
use crate::output::{
    Array, Breakdown, CellKind, Checkpoint, Collection, Field, FieldSnapshot, HistoryWriter, Phases,
    Precision, RunDirectory, Status, Summary, peak_memory, write_vtu,
};
use crate::problem::case::Case;
use crate::simulation::{Row, Simulation};
use crate::space::{FsiSpace, Region, State};
use crate::time::adaptive::Memory;
use crate::time::{Clock, Damping, JacobianPoint};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Where and how to run.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Output directory.
    pub directory: PathBuf,
    /// Threads.
    pub threads: usize,
    /// Replace an unfinished run.
    pub force: bool,
    /// Go on with an unfinished run.
    pub resume: bool,
}

/// Whether to go on.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Yes.
    Continue,
    /// Stop here, as if interrupted.
    Stop,
}

/// Watches a run.
pub trait Observer {
    /// Called once before the first step.
    fn start(&mut self, simulation: &Simulation) {
        let _ = simulation;
    }
    /// Called after every step.
    fn after_step(&mut self, simulation: &Simulation, row: &Row) -> Flow;
}

/// Run `case` to its end and write everything into the directory; the summary says how it ended.
///
/// # Errors
/// Problems with the case, its mesh, or files. A breakdown is no error: the summary has that status.
pub fn run(case: Case, options: &RunOptions, observer: &mut dyn Observer) -> Result<Summary, Error> {
    // Everything that can be wrong with the input is found before a file is touched.
    let simulation = Simulation::new(case, options.threads)?;
    let mut run = if options.resume {
        Run::resume(simulation, &options.directory)?
    } else {
        Run::create(simulation, options)?
    };
    observer.start(&run.simulation);
    let result = run.advance(observer);
    let (status, breakdown, error) = match result {
        Ok(Flow::Continue) => (Status::Completed, None, None),
        Ok(Flow::Stop) => (Status::Interrupted, None, None),
        Err(Error::Breakdown(failure)) => {
            (Status::Breakdown, Some(describe(&run.simulation, &failure)), None)
        }
        Err(error) => (Status::Failed, None, Some(error)),
    };
    let closed = run.close(status, breakdown);
    match error {
        Some(error) => Err(error),
        None => closed,
    }
}

/// What a checkpoint says besides its arrays.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Metadata {
    step: u64,
    clock: [f64; 2],
    /// Intervals begun and damping steps to come in Rannacher's scheme.
    #[serde(default)]
    damping: (u64, u32),
    /// 1/k, θ and time of the kept Jacobian.
    jacobian: Option<[f64; 3]>,
    /// Its age.
    #[serde(default)]
    age: [u32; 3],
    /// Bits of what Newton's method has learnt about kept Jacobians; 0: nothing.
    #[serde(default)]
    worsening: u32,
    /// Steps to go with the whole Jacobian.
    #[serde(default)]
    detour: u32,
    /// Next step, largest velocity, rejected steps and times of the past of step-size control.
    #[serde(default)]
    adaptive: Option<(f64, f64, u64, Vec<f64>)>,
    counters: [u64; 3],
    seconds: [f64; 4],
    wall_seconds: f64,
    case: String,
}

/// A simulation with its open files.
struct Run {
    simulation: Simulation,
    directory: RunDirectory,
    history: HistoryWriter,
    collection: Collection,
    start: Instant,
    /// Seconds of the runs that this one continues.
    wall_before: f64,
    output_seconds: f64,
    last_fields: Option<u64>,
    last_checkpoint: Option<u64>,
}

impl Run {
    fn create(simulation: Simulation, options: &RunOptions) -> Result<Run, Error> {
        let directory = RunDirectory::create(&options.directory, options.force).map_err(Error::Directory)?;
        directory.write_case(&simulation.case.to_toml())?;
        let history = HistoryWriter::create(directory.history(), &columns(&simulation))?;
        let collection = Collection::create(directory.collection())?;
        Ok(Run {
            simulation,
            directory,
            history,
            collection,
            start: Instant::now(),
            wall_before: 0.0,
            output_seconds: 0.0,
            last_fields: None,
            last_checkpoint: None,
        })
    }

    fn resume(mut simulation: Simulation, path: &Path) -> Result<Run, Error> {
        let extended = ends_later(path, &simulation.case);
        let directory = RunDirectory::open_for_resume(path, extended).map_err(Error::Directory)?;
        let (checkpoint, metadata) = latest(&directory, "start again with --force")?;
        if metadata.case != identity(&simulation.case) {
            return Err(Error::Resume("the case has changed in more than its end time and output".into()));
        }
        restore(&mut simulation, &checkpoint, &metadata)?;
        let (history, before) =
            HistoryWriter::resume(directory.history(), &columns(&simulation), metadata.step)?;
        let n = simulation.names().len();
        simulation.history = before.rows.iter().map(|row| read_row(row, n)).collect();
        let collection = Collection::resume(directory.collection(), metadata.clock[0])?;
        directory.write_case(&simulation.case.to_toml())?;
        Ok(Run {
            simulation,
            directory,
            history,
            collection,
            start: Instant::now(),
            wall_before: metadata.wall_seconds,
            output_seconds: metadata.seconds[3],
            last_fields: None,
            last_checkpoint: Some(metadata.step),
        })
    }

    /// Step until the end, a stop, or an error.
    fn advance(&mut self, observer: &mut dyn Observer) -> Result<Flow, Error> {
        self.write_summary(Status::Running, None)?;
        while !self.simulation.finished() {
            let row = self.simulation.step()?;
            self.record(&row)?;
            if observer.after_step(&self.simulation, &row) == Flow::Stop && !self.simulation.finished() {
                return Ok(Flow::Stop);
            }
        }
        Ok(Flow::Continue)
    }

    /// Write what is due after a step.
    fn record(&mut self, row: &Row) -> Result<(), Error> {
        let start = Instant::now();
        let mut numbers = vec![row.step as f64, row.time, row.force_time];
        numbers.extend(&row.values);
        numbers.extend([row.min_j, row.newton_steps as f64, row.jacobians as f64]);
        self.history.append(&numbers)?;
        let due = |every: usize| every > 0 && row.step > 0 && row.step.is_multiple_of(every as u64);
        let output = &self.simulation.case.output;
        let (fields, checkpoint) = (due(output.fields_every), due(output.checkpoint_every));
        if fields || self.simulation.is_output_time() {
            self.write_fields()?;
        }
        if checkpoint {
            self.write_checkpoint()?;
            self.write_summary(Status::Running, None)?;
        }
        self.output_seconds += start.elapsed().as_secs_f64();
        Ok(())
    }

    fn write_fields(&mut self) -> Result<(), Error> {
        let step = self.simulation.steps;
        if self.last_fields == Some(step) {
            return Ok(());
        }
        let name = self.directory.field_name(step);
        let stepper = &self.simulation.stepper;
        let snapshot = snapshot(&stepper.assembler.space, &stepper.new, self.simulation.case.output.deformed);
        write_vtu(self.directory.path().join(&name), &snapshot, stepper.time, Precision::Auto)?;
        self.collection.add(stepper.time, name)?;
        self.last_fields = Some(step);
        Ok(())
    }

    fn write_checkpoint(&mut self) -> Result<(), Error> {
        let step = self.simulation.steps;
        if self.last_checkpoint == Some(step) {
            return Ok(());
        }
        self.history.sync()?;
        let stepper = &self.simulation.stepper;
        let (clock, point) = (stepper.clock(), stepper.jacobian_point());
        let (counters, seconds) = (stepper.newton.counters, stepper.newton.seconds);
        let metadata = Metadata {
            step,
            clock: [clock.time, clock.last_step],
            damping: (clock.damping.interval, clock.damping.left),
            jacobian: point.map(|p| [p.rule.per_k, p.rule.theta, p.time]),
            age: point.map_or([0; 3], |p| [p.age.solves, p.age.iterations, p.age.last]),
            worsening: stepper.newton.worsening.to_bits(),
            detour: stepper.linear.detour,
            adaptive: self.simulation.adaptive.as_ref().map(|a| {
                let memory = &a.memory;
                let times = memory.past.iter().map(|(t, _)| *t).collect();
                (memory.next, memory.scale, memory.rejected, times)
            }),
            counters: [counters.newton_steps, counters.jacobians, counters.factorizations].map(|n| n as u64),
            seconds: [seconds.assembly, seconds.factorization, seconds.solve, self.output_seconds],
            wall_seconds: self.wall_before + self.start.elapsed().as_secs_f64(),
            case: identity(&self.simulation.case),
        };
        let text = serde_json::to_string(&metadata).map_err(|e| Error::Resume(e.to_string()))?;
        let mut checkpoint = Checkpoint { metadata: text, ..Checkpoint::default() };
        let mut states = vec![("new", &stepper.new), ("old", &stepper.old)];
        if let Some(point) = point {
            states.extend([("jacobian_new", &point.new), ("jacobian_old", &point.old)]);
        }
        for (name, state) in states {
            for (field, values) in [("v", &state.v), ("u", &state.u), ("p", &state.p)] {
                checkpoint.arrays.insert(format!("{name}_{field}"), Array::F64(values.clone()));
            }
        }
        for (n, (_, v)) in self.simulation.adaptive.iter().flat_map(|a| &a.memory.past).enumerate() {
            checkpoint.arrays.insert(format!("past{n}_v"), Array::F64(v.clone()));
        }
        checkpoint.save(self.directory.checkpoints(), step)?;
        self.last_checkpoint = Some(step);
        Ok(())
    }

    fn summary(&self, status: Status, breakdown: Option<Breakdown>) -> Summary {
        let simulation = &self.simulation;
        let newton = &simulation.stepper.newton;
        Summary {
            status,
            case: simulation.case.name.clone(),
            cells: simulation.stepper.assembler.space.mesh.n_cells(),
            unknowns: simulation.unknowns(),
            steps: simulation.steps,
            newton_steps: newton.counters.newton_steps as u64,
            jacobians: newton.counters.jacobians as u64,
            rejected_steps: simulation.adaptive.as_ref().map(|a| a.memory.rejected),
            factorizations: newton.counters.factorizations as u64,
            threads: simulation.threads(),
            wall_seconds: self.wall_before + self.start.elapsed().as_secs_f64(),
            phases: Phases {
                assembly: newton.seconds.assembly,
                factorization: newton.seconds.factorization,
                solve: newton.seconds.solve,
                output: self.output_seconds,
            },
            peak_memory_bytes: peak_memory(),
            functionals: simulation.statistics(),
            breakdown,
        }
    }

    fn write_summary(&self, status: Status, breakdown: Option<Breakdown>) -> Result<Summary, Error> {
        let summary = self.summary(status, breakdown);
        summary.write(self.directory.summary())?;
        Ok(summary)
    }

    /// Write what is left to write: last fields, a checkpoint if the run can go on, the summary.
    fn close(mut self, status: Status, breakdown: Option<Breakdown>) -> Result<Summary, Error> {
        let start = Instant::now();
        let transient = self.simulation.case.time.is_some();
        let fields = if self.simulation.history.is_empty() { Ok(()) } else { self.write_fields() };
        let checkpoint =
            if transient && self.simulation.steps > 0 { self.write_checkpoint() } else { Ok(()) };
        self.output_seconds += start.elapsed().as_secs_f64();
        // The summary is written even where the disk refused the rest: it is small.
        let summary =
            self.write_summary(if checkpoint.is_err() { Status::Failed } else { status }, breakdown)?;
        fields?;
        checkpoint?;
        Ok(summary)
    }
}

/// All columns of `history.csv`.
fn columns(simulation: &Simulation) -> Vec<String> {
    let mut columns: Vec<String> = ["step", "time", "force_time"].map(String::from).to_vec();
    columns.extend(simulation.names());
    columns.extend(["min_J", "newton_steps", "jacobians"].map(String::from));
    columns
}

fn read_row(row: &[f64], n: usize) -> Row {
    Row {
        step: row[0] as u64,
        time: row[1],
        force_time: row[2],
        values: row[3..3 + n].to_vec(),
        min_j: row[3 + n],
        newton_steps: row[4 + n] as usize,
        jacobians: row[5 + n] as usize,
    }
}

/// Whether `case` ends later than that of the run in `path`.
fn ends_later(path: &Path, case: &Case) -> bool {
    let former = RunDirectory::open(path).ok().and_then(|directory| {
        let text = std::fs::read_to_string(directory.case()).ok()?;
        Case::from_toml(&text, "case.toml", &[]).ok()
    });
    match (former.and_then(|former| former.time), &case.time) {
        (Some(former), Some(time)) => time.end > former.end,
        _ => false,
    }
}

/// The case without what may change when a run goes on: its end and its output.
fn identity(case: &Case) -> String {
    let mut case = case.clone();
    if let Some(time) = &mut case.time {
        time.end = 0.0;
    }
    // How the equations are solved may change: a run that broke down can go on with a smaller rate.
    (case.newton, case.linear) = Default::default();
    case.output = crate::problem::case::OutputSpec {
        fields_every: 0,
        fields_interval: case.output.fields_interval,
        deformed: true,
        checkpoint_every: 0,
        leading: None,
    };
    case.to_toml()
}

/// Take `simulation` to the newest checkpoint of the run in `directory`; its case may differ from that of the
/// run in all but its unknowns.
///
/// # Errors
/// If there is no run or no checkpoint, or if it has other unknowns.
pub fn restore_latest(simulation: &mut Simulation, directory: impl AsRef<Path>) -> Result<(), Error> {
    let directory = RunDirectory::open(directory).map_err(Error::Directory)?;
    let (checkpoint, metadata) = latest(&directory, "expected a run that has written one")?;
    restore(simulation, &checkpoint, &metadata)
}

/// The newest sound checkpoint of a run; `advice` is for where there is none.
fn latest(directory: &RunDirectory, advice: &str) -> Result<(Checkpoint, Metadata), Error> {
    let found = Checkpoint::load_latest(directory.checkpoints())?;
    let none = || Error::Resume(format!("{} holds none; {advice}", directory.path().display()));
    let checkpoint = found.ok_or_else(none)?.checkpoint;
    let metadata = serde_json::from_str(&checkpoint.metadata).map_err(|e| Error::Resume(e.to_string()))?;
    Ok((checkpoint, metadata))
}

fn restore(simulation: &mut Simulation, checkpoint: &Checkpoint, metadata: &Metadata) -> Result<(), Error> {
    let space = &simulation.stepper.assembler.space;
    let sizes = [("v", space.n_v()), ("u", space.n_u()), ("p", space.n_p())];
    let state = |name: &str| -> Result<State, Error> {
        let mut parts = vec![];
        for (field, n) in sizes {
            let key = format!("{name}_{field}");
            let array = checkpoint.f64s(&key).filter(|a| a.len() == n);
            parts.push(
                array.ok_or_else(|| Error::Resume(format!("array {key} should have {n} numbers")))?.to_vec(),
            );
        }
        let p = parts.pop().unwrap_or_default();
        let u = parts.pop().unwrap_or_default();
        Ok(State { v: parts.pop().unwrap_or_default(), u, p })
    };
    let (interval, left) = metadata.damping;
    let damping = Damping { interval, left };
    let clock = Clock { time: metadata.clock[0], last_step: metadata.clock[1], damping };
    let [solves, iterations, last] = metadata.age;
    let point = match metadata.jacobian {
        Some([per_k, theta, time]) => Some(JacobianPoint {
            rule: simulation.stepper.settings.rule_of(per_k, theta),
            time,
            new: state("jacobian_new")?,
            old: state("jacobian_old")?,
            age: Age { solves, iterations, last },
        }),
        None => None,
    };
    let (new, old) = (state("new")?, state("old")?);
    simulation.stepper.linear.set_detour(metadata.detour);
    let worsening = f32::from_bits(metadata.worsening);
    simulation.stepper.newton.worsening = if worsening.is_finite() { worsening.max(1.0) } else { 1.0 };
    let n_v = new.v.len();
    simulation.restore(clock, new, old, point, metadata.step)?;
    if let (Some(adaptive), Some((next, scale, rejected, times))) =
        (&mut simulation.adaptive, &metadata.adaptive)
    {
        let mut past = vec![];
        for (n, t) in times.iter().enumerate() {
            let key = format!("past{n}_v");
            let v = checkpoint.f64s(&key).filter(|a| a.len() == n_v);
            let v = v.ok_or_else(|| Error::Resume(format!("array {key} should have {} numbers", n_v)))?;
            past.push((*t, v.to_vec()));
        }
        adaptive.memory = Memory { next: *next, scale: *scale, rejected: *rejected, past };
    }
    let newton = &mut simulation.stepper.newton;
    let [newton_steps, jacobians, factorizations] = metadata.counters.map(|n| n as usize);
    newton.counters = crate::nonlinear::Counters { newton_steps, jacobians, factorizations };
    let [assembly, factorization, solve, _] = metadata.seconds;
    newton.seconds = crate::nonlinear::Seconds { assembly, factorization, solve };
    Ok(())
}

/// Fields at the nodes of v and u, on the deformed mesh or on the reference domain.
pub fn snapshot(space: &FsiSpace<2>, state: &State, deformed: bool) -> FieldSnapshot {
    // Bubbles have no value of their own at a point.
    let n = space.nodes.n_lagrange;
    let u = |node: usize, i: usize| if state.u.is_empty() { 0.0 } else { state.u[2 * node + i] };
    let point = |node: usize| {
        let x = space.nodes.points[node];
        let move_by = |i| if deformed { u(node, i) } else { 0.0 };
        [x[0] + move_by(0), x[1] + move_by(1), 0.0]
    };
    let mut point_data = vec![Field::new("velocity", 2, state.v[..2 * n].to_vec())];
    if space.deforms {
        point_data.push(Field::new("deformation", 2, state.u[..2 * n].to_vec()));
    }
    for (name, region) in [("pressure", Region::Fluid), ("solid-pressure", Region::Solid)] {
        if let Some(values) = nodal_pressure(space, state, region) {
            point_data.push(Field::new(name, 1, values));
        }
    }
    let solid = space.regions.iter().map(|r| if *r == Region::Solid { 1.0 } else { 0.0 }).collect();
    FieldSnapshot {
        kind: match space.mesh.shape {
            Shape::Triangle => CellKind::Triangle,
            _ => CellKind::Quadrilateral,
        },
        degree: space.nodes.degree,
        points: (0..n).map(point).collect(),
        cells: (0..space.mesh.n_cells()).flat_map(|cell| points_of(space, cell)).copied().collect(),
        point_data,
        cell_data: vec![Field::new("solid", 1, solid)],
    }
}

/// The nodes of `cell` that are points.
fn points_of(space: &FsiSpace<2>, cell: usize) -> &[u32] {
    &space.nodes.cell(cell)[..space.mesh.shape.n_nodes(space.nodes.degree)]
}

/// Pressure of a region at the nodes, the mean over its cells; 0 outside. `None` if the region has none.
fn nodal_pressure(space: &FsiSpace<2>, state: &State, region: Region) -> Option<Vec<f64>> {
    let n = space.nodes.n_lagrange;
    let (mut sum, mut count) = (vec![0.0; n], vec![0.0; n]);
    for cell in 0..space.mesh.n_cells() {
        let dofs = space.pressure.cell(cell);
        if dofs.is_empty() || space.regions[cell] != region {
            continue;
        }
        for (a, &node) in points_of(space, cell).iter().enumerate() {
            let xi = crate::element::lagrange::node(space.mesh.shape, space.nodes.degree, a);
            let x = space.nodes.points[node as usize];
            let basis = space.pressure.basis(&space.mesh, cell, &xi, &x);
            sum[node as usize] += dofs.iter().zip(&basis).map(|(&d, b)| b * state.p[d as usize]).sum::<f64>();
            count[node as usize] += 1.0;
        }
    }
    let mean = sum.iter().zip(&count).map(|(s, c)| if *c > 0.0 { s / c } else { 0.0 });
    count.iter().any(|c| *c > 0.0).then(|| mean.collect())
}

/// A breakdown in words.
fn describe(simulation: &Simulation, failure: &crate::time::StepFailure) -> Breakdown {
    let mesh = &simulation.stepper.assembler.space.mesh;
    let centre = |&c: &u32| {
        let x = mesh.centre(c as usize);
        format!("cell {c} at ({:.4}, {:.4})", x[0], x[1])
    };
    let cells: Vec<String> = failure.worst.cells.iter().map(centre).collect();
    Breakdown {
        time: failure.time,
        min_j: failure.worst.min_j,
        r#where: cells.join(", "),
        reason: failure.to_string(),
    }
}
