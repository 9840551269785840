//! The computation: step by step, with its functionals. No files; see [`crate::run`] for those.

use crate::assembly::StepView;
use crate::error::Error;
use crate::functional::statistics::{leading_window, statistics};
use crate::functional::{Functional, Snapshot};
use crate::nonlinear::NewtonError;
use crate::output::{FunctionalSummary, Unknowns};
use crate::problem::build::Functionals;
use crate::problem::case::Case;
use crate::space::State;
use crate::time::{Adaptive, Cause, Clock, JacobianPoint, StepFailure, StepReport, Stepper};
use std::collections::BTreeMap;

/// A case in the course of being computed.
///
/// ```no_run
/// # use undula::{problem::case::Case, simulation::Simulation};
/// let case = Case::load("fsi3", &["time.end=6".into()]).expect("a built-in case");
/// let mut simulation = Simulation::new(case, 2).expect("it fits its mesh");
/// while !simulation.finished() {
///     let row = simulation.step().expect("a solution");
///     println!("{:.3} s: drag {:.2} N/m", row.time, row.values[0]);
/// }
/// ```
pub struct Simulation {
    /// The case.
    pub case: Case,
    /// Spaces, equations, solvers, and the solution.
    pub stepper: Stepper<2>,
    /// Rows so far.
    pub history: Vec<Row>,
    /// Steps done.
    pub steps: u64,
    /// How the last step went.
    pub report: StepReport,
    /// Step-size control, if the case has it.
    pub adaptive: Option<Adaptive>,
    functionals: Functionals,
    fluid_residual: Vec<f64>,
    needs_residual: bool,
    threads: usize,
    pool: Option<rayon::ThreadPool>,
}

/// What one step gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Number of the step, from 1; 0 for a stationary solution.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Time t⁻ + θ k to which pressure and forces belong \[s\].
    pub force_time: f64,
    /// Functionals in the order of [`Simulation::names`].
    pub values: Vec<f64>,
    /// Smallest J at the quadrature points.
    pub min_j: f64,
    /// Newton iterations.
    pub newton_steps: usize,
    /// Jacobians assembled.
    pub jacobians: usize,
}

impl Simulation {
    /// Set up `case` on `threads` threads.
    ///
    /// # Errors
    /// If the case does not fit its mesh, or the linear solver cannot be prepared.
    pub fn new(case: Case, threads: usize) -> Result<Simulation, Error> {
        let threads = threads.max(1);
        // One thread has a pool, too: outside of any, the solver's parallel loops would go to the global one.
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = Some(builder.build().map_err(|_| Error::Threads(threads))?);
        let mut stepper = case.build_stepper(threads)?;
        let functionals = case.build_functionals(&stepper.assembler.space)?;
        let nodes: Vec<u32> = functionals.iter().flat_map(|(_, f)| f.residual_nodes()).copied().collect();
        stepper.assembler.watch(&nodes);
        let fluid_residual = vec![0.0; stepper.assembler.space.n_unknowns()];
        let adaptive = case.time.as_ref().and_then(|time| {
            let first = time.step.eval(&[0.0; 3], time.start);
            time.adaptive.map(|settings| Adaptive::new(settings, first))
        });
        Ok(Simulation {
            case,
            adaptive,
            stepper,
            history: vec![],
            steps: 0,
            report: StepReport::default(),
            functionals,
            fluid_residual,
            needs_residual: !nodes.is_empty(),
            threads,
            pool,
        })
    }

    /// Names of the functionals.
    pub fn names(&self) -> Vec<String> {
        self.functionals.iter().map(|(name, _)| name.clone()).collect()
    }

    /// Units of the functionals, empty for a pure number.
    pub fn units(&self) -> Vec<&'static str> {
        self.functionals.iter().map(|(_, f)| f.unit()).collect()
    }

    /// Threads in use.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Whether the end of the case is reached.
    pub fn finished(&self) -> bool {
        match &self.case.time {
            Some(time) => self.stepper.time >= time.end - 1e-9 * time.end.abs().max(1e-3),
            None => !self.history.is_empty(),
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
    pub fn install<R: Send>(&mut self, work: impl FnOnce(&mut Simulation) -> R + Send) -> R {
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
        let result = match &self.case.time {
            None => self.stepper.stationary(),
            Some(time) => {
                let now = self.stepper.time;
                let target = self.next_output().map_or(time.end, |output| output.min(time.end));
                match &mut self.adaptive {
                    Some(adaptive) => adaptive.step(&mut self.stepper, target),
                    None => {
                        let k = self.case.step_at(time, now)?;
                        let rest = target - now;
                        // Steps land on the target; a rest of a few per mille is not worth its own.
                        self.stepper.step(if rest < 1.001 * k { rest } else { k })
                    }
                }
            }
        };
        let report = result.map_err(|failure| self.blame(failure))?;
        if self.case.time.is_some() {
            self.steps += 1;
        }
        let row = self.evaluate(&report);
        self.history.push(row.clone());
        self.report = report;
        Ok(row)
    }

    /// What is to blame for a step without a solution: the data, the size of the problem, else the problem itself.
    fn blame(&self, failure: StepFailure) -> Error {
        match (&failure.details.cause, &failure.reason) {
            (Cause::Data(fault), _) => self.case.blame_data(&self.stepper.assembler.space, fault),
            (_, NewtonError::Linear(error)) if failure.is_too_large() => Error::Solver(error.clone()),
            _ => Error::Breakdown(failure),
        }
    }

    /// The next time of `output.fields-interval` \[s\].
    fn next_output(&self) -> Option<f64> {
        let (interval, time) = (self.case.output.fields_interval?, self.case.time.as_ref()?);
        let done = ((self.stepper.time - time.start) / interval + 1e-9).floor();
        Some(time.start + (done + 1.0) * interval)
    }

    /// Whether the present time is one of `output.fields-interval`.
    pub fn is_output_time(&self) -> bool {
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
            let StepView { rule, new, old } = view;
            let snapshot = Snapshot {
                space: &assembler.space,
                physics: &assembler.physics,
                rule,
                new,
                old,
                fluid_residual: &self.fluid_residual,
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
        }
    }

    /// Go on from a checkpoint taken after step `step`.
    ///
    /// # Errors
    /// If the kept Jacobian cannot be factorised.
    pub fn restore(
        &mut self,
        clock: Clock,
        new: State,
        old: State,
        point: Option<JacobianPoint>,
        step: u64,
    ) -> Result<(), Error> {
        self.steps = step;
        if let Some(adaptive) = &mut self.adaptive {
            adaptive.memory.past.clear();
        }
        let stepper = &mut self.stepper;
        match &self.pool {
            None => stepper.restore(clock, new, old, point)?,
            Some(pool) => pool.install(|| stepper.restore(clock, new, old, point))?,
        }
        Ok(())
    }

    /// Number of the functional whose period is the window of the statistics.
    pub fn leading(&self) -> Option<usize> {
        let position = |test: &dyn Fn(&str) -> bool| self.functionals.iter().position(|(name, _)| test(name));
        match &self.case.output.leading {
            Some(name) => position(&|n| n == name),
            None => position(&|n| n.starts_with("uy")).or_else(|| position(&|n| n == "lift")),
        }
    }

    /// Last values, means, amplitudes and frequencies so far.
    pub fn statistics(&self) -> BTreeMap<String, FunctionalSummary> {
        let times: Vec<f64> = self.history.iter().map(|r| r.time).collect();
        let force_times: Vec<f64> = self.history.iter().map(|r| r.force_time).collect();
        let column = |i: usize| -> Vec<f64> { self.history.iter().map(|r| r.values[i]).collect() };
        let times_of = |i: usize| {
            let f: &dyn Functional<2> = &*self.functionals[i].1;
            if f.at_force_time() { &force_times } else { &times }
        };
        let window = self.leading().and_then(|i| leading_window(times_of(i), &column(i)));
        let mut summaries = BTreeMap::new();
        for (i, (name, f)) in self.functionals.iter().enumerate() {
            let s = statistics(times_of(i), &column(i), window);
            let unit = f.unit().to_string();
            let summary = FunctionalSummary {
                last: s.last,
                mean: s.mean,
                amplitude: s.amplitude,
                frequency: s.frequency,
                unit,
            };
            summaries.insert(name.clone(), summary);
        }
        summaries
    }

    /// Numbers of unknowns, given ones counted.
    pub fn unknowns(&self) -> Unknowns {
        let space = &self.stepper.assembler.space;
        Unknowns {
            velocity: space.n_v(),
            deformation: space.n_u(),
            pressure: space.n_p(),
            total: space.n_unknowns(),
        }
    }
}
