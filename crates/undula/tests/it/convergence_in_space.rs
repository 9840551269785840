//! Orders of convergence in three dimensions of a known solution of the coupled problem in the unit cube: `errors` of
//! `verification/unit_square.rs`, whose series with more cells `undula study validation/orders-in-space.toml` computes.

use crate::common::sets;
use crate::manufactured::{Body, Cells, cube};
use undula::case::Case;
use undula::mesh::gmsh::write;
use undula::verification::unit_square::errors;

/// The unit cube, its lower half solid, in `mesh`.
pub fn case(mesh: &str, more: &[&str]) -> Case {
    let text = format!(
        r#"
[mesh]
{mesh}
[fluid]
density = 1.3
kinematic-viscosity = 0.4
[solid]
density = 2.1
law = "st-venant-kirchhoff"
mu = 3.0
lambda = 4.0
[motion]
poisson = -0.2
[boundary]
left.condition = "no-slip"
right.condition = "no-slip"
front.condition = "no-slip"
back.condition = "no-slip"
bottom.condition = "clamped"
top.condition = "do-nothing"
"#
    );
    Case::from_toml(&text, "cube.toml", &sets(more)).unwrap_or_else(|e| panic!("{e}"))
}

/// Errors of v, u and p with `n` cells per direction: trilinear ones that stay so under refinement, then bent.
fn on_cells(n: usize, more: &[&str]) -> [f64; 3] {
    let [even, mut mesh] = [Cells::Square, Cells::Trapezia].map(|cells| cube(n, cells, Body::Half));
    for (x, even) in mesh.nodes.iter_mut().zip(even.nodes) {
        *x = std::array::from_fn(|d| 0.5 * (x[d] + even[d]));
    }
    // The case names the interface itself.
    let interface = mesh.boundary("interface").unwrap();
    mesh.facets.retain(|facet| facet.boundary != interface);
    let name = format!("undula-cube-{}-{:?}-{n}.msh", std::process::id(), std::thread::current().id());
    let file = std::env::temp_dir().join(name);
    std::fs::write(&file, write(&mesh)).unwrap();
    let more = [more, &["boundary.clamp.condition=clamped"]].concat();
    let found = errors(&case(&format!("file = {file:?}"), &more)).unwrap();
    std::fs::remove_file(file).unwrap();
    [found.v, found.u, found.p]
}

/// Orders between 2 and 4 cells per direction at least `least`.
#[track_caller]
fn check(least: [f64; 3], more: &[&str]) {
    let [coarse, fine] = [2, 4].map(|n| on_cells(n, more));
    let orders = [0, 1, 2].map(|i| (coarse[i] / fine[i]).log2());
    println!("{more:?}: {coarse:?} {fine:?} orders {orders:.2?}");
    assert!((0..3).all(|i| orders[i] >= least[i]), "{more:?}: {orders:.2?}, expected {least:?}");
}

#[test]
fn q2_in_space_has_order_3_and_its_pressures_2() {
    check([2.6, 2.6, 1.9], &["space.velocity=Q2", "space.pressure=P1dc"]);
    check([2.6, 2.6, 1.9], &["space.velocity=Q2", "space.pressure=Q1"]);
}

#[test]
fn stabilised_pairs_in_space_have_their_orders() {
    for how in ["lps", "pspg"] {
        let how = format!("stabilization.pressure={how}");
        check([1.9, 1.9, 1.3], &["space.velocity=Q1", "space.pressure=Q1", &how]);
    }
    check([2.6, 2.6, 1.9], &["space.velocity=Q2", "space.pressure=Q2"]);
}

#[test]
fn q3_in_space_has_order_4_and_its_pressure_3() {
    check([3.6, 3.6, 2.8], &["space.velocity=Q3", "space.pressure=P2dc"]);
}

/// A mesh of 8 cells, as high as this.
fn cuboid(depth: &str) -> String {
    format!(
        "generator = \"box\"\nlower = [0, 0, 0]\nupper = [1, 1, {depth}]\ncells = [2, 2, 2]\nregion.solid = \"0.5 - y\""
    )
}

/// The order of each scheme in time, of v, u and p, on 8 cubes in whose spaces the solution lies at all times.
#[test]
fn schemes_in_space_have_their_orders() {
    let mesh = cuboid("1");
    let mesh = mesh.as_str();
    for (scheme, order, steps) in [
        ("backward-euler", 1.0, 20),
        ("crank-nicolson", 2.0, 12),
        ("shifted-crank-nicolson", 2.0, 20),
        ("fractional-step-theta", 2.0, 12),
        ("bdf2", 2.0, 20),
        ("cg1", 2.0, 12),
    ] {
        let scheme = format!("time.scheme={scheme}");
        let [coarse, fine] = [steps, 2 * steps].map(|steps| {
            let step = format!("time.step={}", 1.2 / steps as f64);
            // θ − ½ of the shifted scheme is this times the step.
            let shift = if scheme.contains("shifted") { &["time.shift=1"][..] } else { &[] };
            let sets = [&[&scheme, &step[..], "time.end=1.2"], shift].concat();
            let found = errors(&case(mesh, &sets)).unwrap();
            [found.v, found.u, found.p]
        });
        let orders = [0, 1, 2].map(|i| (coarse[i] / fine[i]).log2());
        println!("{scheme}: {coarse:?} {fine:?} orders {orders:.2?}");
        assert!(orders.iter().all(|found| *found > order - 0.25), "{scheme}: {orders:.2?}");
    }
}

#[test]
fn another_domain_is_refused() {
    let message = errors(&case(&cuboid("2"), &[])).unwrap_err().to_string();
    let expected = "the known solution lives on the unit cube: expected a mesh of (0, 1)³";
    assert!(message.contains(expected), "{message}");
}
