//! `linear.engine = "petsc"` and `undula engines`, on machines with PETSc and without.

use super::in_space::{FLAP, Row};
use super::{Place, Said};
use std::fs;
use undula::algebra::petsc::engine;

pub const PETSC: &str = "linear.engine=petsc";
pub const TIGHT: [&str; 3] = ["newton.rate-max=0", "newton.tolerance=1e-11", "newton.floor=0"];
pub const LAYER: &str = "mesh.extrude={ depth = 0.1, layers = 1 }";

/// Without PETSc, wherever it is installed.
fn without(here: &Place, arguments: &str, sets: &[&str]) -> Said {
    let mut command = here.command(arguments, sets);
    Said::of(command.env("UNDULA_PETSC", "/no/libpetsc.so").output().unwrap())
}

/// Whether PETSc is there, with MUMPS inside; says so if it is not.
pub fn is_there() -> bool {
    let there = engine().is_ok_and(|engine| engine.packages[0].1);
    if !there {
        println!("skipped: no PETSc with MUMPS here");
    }
    there
}

#[test]
fn a_machine_without_petsc_is_told_what_to_install() {
    let here = Place::new("engines-without");
    here.run("engines", &[]).expect(0, &["own", "petsc"]);
    let packages = "libpetsc-real3.18 openmpi-bin libopenblas0-serial";
    let words = ["UNDULA_PETSC = /no/libpetsc.so: the library cannot be loaded", packages];
    without(&here, "engines", &[]).expect(0, &words);
    let said = without(&here, "run fsi3 -o out", &["mesh.refine=0", PETSC]);
    let said = said.expect(
        2,
        &["--set linear.engine=petsc: UNDULA_PETSC = /no/libpetsc.so: the library cannot be loaded"],
    );
    assert_eq!(said.err.lines().count(), 1, "{}", said.err);
    assert!(!here.file("out").exists());
    without(&here, "check fsi3", &["mesh.refine=0", PETSC])
        .expect(0, &["note      linear.engine: a run is not possible here: UNDULA_PETSC"]);
}

/// Libraries that are something else.
#[test]
fn a_library_that_is_not_petsc_is_told() {
    let here = Place::new("engines-other");
    let with = |variable: &str, name: &str| {
        Said::of(here.command("engines", &[]).env(variable, name).output().unwrap())
    };
    if cfg!(target_os = "linux") {
        with("UNDULA_PETSC", "libm.so.6").expect(0, &["libm.so.6 is no PETSc", "`PetscGetVersionNumber`"]);
        if is_there() {
            with("UNDULA_MPI", "libm.so.6").expect(0, &["libm.so.6 is not the MPI that", "is linked to"]);
        }
    }
    here.write("libpetsc.so", "no library");
    let path = here.file("libpetsc.so");
    with("UNDULA_PETSC", path.to_str().unwrap()).expect(0, &["the library cannot be loaded"]);
    // A copy that was broken off, for which the system would end the process.
    let mut start = fs::read(env!("CARGO_BIN_EXE_undula")).unwrap();
    start.truncate(100_000);
    fs::write(&path, start).unwrap();
    let word = if cfg!(target_os = "linux") { "shorter than its header says" } else { "cannot be loaded" };
    with("UNDULA_PETSC", path.to_str().unwrap()).expect(0, &[word]);
}

#[test]
fn an_installation_is_described() {
    let here = Place::new("engines-there");
    if is_there() {
        let words = ["linear.engine = \"petsc\"", "integers of", "MPI: ", "packages inside: MUMPS"];
        here.run("engines", &[]).expect(0, &words);
    }
}

#[track_caller]
pub fn is_near(one: &[Row], other: &[Row], sets: &[&str]) {
    assert_eq!(one.len(), other.len());
    let counts = ["step", "jacobians", "newton_steps", "linear_iterations"];
    for name in one[0].keys().filter(|name| !counts.contains(&name.as_str())) {
        let largest = one.iter().map(|row| row[name].abs()).fold(1e-5, f64::max);
        for (one, other) in one.iter().zip(other) {
            let gap = (one[name] - other[name]).abs() / largest;
            assert!(gap <= 1e-9, "{name}: {} and {}; {sets:?}", one[name], other[name]);
        }
    }
}

const FGMRES: &str = "linear.petsc.options=-ksp_type fgmres -ksp_rtol 1e-6 -pc_type lu -pc_factor_mat_solver_type mumps \
                      -mat_mumps_icntl_14 60";

/// In the plane and in space, the condensed system and the whole one, with and without kept factors.
#[test]
fn petsc_and_our_own_solver_agree() {
    if !is_there() {
        return;
    }
    let here = Place::new("engines-agree");
    here.write("flap.toml", FLAP);
    for space in [&[][..], &[LAYER]] {
        let own = here.rows("flap.toml", &[&TIGHT[..], space].concat());
        for more in [
            &[PETSC][..],
            &[PETSC, "newton.linearization=newton"],
            &[PETSC, FGMRES],
            &[PETSC, "linear.krylov=gmres"],
        ] {
            let sets = [&TIGHT[..], space, more].concat();
            is_near(&own, &here.rows("flap.toml", &sets), &sets);
        }
    }
}

/// At rest the whole Jacobian is solved with.
#[test]
fn a_body_at_rest_is_the_same() {
    if !is_there() {
        return;
    }
    let here = Place::new("engines-rest");
    for case in ["csm1", "fsi1"] {
        let sets = ["mesh.refine=0", "newton.tolerance=1e-11", "newton.floor=0"];
        let own = here.rows(case, &sets);
        is_near(&own, &here.rows(case, &[&sets[..], &[PETSC]].concat()), &sets);
    }
}

#[test]
fn mistakes_in_options_end_a_run_before_it_begins() {
    let here = Place::new("engines-mistakes");
    let text = "linear.petsc.options=ksp_type fgmres";
    here.run("check fsi3", &[PETSC, text]).expect(2, &["expected the name of an option", "`ksp_type`"]);
    here.run("check fsi3", &["linear.petsc.options=-ksp_type fgmres"])
        .expect(0, &["note      linear.petsc has no effect: linear.engine is `own`"]);
    if !is_there() {
        return;
    }
    let misspelt = "linear.petsc.options=-ksp_type fgmres -pc_tpye lu";
    for command in ["run fsi3 -o out", "check fsi3"] {
        let said = here.run(command, &["mesh.refine=0", PETSC, misspelt]);
        said.expect(2, &["linear.petsc.options", "nothing reads the option `-pc_tpye`"]);
    }
    assert!(!here.file("out").exists());
    let said = here.run("check fsi3", &["mesh.refine=0", PETSC]);
    said.expect(0, &["note      linear.engine: PETSc 3.", " solves, by `-ksp_type preonly"]);
}

/// A solve that ends without a solution ends the run, with the words of PETSc.
#[test]
fn a_solve_that_fails_is_a_breakdown() {
    if !is_there() {
        return;
    }
    let here = Place::new("engines-fails");
    here.write("flap.toml", FLAP);
    let options =
        "linear.petsc.options=-ksp_type richardson -ksp_max_it 2 -ksp_convergence_test skip -pc_type none";
    let said = here.run("run flap.toml --quiet -o out", &[PETSC, options]);
    said.expect(3, &["PETSc calls the system solved, but the residual is"]);
}
