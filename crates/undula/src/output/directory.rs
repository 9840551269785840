//! The directory of a run.

use super::{OutputError, Status, Summary, write_atomic};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Directories of a run, with the endings of the files in them that are ours.
const SUBDIRECTORIES: [(&str, &[&str]); 3] = [
    ("fields", &["vtu", "pvtu", "tmp"]),
    ("checkpoints", &["npz", "tmp"]),
    ("plots", &["png", "svg", "tmp"]),
];

/// The case of a run, in its directory.
pub const CASE: &str = "case.toml";

/// The history of a run.
pub const HISTORY: &str = "history.csv";

/// The summary of a run.
pub const SUMMARY: &str = "summary.json";

/// Files of a run besides its summary.
const FILES: [&str; 6] = [CASE, HISTORY, "fields.pvd", MEANS, "breakdown.txt", REPORT];

/// The page about a run.
const REPORT: &str = "report.html";

/// Means over a window of time.
const MEANS: &str = "mean.vtu";

/// The directory of one run, locked against other processes while this value lives.
///
/// | entry | content |
/// | --- | --- |
/// | `case.toml` | the case with all defaults resolved |
/// | `history.csv` | functionals and solver counts, a row per step |
/// | `summary.json` | status, sizes, times, statistics |
/// | `breakdown.txt` | after a breakdown: its cause, and the residuals of all that was tried |
/// | `fields.pvd`, `fields/*.vtu` | the solution on the deformed mesh |
/// | `mean.vtu` | means over `output.window` |
/// | `checkpoints/*.npz` | exact restart data, the last two |
/// | `plots/*.png`, `plots/*.svg` | pictures |
/// | `report.html` | a page about the run |
#[derive(Debug)]
pub struct RunDirectory {
    path: PathBuf,
    lock: Option<File>,
    /// The directory as it was opened, to see whether it is still there; `None` if it is only read.
    identity: Option<Identity>,
}

impl RunDirectory {
    /// Makes `path` the directory of a new run, with a `summary.json` of status `running`.
    ///
    /// A run that is there is replaced only with `force`: its own files go, others stay. Nothing is changed before all
    /// checks have passed.
    ///
    /// # Errors
    /// [`OutputError::Completed`], [`OutputError::Unfinished`], [`OutputError::Foreign`] if it is not empty and no run,
    /// [`OutputError::Busy`], [`OutputError::Io`] if it cannot be written.
    pub fn create(path: impl AsRef<Path>, force: bool) -> Result<Self, OutputError> {
        let path = path.as_ref();
        match first_entry(path)? {
            None => fs::create_dir_all(path).map_err(OutputError::io("create directory", path))?,
            Some(entry) => may_replace(path, &entry, force)?,
        }
        let directory = Self::locked(path)?;
        // Another run may have begun and ended since.
        if let Some(entry) = first_entry(path)? {
            may_replace(path, &entry, force)?;
        }
        let summary = Summary { status: Status::Running, ..Summary::default() };
        summary.write(directory.summary())?;
        directory.clear()?;
        Ok(directory)
    }

    /// The directory of an unfinished run, to continue it; that of a completed one only if it is to be
    /// `extended`.
    ///
    /// # Errors
    /// [`OutputError::NoRun`] without `case.toml`, [`OutputError::AlreadyCompleted`],
    /// [`OutputError::Busy`], [`OutputError::Io`] if it cannot be written.
    pub fn open_for_resume(path: impl AsRef<Path>, extended: bool) -> Result<Self, OutputError> {
        let path = Self::open(path)?.path().to_path_buf();
        let completed = || {
            let summary = Summary::read(path.join(SUMMARY));
            !extended && summary.is_ok_and(|s| s.status == Status::Completed)
        };
        if completed() {
            return Err(OutputError::AlreadyCompleted { path });
        }
        let directory = Self::locked(&path)?;
        // Another run may have begun and ended since.
        if completed() {
            return Err(OutputError::AlreadyCompleted { path });
        }
        directory.sweep();
        Ok(directory)
    }

    /// The directory of any run, to read it; takes no lock.
    ///
    /// # Errors
    /// [`OutputError::NoRun`] without `case.toml`.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, OutputError> {
        let directory = RunDirectory { path: path.as_ref().to_path_buf(), lock: None, identity: None };
        if !directory.case().is_file() {
            return Err(OutputError::NoRun { path: directory.path.clone(), missing: CASE.into() });
        }
        Ok(directory)
    }

    /// The directory itself.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// `case.toml`.
    pub fn case(&self) -> PathBuf {
        self.path.join(CASE)
    }

    /// `history.csv`.
    pub fn history(&self) -> PathBuf {
        self.path.join(HISTORY)
    }

    /// `summary.json`.
    pub fn summary(&self) -> PathBuf {
        self.path.join(SUMMARY)
    }

    /// `breakdown.txt`.
    pub fn breakdown(&self) -> PathBuf {
        self.path.join("breakdown.txt")
    }

    /// `fields.pvd`, the collection of all field files.
    pub fn collection(&self) -> PathBuf {
        self.path.join("fields.pvd")
    }

    /// Field file of step `step`, relative to the directory as the collection wants it.
    pub fn field_name(&self, step: u64) -> String {
        format!("fields/fields_{step:06}.vtu")
    }

    /// The same where several processes write their pieces.
    pub fn shared_field_name(step: u64) -> String {
        format!("fields/fields_{step:06}.pvtu")
    }

    /// The piece of process `rank`.
    pub fn piece_name(step: u64, rank: usize) -> String {
        format!("fields/fields_{step:06}_{rank}.vtu")
    }

    /// `mean.vtu`.
    pub fn means(&self) -> PathBuf {
        self.path.join(MEANS)
    }

    /// `checkpoints/`.
    pub fn checkpoints(&self) -> PathBuf {
        self.path.join("checkpoints")
    }

    /// `plots/`.
    pub fn plots(&self) -> PathBuf {
        self.path.join("plots")
    }

    /// `report.html`.
    pub fn report(&self) -> PathBuf {
        self.path.join(REPORT)
    }

    /// Writes the resolved case.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    pub fn write_case(&self, text: &str) -> Result<(), OutputError> {
        write_atomic(self.case(), |file| file.write_all(text.as_bytes()))
    }

    /// Checks that the directory is still the one that was opened.
    ///
    /// # Errors
    /// [`OutputError::Lost`].
    pub fn verify(&self) -> Result<(), OutputError> {
        match &self.identity {
            Some(identity) if Identity::of(&self.path).ok().as_ref() != Some(identity) => {
                Err(OutputError::Lost { path: self.path.clone(), content: "into this directory" })
            }
            _ => Ok(()),
        }
    }

    /// Writes what there is to say of a breakdown, and removes the file of a former one for `None`.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    pub fn write_breakdown(&self, text: Option<&str>) -> Result<(), OutputError> {
        let path = self.breakdown();
        match text {
            Some(text) => write_atomic(path, |file| file.write_all(text.as_bytes())),
            None if path.exists() => fs::remove_file(&path).map_err(OutputError::io("remove", &path)),
            None => Ok(()),
        }
    }

    /// Checks that `path` can be written and takes the lock.
    fn locked(path: &Path) -> Result<Self, OutputError> {
        let name = path.join(".lock");
        loop {
            let lock = File::create(&name).map_err(OutputError::io("write to this directory", path))?;
            if let Err(fs::TryLockError::WouldBlock) = lock.try_lock() {
                return Err(OutputError::Busy { path: path.to_path_buf() });
            }
            // Some network file systems have no locks; that is no reason not to compute.
            //
            // Whoever ends removes the lock while holding it. One that was opened before that is no lock any more.
            if Identity::is_of(&lock, &name) {
                let identity = Identity::of(path).ok();
                return Ok(RunDirectory { path: path.to_path_buf(), lock: Some(lock), identity });
            }
        }
    }

    /// Removes what a killed run has left half written.
    fn sweep(&self) {
        let folders = SUBDIRECTORIES.iter().map(|(name, _)| self.path.join(name));
        for folder in folders.chain([self.path.clone()]) {
            for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
                let name = entry.file_name().to_string_lossy().into_owned();
                if name.starts_with('.') && name.ends_with(".tmp") {
                    // One that stays does no harm.
                    let _ = fs::remove_file(entry.path());
                }
            }
        }
    }

    /// Removes the files of a former run, except `summary.json`, which has been replaced already.
    fn clear(&self) -> Result<(), OutputError> {
        for name in FILES {
            let path = self.path.join(name);
            if path.exists() {
                fs::remove_file(&path).map_err(OutputError::io("remove", &path))?;
            }
        }
        for (name, endings) in SUBDIRECTORIES {
            let path = self.path.join(name);
            if !path.is_dir() {
                continue;
            }
            for entry in fs::read_dir(&path).map_err(OutputError::io("list", &path))? {
                let file = entry.map_err(OutputError::io("list", &path))?.path();
                if file.extension().is_some_and(|e| endings.iter().any(|ours| e == *ours)) {
                    fs::remove_file(&file).map_err(OutputError::io("remove", &file))?;
                }
            }
            // Stays if somebody else's files are in it.
            let _ = fs::remove_dir(&path);
        }
        Ok(())
    }
}

impl Drop for RunDirectory {
    fn drop(&mut self) {
        if let Some(lock) = self.lock.take() {
            let name = self.path.join(".lock");
            // While it is held: nobody takes a lock that is removed in the same moment.
            if Identity::is_of(&lock, &name) {
                let _ = fs::remove_file(name);
            }
        }
    }
}

/// Which file or directory it is that has a name.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) struct Identity(u64, u64);

impl Identity {
    /// Of what is at `path` now.
    pub(super) fn of(path: &Path) -> std::io::Result<Identity> {
        fs::metadata(path).map(|metadata| Identity::from(&metadata))
    }

    /// Whether `file` is what is at `path` now.
    pub(super) fn is_of(file: &File, path: &Path) -> bool {
        match (file.metadata(), fs::metadata(path)) {
            (Ok(file), Ok(path)) => Identity::from(&file) == Identity::from(&path),
            _ => false,
        }
    }

    #[cfg(unix)]
    fn from(metadata: &fs::Metadata) -> Identity {
        use std::os::unix::fs::MetadataExt;
        Identity(metadata.dev(), metadata.ino())
    }

    /// Elsewhere files in use cannot be removed.
    #[cfg(not(unix))]
    fn from(_: &fs::Metadata) -> Identity {
        Identity(0, 0)
    }
}

/// Some entry of `path` besides a left-over lock; `None` if it is empty or does not exist.
fn first_entry(path: &Path) -> Result<Option<String>, OutputError> {
    if path.exists() && !path.is_dir() {
        return Err(OutputError::format(path, "this is a file; a directory is needed for the output"));
    }
    if !path.exists() {
        return Ok(None);
    }
    let mut names = Vec::new();
    for entry in fs::read_dir(path).map_err(OutputError::io("list", path))? {
        names.push(entry.map_err(OutputError::io("list", path))?.file_name().to_string_lossy().into_owned());
    }
    names.retain(|name| name != ".lock" && name != ".summary.json.tmp");
    names.sort();
    Ok(names.into_iter().next())
}

/// Whether the run in the non-empty directory `path` may be replaced.
fn may_replace(path: &Path, entry: &str, force: bool) -> Result<(), OutputError> {
    let Ok(summary) = Summary::read(path.join(SUMMARY)) else {
        return Err(OutputError::Foreign { path: path.to_path_buf(), entry: entry.into() });
    };
    let path = path.to_path_buf();
    match summary.status {
        _ if force => Ok(()),
        Status::Completed => Err(OutputError::Completed { path }),
        status => Err(OutputError::Unfinished { path, status: status.to_string() }),
    }
}

#[cfg(test)]
mod tests;
