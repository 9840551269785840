//! What can go wrong with files.

use std::io;
use std::path::{Path, PathBuf};

/// A file or directory of a run cannot be written, read or replaced; every arm names it.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The operating system refused.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// What was attempted, an infinitive.
        action: &'static str,
        /// The file or directory.
        path: PathBuf,
        /// The reason.
        source: io::Error,
    },
    /// The directory holds a run that has not been completed.
    #[error(
        "{}: holds an unfinished run (status `{status}`); use --resume to continue it, --force to replace it, \
         or another directory",
        path.display()
    )]
    Unfinished {
        /// The directory.
        path: PathBuf,
        /// Its status in `summary.json`.
        status: String,
    },
    /// The directory holds a completed run.
    #[error(
        "{}: holds a completed run; use --force to replace it, --resume with a later `time.end` to extend it, \
         or another directory",
        path.display()
    )]
    Completed {
        /// The directory.
        path: PathBuf,
    },
    /// Another process writes into the directory at this moment.
    #[error("{}: another run is writing into this directory", path.display())]
    Busy {
        /// The directory.
        path: PathBuf,
    },
    /// The directory holds something else than a run.
    #[error(
        "{}: not empty and not a run (it contains `{entry}` but no readable summary.json); \
         nothing was changed, choose another directory",
        path.display()
    )]
    Foreign {
        /// The directory.
        path: PathBuf,
        /// One of its entries.
        entry: String,
    },
    /// There is no run to read or to resume.
    #[error("{}: no run here ({missing} is missing)", path.display())]
    NoRun {
        /// The directory.
        path: PathBuf,
        /// What a run would have.
        missing: String,
    },
    /// The run to resume has already been completed.
    #[error("{}: this run is already completed; nothing to resume (a later `time.end` would extend it)", path.display())]
    AlreadyCompleted {
        /// The directory.
        path: PathBuf,
    },
    /// A file of the run, or its directory, is no longer what the run has opened.
    #[error("{}: was removed, moved or changed while the run was writing {content}", path.display())]
    Lost {
        /// The file or directory.
        path: PathBuf,
        /// What was being written there: `into it`, or the name of something else.
        content: &'static str,
    },
    /// A file does not hold what it should: corrupt, truncated, or written by something else.
    #[error("{}: {message}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        message: String,
    },
}

impl OutputError {
    /// Whether it is the disk, not the choice of the file.
    pub fn is_no_room(&self) -> bool {
        use io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
        matches!(self, OutputError::Io { source, .. }
            if matches!(source.kind(), StorageFull | QuotaExceeded | FileTooLarge))
    }

    /// For `map_err`: `action` on `path` failed.
    pub(crate) fn io(action: &'static str, path: impl AsRef<Path>) -> impl FnOnce(io::Error) -> OutputError {
        move |source| OutputError::Io { action, path: path.as_ref().to_path_buf(), source }
    }

    /// `path` does not hold what it should.
    pub(crate) fn format(path: impl AsRef<Path>, message: impl Into<String>) -> OutputError {
        OutputError::Format { path: path.as_ref().to_path_buf(), message: message.into() }
    }
}
