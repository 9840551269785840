//! Processes that compute together: this program, started several times by `mpirun`, where that is there.

use std::process::{Command, Output};
use undula::parallel::{Alone, Comm, Message, Reduce, World};

/// Number of processes, set for those that the tests start.
const PROCESSES: &str = "UNDULA_TEST_PROCESSES";

/// Numbers whose sum depends on the order, different on each rank.
fn of_rank(rank: usize) -> Vec<f64> {
    let large = [1e16, 1.0, -1e16, 0.1, 3.0][rank % 5];
    vec![large, rank as f64, -2.5 * rank as f64, 1.0 / (1.0 + rank as f64)]
}

/// What every process does.
fn work(comm: &mut dyn Comm) {
    let (rank, size) = (comm.rank(), comm.size());
    let all: Vec<Vec<f64>> = (0..size).map(of_rank).collect();
    assert_eq!(comm.all_gather(&of_rank(rank)).unwrap(), all);
    let folded = |f: fn(f64, f64) -> f64| -> Vec<f64> {
        (0..4).map(|i| all.iter().map(|list| list[i]).reduce(f).unwrap()).collect()
    };
    let expected = [folded(|a, b| a + b), folded(f64::min), folded(f64::max)];
    for (how, expected) in [Reduce::Sum, Reduce::Min, Reduce::Max].into_iter().zip(expected) {
        let mut values = of_rank(rank);
        comm.reduce(how, &mut values).unwrap();
        // In the order of the ranks, to the bit.
        assert_eq!(values, expected, "{how:?}");
    }
    for root in 0..size {
        let mut values = of_rank(rank);
        comm.broadcast(root, &mut values).unwrap();
        assert_eq!(values, of_rank(root));
    }
    // Of each rank as many as its number, so that one has none.
    let own = vec![rank as f64 + 0.5; rank];
    let lists: Vec<Vec<f64>> = (0..size).map(|rank| vec![rank as f64 + 0.5; rank]).collect();
    assert_eq!(comm.all_gather_lists(&own).unwrap(), lists);
    let before: usize = (0..rank).sum();
    assert_eq!(comm.offset(rank).unwrap(), [before, (0..size).sum()]);
    assert_eq!(comm.sum(1.0).unwrap(), size as f64);
    assert!(comm.all(true).unwrap() && !comm.all(rank > 0).unwrap());
    halo(comm);
    comm.barrier().unwrap();
}

/// Each sends to the next and to the one before, of lengths that differ, and to nobody where it is alone.
fn halo(comm: &mut dyn Comm) {
    let (rank, size) = (comm.rank(), comm.size());
    let (next, before) = ((rank + 1) % size, (rank + size - 1) % size);
    let list = |from: usize, to: usize, n: usize| (0..n).map(|i| (100 * from + 10 * to + i) as f64).collect();
    for n in [0, 1, 7, 100_000] {
        let message = |rank, values| Message { rank, values };
        let sent = [message(next, list(rank, next, n)), message(before, list(rank, before, n + 3))];
        let mut received = [message(before, vec![0.0; n]), message(next, vec![0.0; n + 3])];
        comm.exchange(&sent, &mut received).unwrap();
        assert_eq!(
            received,
            [message(before, list(before, rank, n)), message(next, list(next, rank, n + 3))]
        );
    }
}

#[test]
fn one_process_is_all() {
    work(&mut Alone);
}

/// `mpirun`, for as many processes as are asked for; `None`, and a word, where there is none.
fn mpirun(processes: usize) -> Option<Command> {
    let version = Command::new("mpirun").arg("--version").output();
    let Some(version) = version.ok().filter(|said| said.status.success()) else {
        println!("skipped: there is no mpirun");
        return None;
    };
    let mut command = Command::new("mpirun");
    if String::from_utf8_lossy(&version.stdout).contains("Open MPI") {
        command.arg("--oversubscribe");
        // In containers of tests everybody is root.
        command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    }
    command.args(["-n", &processes.to_string()]).env(PROCESSES, processes.to_string());
    Some(command)
}

/// This test, in so many processes.
fn again(test: &str, processes: usize) -> Option<Output> {
    let mut command = mpirun(processes)?;
    command.arg(std::env::current_exe().unwrap());
    command.args([test, "--exact", "--nocapture", "--test-threads", "1"]);
    Some(command.output().unwrap())
}

#[test]
fn processes_of_mpi_tell_each_other_their_numbers() {
    if let Ok(processes) = std::env::var(PROCESSES) {
        let name = std::env::var("UNDULA_MPI").ok();
        let mut world = World::start(name.as_deref()).unwrap();
        let (rank, size) = (world.rank(), world.size());
        assert_eq!(processes, size.to_string(), "mpirun belongs to another MPI than the library");
        work(&mut world);
        world.end().unwrap();
        println!("rank {rank} of {size} is well");
        return;
    }
    for n in 1..=3 {
        let Some(output) = again("parallel::processes_of_mpi_tell_each_other_their_numbers", n) else {
            return;
        };
        let said = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        for rank in 0..n {
            assert!(said[0].contains(&format!("rank {rank} of {n} is well")), "{n}: {said:?}");
        }
        assert!(output.status.success(), "{said:?}");
    }
}

#[test]
fn a_library_that_is_no_mpi_is_told() {
    let missing = World::start(Some("/no/libmpi.so")).unwrap_err().to_string();
    assert!(missing.starts_with("no MPI: /no/libmpi.so"), "{missing}");
    if cfg!(target_os = "linux") {
        let other = World::start(Some("libm.so.6")).unwrap_err().to_string();
        assert_eq!(other, "no MPI: no function `MPI_Get_library_version`");
    }
}
