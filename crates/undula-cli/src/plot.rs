//! Pictures of a run: `undula plot DIR`, and the end of `undula run`.

mod cell;
pub mod colors;
pub mod figure;
mod history;
mod picture;

use crate::args::{PlotArgs, bad_input, print};
use anyhow::Context;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use undula::output::{Collection, History, OutputError, RunDirectory, Summary, read_vtu};
use undula::results::computed::Results;

/// Draws the pictures and lists them.
pub fn run(args: &PlotArgs) -> anyhow::Result<ExitCode> {
    if let Err(error @ OutputError::NoRun { .. }) = RunDirectory::open(&args.dir) {
        return bad_input(error);
    }
    let written = plot_directory(&args.dir, args.output.as_deref())?;
    print(&written.iter().map(|path| format!("{}\n", path.display())).collect::<String>())
}

/// The fields that the run in `dir` has written last up to `time`, or last of all, as a picture with streamlines; `None`
/// where it has no such field.
///
/// # Errors
/// If a file cannot be read.
pub fn picture_at(dir: &Path, time: Option<f64>, field: &str) -> anyhow::Result<Option<figure::Image>> {
    let run = RunDirectory::open(dir)?;
    if !run.collection().is_file() {
        return Ok(None);
    }
    let collection = Collection::read(run.collection())?;
    let is_before = |at: f64| time.is_none_or(|time| at <= time + 1e-9 * time.abs().max(1.0));
    let Some((at, file)) = collection.entries().iter().rev().find(|(at, _)| is_before(*at)) else {
        return Ok(None);
    };
    let (snapshot, _) = read_vtu(collection.resolve(file))?;
    let title = format!("t = {} s", crate::digits::fixed(*at, *at, 3));
    picture::image(&snapshot, field, &title, field != "deformation")
}

/// Draws the run in `dir` into `into`, by default `dir/plots`, and returns the files written.
///
/// Histories of all functionals with a zoom on the last periods, the path of a point where `ux_…` and
/// `uy_…` are recorded (each as SVG and PNG), and the last field file as PNG: speed and pressure on the
/// deformed mesh, or the deformation if there is no fluid. What a run does not have is not drawn.
///
/// # Errors
/// If `dir` is no run, or a file cannot be read or written.
pub fn plot_directory(dir: &Path, into: Option<&Path>) -> anyhow::Result<Vec<PathBuf>> {
    let run = RunDirectory::open(dir)?;
    let plots = into.map_or_else(|| run.plots(), Path::to_path_buf);
    let mut summary = Summary::read(run.summary()).unwrap_or_default();
    if summary.case.is_empty() {
        summary.case = dir.file_name().unwrap_or_default().to_string_lossy().into_owned();
    }
    let mut written = Vec::new();
    if run.history().is_file() {
        let mut results = Results::read(dir).unwrap_or_default();
        results.history = History::read(run.history())?;
        results.summary = summary.clone();
        written.extend(history::plot(&results, &plots).context("plotting the history")?);
    }
    if run.collection().is_file() {
        let collection = Collection::read(run.collection())?;
        if let Some((time, file)) = collection.entries().last() {
            let (snapshot, _) = read_vtu(collection.resolve(file))?;
            let transient = collection.entries().len() > 1 || *time > 0.0;
            let time = transient.then_some(*time);
            written.extend(picture::plot(&snapshot, time, &summary, &plots).context("drawing the fields")?);
        }
    }
    Ok(written)
}
