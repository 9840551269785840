//! Files of modes.

use super::{Mode, Modes};
use crate::output::{Field, OutputError, Precision, write_atomic, write_vtu};
use crate::run::snapshot;
use crate::space::{FsiSpace, State};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// Writes into the directory `path`, which is made if it is not there:
///
/// - `modes.csv`: `mode,frequency_vacuum,frequency_added_mass` \[Hz\], a row per mode; `nan` where there is none;
/// - `modes.vtu`: the shapes on the reference domain, `mode_1_vacuum` and so on, the largest displacement of each
///   being 1.
///
/// Cells of higher degree are cut into straight ones unless `curved`.
///
/// # Errors
/// [`OutputError::Format`] if the directory is not empty; [`OutputError::Io`].
pub fn write(path: &Path, space: &FsiSpace<2>, modes: &Modes, curved: bool) -> Result<(), OutputError> {
    check_empty(path)?;
    std::fs::create_dir_all(path).map_err(OutputError::io("create directory", path))?;
    write_atomic(path.join("modes.csv"), |file| file.write_all(table(modes).as_bytes()))?;
    let rest = State::zero(space.n_v(), space.n_u(), space.n_p());
    let mut fields = snapshot(space, &rest, false);
    let lists = [("vacuum", Some(&modes.vacuum)), ("added_mass", modes.with_fluid.as_ref())];
    fields.point_data.clear();
    for (name, list) in lists.into_iter().filter_map(|(name, list)| list.map(|list| (name, list))) {
        let shapes = list.iter().enumerate();
        let field = |(i, mode): (usize, &Mode)| {
            Field::new(format!("mode_{}_{name}", i + 1), 2, scaled(&space.at_places(&mode.shape, 2)))
        };
        fields.point_data.extend(shapes.map(field));
    }
    let fields = if curved { fields } else { fields.linear() };
    write_vtu(path.join("modes.vtu"), &fields, 0.0, Precision::Auto)
}

/// Refuses a directory with something in it, and a file.
///
/// # Errors
/// [`OutputError::Format`], [`OutputError::Io`].
pub fn check_empty(path: &Path) -> Result<(), OutputError> {
    if !path.exists() {
        return Ok(());
    }
    if !path.is_dir() {
        return Err(OutputError::format(path, "this is a file; a directory is needed for the output"));
    }
    let entries = std::fs::read_dir(path).map_err(OutputError::io("list", path))?;
    match entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).min() {
        None => Ok(()),
        Some(entry) => {
            let message =
                format!("not empty (it contains `{entry}`); nothing was changed, choose another directory");
            Err(OutputError::format(path, message))
        }
    }
}

/// The frequencies as CSV.
fn table(modes: &Modes) -> String {
    let mut text = "mode,frequency_vacuum,frequency_added_mass\n".to_string();
    let fluid = modes.with_fluid.as_deref().unwrap_or_default();
    let of = |list: &[Mode], n: usize| {
        list.get(n).map_or_else(|| "nan".into(), |mode: &Mode| format!("{:e}", mode.frequency))
    };
    for n in 0..modes.vacuum.len().max(fluid.len()) {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{},{},{}", n + 1, of(&modes.vacuum, n), of(fluid, n));
    }
    text
}

/// The shape with the largest displacement 1, the component of largest size positive.
fn scaled(shape: &[f64]) -> Vec<f64> {
    let size = shape.chunks_exact(2).map(|u| u[0].hypot(u[1])).fold(0.0, f64::max);
    let largest = shape.iter().copied().fold(0.0, |m: f64, x| if x.abs() > m.abs() { x } else { m });
    let scale = if size > 0.0 { largest.signum() / size } else { 1.0 };
    shape.iter().map(|x| scale * x).collect()
}
