//! Files a run leaves behind.
//!
//! A run fills one directory, see [`RunDirectory`]: the resolved `case.toml`, the growing
//! [`history.csv`](HistoryWriter), a ParaView [collection](Collection) `fields.pvd` of
//! [VTU files](write_vtu) on the deformed mesh, [checkpoints](Checkpoint) for exact restarts, and
//! [`summary.json`](Summary). Whatever is not appended to is written to a temporary file, synced and
//! renamed, so that a killed run never leaves a file half written.

pub mod atomic;
pub mod checkpoint;
pub mod directory;
pub mod error;
pub mod history;
pub mod provenance;
pub mod pvd;
pub mod pvtu;
pub mod snapshot;
pub mod summary;
pub mod vtk_order;
pub mod vtu;

pub use atomic::write_atomic;
pub use checkpoint::{Array, Checkpoint, Latest};
pub use directory::RunDirectory;
pub use error::OutputError;
pub(crate) use history::text_of;
pub use history::{History, HistoryWriter};
pub use provenance::{Provenance, hash, processor};
pub use pvd::Collection;
pub use pvtu::{pieces_of, read_snapshot, write_pvtu};
pub use snapshot::{CellKind, Field, FieldSnapshot};
pub use summary::{
    Breakdown, FunctionalSummary, Phases, RankSummary, Status, Summary, Unknowns, peak_memory,
    processor_seconds,
};
pub use vtu::{Precision, read_vtu, write_vtu};

#[cfg(test)]
pub(crate) mod testing {
    use std::path::{Path, PathBuf};

    /// An empty directory, removed at the end.
    pub(crate) struct Scratch(PathBuf);

    /// The scratch directory of the test `name`.
    pub(crate) fn scratch(name: &str) -> Scratch {
        let path = std::env::temp_dir().join(format!("undula-{}-{name}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Scratch(path)
    }

    impl std::ops::Deref for Scratch {
        type Target = Path;
        fn deref(&self) -> &Path {
            &self.0
        }
    }

    impl AsRef<Path> for Scratch {
        fn as_ref(&self) -> &Path {
            &self.0
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }
}
