//! The computation: step by step, with its functionals. No files; see [`crate::run`] for those.

mod initial;
mod memory;
mod row;
mod summary;

#[doc(hidden)]
pub use initial::SetUp;
pub use initial::with_start;
#[doc(hidden)]
pub use memory::Memory;
pub use row::Row;
pub(crate) use summary::Columns;

use crate::case::{Case, TimeSpec};
use crate::error::Error;
use crate::functional::Snapshot;
use crate::functional::balance::Balance;
use crate::functional::body_energy::BodyResidual;
use crate::functional::fields::{Fields, OwnFunctional};
use crate::nonlinear::NewtonError;
use crate::output::processor_seconds;
use crate::parallel::Crew;
use crate::setup::build::Functionals;
use crate::setup::dimension::Dimension;
use crate::system::{Dim, Operator, StepView};
use crate::time::{Adaptive, Cause, DataKind, Schedule, StepFailure, StepReport, Stepper};
use std::sync::Arc;

/// A case in the course of being computed.
///
/// ```no_run
/// use undula::{CaseBuilder, Simulation};
/// let case = CaseBuilder::load("fsi3")?.set("time.end", 6.0).build()?;
/// let mut simulation = Simulation::new(case, 2)?;
/// while !simulation.finished() {
///     let row = simulation.step()?;
///     println!("{:.3} s: drag {:.2} N/m", row.time, row["drag"]);
/// }
/// # Ok::<(), undula::Error>(())
/// ```
pub struct Simulation<const D: usize = 2> {
    /// The case.
    pub case: Case,
    /// Spaces, equations, solvers, and the solution.
    #[doc(hidden)]
    pub stepper: Stepper<D>,
    /// Rows so far. A run with files keeps the last ones only; other programs may remove rows, too.
    pub history: Vec<Row>,
    /// Steps done.
    pub steps: u64,
    /// How the last step went.
    #[doc(hidden)]
    pub report: StepReport,
    /// Step-size control, if the case has it.
    #[doc(hidden)]
    pub adaptive: Option<Adaptive>,
    /// What flows through the boundaries of the fluid; `None` without fluid.
    #[doc(hidden)]
    pub balance: Option<Balance<D>>,
    functionals: Functionals<D>,
    names: Arc<[String]>,
    fluid_residual: Vec<f64>,
    needs_residual: bool,
    volume: Vec<BodyResidual>,
    threads: usize,
    pool: Option<rayon::ThreadPool>,
    /// Processor time of the process when this began \[s\].
    begun: Option<f64>,
}

/// The times that the steps of `case` land on.
fn schedule(case: &Case, time: &TimeSpec) -> Schedule {
    Schedule { start: time.start, end: time.end, interval: case.output.fields_interval }
}

fn names_of<const D: usize>(functionals: &Functionals<D>) -> Arc<[String]> {
    functionals.iter().map(|(name, _)| name.clone()).collect()
}

impl<const D: usize> Simulation<D>
where
    Dim<D>: Dimension<D>,
{
    /// [`Simulation::new`] at rest, whatever the case begins with: its state comes from elsewhere.
    ///
    /// # Errors
    /// If the case does not fit its mesh, or if the linear solver cannot be prepared.
    pub(crate) fn rest(mut case: Case, threads: usize, crew: Option<&Crew>) -> Result<Simulation<D>, Error> {
        let (threads, begun) = (threads.max(1), processor_seconds());
        // One thread has a pool, too: outside of any, the solver's parallel loops would go to the global one.
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = Some(builder.build().map_err(|_| Error::Threads(threads))?);
        let (mut stepper, notes) = case.build_with_notes(threads, crew)?;
        case.record.notes.extend(notes);
        case.motion = stepper.assembler.space.with_whole(|whole| case.motion_on(whole));
        let functionals = case.build_functionals(&stepper.assembler.space)?;
        let nodes: Vec<u32> = functionals.iter().flat_map(|(_, f)| f.residual_nodes()).copied().collect();
        stepper.assembler.watch(&nodes);
        let volume = BodyResidual::of(functionals.iter().filter_map(|(_, f)| f.residual_body()));
        let fluid_residual = vec![0.0; stepper.assembler.n_unknowns()];
        let adaptive = case.time.as_ref().and_then(|time| {
            let first = time.step.eval(&[0.0; 3], time.start);
            time.adaptive.map(|settings| Adaptive::new(settings, first))
        });
        let (assembler, state) = (&stepper.assembler, &stepper.new);
        let density = assembler.physics.fluids().map(|(_, fluid)| fluid.rho).reduce(f64::min);
        let balance = density.map(|rho| Balance::new(&assembler.space, rho, state, stepper.time));
        // Multigrid still needs its coarser meshes.
        let unused = assembler.space.part.iter().filter(|_| !stepper.linear.is_multigrid());
        unused.for_each(|part| part.forget());
        Ok(Simulation {
            case,
            adaptive,
            balance,
            stepper,
            history: vec![],
            steps: 0,
            report: StepReport::default(),
            names: names_of(&functionals),
            functionals,
            fluid_residual,
            needs_residual: !nodes.is_empty(),
            volume,
            threads,
            pool,
            begun,
        })
    }
}

impl<const D: usize> Simulation<D> {
    /// Names of the functionals.
    pub fn names(&self) -> Vec<String> {
        self.names.to_vec()
    }

    /// Time of the solution \[s\].
    pub fn time(&self) -> f64 {
        self.stepper.time
    }

    /// The solution after the last step; at first that of `[initial]`, or rest, with the boundary values of the
    /// start.
    pub fn fields(&self) -> Fields<'_, D> {
        Fields::new(&self.stepper.assembler.space, &self.stepper.new)
    }

    /// Adds a functional: `value` is called after every step, and the rows have it under `name`; `unit` is an SI unit.
    ///
    /// ```
    /// use undula::{CaseBuilder, Simulation};
    /// let case = CaseBuilder::load("csm1")?.set("mesh.refine", 0).build()?;
    /// let mut simulation = Simulation::new(case, 1)?;
    /// let middle = simulation.fields().locate([0.4, 0.2])?;
    /// simulation.record("uy_middle", "m", move |fields| fields.value(&middle).displacement[1]);
    /// let row = simulation.step()?;
    /// assert!(row["uy_A"] < row["uy_middle"] && row["uy_middle"] < 0.0);
    /// # Ok::<(), undula::Error>(())
    /// ```
    ///
    /// # Panics
    /// If a step was taken already, or there is a functional of that name.
    pub fn record(
        &mut self,
        name: &str,
        unit: &'static str,
        value: impl Fn(&Fields<'_, D>) -> f64 + Send + 'static,
    ) {
        assert!(self.history.is_empty() && self.steps == 0, "functionals are added before the first step");
        assert!(!self.names.iter().any(|n| n == name), "there is a functional `{name}` already");
        self.functionals.push((name.into(), Box::new(OwnFunctional { unit, value })));
        self.names = names_of(&self.functionals);
    }

    /// Add a term to the equations.
    ///
    /// # Panics
    /// If a step was taken already.
    #[doc(hidden)]
    pub fn add_term(&mut self, term: Box<dyn Operator<D>>) {
        assert!(self.history.is_empty() && self.steps == 0, "terms are added before the first step");
        self.stepper.add_term(term);
        self.fluid_residual.resize(self.stepper.assembler.n_unknowns(), 0.0);
    }

    /// Units of the functionals, empty for a pure number.
    pub fn units(&self) -> Vec<&'static str> {
        self.functionals.iter().map(|(_, f)| f.unit()).collect()
    }

    /// Processor time of the process since this began \[s\], where the system tells.
    pub(crate) fn processor_seconds(&self) -> Option<f64> {
        Some(processor_seconds()? - self.begun?)
    }

    /// The processes that share the mesh, if there are several.
    pub(crate) fn crew(&self) -> Option<Crew> {
        self.stepper.assembler.space.part.as_ref().map(|part| part.crew().clone())
    }

    /// Threads in use.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Whether the end of the case is reached.
    pub fn finished(&self) -> bool {
        match &self.case.time {
            Some(time) => schedule(&self.case, time).is_over(self.stepper.time, self.wanted_step(time)),
            None => !self.history.is_empty(),
        }
    }

    /// Whether the next step gets its length from the end of the case: a run to a later end would not take it.
    pub fn next_is_cut(&self) -> bool {
        let Some(time) = &self.case.time else { return false };
        let (schedule, now) = (schedule(&self.case, time), self.stepper.time);
        match &self.adaptive {
            Some(adaptive) => {
                let target = schedule.target(now);
                schedule.is_end(target) && adaptive.feels(target - now)
            }
            None => schedule.next(now, self.wanted_step(time), time.step.is_constant()).cut,
        }
    }

    /// The length that the next step has unless it must land on some time \[s\].
    fn wanted_step(&self, time: &TimeSpec) -> f64 {
        match &self.adaptive {
            Some(adaptive) => adaptive.memory.next,
            None => time.step.eval(&[0.0; 3], self.stepper.time),
        }
    }

    /// Do the next step, or find the stationary solution.
    ///
    /// # Errors
    /// [`Error::Breakdown`], [`Error::Case`] for data that are not finite at the new time, [`Error::Solver`] if the
    /// problem is too large; the solution is then the last one that succeeded.
    pub fn step(&mut self) -> Result<Row, Error> {
        self.install(Simulation::step_here)
    }

    /// Do `work` on the threads of the simulation, as parallel loops need.
    pub fn install<R: Send>(&mut self, work: impl FnOnce(&mut Simulation<D>) -> R + Send) -> R {
        // The pool leaves `self` while it works on it.
        match self.pool.take() {
            None => work(self),
            Some(pool) => {
                let result = pool.install(|| work(self));
                self.pool = Some(pool);
                result
            }
        }
    }

    fn step_here(&mut self) -> Result<Row, Error> {
        self.stepper.remember();
        let before = self.stepper.newton.counters.linear_iterations;
        let result = self.step_in_time();
        if let Err(Error::Breakdown(failure)) = &result
            && failure.is_stop()
        {
            self.stepper.undo();
        }
        let report = result?;
        if self.case.time.is_some() {
            self.steps += 1;
        }
        if let Some(balance) = &mut self.balance {
            balance.observe(&self.stepper.new, self.stepper.time);
        }
        let mut row = self.evaluate(&report);
        row.linear_iterations = self.stepper.newton.counters.linear_iterations - before;
        self.history.push(row.clone());
        self.report = report;
        Ok(row)
    }

    /// The next step of the schedule.
    fn step_in_time(&mut self) -> Result<StepReport, Error> {
        let Some(time) = &self.case.time else {
            return self.stepper.stationary().map_err(|failure| self.blame(failure));
        };
        let (schedule, now) = (schedule(&self.case, time), self.stepper.time);
        let (k, counted) = (self.wanted_step(time), time.step.is_constant());
        if let Some(adaptive) = &mut self.adaptive {
            let result = adaptive.step(&mut self.stepper, schedule.target(now));
            return result.map_err(|failure| self.blame(failure));
        }
        self.case.step_at(time, now)?;
        let next = schedule.next(now, k, counted);
        if next.time <= now {
            let message = format!("the step of {k} s at t = {now} s is below the rounding of t");
            return Err(self.case.refuse("time.step", message));
        }
        self.stepper.step_to(next.length, next.time).map_err(|failure| self.blame(failure))
    }

    /// What is to blame for a step without a solution: the data, the size of the problem, else the problem itself.
    fn blame(&self, failure: StepFailure) -> Error {
        match (&failure.details.cause, &failure.reason) {
            (Cause::Data(fault), _) if fault.kind == DataKind::Elsewhere => Error::Elsewhere { code: 2 },
            (Cause::Data(fault), _) => self.case.blame_data(&self.stepper.assembler.space, fault),
            (_, NewtonError::Linear(error)) if failure.is_too_large() => Error::Solver(error.clone()),
            _ => Error::Breakdown(failure),
        }
    }

    /// Whether fields are written in the course of the run.
    pub(crate) fn writes_fields(&self) -> bool {
        let output = &self.case.output;
        let any =
            output.fields_every > 0 || output.fields_interval.is_some() || !output.fields_times.is_empty();
        any && self.case.time.is_some()
    }

    /// Whether the present time is nearest, among the ends of steps, to one of `output.fields-times`.
    fn is_nearest_time(&self) -> bool {
        let times = &self.case.output.fields_times;
        let (Some(time), Some(last), false) = (&self.case.time, self.history.last(), times.is_empty()) else {
            return false;
        };
        let before = self.history.iter().rev().nth(1).map_or(time.start, |row| row.time);
        let (now, schedule) = (last.time, schedule(&self.case, time));
        let k = self.wanted_step(time).min((schedule.target(now) - now).max(0.0));
        // Halfway between two steps it is the earlier one.
        let slack = 1e-9 * (now - before);
        let (from, to) = (0.5 * (before + now) + slack, now + 0.5 * k + slack);
        times.iter().any(|&t| from < t && t <= to)
    }

    /// Whether fields are written at the present time because of `output.fields-interval` or `output.fields-times`.
    pub fn is_output_time(&self) -> bool {
        if self.is_nearest_time() {
            return true;
        }
        let (Some(interval), Some(time)) = (self.case.output.fields_interval, &self.case.time) else {
            return false;
        };
        let number = (self.stepper.time - time.start) / interval;
        number > 0.5 && (number - number.round()).abs() < 1e-9
    }

    fn evaluate(&mut self, report: &StepReport) -> Row {
        let n_parts = self.stepper.n_parts();
        let mut values = vec![0.0; self.functionals.len()];
        for part in 0..n_parts {
            let (weight, view, assembler) = self.stepper.part(part);
            if self.needs_residual {
                assembler.watched_residual(&view, &mut self.fluid_residual);
            }
            self.volume.iter_mut().for_each(|body| body.fill(assembler, &view));
            let StepView { rule, new, old } = view;
            let snapshot = Snapshot {
                space: &assembler.space,
                physics: &assembler.physics,
                rule,
                new,
                old,
                fluid_residual: &self.fluid_residual,
                system: Some(&*assembler),
                volume: &self.volume,
            };
            for (value, (_, f)) in values.iter_mut().zip(&self.functionals) {
                // Forces are means over the parts of a step, all else belongs to its end.
                if f.at_force_time() {
                    *value += weight * f.evaluate(&snapshot);
                } else if part + 1 == n_parts {
                    *value = f.evaluate(&snapshot);
                }
            }
        }
        Row {
            step: self.steps,
            time: self.stepper.time,
            force_time: self.stepper.force_time(),
            values,
            min_j: report.min_j,
            newton_steps: report.newton_steps,
            jacobians: report.jacobians,
            linear_iterations: 0,
            names: self.names.clone(),
        }
    }
}
