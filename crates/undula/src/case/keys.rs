//! All keys of a case: unit, default value and meaning.
//!
//! Reading asks for keys of this table only, unknown-key messages list its keys, `case.toml` takes its comments from it,
//! and `undula keys` prints it.

use super::choices::{BODY_FORCE_AT, METHODS, OUTPUT_CELLS, OUTPUT_MESH, STARTS};
use super::conditions::{CONDITIONS, DATA};
use super::element::{PRESSURES, VELOCITIES};
use super::error::did_you_mean;
use super::functionals::FUNCTIONALS;
use super::initial::INITIAL;
pub use super::key::Key;
use super::key::{NAME, number, text, word};
use super::material_keys::{OF_FLUID, OF_SOLID};
use super::mesh_keys::MESH;
use super::profile::PROFILE_KEYS;
use super::schema::KRYLOV;
use super::{key, synonyms};
use crate::algebra::{ENGINES, PRECISIONS, SOLVERS};
use crate::choice::Table;
use crate::functional::body_energy::PARTS;
use crate::functional::energy::ENERGIES;
use crate::functional::nodal::FIELDS;
use crate::functional::quantity::{COMPONENTS, TAKES};
use crate::physics::extension::{MOTIONS, OUTER, STIFFENING};
use crate::physics::solid_law::LAWS;
use crate::physics::stabilization::{MAPPINGS, PRESSURE_TERMS, PROJECTIONS, TRANSPORT_TERMS};
use crate::space::{BACKFLOW, WALLS};
use crate::tangent::{DIFFERENCES, LINEARIZATIONS, TANGENTS};
use crate::time::scheme::{DOMAIN_MOTIONS, SCHEMES};
use std::sync::LazyLock;

/// All keys, table by table.
pub static KEYS: LazyLock<Vec<&'static Key>> = LazyLock::new(|| {
    let data = |key: &Key| match key.key {
        "reference" => &MESH[..],
        "boundary.NAME.condition" => &DATA[..],
        "boundary.NAME.backflow" => &PROFILE_KEYS[..],
        "time.adaptive.safety" => &INITIAL[..],
        "fluid.density" => &OF_FLUID[..],
        "solid.poisson" => &OF_SOLID[..],
        _ => &[],
    };
    let keys = KEYS_BUT_DATA.iter().flat_map(|key| std::iter::once(key).chain(data(key)));
    key::with_named(keys.collect())
});

/// All but those of the data of boundary conditions of the start and of materials.
static KEYS_BUT_DATA: &[Key] = &[
    text("name", "name of the file", "short name, also of the output directory"),
    text("title", "empty", "one line for people"),
    text("reference", "none", "built-in case whose published results belong to this problem"),
    word("space.velocity", &VELOCITIES, "Q2, simplices: P2", "element of velocity and displacement"),
    word("space.pressure", &PRESSURES, "from the velocity", "element of the pressure"),
    number(
        "space.quadrature",
        "",
        "from the velocity",
        "Gauss points per direction; exact to the same degree on simplices",
    ),
    text("fluid.region", "fluid", "region of the mesh that the fluid fills, or several as [\"a\", \"b\"]"),
    number("fluid.density", "kg/m³", "required", "density"),
    number("fluid.body-force", "m/s²", "[0, 0]", "body force per mass, two expressions of x, y, t"),
    word("fluid.body-force-at", &BODY_FORCE_AT, "reference", "position at which the body force is taken"),
    word(
        "stabilization.pressure",
        &PRESSURE_TERMS,
        "off, equal order: lps",
        "term in the divergence equation",
    ),
    word(
        "stabilization.transport",
        &TRANSPORT_TERMS,
        "off",
        "term in the momentum equation against oscillations",
    ),
    number("stabilization.alpha", "", "0.1", "factor α₀ of the pressure term"),
    number("stabilization.delta", "", "0.1", "factor δ₀ of the transport term"),
    word("stabilization.projection", &PROJECTIONS, "cell", "projection of `lps`"),
    text(
        "stabilization.directional",
        "false",
        "the axes of a cell have parameters of their own (true or false)",
    ),
    word("stabilization.map", &MAPPINGS, "full", "how the terms are carried to the reference domain"),
    text("solid.region", "solid", "region of the mesh that the solid fills, or several as [\"a\", \"b\"]"),
    word("solid.law", &LAWS, "st-venant-kirchhoff", "constitutive law"),
    number("solid.density", "kg/m³", "required", "density"),
    number("solid.mu", "Pa", "required", "shear modulus; `young` and `poisson` instead of `mu` and `lambda`"),
    number("solid.lambda", "Pa", "required", "first Lamé parameter; not with incompressible laws"),
    number("solid.young", "Pa", "from mu, lambda", "Young's modulus; incompressible: 3 mu"),
    number("solid.poisson", "", "from mu, lambda", "Poisson ratio, above -1 and below 0.5"),
    number("solid.body-force", "m/s²", "[0, 0]", "body force per mass, two expressions of x, y, t"),
    word("motion.model", &MOTIONS, "pseudo-elastic", "extension of the displacement into the fluid"),
    word(
        "motion.jacobian",
        &STIFFENING,
        "lagged, else implicit",
        "J of `jacobian-stiffened`; a stationary case takes `implicit`",
    ),
    word("motion.walls", &WALLS, "fixed", "mesh on the outer boundary of the fluid"),
    word("motion.outer", &OUTER, "clamped", "second condition of `biharmonic`"),
    number("motion.poisson", "", "0", "Poisson ratio of the elastic models; below 0 auxetic"),
    number(
        "motion.offset",
        "m",
        "from the mesh",
        "d₀ of the stiffening (d₀ + d)^−exponent, d the distance to the interface",
    ),
    number("motion.exponent", "", "2", "exponent of the stiffening; 0: none"),
    number("motion.scale", "m", "from the mesh", "L of the stiffening 2 − erf(5 d/L)"),
    word("boundary.NAME.condition", &CONDITIONS, "required", "condition on the boundary NAME of the mesh"),
    word("boundary.NAME.backflow", &BACKFLOW, "none, pressure: tangential", "term against flow back in"),
    word(
        "time.scheme",
        &SCHEMES,
        "shifted-crank-nicolson",
        "time scheme; without [time] the case is stationary",
    ),
    number("time.step", "s", "required", "time step, a number or an expression of t"),
    number("time.start", "s", "0", "first time"),
    number("time.end", "s", "required", "last time; stationary: the time at which expressions are taken"),
    number("time.theta", "", "theta: required", "weight of the new time, from 0.5 to 1"),
    number("time.shift", "1/s", "0.005/step", "θ − ½ by the step, of `shifted-crank-nicolson`"),
    number("time.max-halvings", "", "5", "halvings of a failed step before the run ends"),
    number("time.rannacher-steps", "", "2", "steps of backward Euler at the start of every interval"),
    number("time.rannacher-interval", "s", "200 steps", "interval of `rannacher`"),
    word(
        "time.domain-motion",
        &DOMAIN_MOTIONS,
        "secant",
        "time of the factors of the time derivatives; not with `cg1`, `bdf2`, `esdirk3` and `esdirk4`",
    ),
    number(
        "time.adaptive.tolerance",
        "",
        "1e-3",
        "local error of a step, relative to the largest v and u so far",
    ),
    number("time.adaptive.min-step", "s", "step/1000", "smallest step"),
    number("time.adaptive.max-step", "s", "10 steps", "largest step"),
    number("time.adaptive.safety", "", "0.9", "factor of every new step"),
    word(
        "newton.linearization",
        &LINEARIZATIONS,
        "condensed, else newton",
        "derivatives in the Jacobian; a stationary deformation takes `newton`",
    ),
    word("newton.jacobian", &TANGENTS, "automatic", "computation of the derivatives"),
    word("newton.difference", &DIFFERENCES, "one-sided", "differences of `finite-difference`"),
    number("newton.epsilon", "", "1e-6", "perturbation of `finite-difference`, relative to the fields"),
    number(
        "newton.rate-max",
        "",
        "by cost, newton: 0.2",
        "a Jacobian is kept while residuals shrink by this factor",
    ),
    number("newton.secants", "", "0", "secant pairs that improve corrections of a kept Jacobian"),
    number("newton.tolerance", "", "1e-8", "residual at the end, relative to the old solution"),
    number("newton.floor", "m/s", "from rounding", "residual that is small enough in any case"),
    number("newton.max-steps", "", "30", "iterations before a step counts as failed"),
    word("newton.start", &STARTS, "extrapolated", "start value of a step"),
    number("newton.line-search", "", "5", "halvings of a correction"),
    word("linear.engine", &ENGINES, "own", "who solves the systems of Newton's method"),
    text("linear.petsc.options", "LU of MUMPS", "options of PETSc, as on its command line"),
    word("linear.solver", &SOLVERS, "multifrontal; in space automatic", "direct solver, or multigrid"),
    number("linear.refinement", "", "2", "steps of iterative refinement"),
    word(
        "linear.precision",
        &PRECISIONS,
        "single",
        "precision of the factors that only make corrections, and of the cycles of multigrid",
    ),
    word("linear.krylov", &KRYLOV, "none", "iterative solver on top of the factors"),
    number("linear.krylov-tolerance", "", "0.03", "residual of GMRES, relative to the right-hand side"),
    number(
        "linear.krylov-size",
        "",
        "20",
        "iterations of GMRES before the factors are renewed, 60 with multigrid",
    ),
    word("functional.NAME.kind", &FUNCTIONALS, "required", "quantity of the column NAME of history.csv"),
    text(
        "functional.NAME.on",
        "force, flux, power: required",
        "names of boundaries of the fluid, also `interface`",
    ),
    word("functional.NAME.method", &METHODS, "residual", "force: computation"),
    number("functional.NAME.point", "m", "displacement, moment: required", "material point, or centre"),
    text(
        "functional.NAME.region",
        "balance, volume: required",
        "region of a body; beside `point` the body that is meant",
    ),
    word("functional.NAME.take", &TAKES, "required", "what is taken on boundaries and in regions"),
    word(
        "functional.NAME.component",
        &COMPONENTS,
        "required",
        "component of a vector or of a stress; of moment and rotation in space the axis",
    ),
    number(
        "functional.NAME.coefficient",
        "m/s, m",
        "none",
        "force: V and L, the factor is 2/(density V² L); on an extruded plane L times depth, in space an area",
    ),
    number("functional.NAME.a", "m", "required", "pressure-difference: first point"),
    number("functional.NAME.b", "m", "required", "pressure-difference: second point"),
    word("functional.NAME.term", &ENERGIES, "energy: required", "energy: which one"),
    word("functional.NAME.part", &PARTS, "balance: required", "balance: which part"),
    number("output.fields-every", "", "0", "fields are written after so many steps; 0: only at the end"),
    number("output.fields-interval", "s", "none", "fields are written after this time, steps end there"),
    number(
        "output.fields-times",
        "s",
        "none",
        "fields are written at the ends of steps nearest to these times",
    ),
    word(
        "output.fields",
        &FIELDS,
        "[\"velocity\", \"displacement\", \"pressure\"]",
        "fields that are written, derived ones with an array for each body",
    ),
    number("output.window", "s", "none", "first and last time of the means in mean.vtu, as [4, 6]"),
    word("output.mesh", &OUTPUT_MESH, "deformed", "positions of the nodes in field files"),
    word("output.cells", &OUTPUT_CELLS, "linear", "cells of higher order in field files"),
    number("output.checkpoint-every", "", "0", "checkpoint after so many steps; 0: not by steps"),
    number(
        "output.checkpoint-minutes",
        "",
        "10",
        "checkpoint after so many minutes of wall-clock time; 0: not by time",
    ),
    text("output.report", "true", "the run ends with a page about it, report.html (true or false)"),
    text(
        "output.leading",
        "first uy_*, else lift",
        "functional whose period gives the window of the statistics",
    ),
];

impl Key {
    /// Names of the values with a line about each; empty if any value of a type is accepted.
    pub fn choices(&self) -> Vec<(&'static str, &'static str)> {
        self.choices.map_or(vec![], Table::rows)
    }

    /// The table that it is in, empty for keys in none.
    pub fn table(&self) -> &'static str {
        key::parent(self.key).unwrap_or("")
    }

    /// Whether `dotted` is this key or, if shorter, a table that it is in.
    fn begins_with(&self, dotted: &[&str]) -> bool {
        let parts: Vec<&str> = self.key.split('.').collect();
        dotted.len() <= parts.len()
            && parts.iter().zip(dotted).all(|(part, other)| *part == NAME || part == other)
    }

    /// The comment behind the value in a case.
    pub(super) fn comment(&self) -> &'static str {
        if self.unit.is_empty() { self.about } else { self.unit }
    }
}

/// The key of the table that `dotted` is, such as `boundary.NAME.condition` of `boundary.inflow.condition`.
pub fn find(dotted: &str) -> Option<&'static Key> {
    let parts = key::parts(dotted);
    KEYS.iter().copied().find(|key| key.key.split('.').count() == parts.len() && key.begins_with(&parts))
}

/// Whether `dotted` is a key or a table of keys.
pub(super) fn is_known(dotted: &str) -> bool {
    let parts = key::parts(dotted);
    KEYS.iter().any(|key| key.begins_with(&parts))
}

/// Names of keys and tables in the table `path`, in order.
pub(super) fn names_in(path: &str) -> Vec<&'static str> {
    let parts = if path.is_empty() { vec![] } else { key::parts(path) };
    let inside = KEYS.iter().filter(|key| key.begins_with(&parts));
    let mut names: Vec<&str> = inside.filter_map(|key| key.key.split('.').nth(parts.len())).collect();
    names.dedup();
    names
}

/// A key that was looked for, with those of its values that are meant.
pub struct Found {
    /// The key.
    pub key: &'static Key,
    /// Name and line of values.
    pub choices: Vec<(&'static str, &'static str)>,
}

/// The keys that `pattern` means: the key or table with this name, else all keys that contain the pattern or have a
/// value that contains it, else keys that other programs call so. `*` and `?` stand for any characters and for one. With
/// a pattern that occurs in values only, `choices` has those values only.
pub fn search(pattern: &str) -> Vec<Found> {
    let whole = |key: &'static Key| Found { key, choices: key.choices() };
    let word =
        pattern.trim().trim_start_matches('[').trim_end_matches(']').trim_end_matches('.').to_lowercase();
    if word.is_empty() {
        return KEYS.iter().copied().map(whole).collect();
    }
    let parts = key::parts(&word);
    let exact: Vec<Found> = KEYS.iter().copied().filter(|key| key.begins_with(&parts)).map(whole).collect();
    if !exact.is_empty() {
        return exact;
    }
    let glob = if word.contains(['*', '?']) { word.clone() } else { format!("*{word}*") };
    let found = KEYS.iter().copied().filter_map(|key| {
        if matches(&glob, &key.key.to_lowercase()) {
            return Some(whole(key));
        }
        let choices: Vec<_> =
            key.choices().into_iter().filter(|(name, _)| matches(&glob, &name.to_lowercase())).collect();
        (!choices.is_empty()).then_some(Found { key, choices })
    });
    let found: Vec<Found> = found.collect();
    if !found.is_empty() {
        return found;
    }
    KEYS.iter()
        .copied()
        .filter(|key| synonyms::meant(key.table(), &word) == key.key.rsplit('.').next())
        .map(whole)
        .collect()
}

/// `; did you mean `…`?` for the key, table or value closest to `pattern`, or nothing if none is close.
pub fn nearest(pattern: &str) -> String {
    let values = KEYS.iter().flat_map(|key| key.choices().into_iter().map(|(name, _)| name));
    let ends = KEYS.iter().filter_map(|key| key.key.rsplit('.').next());
    let tables = KEYS.iter().map(|key| key.table());
    did_you_mean(pattern, KEYS.iter().map(|key| key.key).chain(tables).chain(ends).chain(values))
}

/// Whether `text` is `glob`, where `*` stands for any characters and `?` for one.
fn matches(glob: &str, text: &str) -> bool {
    let mut rest = glob.chars();
    match rest.next() {
        None => text.is_empty(),
        Some('*') => {
            let rest = rest.as_str();
            text.char_indices().map(|(i, _)| i).chain([text.len()]).any(|i| matches(rest, &text[i..]))
        }
        Some(c) => {
            let mut letters = text.chars();
            letters.next().is_some_and(|letter| c == '?' || c == letter)
                && matches(rest.as_str(), letters.as_str())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(pattern: &str) -> Vec<&'static str> {
        search(pattern).iter().map(|found| found.key.key).collect()
    }

    #[test]
    fn keys_are_found_by_table_part_glob_value_and_other_names() {
        assert_eq!(keys("time.scheme"), ["time.scheme"]);
        assert_eq!(keys("boundary.inflow.backflow"), ["boundary.NAME.backflow"]);
        assert!(keys("motion").iter().all(|key| key.starts_with("motion.")));
        assert_eq!(keys("[time.adaptive]").len(), 4);
        assert_eq!(keys("min-"), ["time.adaptive.min-step"]);
        assert_eq!(
            keys("*.den*y"),
            ["fluid.density", "fluid.NAME.density", "solid.density", "solid.NAME.density"]
        );
        assert_eq!(keys("motion.?uter"), ["motion.outer"]);
        assert_eq!(keys("bdf2"), ["time.scheme"]);
        assert_eq!(search("bdf2")[0].choices.len(), 1);
        assert_eq!(keys("dt"), ["time.step"]);
        assert_eq!(keys("nonsense"), [""; 0]);
        assert_eq!(keys("").len(), KEYS.len());
        assert_eq!(nearest("time.shceme"), "; did you mean `time.scheme`?");
    }

    #[test]
    fn every_line_is_there_once() {
        for (n, key) in KEYS.iter().enumerate() {
            assert!(!key.about.is_empty() && !key.default.is_empty(), "{}", key.key);
            assert!(KEYS[..n].iter().all(|other| other.key != key.key), "{} is there twice", key.key);
            for (name, about) in key.choices() {
                // Elements say it by their names.
                assert!(!about.is_empty(), "{} = {name}", key.key);
            }
        }
    }
}
