//! Input that is refused: exit code 2, and a message with file, line, key and what is allowed.

use super::{Place, SMALL};
use std::fs;

/// Two cells that meet at x = 1 with two sets of nodes there.
const CUT_OPEN: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n1 1 \"walls\"\n1 2 \"clamp\"\n\
    2 3 \"fluid\"\n2 4 \"solid\"\n$EndPhysicalNames\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 1 0 0\n\
    6 2 0 0\n7 2 1 0\n8 1 1 0\n$EndNodes\n$Elements\n10\n1 1 2 1 1 1 2\n2 1 2 1 1 2 3\n3 1 2 1 1 3 4\n\
    4 1 2 1 1 4 1\n5 1 2 2 2 5 6\n6 1 2 2 2 6 7\n7 1 2 2 2 7 8\n8 1 2 2 2 8 5\n9 3 2 3 3 1 2 3 4\n\
    10 3 2 4 4 5 6 7 8\n$EndElements\n";

const BODIES: &str = "[fluid]\ndensity = 1\nkinematic-viscosity = 1\n[solid]\ndensity = 1\nmu = 1\nlambda = 1\n\
    [boundary.walls]\ncondition = \"do-nothing\"\n[boundary.clamp]\ncondition = \"clamped\"\n\
    [time]\nstep = 0.1\nend = 1\n";

#[test]
fn mistakes_in_the_case_are_told_with_their_place() {
    let here = Place::new("mistakes");
    here.run("new fsi3 own.toml", &[]).expect(0, &["own.toml", "undula run"]);
    let good = here.read("own.toml");
    let line = |text: &str| 1 + good.lines().position(|line| line.starts_with(text)).unwrap();
    let density = line("density = 1000.0            # kg/m3");
    for (from, to, line, words) in [
        (
            "kinematic-viscosity",
            "kinematic-viscositty",
            density + 1,
            vec!["fluid.kinematic-viscositty", "unknown key", "did you mean `kinematic-viscosity`?"],
        ),
        (
            "density = 1000.0  ",
            "density = \"heavy\"",
            density,
            vec!["fluid.density = \"heavy\"", "a number above 0"],
        ),
        (
            "density = 1000.0  ",
            "density = -1000.0",
            density,
            vec!["fluid.density = -1000.0", "a number above 0"],
        ),
        (
            "[boundary.walls]",
            "[boundary.wall]",
            line("[boundary.walls]"),
            vec!["the mesh has no boundary `wall`", "did you mean `walls`?", "`inflow`"],
        ),
        (
            "*ramp(t,2)",
            "*rampp(t,2)",
            line("velocity ="),
            vec!["boundary.inflow.velocity[0]", "unknown function `rampp`", "did you mean `ramp`?"],
        ),
        (
            "on = [\"cylinder\", \"interface\"]\ncomponent = \"x\"",
            "on = [\"cilinder\"]\ncomponent = \"x\"",
            line("on ="),
            vec!["functional.drag.on", "no boundary `cilinder`", "did you mean `cylinder`?"],
        ),
        (
            "point = [0.6, 0.2]\ncomponent = \"y\"",
            "point = [0.6, 2]\ncomponent = \"y\"",
            line("[functional.uy_A]") + 2,
            vec!["functional.uy_A.point", "lies in no cell"],
        ),
        (
            "[functional.drag]",
            "[functional.min_J]",
            line("[functional.drag]"),
            vec!["functional.min_J", "columns of history.csv"],
        ),
    ] {
        let bad = good.replacen(from, to, 1);
        assert!(bad != good, "{from}");
        here.write("bad.toml", &bad);
        for command in ["check bad.toml", "run bad.toml -o results"] {
            let said = here.run(command, &[]).expect(2, &words);
            assert!(said.err.contains(&format!("bad.toml:{line}:")), "line {line}: {}", said.err);
        }
    }
    assert!(!here.file("results").exists());
}

#[test]
fn a_beam_that_nothing_holds_and_a_name_that_is_none() {
    let here = Place::new("unheld");
    here.run("run csm1 -o results", &["boundary.clamp=none"])
        .expect(2, &["csm1.toml:", "boundary `clamp` of the mesh has no condition", "`clamped`"]);
    here.run("run fsi3 -o results", &["boundary.clamp=none"]).expect(2, &["`clamp`", "[boundary.clamp]"]);
    here.run("run fsi33", &[]).expect(2, &["no such case or file: `fsi33`", "did you mean `fsi3`?"]);
    here.run("new fsy3", &[]).expect(2, &["did you mean `fsi3`?"]);
    here.run("run fsi3", &["time.step"]).expect(2, &["--set time.step", "key=value"]);
    here.run("run fsi3 --threads 0", &[]).expect(2, &["threads"]);
    assert!(!here.file("out").exists() && !here.file("results").exists());
}

#[test]
fn meshes_that_do_not_match_are_refused() {
    let here = Place::new("matching");
    let mesh = "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [4, 1]\ncells = [8, 2]\n";
    let case = |solid: &str| format!("{mesh}region.solid = \"{solid}\"\n{}", BODIES.replace("walls", "left"));
    here.write("cut.toml", &case("x - 2.1"));
    here.run("check cut.toml", &[])
        .expect(2, &["cut.toml:6:", "mesh.region.solid", "cut by the interface", "(2.25, 0.25)"]);
    // Along the edges of the cells the same regions are accepted, as a signed function and as a condition.
    for solid in ["x - 2", "x > 2"] {
        here.write("good.toml", &case(solid));
        let said = here.run("check good.toml", &[]);
        assert!(!said.err.contains("cut by"), "{}", said.err);
        assert!(said.err.contains("the mesh has no boundary `clamp`"), "{}", said.err);
    }
    here.write("open.msh", CUT_OPEN);
    here.write("open.toml", &format!("[mesh]\nfile = \"open.msh\"\n{BODIES}"));
    here.run("run open.toml", &[])
        .expect(2, &["open.toml:2:", "mesh.file", "duplicated nodes", "Coherence", "(0.5, 0.5)"]);
    here.write("no-mesh.toml", &format!("[mesh]\nfile = \"none.msh\"\n{BODIES}"));
    here.run("run no-mesh.toml", &[])
        .expect(2, &["no-mesh.toml:2:", "mesh.file", "none.msh", "No such file"]);
    // Vectors of three components are no mistake then.
    let sets = ["solid.body-force=[0, 0, -1]", "mesh.wall={ surface = 'lumen', thickness = 1 }"];
    let said =
        here.run("run no-mesh.toml", &sets).expect(2, &["no-mesh.toml:2:", "none.msh", "No such file"]);
    assert!(!said.err.contains("mistakes") && !said.err.contains("expected two"), "{}", said.err);
    here.write("broken.msh", &CUT_OPEN.replace("6 2 0 0", "6 2 zero 0"));
    here.write("broken.toml", &format!("[mesh]\nfile = \"broken.msh\"\n{BODIES}"));
    here.run("run broken.toml", &[]).expect(2, &["broken.toml:2:", "broken.msh:18:", "zero"]);
}

#[test]
fn directories_of_others_are_left_alone() {
    let here = Place::new("foreign");
    fs::create_dir(here.file("thesis")).unwrap();
    here.write("thesis/chapter5.tex", "years of work");
    for flag in ["", "--force", "--resume"] {
        here.run(&format!("run fsi3 -o thesis {flag}"), &SMALL).expect(2, &["thesis"]);
    }
    assert_eq!(fs::read_dir(here.file("thesis")).unwrap().count(), 1);
    here.run("run fsi3 -o thesis/chapter5.tex", &SMALL).expect(2, &["chapter5.tex", "a directory is needed"]);
    here.run("run fsi3 -o thesis/chapter5.tex/out", &SMALL)
        .expect(2, &["chapter5.tex", "cannot create directory"]);
    here.run("plot thesis", &[]).expect(2, &["thesis", "no run here"]);
    here.run("compare thesis", &[]).expect(2, &["thesis", "summary.json"]);
    here.run("compare nowhere", &[]).expect(2, &["nowhere"]);
}
