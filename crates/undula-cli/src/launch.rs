//! Whether this process is one of several that were started together, by what launchers of MPI set in the environment:
//! known before any call of MPI.

use crate::args::{say, silence};
use std::process::ExitCode;
use undula::algebra::petsc::{Engine, engine, processes};
use undula::parallel::{Comm, Crew, Team};

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

/// The exit code of a process that is one of several, but for a run: all end, and the first says why.
pub fn refuse() -> Option<ExitCode> {
    let launch = launch(|name| std::env::var(name).ok())?;
    Some(
        launch.refused(
            "only `undula run` takes several processes, and each would do all of it; start one process",
        ),
    )
}

impl Launch {
    /// The exit code of all processes; the first one says `why`.
    fn refused(&self, why: &str) -> ExitCode {
        let Launch { by, variable, size, rank } = self;
        if *rank == 0 {
            say(format_args!("error: started as {size} processes by {by} ({variable} = {size}): {why}"));
        }
        ExitCode::from(2)
    }
}

/// The processes of a run: this one alone, or all that were started together. The first of them speaks from here on.
///
/// # Errors
/// The exit code where several processes cannot compute a run.
pub fn team() -> Result<Team, ExitCode> {
    let Some(launch) = launch(|name| std::env::var(name).ok()) else { return Ok(Team::alone()) };
    let refused = |why: String| Err(launch.refused(&why));
    let world = match processes() {
        Ok(world) => world,
        Err(missing) => {
            return refused(format!(
                "several processes are computed by PETSc (linear.engine = \"petsc\"): {missing}"
            ));
        }
    };
    if world.size() != launch.size {
        let title = engine().map(Engine::title).unwrap_or_default();
        return refused(format!(
            "{title} knows of {} of them: its MPI is not that of the launcher, and each would compute all of the run",
            world.size()
        ));
    }
    if !world.is_first() {
        silence();
    }
    let team = Team::new(world);
    Ok(match processes() {
        Ok(world) => team.with_crew(Crew::new(world)),
        Err(_) => team,
    })
}
