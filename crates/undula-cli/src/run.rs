//! `undula run`: compute a case and show how it goes.

use crate::args::{
    BREAKDOWN, CaseArgs, INTERRUPTED, Log, RunArgs, bad_input, log_as, say, say_notes, show, speak_as,
    threads, with_causes,
};
use crate::digits::fixed;
use crate::events::{self, Events};
use crate::live::Live;
use crate::progress::{Progress, StepInfo};
use crate::{check, compare, launch, plot, report};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use undula::algebra::Engine;
use undula::case::Case;
use undula::error::Error;
use undula::output::directory::{HISTORY, SUMMARY};
use undula::output::{Status, Summary};
use undula::parallel::{Agreed, Team, Wish};
use undula::results::computed::case_of;
use undula::run::{Flow, Observer, RunOptions};
use undula::simulation::{Row, Simulation};

/// Runs the case; afterwards results stand beside published ones, and pictures are drawn.
pub fn run(args: &RunArgs) -> anyhow::Result<ExitCode> {
    log_as(args.log);
    let mut team = match launch::team() {
        Ok(team) => team,
        Err(code) => return Ok(code),
    };
    let case = match load(&args.case, &mut team)? {
        Ok(case) => case,
        Err(code) => return Ok(code),
    };
    let directory = args.output.clone().unwrap_or_else(|| Path::new("out").join(&case.name));
    let options = RunOptions {
        directory: directory.clone(),
        threads: if team.size() > 1 { usize::from(args.threads.unwrap_or(1)) } else { threads(args.threads) },
        force: args.force,
        resume: args.resume,
        commit: option_env!("UNDULA_COMMIT").map(String::from),
    };
    let end = case.time.as_ref().map(|t| t.end);
    let mut display = Display {
        progress: team.is_first().then(|| Progress::new(end, args.quiet, args.log)),
        events: (args.log == Log::Json && team.is_first()).then(Events::new),
        directory: directory.clone(),
        quiet: args.quiet,
        verbose: args.verbose,
        stop: interrupt_flag()?,
        live: None,
    };
    if let Some(port) = args.live.filter(|_| team.is_first()) {
        match Live::start(&directory, port) {
            Ok(live) => {
                say(format_args!("live page {}", live.url));
                display.live = Some(live);
            }
            // The others wait for this one.
            Err(error) if team.size() > 1 => say(format_args!("note: --live={port}: {error}: no live page")),
            Err(error) => return bad_input(format_args!("--live={port}: {error}; name another port")),
        }
    }
    let result = match case.mesh.dimension {
        3 => undula::run::run_together::<3>(case, &options, &mut display, &mut team),
        _ => undula::run::run_together::<2>(case, &options, &mut display, &mut team),
    };
    if !team.is_first() {
        return end_of_follower(result, &team);
    }
    display.end(&result, args.log);
    let progress = display.progress.take();
    match result {
        Ok(summary) => finish(progress, &summary, &directory, args, end.is_some()),
        Err(error) => {
            if let Some(progress) = progress {
                progress.clear();
            }
            failed(error)
        }
    }
}

/// The case of a run: the same for all processes, which end together where one of them has none.
fn load(args: &CaseArgs, team: &mut Team) -> anyhow::Result<Result<Case, ExitCode>> {
    let loaded = load_here(args, team.size());
    if team.size() == 1 {
        return loaded;
    }
    let wish = match &loaded {
        Ok(Ok(_)) => Wish::GoOn,
        Ok(Err(_)) => Wish::Fail(2),
        Err(_) => Wish::Fail(1),
    };
    match team.agree(wish).map_err(Error::Processes)? {
        Agreed::Fail { first, .. } if first > 0 && first == team.rank() => {
            // Again, aloud.
            speak(team);
            load_here(args, team.size())
        }
        Agreed::Fail { first, code } if first != team.rank() => Ok(Err(ExitCode::from(code))),
        _ => loaded,
    }
}

/// The case of one of `n` processes. Several of them take PETSc, unless the case names another engine, and multigrid in
/// space where it is usual there, unless the case says how PETSc shall solve.
fn load_here(args: &CaseArgs, n: usize) -> anyhow::Result<Result<Case, ExitCode>> {
    const ENGINE: &str = "linear.engine";
    const OTHERS: [&str; 2] = ["linear.solver", "linear.petsc.options"];
    let loaded = check::load(args)?;
    let Ok(case) = &loaded else { return Ok(loaded) };
    if n == 1 || case.linear.engine == Engine::Petsc {
        return Ok(loaded);
    }
    if case.record.places.contains_key(ENGINE) {
        let message = format!("{n} processes are computed by PETSc: expected `petsc`");
        return bad_input(case.refuse(ENGINE, message)).map(Err);
    }
    let says_how = OTHERS.iter().any(|key| case.record.places.contains_key(*key));
    let usual = (case.mesh.dimension == 3 && !says_how).then(|| "linear.solver=automatic".to_string());
    let set = args.set.iter().cloned().chain([format!("{ENGINE}=petsc")]).chain(usual).collect();
    check::load(&CaseArgs { case: args.case.clone(), set })
}

/// What is said from here on is said by this process, by its number.
fn speak(team: &Team) {
    speak_as(format!("process {} of {}", team.rank(), team.size()));
}

/// The exit code of a process that writes nothing. It speaks where the first one does not know what went wrong.
fn end_of_follower(result: Result<Summary, Error>, team: &Team) -> anyhow::Result<ExitCode> {
    match result {
        Ok(summary) => Ok(match summary.status {
            Status::Interrupted => ExitCode::from(INTERRUPTED),
            _ => ExitCode::SUCCESS,
        }),
        Err(Error::Elsewhere { code }) => Ok(ExitCode::from(code)),
        // All have found it, and the first one says it.
        Err(error @ Error::Differing { .. }) => Ok(ExitCode::from(error.exit_code())),
        Err(error) => {
            speak(team);
            failed(error)
        }
    }
}

/// Set by Ctrl-C and by a termination signal; the run then ends after an iteration of Newton's method, with the state
/// before the step. A second signal ends it now.
pub fn interrupt_flag() -> anyhow::Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = stop.clone();
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    })?;
    Ok(stop)
}

/// Shows the steps of a run.
struct Display {
    progress: Option<Progress>,
    events: Option<Events>,
    directory: PathBuf,
    quiet: bool,
    verbose: bool,
    stop: Arc<AtomicBool>,
    live: Option<Live>,
}

impl Display {
    /// The end of a run for those who watch it.
    fn end(&mut self, result: &Result<Summary, Error>, log: Log) {
        if let Some(live) = self.live.take() {
            live.end(&result.as_ref().map_or_else(ToString::to_string, |summary| summary.status.to_string()));
        }
        if log == Log::Json {
            events::end(result.as_ref().map_err(ToString::to_string));
        }
    }
}

impl<const D: usize> Observer<D> for Display {
    fn start(&mut self, simulation: &Simulation<D>) {
        if let Some(events) = &mut self.events {
            events.start(simulation, &self.directory);
            say_notes(simulation.case.notes());
            say_notes(&simulation.case.notes_on(&simulation.stepper.assembler.space));
        } else if !self.quiet {
            say_notes(simulation.case.notes());
            let unknowns = simulation.unknowns();
            let cells = simulation.cells();
            let Case { name, title, .. } = &simulation.case;
            let threads = simulation.threads();
            let text = format!(
                "{name}: {title}\n{cells} cells, {} unknowns (velocity {}, deformation {}, pressure {}), {threads} \
                 thread{}",
                unknowns.total,
                unknowns.velocity,
                unknowns.deformation,
                unknowns.pressure,
                if threads == 1 { "" } else { "s" },
            );
            if let Some(progress) = &self.progress {
                progress.message(&text);
                for note in simulation.case.notes_on(&simulation.stepper.assembler.space) {
                    progress.message(&format!("note: {note}"));
                }
            }
        }
    }

    fn note(&mut self, note: &str) {
        if let Some(progress) = &self.progress {
            progress.message(&format!("note: {note}"));
        }
    }

    fn stop(&self) -> Option<Arc<AtomicBool>> {
        Some(self.stop.clone())
    }

    fn after_step(&mut self, simulation: &Simulation<D>, row: &Row) -> Flow {
        if let Some(live) = &self.live {
            live.row(row);
        }
        if let Some(events) = &mut self.events {
            events.step(simulation, row);
        }
        let names = simulation.names();
        let leading = simulation.leading().map(|i| (names[i].as_str(), row.values[i], simulation.units()[i]));
        let info = StepInfo {
            step: row.step,
            time: row.time,
            newton_steps: row.newton_steps,
            jacobians: row.jacobians,
            leading,
            min_j: row.min_j,
        };
        if let (true, Some(progress)) = (self.verbose, &self.progress) {
            progress.message(&iterations(simulation, row));
        }
        if let Some(progress) = &mut self.progress {
            progress.update(&info);
        }
        if self.stop.load(Ordering::Relaxed) { Flow::Stop } else { Flow::Continue }
    }
}

/// The scaled residuals of a step, from its start value on; those of its parts apart.
fn iterations<const D: usize>(simulation: &Simulation<D>, row: &Row) -> String {
    let residuals = |part: &[f64]| part.iter().map(|r| format!("{r:.2e}")).collect::<Vec<_>>().join(" ");
    let parts: Vec<String> = simulation.report.residuals_of_parts().map(residuals).collect();
    let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    let jacobians = count(row.jacobians, "Jacobian");
    let of = match simulation.case.time {
        Some(_) => format!("t = {} s", fixed(row.time, row.time, 4)),
        None => "stationary".into(),
    };
    format!("{of}: {jacobians}, residuals {}", parts.join(" | "))
}

/// What a step has cost, for each unknown.
fn cost(summary: &Summary) -> Option<String> {
    let pieces = summary.unknowns.total as f64 * summary.steps as f64;
    let each = summary.cpu_seconds.filter(|_| pieces > 0.0)? / pieces;
    Some(format!(", {:.3} µs of processor time per unknown and step", 1e6 * each))
}

/// The end of a run that has a summary.
fn finish(
    progress: Option<Progress>,
    summary: &Summary,
    directory: &Path,
    args: &RunArgs,
    resumable: bool,
) -> anyhow::Result<ExitCode> {
    if let Some(progress) = progress {
        // Seconds of a run that was resumed are those since then, its steps are not.
        let cost = if args.resume { None } else { cost(summary) };
        progress.finish(&summary.status.to_string(), cost.as_deref().unwrap_or_default());
    }
    if let Some(breakdown) = &summary.breakdown {
        say(format_args!("breakdown: {}", breakdown.reason));
        if !breakdown.remedy.is_empty() {
            say(format_args!("{}", breakdown.remedy));
        }
        let directory = directory.display();
        say(format_args!(
            "what was computed so far is in {directory}, residuals in {directory}/breakdown.txt"
        ));
    }
    if let Some(part) = summary.mass_balance.filter(|&part| part > Summary::BALANCED) {
        say(format_args!(
            "warning: the flow through the boundaries of the fluid does not balance: at some step {part:.1e} of the \
             largest flow is gained or lost (mass_balance in summary.json)"
        ));
    }
    let code = match summary.status {
        Status::Breakdown => ExitCode::from(BREAKDOWN),
        Status::Interrupted => {
            if !args.quiet {
                say(match resumable {
                    true => "go on with the same command and --resume",
                    // On the way to a stationary solution there is no state that would be worth keeping.
                    false => "nothing of a stationary solution is kept: start again with --force",
                });
            }
            return Ok(ExitCode::from(INTERRUPTED));
        }
        Status::Completed => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    };
    if !args.quiet {
        show_results(summary, directory);
        show_report(directory);
    }
    for file in [SUMMARY, HISTORY].map(|name| directory.join(name)) {
        anyhow::ensure!(file.exists(), "{}: was removed as soon as the run had ended", file.display());
    }
    Ok(code)
}

/// Writes the page about the run, unless its case wants none, and says where it is. It cannot spoil a finished run.
fn show_report(directory: &Path) {
    let wanted = case_of(directory).is_none_or(|case| case.output.report);
    if !wanted {
        return;
    }
    match report::write(directory, None, &[]) {
        Ok(path) => show(&format!("report    {}\n", path.display())),
        Err(error) => say(format_args!("note: no report: {}", with_causes(&error))),
    }
}

/// Computed beside published values, and where the pictures lie. Neither can spoil a finished run.
fn show_results(summary: &Summary, directory: &Path) {
    if summary.status == Status::Completed
        && let Err(error) = compare::show(directory)
    {
        say(format_args!("note: {}", with_causes(&error)));
    }
    match plot::plot_directory(directory, None) {
        Ok(pictures) => {
            let list: Vec<String> = pictures.iter().map(|p: &PathBuf| p.display().to_string()).collect();
            show(&format!("results   {}\n", directory.display()));
            show(&format!("fields    {}\n", directory.join("fields.pvd").display()));
            for (n, picture) in list.iter().enumerate() {
                show(&format!("{}{picture}\n", if n == 0 { "pictures  " } else { "          " }));
            }
        }
        Err(error) => say(format_args!("note: no pictures: {}", with_causes(&error))),
    }
}

/// An error: 2 where the input is to blame, else 1.
pub fn failed(error: Error) -> anyhow::Result<ExitCode> {
    match &error {
        Error::Breakdown(failure) => {
            say(format_args!("breakdown: there is no equilibrium to start with: {failure}"));
            Ok(ExitCode::from(BREAKDOWN))
        }
        Error::Elsewhere { code } => {
            say(format_args!("error: {error}"));
            Ok(ExitCode::from(*code))
        }
        _ if error.is_bad_input() => bad_input(error),
        _ => Err(error.into()),
    }
}
