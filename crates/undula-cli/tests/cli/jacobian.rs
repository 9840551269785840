//! `undula check --jacobian`, and what `undula run --verbose` tells of Newton's method.

use super::{Place, SMALL};

#[test]
fn jacobians_are_compared_at_a_random_state() {
    let here = Place::new("jacobian");
    let said = here.run("check fsi3 --jacobian", &["mesh.refine=0"]);
    let said =
        said.expect(0, &["a random state, seed 1", "analytic", "whole residual", "all Jacobians agree"]);
    for block in ["NS x u", "NS+ES x v", "ES x u", "div x v", "ALE x u", "uv x v"] {
        assert!(said.out.contains(block), "{block}: {}", said.out);
    }
    here.run("check fsi3 --jacobian --seed 2", &["mesh.refine=0"]).expect(0, &["seed 2"]);
    // Steps so small that differences see a slope where derivatives see none.
    let steps =
        ["mesh.refine=0", "fluid.body-force=[\"1e-3*floor(1e9*x)\", 0]", "fluid.body-force-at=current"];
    let said = here.run("check fsi3 --jacobian", &steps).expect(1, &["do NOT agree", "TOO MUCH"]);
    assert!(
        said.out.contains("NS x u: row of v_x at (") && said.out.contains("column of u_x at ("),
        "{}",
        said.out
    );
}

#[test]
fn jacobians_are_compared_where_a_run_is() {
    let here = Place::new("jacobian-from");
    here.run("run fsi3 -o results --quiet", &SMALL).expect(0, &[]);
    here.run("check --jacobian --from results", &[])
        .expect(0, &["the state at t = 0.05 s", "all Jacobians agree"]);
    here.run("check --jacobian --from nowhere", &[]).expect(2, &["the output directory of `undula run`"]);
    here.run("check --from results", &[]).expect(2, &["--jacobian"]);
    here.run("check", &[]).expect(2, &["required"]);
}

#[test]
#[ignore = "long"]
fn a_verbose_run_tells_its_residuals() {
    let here = Place::new("verbose");
    let said =
        here.run("run fsi3 -o results --verbose", &SMALL).expect(0, &["t = 0.05000 s: ", "residuals "]);
    assert_eq!(said.err.matches("residuals ").count(), 5, "{}", said.err);
}
