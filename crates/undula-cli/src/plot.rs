//! Pictures of a run: `undula plot DIR`, and the end of `undula run`.

mod animate;
mod cell;
pub mod colors;
pub mod cube;
pub mod cut;
pub mod figure;
mod history;
mod lines;
mod picture;
pub mod space;
mod surface;
pub mod tetrahedra;

use crate::args::{Plane, PlotArgs, SurfaceField, bad_input, print, say_notes};
use crate::digits::fixed;
use anyhow::Context;
use picture::View;
pub use picture::solid_cells;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use surface::Surface;
use tetrahedra::{as_hexahedra, read_fields};
use undula::output::{Collection, FieldSnapshot, History, OutputError, RunDirectory, Summary};
use undula::results::computed::Results;

/// Draws the pictures and lists them.
pub fn run(args: &PlotArgs) -> anyhow::Result<ExitCode> {
    if let Err(error @ OutputError::NoRun { .. }) = RunDirectory::open(&args.dir) {
        return bad_input(error);
    }
    if let Some(file) = &args.animate {
        return match animate::animate(&args.dir, file, args.field, args.rate) {
            Err(error) if error.is::<NotDrawn>() => bad_input(error),
            written => written.and_then(|()| print(&format!("{}\n", file.display()))),
        };
    }
    let views = Views { cuts: args.cut.clone(), surfaces: args.surface.clone() };
    let written = match plot_views(&args.dir, args.output.as_deref(), &views) {
        Err(error) if error.is::<NotDrawn>() => return bad_input(error),
        written => written?,
    };
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
    picture_of(read_fields(collection.resolve(file))?, field, &format!("t = {} s", fixed(*at, *at, 3)))
}

/// The fields as a picture, with streamlines unless it is that of the deformation; `None` where there is no such field.
///
/// # Errors
/// If it cannot be drawn.
pub fn picture_of(fields: FieldSnapshot, field: &str, title: &str) -> anyhow::Result<Option<figure::Image>> {
    let fields = as_hexahedra(fields);
    let view = match fields.kind.dim() {
        2 => View::whole(&fields),
        _ => View::middle(&fields).map_err(NotDrawn)?,
    };
    picture::image(&view, field, title, field != "deformation")
}

/// What is drawn of fields in three dimensions.
#[derive(Clone, Debug, Default)]
pub struct Views {
    /// Cuts; by default one across the shortest side.
    pub cuts: Vec<Plane>,
    /// What colours the surface of the bodies; by default the displacement.
    pub surfaces: Vec<SurfaceField>,
}

/// A picture that was asked for and cannot be drawn: why, and what to do.
#[derive(Debug)]
pub struct NotDrawn(pub String);

impl std::fmt::Display for NotDrawn {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for NotDrawn {}

/// Draws the run in `dir` into `into`, by default `dir/plots`, and returns the files written.
///
/// # Errors
/// As [`plot_views`].
pub fn plot_directory(dir: &Path, into: Option<&Path>) -> anyhow::Result<Vec<PathBuf>> {
    plot_views(dir, into, &Views::default())
}

/// Draws the run in `dir` into `into`, by default `dir/plots`, and returns the files written.
///
/// Histories of all functionals with a zoom on the last periods, the path of a point where `ux_…` and
/// `uy_…` are recorded (each as SVG and PNG), and the last field file as PNG: speed and pressure on the
/// deformed mesh, or the deformation if there is no fluid. What a run does not have is not drawn. Of fields in three
/// dimensions `views` says which cuts and surfaces are drawn.
///
/// # Errors
/// If `dir` is no run, or a file cannot be read or written; [`NotDrawn`] before anything is written.
pub fn plot_views(dir: &Path, into: Option<&Path>, views: &Views) -> anyhow::Result<Vec<PathBuf>> {
    let run = RunDirectory::open(dir)?;
    let plots = into.map_or_else(|| run.plots(), Path::to_path_buf);
    let mut summary = Summary::read(run.summary()).unwrap_or_default();
    if summary.case.is_empty() {
        summary.case = dir.file_name().unwrap_or_default().to_string_lossy().into_owned();
    }
    let fields = last_fields(&run)?;
    if fields.is_none() && !(views.cuts.is_empty() && views.surfaces.is_empty()) {
        let dir = dir.display();
        return Err(
            NotDrawn(format!("{dir} has no field files, which cuts and surfaces are drawn from")).into()
        );
    }
    let drawings = fields.as_ref().map(|(_, snapshot, file)| drawings(snapshot, file, views)).transpose()?;
    let mut written = Vec::new();
    if run.history().is_file() {
        let mut results = Results::read(dir).unwrap_or_default();
        results.history = History::read(run.history())?;
        results.summary = summary.clone();
        written.extend(history::plot(&results, &plots).context("plotting the history")?);
    }
    if let (Some((time, ..)), Some((views, surfaces))) = (&fields, &drawings) {
        let mut title = summary.case;
        if let Some(time) = time {
            title += &format!(",  t = {} s", fixed(*time, *time, 3));
        }
        for view in views {
            written.extend(picture::plot(view, &title, &plots).context("drawing the fields")?);
        }
        for surface in surfaces {
            let path = plots.join(surface.file());
            surface.image(&title)?.save(&path).context("drawing a surface")?;
            written.push(path);
        }
    }
    Ok(written)
}

/// The last field file of a run: its time \[s\] if the run depends on time, its fields, its path.
fn last_fields(run: &RunDirectory) -> anyhow::Result<Option<(Option<f64>, FieldSnapshot, PathBuf)>> {
    if !run.collection().is_file() {
        return Ok(None);
    }
    let collection = Collection::read(run.collection())?;
    let Some((time, file)) = collection.entries().last() else { return Ok(None) };
    let path = collection.resolve(file);
    let snapshot = read_fields(&path)?;
    let transient = collection.entries().len() > 1 || *time > 0.0;
    Ok(Some((transient.then_some(*time), snapshot, path)))
}

/// What is drawn of fields.
fn drawings<'a>(
    snapshot: &'a FieldSnapshot,
    file: &Path,
    views: &Views,
) -> Result<(Vec<View<'a>>, Vec<Surface>), NotDrawn> {
    let asked = !(views.cuts.is_empty() && views.surfaces.is_empty());
    if snapshot.kind.dim() == 2 {
        if asked {
            say_notes(&["--cut and --surface have no effect: the run is one of two dimensions".into()]);
        }
        return Ok((vec![View::whole(snapshot)], vec![]));
    }
    let wrong = |why: String| NotDrawn(format!("{why} (ParaView shows all of {})", file.display()));
    let cuts = match views.cuts[..] {
        [] => match View::middle(snapshot) {
            Ok(view) => vec![view],
            Err(why) => {
                say_notes(&[why]);
                vec![]
            }
        },
        _ => views
            .cuts
            .iter()
            .map(|&plane| View::cut(snapshot, plane))
            .collect::<Result<_, _>>()
            .map_err(wrong)?,
    };
    let solid = solid_cells(snapshot);
    let surface = |field| Surface::new(snapshot, &solid, field);
    let surfaces = match views.surfaces[..] {
        [] => surface(SurfaceField::Displacement).into_iter().collect(),
        _ => views.surfaces.iter().map(|&field| surface(field)).collect::<Result<_, _>>().map_err(wrong)?,
    };
    Ok((cuts, surfaces))
}
