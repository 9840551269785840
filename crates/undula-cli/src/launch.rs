//! Whether this process is one of several that were started together, by what launchers of MPI set in the environment:
//! known before any call of MPI.

use std::process::ExitCode;

/// Launchers, with their variables for the number of processes and for that of this one. The first that is there counts:
/// those of Slurm are inherited by what others start. `SLURM_NTASKS` says nothing: a batch script has it, too.
const LAUNCHERS: [(&str, &str, &str); 4] = [
    ("Open MPI", "OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"),
    ("MPICH (Hydra) or Slurm (PMI)", "PMI_SIZE", "PMI_RANK"),
    ("MVAPICH", "MV2_COMM_WORLD_SIZE", "MV2_COMM_WORLD_RANK"),
    ("srun of Slurm", "SLURM_STEP_NUM_TASKS", "SLURM_PROCID"),
];

/// One of several processes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Launch {
    /// Who has started them.
    pub by: &'static str,
    /// The variable that tells so.
    pub variable: &'static str,
    /// How many there are.
    pub size: usize,
    /// Number of this one.
    pub rank: usize,
}

/// What the variables that `get` reads tell; `None` of a process that is alone.
pub fn launch(get: impl Fn(&str) -> Option<String>) -> Option<Launch> {
    let number = |name: &str| get(name).and_then(|text| text.trim().parse::<usize>().ok());
    let found = LAUNCHERS.into_iter().find_map(|(by, variable, rank)| {
        let rank = number(rank).unwrap_or(0);
        number(variable).map(|size| Launch { by, variable, size, rank })
    });
    found.filter(|launch| launch.size > 1)
}

/// The exit code of a process that is one of several: all end, and the first says why. The same run would be computed by
/// each of them, into the same files.
pub fn refuse() -> Option<ExitCode> {
    let Launch { by, variable, size, rank } = launch(|name| std::env::var(name).ok())?;
    if rank == 0 {
        crate::args::say(format_args!(
            "error: started as {size} processes by {by} ({variable} = {size}): one run on several processes is not yet \
             available, and each would compute all of it; start one process, and give it more cores with `--threads N`"
        ));
    }
    Some(ExitCode::from(2))
}
