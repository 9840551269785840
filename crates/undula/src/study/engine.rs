//! The runs of a study: their cases, and their computation on all cores.

use super::file::{RunEntry, Study, StudyError, Values};
use super::known::NUMBERS;
use crate::case::Case;
use crate::case::builtin::builtin_case;
use crate::error::Error;
use crate::output::{Status, Summary, hash, write_atomic};
use crate::results::computed::Results;
use crate::run::{Flow, Observer, RunOptions, mesh_hash, run};
use crate::simulation::{Row, Simulation};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

/// One run of a study.
#[derive(Clone, Debug)]
pub struct Job {
    /// Name in expressions.
    pub name: String,
    /// Built-in case or file.
    pub of: String,
    /// Settings of this run that others of the study do not have, `key = value`.
    pub settings: Vec<(String, String)>,
    /// The case; that of a run that goes on from another is at rest.
    pub case: Case,
    /// Path or name of the case, and its settings.
    source: (String, Vec<String>),
    /// Run from whose last state it goes on.
    from: String,
    /// Whether a quick study leaves it out.
    pub left_out: bool,
}

impl Job {
    /// The case, from the state that another run of the study in `directory` has reached.
    fn case_in(&self, directory: &Path) -> Result<Case, Error> {
        if self.from.is_empty() {
            return Ok(self.case.clone());
        }
        let from = directory.join(&self.from);
        let from = std::path::absolute(&from).unwrap_or(from);
        let assignment = format!("initial.from={}", toml::Value::String(from.to_string_lossy().into_owned()));
        let (path, settings) = &self.source;
        Ok(Case::load(path, &[settings.clone(), vec![assignment]].concat())?)
    }

    /// Names of its functionals.
    pub(super) fn functionals(&self) -> Vec<String> {
        self.case.functional.iter().map(|(name, _)| name.clone()).collect()
    }
}

/// How a study is computed.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Directory of the study; each run has one of its own inside.
    pub directory: PathBuf,
    /// Threads, over all runs.
    pub threads: usize,
    /// Commit of the source of the program, which the summaries name.
    pub commit: Option<String>,
}

impl Settings {
    /// Runs of `jobs` that were computed with other settings.
    pub fn changed(&self, jobs: &[Job]) -> Vec<String> {
        let is_other = |job: &&Job| {
            let before = std::fs::read_to_string(self.marker(job));
            !job.left_out && before.is_ok_and(|before| before != self.asked(job, jobs))
        };
        jobs.iter().filter(is_other).map(|job| job.name.clone()).collect()
    }

    /// All that makes a run another one.
    fn asked(&self, job: &Job, jobs: &[Job]) -> String {
        let mesh = mesh_hash(&job.case).unwrap_or_default();
        let before = jobs.iter().find(|other| other.name == job.from).map(|other| self.asked(other, &[]));
        let before =
            before.map_or(String::new(), |text| format!("# goes on from {}\n", hash(text.as_bytes())));
        format!("# mesh {mesh}\n{before}{}", job.case.to_toml())
    }

    /// The file with the case as it was asked for.
    fn marker(&self, job: &Job) -> PathBuf {
        self.directory.join(format!("{}.asked.toml", job.name))
    }
}

/// A run with its results.
#[derive(Clone, Debug)]
pub struct Computed {
    /// Which.
    pub job: Job,
    /// Its results; `None` where it is left out or was interrupted.
    pub results: Option<Results>,
    /// Whether an earlier call had computed it.
    pub kept: bool,
    /// Its directory.
    pub directory: PathBuf,
}

impl Computed {
    /// Whether it has results up to its end.
    pub fn is_completed(&self) -> bool {
        self.results.as_ref().is_some_and(|results| results.summary.status == Status::Completed)
    }

    /// A run without results in a study in `directory`.
    fn absent(job: &Job, directory: &Path) -> Computed {
        Computed { job: job.clone(), results: None, kept: false, directory: directory.join(&job.name) }
    }
}

/// What happens to a run.
#[derive(Clone, Debug)]
pub enum Event<'a> {
    /// It begins; how many have ended, of how many.
    Begins(&'a Job, [usize; 2]),
    /// It has ended.
    Ended(&'a Job, Status, f64),
    /// An earlier call had computed it.
    Kept(&'a Job),
}

/// Watches a study.
pub trait Watch: Sync {
    /// Called from several threads.
    fn event(&self, event: &Event<'_>);
    /// Ends the study when it is set.
    fn stop(&self) -> Arc<AtomicBool>;
}

impl Study {
    /// The runs with their cases. Relative paths of cases are relative to `base`; `file` is the name of the study in
    /// messages.
    ///
    /// # Errors
    /// A run whose case has mistakes.
    pub fn jobs(&self, quick: bool, base: &Path, file: &str) -> Result<Vec<Job>, StudyError> {
        let mut jobs = vec![];
        for entry in &self.run {
            for (name, values, is_quick) in combinations(entry) {
                let mut all = defaults();
                all.extend(self.set.clone());
                if quick {
                    all.extend(self.quick.clone());
                }
                let mut own = entry.set.clone();
                if quick {
                    own.extend(entry.quick.clone());
                }
                own.extend(values);
                all.extend(own.clone());
                let of = if entry.case.is_empty() { &self.case } else { &entry.case };
                let path = match builtin_case(of) {
                    Some(_) => of.clone(),
                    None => base.join(of).to_string_lossy().into_owned(),
                };
                let wrong =
                    |message: String| StudyError::Run { file: file.into(), run: name.clone(), message };
                if jobs.iter().any(|job: &Job| job.name == name) {
                    return Err(wrong("another run has this name, of which `over` makes some".into()));
                }
                let left_out = quick && (entry.full_only || !is_quick);
                let all = [self.assignments.clone(), assignments(&all)].concat();
                let case = Case::load(&path, &all).map_err(|e| wrong(e.to_string()))?;
                if let Some(twice) = reserved(&case) {
                    return Err(wrong(format!("functional.{twice}: every run has a result of this name")));
                }
                let (source, from) = ((path, all), entry.from.clone());
                let settings = own.iter().map(|(key, value)| (key.clone(), text(value))).collect();
                jobs.push(Job { name, of: of.clone(), settings, case, left_out, source, from });
            }
        }
        Ok(jobs)
    }

    /// Reads all expressions, without results of `jobs`: mistakes in them are found before anything is computed.
    ///
    /// # Errors
    /// As [`Study::report`].
    pub fn check(&self, jobs: &[Job], file: &str) -> Result<(), StudyError> {
        let absent: Vec<Computed> = jobs.iter().map(|job| Computed::absent(job, Path::new(""))).collect();
        self.report(&absent, false, file).map(|_| ())
    }

    /// Computes `jobs`, as many at a time as there are threads, or one after the other where their seconds are compared.
    /// A run that an earlier call has computed is kept, one that it has begun goes on.
    ///
    /// # Errors
    /// The first error of a run. A breakdown is none.
    pub fn compute(
        &self,
        jobs: &[Job],
        settings: &Settings,
        watch: &dyn Watch,
    ) -> Result<Vec<Computed>, Error> {
        let found: Mutex<Vec<Option<Computed>>> = Mutex::new(vec![None; jobs.len()]);
        let failure: Mutex<Option<Error>> = Mutex::new(None);
        let ended = AtomicUsize::new(0);
        let stop = watch.stop();
        for later in [false, true] {
            let wave: Vec<usize> = (0..jobs.len()).filter(|&n| jobs[n].from.is_empty() != later).collect();
            let at_once = if self.timed { 1 } else { settings.threads.min(wave.len()).max(1) };
            let threads = if self.timed { 1 } else { (settings.threads / at_once).max(1) };
            let next = AtomicUsize::new(0);
            let work = || {
                while let Some(&n) = wave.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if stop.load(Ordering::Relaxed) || lock(&failure).is_some() {
                        return;
                    }
                    let progress = [ended.load(Ordering::Relaxed), jobs.len()];
                    // A run that did not reach its end has no state to go on from.
                    let reached = |base: &Computed| base.job.name == jobs[n].from && base.is_completed();
                    if later && !lock(&found).iter().flatten().any(reached) {
                        continue;
                    }
                    match compute(n, jobs, settings, threads, watch, progress) {
                        Ok(computed) => lock(&found)[n] = Some(computed),
                        Err(error) => *lock(&failure) = Some(error),
                    }
                    ended.fetch_add(1, Ordering::Relaxed);
                }
            };
            std::thread::scope(|scope| {
                (0..at_once).for_each(|_| {
                    scope.spawn(work);
                });
            });
        }
        if let Some(error) = lock(&failure).take() {
            return Err(error);
        }
        let found = std::mem::take(&mut *lock(&found));
        let absent = |job: &Job| Computed::absent(job, &settings.directory);
        Ok(found
            .into_iter()
            .zip(jobs)
            .map(|(computed, job)| computed.unwrap_or_else(|| absent(job)))
            .collect())
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// A functional whose name is that of another result in expressions.
fn reserved(case: &Case) -> Option<&str> {
    case.functional.iter().map(|(name, _)| name.as_str()).find(|name| NUMBERS.contains(name))
}

/// Runs of a study write what expressions need.
fn defaults() -> Values {
    ["output.fields-every", "output.checkpoint-every"]
        .map(|key| (key.to_string(), toml::Value::Integer(0)))
        .into()
}

/// Names and settings of all combinations, and whether a quick study has them.
fn combinations(entry: &RunEntry) -> Vec<(String, Values, bool)> {
    let mut all = vec![(entry.name.clone(), Values::new(), true)];
    for axis in &entry.over {
        let more = |(name, values, is_quick): &(String, Values, bool)| {
            let with = |(n, value): (usize, &toml::Value)| {
                let mut values = values.clone();
                values.insert(axis.key.clone(), value.clone());
                (format!("{name}_{n}"), values, *is_quick && axis.quick.is_none_or(|count| n < count))
            };
            axis.values.iter().enumerate().map(with).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(more).collect();
    }
    all
}

fn text(value: &toml::Value) -> String {
    match value {
        toml::Value::String(word) if word == "none" => word.clone(),
        value => value.to_string(),
    }
}

fn assignments(values: &Values) -> Vec<String> {
    values.iter().map(|(key, value)| format!("{key}={}", text(value))).collect()
}

fn compute(
    n: usize,
    jobs: &[Job],
    settings: &Settings,
    threads: usize,
    watch: &dyn Watch,
    progress: [usize; 2],
) -> Result<Computed, Error> {
    let job = &jobs[n];
    let mut computed = Computed::absent(job, &settings.directory);
    let directory = computed.directory.clone();
    if job.left_out {
        return Ok(computed);
    }
    let (asked, marker) = (settings.asked(job, jobs), settings.marker(job));
    let same = std::fs::read_to_string(&marker).is_ok_and(|before| before == asked);
    let before = Summary::read(directory.join("summary.json")).ok().filter(|_| same);
    let ended = |status: Status| matches!(status, Status::Completed | Status::Breakdown);
    if before.as_ref().is_some_and(|summary| ended(summary.status)) {
        watch.event(&Event::Kept(job));
        (computed.kept, computed.results) = (true, Some(Results::read(&directory)?));
        return Ok(computed);
    }
    watch.event(&Event::Begins(job, progress));
    std::fs::create_dir_all(&settings.directory)
        .map_err(crate::output::OutputError::io("create", &settings.directory))?;
    write_atomic(&marker, |file| file.write_all(asked.as_bytes()))?;
    let case = job.case_in(&settings.directory)?;
    let go_on = before.is_some() && case.time.is_some();
    let options = |resume: bool| RunOptions {
        directory: directory.clone(),
        threads,
        force: !resume,
        resume,
        commit: settings.commit.clone(),
    };
    let mut observer = Silent(watch.stop());
    let mut result = run(case.clone(), &options(go_on), &mut observer);
    if go_on && matches!(&result, Err(Error::Resume(_) | Error::Directory(_))) {
        result = run(case.clone(), &options(false), &mut observer);
    }
    let summary = result?;
    watch.event(&Event::Ended(job, summary.status, summary.wall_seconds));
    if ended(summary.status) {
        computed.results = Some(Results::read(&directory)?);
    }
    Ok(computed)
}

/// Ends a run when the study is stopped.
struct Silent(Arc<AtomicBool>);

impl Observer for Silent {
    fn stop(&self) -> Option<Arc<AtomicBool>> {
        Some(self.0.clone())
    }

    fn after_step(&mut self, _: &Simulation, _: &Row) -> Flow {
        if self.0.load(Ordering::Relaxed) { Flow::Stop } else { Flow::Continue }
    }
}
