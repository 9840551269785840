//! One run by several processes, started by `mpirun` where that is there and PETSc too: numbers, files, and what goes
//! wrong on some of them.

use super::engines::{LAYER, PETSC, TIGHT, is_near, is_there};
use super::in_space::{FLAP, FUNCTIONALS};
use super::{Place, Said};
use std::fs;
use std::process::Command;
use undula::output::read_snapshot;

/// Whether the machine can; says so if not.
fn can() -> bool {
    let there = Command::new("mpirun").arg("--version").output().is_ok_and(|said| said.status.success());
    if !there {
        println!("skipped: there is no mpirun");
    }
    there && is_there()
}

/// `mpirun`, about to start programs here.
fn mpirun(here: &Place) -> Command {
    let mut command = Command::new("mpirun");
    command.arg("--oversubscribe").current_dir(here.file("."));
    // In containers of tests everybody is root.
    command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    command
}

/// Several programs: of each the number of processes, the arguments, and the settings.
fn together(here: &Place, programs: &[(usize, &str, &[&str])]) -> Said {
    let mut command = mpirun(here);
    for (i, (n, arguments, sets)) in programs.iter().enumerate() {
        command.args((i > 0).then_some(":")).args(["-n", &n.to_string()]);
        command.arg(env!("CARGO_BIN_EXE_undula")).args(arguments.split_whitespace());
        command.args(sets.iter().flat_map(|set| ["--set", set]));
    }
    Said::of(command.output().unwrap())
}

/// A process in each of two directories, which do not see the same files.
fn apart(here: &Place, directories: [&str; 2], arguments: &str, sets: &[&str]) -> Said {
    let mut command = mpirun(here);
    for (i, directory) in directories.iter().enumerate() {
        command.args((i > 0).then_some(":")).args([
            "-n",
            "1",
            "-wdir",
            here.file(directory).to_str().unwrap(),
        ]);
        command.arg(env!("CARGO_BIN_EXE_undula")).args(arguments.split_whitespace());
        command.args(sets.iter().flat_map(|set| ["--set", set]));
    }
    Said::of(command.output().unwrap())
}

/// Lines of the program: `mpirun` adds some of its own where a process ends with an error.
fn own_lines(said: &Said, of: &str) -> usize {
    said.err.lines().filter(|line| line.contains(of)).count()
}

#[test]
fn several_processes_compute_what_one_computes() {
    if !can() {
        return;
    }
    let here = Place::new("several-same");
    here.write("flap.toml", &format!("{FLAP}{FUNCTIONALS}"));
    for space in [&[][..], &[LAYER]] {
        let sets = [&TIGHT[..], space].concat();
        let own = here.rows("flap.toml", &sets);
        for (n, more) in [
            (2, &[][..]),
            (3, &["newton.linearization=newton"]),
            (2, &["linear.petsc.options=-ksp_type fgmres -ksp_rtol 1e-8 -pc_type asm -sub_pc_type ilu"]),
        ] {
            // Blocks of the processes alone are too weak for the whole Jacobian in space.
            let sets = [&sets[..], &[PETSC], more].concat();
            let said = together(&here, &[(n, "run flap.toml --quiet --force -o several", &sets)]);
            said.expect(0, &[]);
            is_near(&own, &here.rows_of("several"), &sets);
        }
    }
    let summary = here.json("several/summary.json");
    assert_eq!((&summary["status"], &summary["processes"]), (&"completed".into(), &2.into()));
    assert!(summary["engine"].as_str().is_some_and(|engine| engine.starts_with("PETSc 3.")), "{summary}");
    // They share the mesh: none has all of it.
    let ranks = summary["ranks"].as_array().unwrap();
    let cells = |key: &str| ranks.iter().map(|rank| rank[key].as_u64().unwrap()).sum::<u64>();
    assert_eq!((ranks.len(), cells("cells")), (2, summary["cells"].as_u64().unwrap()));
    assert!(
        cells("copies") < cells("cells") && ranks.iter().all(|rank| rank["sent_bytes"].as_u64() > Some(0))
    );
}

/// Levels of multigrid, and older factors with GMRES.
#[test]
fn our_own_iterations_go_on_across_the_processes() {
    if !can() {
        return;
    }
    let here = Place::new("several-levels");
    here.write("flap.toml", FLAP);
    let sets = [&TIGHT[..], &["linear.precision=double", "mesh.refine=1"]].concat();
    let own = here.rows("flap.toml", &sets);
    for (n, more) in
        [(2, "linear.solver=multigrid"), (3, "linear.solver=multigrid"), (2, "linear.krylov=gmres")]
    {
        let sets = [&sets[..], &[more]].concat();
        let said = together(&here, &[(n, "run flap.toml --force -o several", &sets)]);
        said.expect(0, &["processes share the mesh of 48 cells"]);
        is_near(&own, &here.rows_of("several"), &sets);
        let summary = here.json("several/summary.json");
        assert_eq!(summary["direct_fallbacks"], 0);
        let iterations = summary["linear_iterations"].as_u64();
        assert!(iterations > summary["newton_steps"].as_u64(), "{summary}");
    }
    // Nothing as large as the system has factors.
    here.run("run flap.toml --force --quiet -o one", &[&sets[..], &["linear.solver=multigrid"]].concat())
        .expect(0, &[]);
    let sets = [&sets[..], &["linear.solver=multigrid"]].concat();
    together(&here, &[(2, "run flap.toml --force --quiet -o several", &sets)]).expect(0, &[]);
    let largest = |name: &str| here.json(name)["largest_factor_unknowns"].as_u64().unwrap();
    assert_eq!(largest("several/summary.json"), largest("one/summary.json"));
}

/// A tube with an outlet whose pressure depends on the flow.
const OUTLET: &str = r#"
[mesh]
generator = "tube"
length = 0.05
radii = [0.005, 0.006]
cells = [6, 4, 1]
[fluid]
density = 1000
kinematic-viscosity = 3e-6
[solid]
density = 1200
young = 3e5
poisson = 0.3
[boundary.inflow]
condition = "flux"
profile = "parabolic"
flow-rate = "-1e-5*ramp(t,0.001)"
[boundary.outflow]
condition = "windkessel"
proximal = 1e7
capacitance = 1e-9
distal = 1e8
[boundary.clamp]
condition = "clamped"
[boundary.outside]
condition = "traction-free"
[time]
step = 1e-4
end = 3e-4
[functional.flow]
kind = "flux"
on = ["outflow"]
[functional.force]
kind = "force"
on = ["outflow", "interface"]
component = "z"
"#;

/// What couples all of the domain: flow through an outlet, a pressure without a level, patches, terms of fourth order,
/// boundaries that move.
#[test]
#[ignore = "long"]
fn what_couples_the_whole_domain_is_shared() {
    if !can() {
        return;
    }
    let here = Place::new("several-couplings");
    here.write("outlet.toml", OUTLET);
    let fsi3 = ["mesh.refine=0", "time.end=0.01"];
    for (case, sets) in [
        ("outlet.toml", &[][..]),
        ("outlet.toml", &["newton.linearization=newton"]),
        ("cavity", &["mesh.refine=0", "time.end=0.05"]),
        ("pump", &["mesh.refine=0", "time.end=0.02"]),
        ("fsi3", &[fsi3[0], fsi3[1], "motion.model=biharmonic"]),
        ("fsi3", &["mesh.refine=1", fsi3[1], "space.pressure=Q2", "stabilization.pressure=lps"]),
        ("fsi3", &[fsi3[0], "time.end=0.02", "time.adaptive.tolerance=1e-3"]),
        ("fsi3", &[fsi3[0], fsi3[1], "time.scheme=esdirk3"]),
        ("land", &[]),
        ("outlet.toml", &["linear.solver=multigrid", "mesh.refine=1"]),
        ("fsi3", &["linear.solver=multigrid", "mesh.refine=1", "time.end=0.005"]),
        ("dfg-2d3", &["linear.solver=multigrid", "mesh.refine=1", "time.end=0.01"]),
    ] {
        let sets = [&["newton.tolerance=1e-11", "linear.precision=double"], sets].concat();
        let arguments = format!("run {case} --quiet --force -o");
        here.run(&format!("{arguments} one"), &sets).expect(0, &[]);
        together(&here, &[(3, &format!("{arguments} several"), &sets)]).expect(0, &[]);
        assert!(here.json("several/summary.json")["ranks"].is_array(), "{case} {sets:?} is not shared");
        is_near(&here.rows_of("one"), &here.rows_of("several"), &sets);
    }
}

#[test]
fn fields_of_several_processes_are_those_of_one() {
    if !can() {
        return;
    }
    let here = Place::new("several-fields");
    here.write("flap.toml", FLAP);
    let fields = "output.fields=[\"velocity\", \"displacement\", \"pressure\", \"stress\", \"vorticity\"]";
    let sets = [&TIGHT[..], &["linear.precision=double", "output.fields-every=1", fields]].concat();
    here.run("run flap.toml --quiet -o one", &sets).expect(0, &[]);
    together(&here, &[(3, "run flap.toml --quiet -o several", &sets)]).expect(0, &[]);
    let read = |name: &str| read_snapshot(here.file(name)).unwrap();
    let (one, time) = read("one/fields/fields_000002.vtu");
    let (several, same) = read("several/fields/fields_000002.pvtu");
    assert_eq!((time, one.n_cells(), one.points.len()), (same, several.n_cells(), several.points.len()));
    let near = |a: &[f64; 3], b: &[f64; 3]| (0..3).all(|d| (a[d] - b[d]).abs() < 1e-9);
    for (n, x) in several.points.iter().enumerate() {
        let m = one.points.iter().position(|y| near(x, y)).unwrap();
        for (a, b) in several.point_data.iter().zip(&one.point_data) {
            let (k, largest) = (a.components, b.values.iter().fold(1e-9, |most: f64, b| most.max(b.abs())));
            for (a_i, b_i) in a.values[n * k..][..k].iter().zip(&b.values[m * k..][..k]) {
                let gap = (a_i - b_i).abs() / largest;
                assert!(gap < 1e-8 || (a_i.is_nan() && b_i.is_nan()), "{} at {x:?}: {a_i} {b_i}", a.name);
            }
        }
    }
    here.run("plot several", &[]).expect(0, &[]);
    here.run("report several", &[]).expect(0, &[]);
}

#[test]
fn one_process_writes_and_a_run_goes_on_with_others() {
    if !can() {
        return;
    }
    let here = Place::new("several-resume");
    here.write("flap.toml", FLAP);
    let run = |n: usize, arguments: &str, sets: &[&str]| together(&here, &[(n, arguments, sets)]);
    let [first, more] = ["time.end=0.02", "time.end=0.04"];
    let said = run(2, "run flap.toml -o out", &[first]).expect(0, &["linear.engine: PETSc"]);
    assert_eq!(own_lines(&said, "unknowns (velocity"), 1, "{}", said.err);
    run(2, "run flap.toml -o out", &[first]).expect(2, &["holds a completed run; use --force"]);
    run(2, "run flap.toml -o out --resume --quiet", &[more]).expect(0, &[]);
    run(3, "run flap.toml -o at-once --quiet", &[more]).expect(0, &[]);
    is_near(&here.rows_of("at-once"), &here.rows_of("out"), &[more]);
    // The last step was shortened: a longer run goes on from the one before.
    run(2, "run flap.toml -o cut --quiet", &["time.end=0.025"]).expect(0, &[]);
    run(2, "run flap.toml -o cut --resume --quiet", &[more]).expect(0, &[]);
    is_near(&here.rows_of("at-once"), &here.rows_of("cut"), &[more]);
    let said = run(2, "run flap.toml -o out --resume", &["time.end=0.06", "fluid.density=2"]);
    said.expect(2, &["the case has changed in more than its end"]);
    // Alone again, by our own solver.
    here.run("run flap.toml -o out --resume --quiet", &["time.end=0.05"]).expect(0, &[]);
    assert_eq!((here.rows_of("at-once").len(), here.rows_of("out").len()), (4, 5));
}

#[test]
fn what_goes_wrong_on_one_ends_all_and_is_said_once() {
    if !can() {
        return;
    }
    let here = Place::new("several-wrong");
    here.write("flap.toml", FLAP);
    let run = "run flap.toml -o out";
    for (n, sets, words) in [
        (2, &["time.stepp=1"][..], &["time.stepp=1: unknown key; did you mean `step`?"][..]),
        (3, &["linear.engine=own"], &["linear.engine=own: 3 processes are computed by PETSc"]),
        (2, &["linear.petsc.options=-ksp_tpye gmres"], &["nothing reads the option `-ksp_tpye`"]),
    ] {
        let said = together(&here, &[(n, run, sets)]).expect(2, words);
        assert_eq!(own_lines(&said, words[0]), 1, "{}", said.err);
    }
    let said = together(&here, &[(1, run, &[]), (1, run, &["time.stepp=1"])]);
    said.expect(2, &["process 1 of 2: --set time.stepp=1: unknown key; did you mean `step`?"]);
    let said = together(&here, &[(2, run, &[]), (1, run, &["fluid.density=999"])]);
    said.expect(2, &["process 2 has another case than process 0"]);
    let said = together(&here, &[(2, "check flap.toml", &[])]);
    said.expect(2, &["only `undula run` takes several processes"]);
    assert!(!here.file("out").exists());
    // A step without a solution is one for all, and what was computed is kept.
    let said = together(
        &here,
        &[(2, "run flap.toml -o broken", &["solid.mu=1", "time.max-halvings=0", "time.end=1"])],
    );
    said.expect(3, &["breakdown: ", "broken/breakdown.txt"]);
    assert!(fs::metadata(here.file("broken/breakdown.txt")).is_ok());
    // Data that are no numbers in the part of the second process alone, at one time.
    let force = "fluid.body-force=[\"sqrt(abs(t - 0.03) - 1e-4 + 1e-3*(1.2 - x))\", 0]";
    let said = together(&here, &[(2, "run flap.toml -o data", &[force, "time.end=0.05"])]);
    let said = said.expect(2, &["fluid.body-force"]);
    assert_eq!(own_lines(&said, "fluid.body-force"), 1, "{}", said.err);
    assert_eq!(here.rows_of("data").len(), 2);
}

#[test]
fn processes_that_see_other_files_are_told() {
    // A path that is another one in each process.
    if !can() || !cfg!(target_os = "linux") {
        return;
    }
    let here = Place::new("several-apart");
    for (directory, density) in [("one", "1000"), ("two", "999"), ("none", "")] {
        fs::create_dir_all(here.file(directory)).unwrap();
        here.write(&format!("{directory}/flap.toml"), FLAP);
        if !density.is_empty() {
            let sets = ["time.end=0.01", &format!("fluid.density={density}")];
            here.run(&format!("run {directory}/flap.toml -o {directory}/start --quiet"), &sets)
                .expect(0, &[]);
        }
    }
    let (run, sets) = ("run flap.toml -o out", ["initial.from=/proc/self/cwd/start", "time.end=0.03"]);
    apart(&here, ["one", "two"], run, &sets).expect(2, &["process 1 has another state to begin with"]);
    let said = apart(&here, ["one", "none"], run, &sets);
    said.expect(2, &["process 1 of 2: --set initial.from=/proc/self/cwd/start: "]);
    assert!(!here.file("one/out").exists());
}
