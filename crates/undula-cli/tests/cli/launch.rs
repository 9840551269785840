//! Several processes that were started together never compute the same run beside each other. One run by all of them is in
//! `several.rs`.

use super::Place;
use std::process::Command;

/// The program as rank `rank` of `size` processes, by these variables.
fn one_of(here: &Place, [size_name, rank_name]: [&str; 2], size: &str, rank: &str) -> Command {
    let mut command = here.command("run fsi3 --quiet -o out", &["mesh.refine=0", "time.end=0.01"]);
    command.env(size_name, size).env(rank_name, rank);
    command
}

const VARIABLES: [[&str; 2]; 4] = [
    ["OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"],
    ["PMI_SIZE", "PMI_RANK"],
    ["MV2_COMM_WORLD_SIZE", "MV2_COMM_WORLD_RANK"],
    ["SLURM_STEP_NUM_TASKS", "SLURM_PROCID"],
];

#[test]
fn several_processes_are_refused_once() {
    let here = Place::new("launch-several");
    for names in VARIABLES {
        let of = |rank: &str, petsc: &str| {
            let mut command = one_of(&here, names, "4", rank);
            super::Said::of(command.env("UNDULA_PETSC", petsc).output().unwrap())
        };
        let said =
            of("0", "/no").expect(2, &["error: started as 4 processes", names[0], "UNDULA_PETSC = /no"]);
        assert_eq!(said.err.lines().count(), 1, "{}", said.err);
        let other = of("3", "/no").expect(2, &[]);
        assert_eq!((other.out.as_str(), other.err.as_str()), ("", ""), "{names:?}");
    }
    assert!(!here.file("out").exists());
}

/// A batch script of Slurm knows of tasks that it has not started; `mpirun -n 1` within a step of several is one.
#[test]
fn one_process_is_not_several() {
    let here = Place::new("launch-one");
    for (names, size) in [(VARIABLES[0], "1"), (VARIABLES[1], "1"), (["SLURM_NTASKS", "SLURM_PROCID"], "4")] {
        let mut command = here.command("cases", &[]);
        let output = command.env(names[0], size).env(names[1], "0").output().unwrap();
        super::Said::of(output).expect(0, &["fsi3"]);
    }
    let mut command = here.command("cases", &[]);
    command.env("OMPI_COMM_WORLD_SIZE", "1").env("SLURM_STEP_NUM_TASKS", "4");
    super::Said::of(command.output().unwrap()).expect(0, &["fsi3"]);
}
