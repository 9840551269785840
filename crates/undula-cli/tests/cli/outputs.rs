//! What a run leaves behind, and the commands that read it.

use super::{Place, SMALL};
use std::fs;

#[test]
#[ignore = "long"]
fn the_output_directory_keeps_its_contract() {
    let here = Place::new("contract");
    let mut sets = SMALL.to_vec();
    sets.extend(["output.fields-every=2", "output.checkpoint-every=2"]);
    here.run("run fsi3 -o results --threads 2", &sets)
        .expect(0, &[" cells, ", "2 threads", "completed", "is not `fsi3`", "results/plots/speed.png"]);
    let history = here.read("results/history.csv");
    let lines: Vec<&str> = history.lines().collect();
    assert_eq!(lines[0], "step,time,force_time,drag,lift,ux_A,uy_A,min_J,newton_steps,jacobians");
    assert_eq!(lines.len(), 6);
    assert!(lines[3].starts_with("3,0.03,"), "{}", lines[3]);
    assert!(lines.iter().all(|line| line.split(',').count() == 10));
    let summary = here.json("results/summary.json");
    for key in
        "status case cells unknowns steps newton_steps jacobians factorizations threads wall_seconds phases \
                peak_memory_bytes mass_balance swept_volume functionals"
            .split_whitespace()
    {
        assert!(summary.get(key).is_some(), "{key}");
    }
    assert_eq!((&summary["status"], &summary["case"]), (&"completed".into(), &"fsi3".into()));
    assert_eq!((&summary["steps"], &summary["threads"]), (&5.into(), &2.into()));
    let last: f64 = lines[5].split(',').nth(3).unwrap().parse().unwrap();
    assert_eq!(summary["functionals"]["drag"]["last"].as_f64(), Some(last));
    assert_eq!(summary["functionals"]["drag"]["unit"], "N/m");
    for file in ["fields.pvd", "fields/fields_000002.vtu", "fields/fields_000005.vtu"] {
        assert!(here.file("results").join(file).is_file(), "{file}");
    }
    for file in ["checkpoint_00000004.npz", "checkpoint_00000005.npz"] {
        assert!(here.file("results/checkpoints").join(file).is_file(), "{file}");
    }
    assert_eq!(fs::read_dir(here.file("results/checkpoints")).unwrap().count(), 2);
    assert!(!here.file("results/.lock").exists());
    // The resolved case is a case: it gives the same bits, on another number of threads.
    here.run("check results/case.toml", &[]).expect(0, &[" cells, "]);
    here.run("run results/case.toml -o again --quiet --threads 1", &[]).expect(0, &[]);
    assert_eq!(here.read("again/history.csv"), history);
    assert_eq!(here.read("again/case.toml"), here.read("results/case.toml"));
    commands_read_it(&here);
}

fn commands_read_it(here: &Place) {
    // The beam falls, as that of the benchmark does not.
    here.run("compare results", &[]).expect(2, &["solid.body-force = [0.0,-2.0] instead of [0.0,0.0]"]);
    here.run("compare results again", &[]).expect(0, &["drag", "lift", "uy_A"]);
    here.write("own.reference.toml", "case = \"fsi3\"\n[reference.drag]\nvalue = 100\nsource = \"own\"\n");
    here.run("compare results --reference own.reference.toml", &[]).expect(0, &["own"]);
    fs::remove_dir_all(here.file("results/plots")).unwrap();
    let said =
        here.run("plot results", &[]).expect(0, &["results/plots/speed.png", "results/plots/pressure.png"]);
    assert!(said.out.lines().all(|picture| here.file(picture).is_file()), "{}", said.out);
    here.run("plot results -o pictures", &[]).expect(0, &["pictures/speed.png"]);
    here.run("run fsi3 -o again --quiet --force", &[&SMALL[..], &["time.end=0.01"]].concat()).expect(0, &[]);
    assert_eq!(here.read("again/history.csv").lines().count(), 2);
    assert!(!here.file("again/checkpoints/checkpoint_00000005.npz").exists());
}

#[test]
fn a_case_without_solid_or_without_fluid() {
    let here = Place::new("parts");
    let flow = ["solid=none", "time=none", "time.scheme=stationary", "time.end=0.5"];
    here.run("run fsi3 -o flow", &[&flow[..], &["mesh.refine=0"]].concat())
        .expect(0, &["deformation 0", "functional.uy_A is left out", "speed.png"]);
    let history = here.read("flow/history.csv");
    assert!(
        history.starts_with("step,time,force_time,drag,lift,min_J,newton_steps,jacobians\n0,"),
        "{history}"
    );
    here.run("run fsi3 -o solid", &[&SMALL[..], &["fluid=none"]].concat())
        .expect(0, &["pressure 0", "functional.drag is left out", "deformation.png"]);
    assert!(here.read("solid/history.csv").starts_with("step,time,force_time,ux_A,uy_A,"));
}

#[test]
fn cases_new_and_check() {
    let here = Place::new("cases");
    let said = here.run("cases", &[]).expect(0, &[]);
    let names: Vec<&str> = said.out.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.len() >= 12 && names.contains(&"fsi3") && names.contains(&"dfg-2d2"), "{names:?}");
    for name in names {
        here.run(&format!("new {name}"), &[]).expect(0, &[]);
        let said =
            here.run(&format!("check {name}.toml"), &["mesh.refine=0"]).expect(0, &["cells", "unknowns"]);
        assert!(said.err.is_empty(), "{name}: {}", said.err);
    }
    here.run("new fsi3", &[]).expect(2, &["fsi3.toml exists already", "--force"]);
    here.run("new fsi3 --force", &[]).expect(0, &[]);
    here.run("check fsi3", &[]).expect(0, &["Re = 200 ", "Poisson 0.4000", "2000 steps", "density ratio"]);
    let resolved = here.run("check fsi3 --toml", &["time.step=0.002"]).expect(0, &["step = 0.002"]);
    here.write("resolved.toml", &resolved.out);
    assert_eq!(here.run("check resolved.toml --toml", &[]).out, resolved.out);
}

/// One quadrilateral of 100 by 50, as a mesh in millimetres is.
const LARGE: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 1 \"wall\"\n1 2 \"inlet\"\n2 3 \"fluid\"\n\
                     $EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 100 0 0\n3 100 50 0\n4 0 50 0\n$EndNodes\n$Elements\n5\n\
                     1 1 2 1 1 1 2\n2 1 2 1 1 3 4\n3 1 2 1 1 2 3\n4 1 2 2 2 4 1\n5 3 2 3 3 1 2 3 4\n$EndElements\n";

#[test]
fn check_tells_extents_regions_boundaries_and_the_flow() {
    let here = Place::new("overview");
    let told = [
        "x from 0 to 2.5 m, y from 0 to 0.41 m",
        "region    fluid: ",
        "region    solid: ",
        "boundary  inflow: velocity, 0.41 m (fluid)",
        "boundary  interface: coupling, 0.7",
        "inflow    inflow: mean velocity up to 2 m/s, largest 3 m/s",
        "Re = 200 with that mean and 0.1 m, the diameter of the cylinder",
        "CFL = ",
        " MB of memory for a run, about 0.00",
        " s of a processor for a step",
    ];
    for velocity in ["space.velocity=Q2", "space.velocity=P2"] {
        here.run("check fsi3", &["mesh.refine=0", velocity]).expect(0, &told);
    }
    here.run("check dfg-2d3", &["mesh.refine=0"]).expect(0, &["Re = 100 with that mean and 0.1 m"]);
    here.write("large.msh", LARGE);
    let case = "[mesh]\nfile = \"large.msh\"\n[fluid]\ndensity = 1000\nkinematic-viscosity = 1e-6\n[boundary]\n\
                wall.condition = \"do-nothing\"\ninlet = { condition = \"velocity\", velocity = [0.1, 0] }\n";
    here.write("large.toml", case);
    let said = here.run("check large.toml", &[]).expect(0, &["the mesh is 100 m long", "mesh.scale = 1e-3"]);
    assert!(
        said.out.contains("Re = 5e6 with that mean and 50 m, the length of that boundary"),
        "{}",
        said.out
    );
    let said = here.run("check large.toml", &["fluid.density=1e-3"]).expect(0, &[]);
    assert!(!said.out.contains("millimetres"), "{}", said.out);
}

/// Constants of the case alone and of the state of a run, in words.
#[test]
fn inf_sup_constants_are_told_with_what_they_mean() {
    let here = Place::new("inf-sup");
    here.run("run fsi3 -o results --quiet", &SMALL).expect(0, &[]);
    let common = ["reference domain, (5.25)", "(5.24)", "coupled matrix (5.35)", "extension: ALE", "2-norm"];
    let small = &SMALL[..];
    let said = here.run("check --inf-sup fsi3", small).expect(0, &common);
    assert!(said.out.contains("with a smooth deformation"), "{}", said.out);
    let said = here.run("check --inf-sup fsi3 --from results", small).expect(0, &common);
    assert!(said.out.contains("on the domain at t = 0.05 s"), "{}", said.out);
    let equal = [small, &["space.velocity=Q1"]].concat();
    here.run("check --inf-sup fsi3", &equal).expect(0, &["(5.25)", "(5.24)"]);
    here.run("check fsi3 --from results", &[]).expect(2, &["--inf-sup"]);
}

#[test]
fn a_summary_says_where_the_result_comes_from() {
    let here = Place::new("provenance");
    here.run("run fsi3 -o results --quiet", &SMALL).expect(0, &[]);
    let summary = here.json("results/summary.json");
    let text = |key: &str| summary[key].as_str().unwrap_or_default().to_string();
    assert_eq!(text("version"), env!("CARGO_PKG_VERSION"));
    assert!(text("date").ends_with('Z') && text("date").len() == 20, "{summary}");
    let commit = text("commit");
    let digits = commit.trim_end_matches("-dirty");
    assert!(
        summary["commit"].is_null() || digits.len() == 40 && digits.bytes().all(|c| c.is_ascii_hexdigit())
    );
    assert!(summary.get("processor").is_some());
    assert!(text("case_hash").len() == 32 && summary["mesh_hash"].is_null(), "{summary}");
    // The same input has the same hash, another one has another.
    here.run("run fsi3 -o again --quiet", &SMALL).expect(0, &[]);
    assert_eq!(here.json("again/summary.json")["case_hash"], summary["case_hash"]);
    here.run("run fsi3 -o other --quiet --set fluid.density=999", &SMALL).expect(0, &[]);
    assert_ne!(here.json("other/summary.json")["case_hash"], summary["case_hash"]);
}
