//! What goes wrong with libraries that are loaded at run time, in sentences.

use std::fmt;
use std::sync::{Mutex, PoisonError};

/// Packages of Debian 12 that bring what is loaded, an OpenBLAS among them: the reference BLAS makes MUMPS many times
/// slower.
pub const PACKAGES: &str = "libpetsc-real3.18 openmpi-bin libopenblas0-serial";

/// How to install them.
pub const INSTALL: &str =
    "apt-get install --no-install-recommends libpetsc-real3.18 openmpi-bin libopenblas0-serial";

/// Why there is no PETSc.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Missing {
    /// No library has one of the usual names.
    #[error(
        "no PETSc was found (its library is called {0}): install {PACKAGES} (Debian 12), or name it by UNDULA_PETSC"
    )]
    Library(&'static str),
    /// A library that was named cannot be loaded.
    #[error(
        "{variable} = {name}: the library cannot be loaded: {reason}; without the variable the usual names are tried"
    )]
    Named {
        /// What names it.
        variable: &'static str,
        /// Its name.
        name: String,
        /// What the system says.
        reason: String,
    },
    /// A library lacks a function.
    #[error("{library} is no PETSc that can be used: it has no function `{function}`")]
    Function {
        /// Name or path.
        library: String,
        /// The first function that is missing.
        function: &'static str,
    },
    /// A version that is too old.
    #[error("{library} is PETSc {found}: 3.18 or newer is needed")]
    Version {
        /// Name or path.
        library: String,
        /// Its version.
        found: String,
    },
    /// Numbers of another kind.
    #[error(
        "{library} computes with {found}: real numbers of 64 bits are needed, Debian's libpetsc-real3.18 has them"
    )]
    Numbers {
        /// Name or path.
        library: String,
        /// What it has.
        found: String,
    },
    /// Two MPI in one process.
    #[error(
        "UNDULA_MPI = {mpi} is not the MPI that {petsc} is linked to: leave UNDULA_MPI out, or name another PETSc"
    )]
    OtherMpi {
        /// Name or path of the MPI that was asked for.
        mpi: String,
        /// Name or path of PETSc.
        petsc: String,
    },
    /// A call fails that should not.
    #[error("{library} does not start: {reason}")]
    Start {
        /// Name or path.
        library: String,
        /// What it says.
        reason: String,
    },
    /// It has ended before, and starts once only.
    #[error("PETSc has ended, and does not start again in the same process")]
    Ended,
}

/// What was said since the last error, function and message.
static SAID: Mutex<Vec<(String, String)>> = Mutex::new(vec![]);

/// Keeps a message for the error that follows from it.
pub(super) fn record(function: &str, message: &str) {
    SAID.lock().unwrap_or_else(PoisonError::into_inner).push((function.into(), message.trim().into()));
}

/// A call that failed, with its code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Trouble {
    pub(super) code: i32,
    text: String,
}

impl Trouble {
    /// What is known before a call.
    pub(super) fn plain(text: String) -> Trouble {
        Trouble { code: -1, text }
    }

    pub(super) fn new(called: &str, code: i32) -> Trouble {
        let said = std::mem::take(&mut *SAID.lock().unwrap_or_else(PoisonError::into_inner));
        let text = match said.first() {
            // In one line, as all messages.
            Some((function, message)) => {
                let words: Vec<&str> = message.split_whitespace().collect();
                format!("{} ({function}, error {code})", words.join(" "))
            }
            None => format!("{called} returns error {code}"),
        };
        Trouble { code, text }
    }
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}
