//! Options tried on a small system, so that a mistake in them is told before a run begins.

use super::access::engine;
use super::error::{Missing, Trouble};
use super::prepared::Prepared;
use crate::algebra::{Csr, Kind, Pattern, Sizes, Unknown};
use std::sync::Arc;

/// Unknowns of each field of the small system: enough for two levels of algebraic multigrid.
const SIDE: usize = 20;

/// Errors of PETSc that say something of the small system, not of the options: zero pivots, no convergence, and what a
/// package inside returns.
const OF_THE_SYSTEM: [i32; 3] = [71, 76, 91];

/// What is wrong with options; `None`: nothing was found.
///
/// Types of iterations and of preconditioners that are not there, values that are none, and options that nobody reads.
/// Options of single levels of multigrid (`-mg_levels_3_...`) are not judged: the small system has few. `fields` are those
/// of the system that is meant.
///
/// # Errors
/// If there is no PETSc.
pub fn mistake_in_options(options: &str, fields: &[Kind]) -> Result<Option<String>, Missing> {
    let (a, unknowns) = small(fields);
    let engine = engine()?;
    let access = engine.access()?;
    let mut prepared = match Prepared::new(&access, options, &a.pattern, &unknowns, None) {
        Ok(prepared) => prepared,
        Err(trouble) => return Ok(Some(trouble.to_string())),
    };
    // Its entries are finite, and none of its rows is zero.
    let _ = prepared.scale(&a, &unknowns, Sizes::default());
    let tried = prepared.set(&access, &a, &unknowns).and_then(|failure| match failure {
        None => prepared.system.precondition(&access),
        Some(_) => Ok(()),
    });
    let unused = prepared.system.unused(&access);
    prepared.system.destroy(&access);
    Ok(match (tried, unused) {
        (Err(Trouble { code, .. }), _) if OF_THE_SYSTEM.contains(&code) => None,
        (Err(trouble), _) | (Ok(()), Err(trouble)) => Some(trouble.to_string()),
        (Ok(()), Ok(unused)) => unread(&unused),
    })
}

/// Ends of options that are read while a system is solved.
const LATER: [&str; 2] = ["ksp_converged_reason", "ksp_converged_rate"];

/// Options of PETSc as a whole, which it reads when it starts.
const OF_ALL: [&str; 4] = ["log_view", "options_left", "info", "malloc_debug"];

/// Options that were not read, in words.
fn unread(unused: &[String]) -> Option<String> {
    if let Some(name) = unused.iter().find(|name| OF_ALL.contains(&name.as_str())) {
        return Some(format!(
            "`-{name}` is of PETSc as a whole: expected it in the environment, PETSC_OPTIONS=-{name}"
        ));
    }
    let of_a_level = |name: &str| {
        let level = name.split_once("mg_levels_").and_then(|(_, rest)| rest.chars().next());
        level.is_some_and(|c| c.is_ascii_digit())
    };
    let is_later = |name: &str| of_a_level(name) || LATER.iter().any(|end| name.ends_with(end));
    let names: Vec<String> =
        unused.iter().filter(|name| !is_later(name)).map(|name| format!("`-{name}`")).collect();
    match &names[..] {
        [] => None,
        [one] => Some(format!(
            "nothing reads the option {one}: it is misspelt, or belongs to a solver that is not chosen"
        )),
        more => Some(format!(
            "nothing reads the options {}: they are misspelt, or belong to solvers that are not chosen",
            more.join(", ")
        )),
    }
}

/// Laplace on a square for each field, a negative one for pressures, weakly coupled.
fn small(fields: &[Kind]) -> (Csr, Vec<Unknown>) {
    let n = SIDE * SIDE;
    let at = |field: usize, x: usize, y: usize| (field * n + y * SIDE + x) as u32;
    let (mut rows, mut unknowns) = (vec![], vec![]);
    for (field, kind) in fields.iter().enumerate() {
        for (x, y) in (0..n).map(|i| (i % SIDE, i / SIDE)) {
            let mut row = vec![at(field, x, y)];
            row.extend((x > 0).then(|| at(field, x - 1, y)));
            row.extend((y > 0).then(|| at(field, x, y - 1)));
            row.extend((x + 1 < SIDE).then(|| at(field, x + 1, y)));
            row.extend((y + 1 < SIDE).then(|| at(field, x, y + 1)));
            row.extend((0..fields.len()).filter(|other| *other != field).map(|other| at(other, x, y)));
            rows.push(row);
            unknowns.push(Unknown { node: at(0, x, y), kind: *kind, at: [x as f64, y as f64, 0.0] });
        }
    }
    let pattern = Arc::new(Pattern::from_rows(&rows));
    let mut a = Csr::zeros(&pattern);
    for row in 0..pattern.n {
        let sign = if unknowns[row].kind == Kind::Pressure { -1.0 } else { 1.0 };
        for at in pattern.row(row) {
            let column = pattern.column(row, at) as usize;
            a.values[at] = match () {
                () if column == row => 4.5 * sign,
                () if column / n == row / n => -sign,
                () => 0.1,
            };
        }
    }
    (a, unknowns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_single_levels_are_not_judged() {
        let of = |names: &[&str]| unread(&names.iter().map(ToString::to_string).collect::<Vec<_>>());
        assert_eq!(of(&[]), None);
        assert_eq!(of(&["fieldsplit_v_mg_levels_3_pc_type"]), None);
        assert_eq!(of(&["fieldsplit_v_ksp_converged_reason"]), None);
        assert!(of(&["log_view"]).unwrap().contains("PETSC_OPTIONS=-log_view"));
        assert!(of(&["ksp_tpye"]).unwrap().contains("the option `-ksp_tpye`:"));
        assert!(
            of(&["ksp_tpye", "mg_levels_2_ksp_type", "b"]).unwrap().contains("options `-ksp_tpye`, `-b`:")
        );
    }
}
