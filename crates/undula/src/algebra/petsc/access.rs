//! The engine of this process: which libraries it is, and that one thread at a time calls them.

use super::calls::Petsc;
use super::error::{Missing, Trouble};
use crate::parallel::library::{Library, Object};
use crate::parallel::mpi::{Functions as Mpi, MPI_NAMES};
use crate::parallel::{Comm, World};
use std::ops::Range;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

/// Oldest version whose functions are known to be as declared.
const OLDEST: [i64; 2] = [3, 18];

/// Newest minor version that is looked for by its name; newer ones are found as `libpetsc.so`.
const NEWEST_MINOR: i64 = 40;

/// Libraries of other names or places than the usual ones. The program takes them from environment variables.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Names {
    /// Name or path of PETSc (UNDULA_PETSC); no other is then taken.
    pub petsc: Option<String>,
    /// Directory of PETSc (PETSC_DIR and PETSC_ARCH), whose `lib` is looked into first.
    pub directory: Option<PathBuf>,
    /// Name or path of MPI (UNDULA_MPI), loaded before PETSc.
    pub mpi: Option<String>,
}

static NAMES: OnceLock<Names> = OnceLock::new();

static ENGINE: OnceLock<Result<Engine, Missing>> = OnceLock::new();

/// Whether several processes have come together to compute the same.
static TOGETHER: AtomicBool = AtomicBool::new(false);

/// Whether they have gone different ways since: what takes all of them would wait for ever.
static PARTED: AtomicBool = AtomicBool::new(false);

/// The part of this process in what all compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Share {
    pub(super) rank: usize,
    pub(super) size: usize,
}

impl Share {
    /// Its rows of `n`: those of the processes follow each other.
    pub(super) fn of(self, n: usize) -> Range<usize> {
        let first = |rank: usize| n * rank / self.size;
        first(self.rank)..first(self.rank + 1)
    }
}

/// Tells where libraries are. Without effect once they were looked for, or told before.
pub fn name_libraries(names: Names) {
    let _ = NAMES.set(names);
}

/// Whose MPI it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MpiKind {
    /// Open MPI: communicators are pointers.
    OpenMpi,
    /// MPICH and others of its binary interface (Intel MPI, MVAPICH, Cray MPICH): communicators are numbers.
    Mpich,
    /// PETSc was built without MPI.
    Without,
}

impl MpiKind {
    fn of(library: Library) -> MpiKind {
        if library.has("ompi_mpi_comm_world") {
            MpiKind::OpenMpi
        } else if library.has("MPI_Init_thread") {
            MpiKind::Mpich
        } else {
            MpiKind::Without
        }
    }
}

/// PETSc as it was found, with the MPI that it is linked to.
pub struct Engine {
    /// Name or path of PETSc.
    pub library: String,
    /// Major, minor and patch.
    pub version: [i64; 3],
    /// Bits of its integers: 32 or 64.
    pub index_bits: usize,
    /// Whose MPI.
    pub mpi: MpiKind,
    /// What the MPI calls itself; empty without.
    pub mpi_version: String,
    /// Packages inside, and whether they are there.
    pub packages: [(&'static str, bool); 3],
    handle: Library,
    pub(super) petsc: Petsc,
    mpi_calls: Option<Mpi>,
    state: Mutex<State>,
}

#[derive(Clone, PartialEq)]
enum State {
    Waiting,
    Running(Object, Share),
    Failed(Missing),
    Ended,
}

/// Packages by functions of their own, and by some of PETSc that are there with them alone. Newer versions show none of the
/// latter, and have `MatMumpsSetIcntl` and `PCHYPRESetType` without the package, too.
const PACKAGES_BY_SYMBOL: [(&str, [&str; 2]); 3] = [
    ("MUMPS", ["dmumps_c", "MatMumpsSetIcntl_MUMPS"]),
    ("SuperLU_DIST", ["superlu_gridinit", "MatSuperluDistGetDiagU_SuperLU_DIST"]),
    ("hypre", ["HYPRE_IJMatrixCreate", "MatCreate_HYPRE"]),
];

/// The engine, looked for once in the life of the process; nothing is started yet.
///
/// # Errors
/// What is missing, or why what was found cannot be used.
pub fn engine() -> Result<&'static Engine, Missing> {
    ENGINE.get_or_init(|| load(NAMES.get_or_init(Names::default))).as_ref().map_err(Clone::clone)
}

/// The first MPI that is there, whether there is PETSc or not: name of the library, and what it calls itself.
pub fn mpi_alone() -> Option<(String, String)> {
    let named = NAMES.get_or_init(Names::default).mpi.clone();
    let names: Vec<String> = named.map_or_else(|| MPI_NAMES.map(String::from).to_vec(), |name| vec![name]);
    names.into_iter().find_map(|name| {
        let calls = Mpi::find(Library::open(&name).ok()?).ok()?;
        Some((name, calls.version().ok()?))
    })
}

/// The processes that were started together, in the MPI of PETSc: from now on all of them make the same calls.
///
/// # Errors
/// If there is no PETSc, or none with MPI.
pub fn processes() -> Result<World, Missing> {
    let engine = engine()?;
    let failed = |reason: String| Missing::Start { library: engine.library.clone(), reason };
    if engine.mpi == MpiKind::Without {
        return Err(failed("it was built without MPI".into()));
    }
    let world = World::of(engine.handle).map_err(|fault| failed(fault.to_string()))?;
    TOGETHER.store(true, Ordering::Relaxed);
    Ok(world)
}

/// How many processes compute together: 1 unless PETSc has been started by several.
pub fn processes_at_work() -> usize {
    let Some(Ok(engine)) = ENGINE.get() else { return 1 };
    match *engine.state.lock().unwrap_or_else(PoisonError::into_inner) {
        State::Running(_, share) => share.size,
        State::Waiting | State::Failed(_) | State::Ended => 1,
    }
}

/// Tells that the processes, if there are several, no longer make the same calls.
pub fn part() {
    PARTED.store(TOGETHER.load(Ordering::Relaxed), Ordering::Relaxed);
}

/// Whether the processes have gone different ways, so that PETSc can no longer be asked for anything.
pub fn have_parted() -> bool {
    PARTED.load(Ordering::Relaxed)
}

/// Usual names of PETSc, newest first: those of Debian, then those of PETSc itself.
fn usual_names(names: &Names) -> Vec<String> {
    let inside =
        names.directory.iter().map(|path| path.join("lib/libpetsc.so").to_string_lossy().into_owned());
    let plain = ["libpetsc_real.so", "libpetsc.so"].map(String::from);
    let numbered = (OLDEST[1]..=NEWEST_MINOR).rev().flat_map(|minor| {
        ["libpetsc_real", "libpetsc", "libpetsc64_real"].map(|stem| format!("{stem}.so.3.{minor}"))
    });
    inside.chain(plain).chain(numbered).collect()
}

fn load(names: &Names) -> Result<Engine, Missing> {
    let named = |variable: &'static str, name: &String| {
        let reason = |reason| Missing::Named { variable, name: name.clone(), reason };
        Library::open(name).map_err(reason)
    };
    let mpi = names.mpi.as_ref().map(|name| named("UNDULA_MPI", name)).transpose()?;
    let (library, handle) = match &names.petsc {
        Some(name) => (name.clone(), named("UNDULA_PETSC", name)?),
        // Its MPI comes with it: no other is loaded that might be of another kind.
        None => usual_names(names)
            .into_iter()
            .find_map(|name| Library::open(&name).ok().map(|handle| (name, handle)))
            .ok_or(Missing::Library("libpetsc_real.so or libpetsc.so"))?,
    };
    if let (Some(mpi), Some(name)) = (mpi, &names.mpi)
        && !handle.shares(mpi, "MPI_Init_thread")
    {
        return Err(Missing::OtherMpi { mpi: name.clone(), petsc: library });
    }
    examine(library, handle)
}

/// Whether the library is what is needed, before anything of it is started.
fn examine(library: String, handle: Library) -> Result<Engine, Missing> {
    let failed = |reason: String| Missing::Start { library: library.clone(), reason };
    let start = |trouble: Trouble| failed(trouble.to_string());
    let lacks = |function| Missing::Function { library: library.clone(), function };
    let petsc = Petsc::find(handle).map_err(lacks)?;
    let version = petsc.version().map_err(start)?;
    if version[..2] < OLDEST[..] {
        let found = version.map(|n| n.to_string()).join(".");
        return Err(Missing::Version { library, found });
    }
    let numbers = |found: &str| Missing::Numbers { library: library.clone(), found: found.into() };
    let scalar = petsc.width(c"scalar").map_err(start)?;
    let (double, complex) = (petsc.width(c"double").map_err(start)?, petsc.width(c"complex").map_err(start)?);
    if scalar.is_none() || scalar != double {
        let is_complex = complex.is_some() && scalar == complex;
        return Err(numbers(if is_complex { "complex numbers" } else { "numbers of another width" }));
    }
    let index_bits = match petsc.width(c"int").map_err(start)? {
        Some((bytes @ (4 | 8), _)) => 8 * bytes,
        other => return Err(numbers(&format!("integers of unknown width ({other:?})"))),
    };
    let mpi = MpiKind::of(handle);
    let mpi_calls = (mpi != MpiKind::Without).then(|| Mpi::find(handle)).transpose().map_err(lacks)?;
    let mpi_version = mpi_calls.map_or(Ok(String::new()), |calls| calls.version());
    let mpi_version = mpi_version.map_err(|fault| failed(fault.to_string()))?;
    let packages = PACKAGES_BY_SYMBOL.map(|(name, of)| (name, of.iter().any(|symbol| handle.has(symbol))));
    let state = Mutex::new(State::Waiting);
    Ok(Engine { library, version, index_bits, mpi, mpi_version, packages, handle, petsc, mpi_calls, state })
}

/// PETSc in the hands of one thread.
pub(super) struct Access {
    pub(super) engine: &'static Engine,
    pub(super) world: Object,
    pub(super) share: Share,
    _alone: MutexGuard<'static, State>,
}

impl Engine {
    /// `PETSc 3.18.5 with Open MPI v4.1.4`.
    pub fn title(&self) -> String {
        let version = self.version.map(|n| n.to_string()).join(".");
        match self.mpi {
            MpiKind::Without => format!("PETSc {version} without MPI"),
            MpiKind::OpenMpi | MpiKind::Mpich => format!("PETSc {version} with {}", self.mpi_version),
        }
    }

    /// Waits until no other thread is in PETSc, and starts it the first time.
    ///
    /// # Errors
    /// If it does not start, or has ended.
    pub(super) fn access(&'static self) -> Result<Access, Missing> {
        if have_parted() {
            return Err(Missing::Ended);
        }
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if *state == State::Waiting {
            *state = self.start().map_or_else(State::Failed, |(world, share)| State::Running(world, share));
        }
        match &*state {
            &State::Running(world, share) => Ok(Access { engine: self, world, share, _alone: state }),
            State::Failed(missing) => Err(missing.clone()),
            State::Waiting | State::Ended => Err(Missing::Ended),
        }
    }

    fn start(&self) -> Result<(Object, Share), Missing> {
        let failed = |reason: String| Missing::Start { library: self.library.clone(), reason };
        if let Some(mpi) = &self.mpi_calls {
            mpi.start().map_err(|trouble| failed(trouble.to_string()))?;
        }
        // Signals belong to the program, and a file in some directory must not change a result.
        let arguments = [c"undula", c"-no_signal_handler", c"-skip_petscrc"];
        self.petsc.start(&arguments).map_err(|trouble| failed(trouble.to_string()))?;
        let narrow = self.mpi != MpiKind::OpenMpi;
        let world = Petsc::world(self.handle, narrow).ok_or(failed("it has no PETSC_COMM_WORLD".into()))?;
        let alone = Share { rank: 0, size: 1 };
        let Some(mpi) = self.mpi_calls else { return Ok((world, alone)) };
        match mpi.size(world).map_err(|trouble| failed(trouble.to_string()))? {
            1 => Ok((world, alone)),
            size if TOGETHER.load(Ordering::Relaxed) => {
                let of_mpi = World::of(self.handle).map_err(|trouble| failed(trouble.to_string()))?;
                Ok((world, Share { rank: of_mpi.rank(), size }))
            }
            n => Err(failed(format!(
                "it has {n} processes, each of which would compute the same alone: `undula run` takes several"
            ))),
        }
    }

    fn end(&self) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if matches!(*state, State::Running(..)) {
            // At the end of a process nobody is left to be told.
            let _ = self.petsc.end();
            let _ = self.mpi_calls.map(|mpi| mpi.end());
            *state = State::Ended;
        }
    }
}

/// Ends PETSc and MPI where they were started, as MPI wants it before the end of a process.
pub fn finish() {
    if let Some(Ok(engine)) = ENGINE.get() {
        engine.end();
    }
}
