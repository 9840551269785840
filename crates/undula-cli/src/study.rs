//! `undula study`: many runs, their tables, figures and statements on one page; `undula reproduce`: those of the book.

use crate::args::{CaseArgs, Common, INTERRUPTED, ReproduceArgs, StudyArgs, bad_input, say, show, threads};
use crate::check;
use crate::digits::significant;
use crate::page::{self, Heading};
use crate::run::{failed, interrupt_flag};
use anyhow::Context;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use undula::output::Status;
use undula::study::converge::{self, Converged, Direction};
use undula::study::{Event, Job, Report, Settings, Shown, Study, Table, Verdict, Watch, chapter};

/// A file that says that a directory is one of studies.
const MARK: &str = "study.txt";

/// Computes a study of the user.
pub fn run(args: &StudyArgs) -> anyhow::Result<ExitCode> {
    let file = args.file.clone();
    let study = if args.converge {
        let case = CaseArgs { case: file.clone(), set: args.set.clone() };
        match check::load(&case)? {
            Ok(case) => converge::study(&case, &file, &args.set, usize::from(args.levels)),
            Err(code) => return Ok(code),
        }
    } else {
        let text = match std::fs::read_to_string(&file) {
            Ok(text) => text,
            Err(error) => {
                return bad_input(format_args!(
                    "{file}: {error}; expected a study, a TOML file{}",
                    hint(&file)
                ));
            }
        };
        match Study::from_toml(&text, &file) {
            Ok(study) => study,
            Err(error) => return bad_input(format_args!("{error}{}", hint_of_case(&text, &file))),
        }
    };
    // The case of a convergence study is named as on the command line.
    let base = if args.converge {
        PathBuf::new()
    } else {
        Path::new(&file).parent().map(Path::to_path_buf).unwrap_or_default()
    };
    let directory = args.common.output.clone().unwrap_or_else(|| Path::new("out").join(&study.name));
    let title = if study.title.is_empty() { study.name.clone() } else { study.title.clone() };
    let mut command = format!("undula study {file}");
    if args.converge {
        command += &format!(" --converge --levels {}", args.levels);
        args.set.iter().for_each(|set| command += &format!(" --set {set}"));
    }
    if args.common.quick {
        command += " --quick";
    }
    let all = [Source { study, file, base }];
    let heading = Heading { title: &title, about: &[], command: &command };
    let Common { force, collect, quiet, threads: asked, .. } = args.common;
    Call { quick: args.common.quick, force, collect, quiet, threads: threads(asked), converge: args.converge }
        .compute(&all, &directory, &heading)
}

/// Where somebody names a built-in case instead of a study.
fn hint(file: &str) -> String {
    match undula::case::builtin::builtin_case(file) {
        Some(_) => format!(
            "; `{file}` is a built-in case: run it with `undula run {file}`, refine it with --converge"
        ),
        None => String::new(),
    }
}

/// Where somebody names a case file instead of a study.
fn hint_of_case(text: &str, file: &str) -> String {
    match undula::case::Case::from_toml(text, file, &[]) {
        Ok(_) => format!("\n{file} is a case: run it with `undula run {file}`, refine it with --converge"),
        Err(_) => String::new(),
    }
}

/// Computes studies of the book.
pub fn reproduce(args: &ReproduceArgs) -> anyhow::Result<ExitCode> {
    let mut all = vec![];
    for (name, text) in chapter() {
        if args.studies.is_empty() || args.studies.iter().any(|asked| asked == name) {
            let file = format!("{name}.toml");
            let study = Study::from_toml(text, &file)?;
            all.push(Source { study, file, base: PathBuf::new() });
        }
    }
    let names: Vec<&str> = chapter().iter().map(|(name, _)| *name).collect();
    if let Some(unknown) = args.studies.iter().find(|asked| !names.contains(&asked.as_str())) {
        return bad_input(format_args!(
            "no study of the book is called `{unknown}`; there are {}",
            names.join(", ")
        ));
    }
    if args.list {
        let lines = all.iter().map(|source| {
            format!("{:14} {} ({})\n", source.study.name, source.study.title, source.study.section)
        });
        show(&lines.collect::<String>());
        return Ok(ExitCode::SUCCESS);
    }
    let directory = args.common.output.clone().unwrap_or_else(|| Path::new("out").join("chapter-5"));
    let mut command = "undula reproduce".to_string();
    args.studies.iter().for_each(|study| command += &format!(" {study}"));
    if args.common.quick {
        command += " --quick";
    }
    let heading = Heading {
        title: "Numerical studies of chapter 5",
        about: &[
            "Th. Richter, Fluid-structure Interactions, Springer 2017, chapter 5: published numbers and statements, beside \
             what Undula computes. Numbers in grey are published ones.",
            "A statement is reproduced if its condition holds for the number that was computed. Conditions are expressions \
             over results of the runs.",
        ],
        command: &command,
    };
    let Common { force, collect, quiet, threads: asked, .. } = args.common;
    Call { quick: args.common.quick, force, collect, quiet, threads: threads(asked), converge: false }
        .compute(&all, &directory, &heading)
}

/// A study with its origin.
struct Source {
    study: Study,
    file: String,
    /// Directory that relative paths of cases are relative to.
    base: PathBuf,
}

/// How studies are computed.
struct Call {
    quick: bool,
    force: bool,
    collect: bool,
    quiet: bool,
    threads: usize,
    converge: bool,
}

impl Call {
    fn compute(&self, all: &[Source], directory: &Path, heading: &Heading<'_>) -> anyhow::Result<ExitCode> {
        let mut jobs = vec![];
        for source in all {
            match source.study.jobs(self.quick, &source.base, &source.file) {
                Ok(found) => jobs.push(found),
                Err(error) => return bad_input(error),
            }
        }
        for (source, jobs) in all.iter().zip(&jobs) {
            if let Err(error) = source.study.check(jobs, &source.file) {
                return bad_input(error);
            }
        }
        if let Some(code) = self.prepare(all, &jobs, directory)? {
            return Ok(code);
        }
        let watch = Lines { quiet: self.quiet, stop: interrupt_flag()?, begun: Instant::now() };
        let mut reports: Vec<Report> = vec![];
        for (source, jobs) in all.iter().zip(&jobs) {
            if !self.quiet {
                let how =
                    if source.study.timed { ", timed: one after the other, on one thread each" } else { "" };
                say(format_args!("{}: {} runs{how}", source.study.name, jobs.len()));
            }
            let computed = match source.study.compute(jobs, &self.settings(directory, &source.study), &watch)
            {
                Ok(computed) => computed,
                Err(error) => return failed(error),
            };
            match source.study.report(&computed, self.quick, &source.file) {
                Ok(mut report) => {
                    if self.converge {
                        let found = converge::converged(&computed);
                        if !self.quiet {
                            found.iter().for_each(|found| show(&format!("{}\n", words(found))));
                        }
                        report.tables.push(converge_table(&found));
                    }
                    reports.push(report);
                }
                Err(error) => return bad_input(error),
            }
            page::write(directory, heading, &reports)?;
            if watch.stop.load(Ordering::Relaxed) {
                if !self.quiet {
                    say("interrupted: the same command goes on");
                }
                return Ok(ExitCode::from(INTERRUPTED));
            }
        }
        if !self.quiet {
            self.conclude(&reports, directory);
        }
        Ok(ExitCode::SUCCESS)
    }

    fn settings(&self, directory: &Path, study: &Study) -> Settings {
        Settings {
            directory: directory.join(&study.name).join("runs"),
            threads: self.threads,
            commit: option_env!("UNDULA_COMMIT").map(String::from),
            collect: self.collect,
        }
    }

    /// Makes the directory; an exit code where it cannot be used.
    fn prepare(
        &self,
        all: &[Source],
        jobs: &[Vec<Job>],
        directory: &Path,
    ) -> anyhow::Result<Option<ExitCode>> {
        let mark = directory.join(MARK);
        let strange = directory.is_file()
            || (!mark.is_file()
                && std::fs::read_dir(directory).is_ok_and(|mut entries| entries.next().is_some()));
        if strange {
            let directory = directory.display();
            return Ok(Some(bad_input(format_args!(
                "{directory}: is no directory of a study; name another with -o"
            ))?));
        }
        for (source, jobs) in all.iter().zip(jobs) {
            let changed = self.settings(directory, &source.study).changed(jobs);
            if !changed.is_empty() && !self.force {
                let (file, directory, changed) = (&source.file, directory.display(), changed.join(", "));
                return Ok(Some(bad_input(format_args!(
                    "{file}: {directory} has these runs with other settings: {changed}; replace them with --force, or \
                     name another directory with -o"
                ))?));
            }
        }
        std::fs::create_dir_all(directory)
            .with_context(|| format!("cannot create {}", directory.display()))?;
        std::fs::write(&mark, "A directory of undula study or undula reproduce: they go on in it.\n")
            .with_context(|| format!("cannot write {}", mark.display()))?;
        Ok(None)
    }

    fn conclude(&self, reports: &[Report], directory: &Path) {
        for weighed in reports.iter().flat_map(|report| &report.statements) {
            if weighed.verdict != Verdict::Reproduced {
                show(&format!("{}: {}\n", weighed.verdict, weighed.statement.text));
            }
        }
        let n = |verdict| page::count(reports, verdict);
        let total = reports.iter().map(|report| report.statements.len()).sum::<usize>();
        if total > 0 {
            show(&format!(
                "{total} statements: {} reproduced, {} not reproduced, {} undecided\n",
                n(Verdict::Reproduced),
                n(Verdict::NotReproduced),
                n(Verdict::Undecided)
            ));
        }
        show(&format!("page  {}\n", directory.join("index.html").display()));
    }
}

fn refined(direction: Direction) -> &'static str {
    match direction {
        Direction::Mesh => "mesh",
        Direction::Step => "step",
    }
}

/// What refinement says about one number, in a line.
fn words(found: &Converged) -> String {
    let Converged { functional, quantity, unit, direction, results, order, extrapolated, uncertainty } =
        found;
    let order = order.map_or("none".into(), |p| significant(p, 3));
    let value = extrapolated
        .map_or_else(|| format!("{} (finest)", significant(results[2], 7)), |x| significant(x, 7));
    let by = refined(*direction);
    format!(
        "{functional} {quantity}, {by} refined: {value} ± {} {unit}, order {order}",
        significant(*uncertainty, 2)
    )
}

fn converge_table(found: &[Converged]) -> Table {
    let head =
        ["functional", "", "unit", "refined", "coarse", "medium", "fine", "order", "extrapolated", "±"];
    let row = |found: &Converged| {
        let mut row: Vec<Shown> = [&found.functional, found.quantity, &found.unit, refined(found.direction)]
            .map(|text| Shown::Text(text.to_string()))
            .into();
        row.extend(found.results.map(Shown::Exact));
        row.push(Shown::Computed(found.order));
        row.push(found.extrapolated.map_or(Shown::Computed(None), Shown::Exact));
        row.push(Shown::Computed(Some(found.uncertainty)));
        row
    };
    Table {
        title: "Convergence".into(),
        head: head.map(String::from).into(),
        rows: found.iter().map(row).collect(),
        note: "The order is that of the last three results; extrapolated after Richardson, uncertainty by the grid \
               convergence index. Without an order between ½ and 8 there is no extrapolated value."
            .into(),
    }
}

/// One line for each run.
struct Lines {
    quiet: bool,
    stop: Arc<AtomicBool>,
    begun: Instant,
}

impl Watch for Lines {
    fn event(&self, event: &Event<'_>) {
        if self.quiet {
            return;
        }
        let clock = self.begun.elapsed().as_secs_f64();
        match event {
            Event::Begins(job, [ended, of]) => {
                say(format_args!("{clock:7.1} s  {}/{of}  {} …", ended + 1, job.name))
            }
            Event::Kept(job) => say(format_args!("{clock:7.1} s  {} is there already", job.name)),
            Event::Ended(job, status, seconds) => {
                let status =
                    if *status == Status::Breakdown { "breakdown".into() } else { status.to_string() };
                say(format_args!("{clock:7.1} s  {} {status} after {seconds:.1} s", job.name));
            }
        }
    }

    fn stop(&self) -> Arc<AtomicBool> {
        self.stop.clone()
    }
}
