//! What the tests of case files share.
#![allow(dead_code)]

use undula::case::Case;
use undula::setup::names::MeshNames;

pub fn sets(overrides: &[&str]) -> Vec<String> {
    overrides.iter().map(|s| s.to_string()).collect()
}

pub fn builtin(name: &str, overrides: &[&str]) -> Case {
    match Case::builtin(name, &sets(overrides)) {
        Ok(case) => case,
        Err(e) => panic!("{name} {overrides:?}:\n{e}"),
    }
}

/// The messages for `text`, one per line.
pub fn wrong(text: &str, overrides: &[&str]) -> String {
    match Case::from_toml(text, "own.toml", &sets(overrides)) {
        Ok(_) => panic!("should be refused:\n{text}\n{overrides:?}"),
        Err(e) => e.to_string(),
    }
}

pub fn wrong_builtin(name: &str, overrides: &[&str]) -> String {
    match Case::builtin(name, &sets(overrides)) {
        Ok(_) => panic!("should be refused: {name} {overrides:?}"),
        Err(e) => e.to_string(),
    }
}

pub const FLUID: &str =
    "[mesh]\ngenerator = \"schaefer-turek\"\n[fluid]\ndensity = 1\nkinematic-viscosity = 1e-3\n";

/// Names of the built-in channel with beam.
pub fn turek_hron() -> MeshNames {
    MeshNames::of(&undula::mesh::generate::turek_hron(0, 0))
}

/// Every scheme in time as a setting.
pub const SCHEMES: [&str; 9] = [
    "time.scheme=backward-euler",
    "time.scheme=crank-nicolson",
    "time.scheme=shifted-crank-nicolson",
    "time.scheme=rannacher",
    "time.scheme=fractional-step-theta",
    "time.scheme=cg1",
    "time.scheme=bdf2",
    "time.scheme=esdirk3",
    "time.scheme=esdirk4",
];

/// A channel of 4 m × 1 m with ρ = 1 and ν = 0.1 between two walls, in `cells` cells, with tractions (N/m²) at its inlet
/// `left` and its outlet `right`, and the tables `more`.
pub fn channel(
    cells: [usize; 2],
    inlet: [String; 2],
    outlet: [String; 2],
    more: &str,
    overrides: &[&str],
) -> Case {
    let traction = |data: [String; 2]| format!("condition = \"traction\"\ntraction = {data:?}");
    channel_between(cells, [&traction(inlet), &traction(outlet)], more, overrides)
}

/// The same with what the tables of `left` and `right` say.
pub fn channel_between(cells: [usize; 2], ends: [&str; 2], more: &str, overrides: &[&str]) -> Case {
    let [left, right] = ends;
    let text = format!(
        r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [4, 1]
cells = {cells:?}
[fluid]
density = 1
kinematic-viscosity = 0.1
[boundary.left]
{left}
[boundary.right]
{right}
[boundary.top]
condition = "no-slip"
[boundary.bottom]
condition = "no-slip"
[newton]
tolerance = 1e-12
{more}"#
    );
    Case::from_toml(&text, "channel.toml", &sets(overrides)).unwrap()
}
