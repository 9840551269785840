//! `undula report DIR`: a run on one page, which needs nothing else.

mod arrays;
mod fields;
mod layer;
mod quantity;
mod sections;
mod series;
mod space;

use crate::args::{Plane, ReportArgs, bad_input, print};
use crate::compare::{Published, published};
use crate::page::Html;
use crate::plot::NotDrawn;
use crate::plot::colors::{PLASMA, Rgb, VIRIDIS};
use fields::{Scene, scene};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use undula::case::Case;
use undula::output::{OutputError, RunDirectory, write_atomic};
use undula::results::computed::Results;
use undula::setup::overview::Overview;

const STYLE: &str = include_str!("report/report.css");

/// The scripts of the page, each of which needs those before it.
const SCRIPTS: [&str; 8] = [
    include_str!("report/data.js"),
    include_str!("report/chart.js"),
    include_str!("report/raster.js"),
    include_str!("report/view.js"),
    include_str!("report/layer.js"),
    include_str!("report/player.js"),
    include_str!("report/controls.js"),
    include_str!("report/page.js"),
];

/// Writes the page of a run and names it.
pub fn run(args: &ReportArgs) -> anyhow::Result<ExitCode> {
    match RunDirectory::open(&args.dir) {
        Err(error @ OutputError::NoRun { .. }) => bad_input(error),
        Err(error) => Err(error.into()),
        Ok(run) if !run.summary().is_file() => {
            bad_input(format_args!("{}: this run has no summary.json", args.dir.display()))
        }
        Ok(_) => match write(&args.dir, args.output.as_deref(), &args.cut) {
            Err(error) if error.is::<NotDrawn>() => bad_input(error),
            written => written.and_then(|path| print(&format!("{}\n", path.display()))),
        },
    }
}

/// Writes the page of the run in `directory` into `to`, by default `report.html` in that directory, and returns its path.
/// In space it has these `cuts`, by default one across the shortest side.
///
/// # Errors
/// If a file of the run cannot be read, or the page cannot be written; [`NotDrawn`] for a plane that meets nothing.
pub fn write(directory: &Path, to: Option<&Path>, cuts: &[Plane]) -> anyhow::Result<PathBuf> {
    let run = RunDirectory::open(directory)?;
    let path = to.map_or_else(|| run.report(), Path::to_path_buf);
    let text = text(directory, false, cuts)?;
    write_atomic(&path, |file| std::io::Write::write_all(file, text.as_bytes()))?;
    Ok(path)
}

/// All that a page says.
struct Content<'a> {
    run: &'a RunDirectory,
    results: Results,
    /// The case as text.
    toml: String,
    /// The case with its mesh, if both can be read.
    overview: Option<(Case, Overview)>,
    published: Published,
}

/// The page of the run in `directory`; one that is `live` asks its server for news.
///
/// # Errors
/// As [`write`].
pub fn text(directory: &Path, live: bool, cuts: &[Plane]) -> anyhow::Result<String> {
    let run = &RunDirectory::open(directory)?;
    let results = Results::read(directory)?;
    let published = published(&results);
    let toml = std::fs::read_to_string(run.case()).unwrap_or_default();
    let content = Content { run, overview: measured(run), published, results, toml };
    let rows = match &content.published {
        Published::Table(comparison) => comparison.rows.as_slice(),
        _ => &[],
    };
    let histories = series::histories(&content.results, rows)?;
    let reference = content.results.case.as_ref().is_some_and(|case| !case.output.deformed);
    let mut fields = scene(run, reference, cuts)?;
    if let (Scene::Shown(scene, _), Some((_, overview))) = (&mut fields, &content.overview) {
        scene["axes"] = json!(if overview.around_axis { ["r", "z", ""] } else { ["x", "y", "z"] });
    }
    let title = sections::title(&content);
    let mut page = Html::styled(&title, STYLE);
    sections::head(&mut page, &content, &title);
    sections::warnings(&mut page, &content);
    sections::fields(&mut page, &fields, histories.is_some());
    sections::histories(&mut page, histories.as_ref());
    sections::published(&mut page, &content);
    sections::numbers(&mut page, &content);
    sections::solver(&mut page, &content, histories.is_some());
    sections::provenance(&mut page, &content);
    sections::case(&mut page, &content);
    let scene = match fields {
        Scene::Shown(scene, _) => scene,
        _ => Value::Null,
    };
    let histories = histories.map_or(Value::Null, |(value, _)| value);
    let maps = json!({ "viridis": map(&VIRIDIS), "plasma": map(&PLASMA) });
    let step = content.results.history.column("step").and_then(|steps| steps.last().copied()).unwrap_or(0.0);
    let data = json!({ "scene": scene, "histories": histories, "maps": maps, "step": step });
    page.data("report-data", &data);
    page.script(&SCRIPTS);
    if live {
        page.script(&[include_str!("report/live.js")]);
    }
    Ok(page.finish())
}

fn map(colors: &[Rgb]) -> Value {
    json!(colors)
}

/// The case on its mesh; `None` if one of them cannot be read any more.
fn measured(run: &RunDirectory) -> Option<(Case, Overview)> {
    let case = Case::load(&run.case().to_string_lossy(), &[]).ok()?;
    let overview = case.check_mesh_and_measure().ok()?;
    Some((case, overview))
}
