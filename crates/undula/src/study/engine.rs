//! The runs of a study: their computation on all cores, and what an earlier call has left of them.

use super::file::{Study, StudyError};
use super::job::Job;
use super::quantities::{Compute, Numbers};
use crate::error::Error;
use crate::output::{Status, Summary, hash, write_atomic};
use crate::results::computed::Results;
use crate::run::{Flow, Observer, RunOptions, mesh_hash, run};
use crate::simulation::{Row, Simulation};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// How a study is computed.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Directory of the study; each run has one of its own inside.
    pub directory: PathBuf,
    /// Threads, over all runs.
    pub threads: usize,
    /// Commit of the source of the program, which the summaries name.
    pub commit: Option<String>,
    /// Nothing is computed: runs that are not there stay without results.
    pub collect: bool,
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
        let before = jobs.iter().find(|other| other.name == job.from).map(|other| self.asked(other, jobs));
        let before =
            before.map_or(String::new(), |text| format!("# goes on from {}\n", hash(text.as_bytes())));
        let case = job.case.to_toml_with(|table| format!("{}#{}", table.path.display(), table.hash));
        format!("# mesh {mesh}\n{before}{}{}", job.asked_numbers(), case)
    }

    /// The file with the case as it was asked for.
    fn marker(&self, job: &Job) -> PathBuf {
        self.directory.join(format!("{}.asked.toml", job.name))
    }

    /// The file with the numbers of a run besides or instead of its history.
    fn numbers(&self, job: &Job) -> PathBuf {
        self.directory.join(format!("{}.numbers.toml", job.name))
    }
}

/// A run with its results.
#[derive(Clone, Debug)]
pub struct Computed {
    /// Which.
    pub job: Job,
    /// Its results; `None` where it is left out, was interrupted, or is no run.
    pub results: Option<Results>,
    /// Numbers besides or instead of a history.
    pub numbers: Numbers,
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

    /// Whether it has results.
    pub fn is_there(&self) -> bool {
        self.results.is_some() || !self.numbers.is_empty()
    }

    /// Whether it is no run and has none of its numbers.
    pub(super) fn has_failed(&self) -> bool {
        let names = self.job.compute.names();
        !names.is_empty()
            && self.is_there()
            && names.iter().all(|name| self.numbers.get(name).is_none_or(|x| x.is_nan()))
    }

    /// A run without results in a study in `directory`.
    fn absent(job: &Job, directory: &Path) -> Computed {
        let directory = directory.join(&job.name);
        Computed { job: job.clone(), results: None, numbers: Numbers::new(), kept: false, directory }
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
        let depths: Vec<usize> = jobs.iter().map(|job| depth(job, jobs)).collect();
        for depth in 0..=depths.iter().copied().max().unwrap_or(0) {
            let wave: Vec<usize> = (0..jobs.len()).filter(|&n| depths[n] == depth).collect();
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
                    if depth > 0 && !lock(&found).iter().flatten().any(reached) {
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

/// How many runs there are before `job`, one behind the other.
fn depth(job: &Job, jobs: &[Job]) -> usize {
    jobs.iter().find(|other| other.name == job.from).map_or(0, |before| 1 + depth(before, jobs))
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// Whether a run has come to its end, whatever that was.
fn has_ended(summary: &Summary) -> bool {
    matches!(summary.status, Status::Completed | Status::Breakdown)
}

/// Computes job `n` of `jobs`, or takes what an earlier call has left of it.
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
    if job.left_out {
        return Ok(computed);
    }
    let asked = settings.asked(job, jobs);
    let same = std::fs::read_to_string(settings.marker(job)).is_ok_and(|before| before == asked);
    let before = Summary::read(computed.directory.join("summary.json")).ok().filter(|_| same);
    let numbers = read_numbers(&settings.numbers(job)).filter(|_| same);
    if let (Some(numbers), true) = (&numbers, job.compute != Compute::Run) {
        watch.event(&Event::Kept(job));
        (computed.kept, computed.numbers) = (true, numbers.clone());
        return Ok(computed);
    }
    if before.as_ref().is_some_and(has_ended) {
        watch.event(&Event::Kept(job));
        (computed.kept, computed.results) = (true, Some(Results::read(&computed.directory)?));
        computed.numbers = job.numbers_after(settings, numbers, threads)?;
        return Ok(computed);
    }
    if settings.collect {
        return Ok(computed);
    }
    watch.event(&Event::Begins(job, progress));
    settings.mark(job, &asked)?;
    match job.compute {
        Compute::Run => computed.run(before.is_some(), settings, threads, watch)?,
        _ => computed.without_run(settings, threads, watch)?,
    }
    Ok(computed)
}

impl Settings {
    /// Notes what is asked for now, and removes the numbers of what was asked for before.
    fn mark(&self, job: &Job, asked: &str) -> Result<(), Error> {
        std::fs::create_dir_all(&self.directory)
            .map_err(crate::output::OutputError::io("create", &self.directory))?;
        let numbers = self.numbers(job);
        if numbers.exists() {
            std::fs::remove_file(&numbers).map_err(crate::output::OutputError::io("remove", &numbers))?;
        }
        Ok(write_atomic(self.marker(job), |file| file.write_all(asked.as_bytes()))?)
    }
}

impl Computed {
    /// Computes the numbers of a job that is no run.
    fn without_run(&mut self, settings: &Settings, threads: usize, watch: &dyn Watch) -> Result<(), Error> {
        let (job, begun) = (&self.job, Instant::now());
        let (numbers, status) = match job.compute.numbers(&job.case, threads) {
            Ok(numbers) => (numbers, Status::Completed),
            // As in a run, a breakdown is a result.
            Err(Error::Breakdown(_)) => (job.compute.without_numbers(), Status::Breakdown),
            Err(error) => return Err(error),
        };
        self.numbers = numbers;
        let seconds = begun.elapsed().as_secs_f64();
        self.numbers.insert("seconds".into(), seconds);
        write_numbers(&settings.numbers(job), &self.numbers)?;
        watch.event(&Event::Ended(job, status, seconds));
        Ok(())
    }

    /// Computes the run, from where it was interrupted if it has `begun` before.
    fn run(
        &mut self,
        begun: bool,
        settings: &Settings,
        threads: usize,
        watch: &dyn Watch,
    ) -> Result<(), Error> {
        let job = &self.job;
        let case = job.case_in(&settings.directory)?;
        let go_on = begun && case.time.is_some();
        let options = |resume: bool| RunOptions {
            directory: self.directory.clone(),
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
        if has_ended(&summary) {
            self.results = Some(Results::read(&self.directory)?);
            self.numbers = self.job.numbers_after(settings, None, threads)?;
        }
        Ok(())
    }
}

impl Job {
    /// The numbers of the last state of the run: those `kept`, or computed now.
    fn numbers_after(
        &self,
        settings: &Settings,
        kept: Option<Numbers>,
        threads: usize,
    ) -> Result<Numbers, Error> {
        if self.also.is_empty() {
            return Ok(Numbers::new());
        }
        if let Some(kept) = kept {
            return Ok(kept);
        }
        if settings.collect {
            return Ok(self.numbers().into_iter().map(|name| (name, f64::NAN)).collect());
        }
        let case = match self.case.time {
            // Nothing is computed up to that end, which only has to lie ahead.
            Some(_) => self.after(&settings.directory.join(&self.name), &["time.end=1e9".into()])?,
            None => self.case.clone(),
        };
        let mut simulation = Simulation::new(case, threads)?;
        if self.case.time.is_none() {
            simulation.step()?;
        }
        let mut numbers = Numbers::new();
        for also in &self.also {
            numbers.extend(also.numbers(&mut simulation)?);
        }
        write_numbers(&settings.numbers(self), &numbers)?;
        Ok(numbers)
    }
}

/// Numbers that an earlier call has written.
fn read_numbers(path: &Path) -> Option<Numbers> {
    toml::from_str(&std::fs::read_to_string(path).ok()?).ok()
}

fn write_numbers(path: &Path, numbers: &Numbers) -> Result<(), Error> {
    let lines: String =
        numbers.iter().map(|(name, x)| format!("{name} = {}\n", toml::Value::Float(*x))).collect();
    Ok(write_atomic(path, |file| file.write_all(lines.as_bytes()))?)
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
