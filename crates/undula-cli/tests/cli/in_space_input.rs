//! Input of cases in space that is refused, with key and reason.

use super::Place;

const BOX: &str = r#"
[mesh]
generator = "box"
lower = [0, 0, 0]
upper = [2, 1, 1]
cells = [4, 2, 2]
[fluid]
density = 1
kinematic-viscosity = 0.1
[boundary]
left = { condition = "velocity", velocity = ["y*(1 - y)*z*(1 - z)", 0, 0] }
right = { condition = "do-nothing" }
top = { condition = "no-slip" }
bottom = { condition = "no-slip" }
front = { condition = "no-slip" }
back = { condition = "no-slip" }
[functional]
force = { kind = "force", on = ["top"], component = "z" }
"#;

const LAYER: &str = "mesh.extrude={ depth = 0.1, layers = 1 }";

#[test]
fn vectors_of_a_box_have_three_components() {
    let here = Place::new("space-vectors");
    here.write("box.toml", BOX);
    here.run("check box.toml", &[]).expect(0, &[]);
    for (set, words) in [
        (
            "boundary.left.velocity=[1, 0]",
            &["expected three expressions", "\"z component\"", "not 2 values"][..],
        ),
        ("boundary.left.velocity=[1, 0, 0, 0]", &["expected three expressions", "not 4 values"]),
        ("fluid.body-force=[0, 1]", &["expected three expressions"]),
        ("mesh.lower=[0, 0]", &["expected three numbers, not 2 values"]),
        ("mesh.cells=[4, 2]", &["expected three integers"]),
        ("mesh.upper=[2, 1, -1]", &["right of, above and behind"]),
        ("functional.p={ kind = \"pressure\", point = [1, 0.5] }", &["functional.p.point", "three numbers"]),
        ("functional.p={ kind = \"pressure\", point = [1, 0.5, 3] }", &["lies in no cell"]),
        ("functional.force.component=tangential", &["expected one of `x`, `y`, `z`"]),
        (
            "functional.m={ kind = \"moment\", on = [\"top\"], point = [0, 0, 0] }",
            &["functional.m.component: missing"],
        ),
        ("mesh.coordinates=axisymmetric", &["expected `cartesian`"]),
        ("mesh.cells=[1000, 1000, 1000]", &["GB of memory", "expected fewer cells"]),
        (LAYER, &["only for meshes of the plane"]),
        (
            "boundary.right={ condition = \"resistance\", resistance = \"1 Pa s/m^2\" }",
            &["a flow resistance in space"],
        ),
    ] {
        let said = here.run("check box.toml", &[set]).expect(2, words);
        assert!(said.err.starts_with("--set"), "{}", said.err);
        assert!(!said.err.contains("mistakes"), "{}", said.err);
    }
    // What is written is read as the same case.
    let more = ["functional.m={ kind = \"moment\", on = [\"top\"], point = [0, 0, 0], component = \"x\" }"];
    let text = here.run("check box.toml --toml", &more).expect(0, &[]).out;
    here.write("again.toml", &text);
    assert_eq!(here.run("check again.toml --toml", &[]).expect(0, &[]).out, text);
}

#[test]
fn planes_are_extruded_if_they_can_be() {
    let here = Place::new("space-extrude");
    for (case, sets, words) in [
        ("cfd1", &["mesh.extrude={ depth = 0, layers = 1 }"][..], &["mesh.extrude.depth = 0", "above 0"][..]),
        (
            "cfd1",
            &["mesh.extrude={ depth = 0.1, layers = 0 }"],
            &["mesh.extrude.layers = 0", "from 1 to 100000"],
        ),
        ("cfd1", &["mesh.extrude={ depth = 0.1, layers = 1000000000 }"], &["from 1 to 100000"]),
        ("cfd1", &["mesh.extrude={ depth = 0.1, layers = 100000 }"], &["GB of memory"]),
        ("cfd1", &["mesh.extrude={ depth = 0.1 }"], &["mesh.extrude.layers: missing"]),
        ("cfd1", &["mesh.extrude=3"], &["expected a table"]),
        ("cfd1", &["mesh.extrude={ depth = \"1 kg\", layers = 1 }"], &["expected a length"]),
        ("cfd1", &["mesh.extrude={ depth = 1e-300, layers = 1 }"], &["det(DX)"]),
        ("tube-2d", &[LAYER], &["mesh.coordinates", "expected `cartesian`: an extruded mesh"]),
        ("csm1", &[LAYER, "functional.uy_A.point=[0.6, 0.2, 0.3]"], &["lies in no cell"]),
        ("csm1", &[LAYER, "solid.body-force=[0]"], &["two or three expressions"]),
        ("cfd1", &["boundary.inflow.velocity=[\"z*y\", 0]"], &["has no `z`", "an expression of x and y"]),
        ("tube-2d", &["boundary.inflow.pressure=\"z\""], &["has no `z`", "the place along the axis"]),
        ("cfd1", &["boundary.front.condition=symmetry"], &["the mesh has no boundary `front`"]),
        (
            "cfd1",
            &[LAYER, "boundary.front={ condition = \"periodic\", with = \"walls\" }"],
            &["`walls` has condition = `no-slip`"],
        ),
    ] {
        here.run(&format!("check {case}"), sets).expect(2, words);
    }
    here.run("check cfd1", &[LAYER, "boundary.front={ condition = \"periodic\", with = \"back\" }"])
        .expect(0, &[]);
    here.run("modes csm1", &["mesh.refine=0", LAYER]).expect(2, &["modes in space are not yet available"]);
    here.run("check tube-2d", &[LAYER, "mesh.coordinates=cartesian"]).expect(0, &[]);
}

/// A tube whose axis is an arc: the volume, and what is refused.
#[test]
fn tubes_follow_an_axis() {
    let here = Place::new("space-bent-tube");
    let arc = "mesh.axis=[\"0.02*(1 - cos(z/0.02))\", 0, \"0.02*sin(z/0.02)\"]";
    let sets = [arc, "mesh.length=0.03", "mesh.cells=[6, 8, 1]", "mesh.grading=1", "functional=none"];
    here.run("check tube", &sets).expect(0, &["168 cells"]);
    let toml = here.run("check tube --toml", &sets).expect(0, &["axis = [", "grading = 1"]);
    here.write("again.toml", &toml.out);
    let again = here.run("check again.toml --toml", &[]).expect(0, &[]);
    assert!(again.out == toml.out, "{}", again.out);
    for (axis, message) in [
        ("[\"x\", 0, \"z\"]", "mesh.axis"),
        ("[\"t\", 0, \"z\"]", "expected expressions of z, the coordinate along the straight tube"),
        ("[0, 0, \"-z\"]", "a curve that does not run against z"),
        ("[0, \"z\"]", "expected three expressions"),
    ] {
        here.run("check tube", &[&format!("mesh.axis={axis}")]).expect(2, &[message]);
    }
    here.run("check fsi-box", &[arc]).expect(2, &["only for generator = \"tube\""]);
}
