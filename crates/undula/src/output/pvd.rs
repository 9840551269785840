//! `fields.pvd`: the list of field files with their times, which ParaView opens as one animation.

use super::history::number;
use super::pvtu::pieces_of;
use super::{OutputError, write_atomic};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A ParaView collection; the file is rewritten, atomically, whenever a field file is added.
#[derive(Clone, Debug, PartialEq)]
pub struct Collection {
    path: PathBuf,
    entries: Vec<(f64, String)>,
}

impl Collection {
    /// A new, empty collection.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    pub fn create(path: impl AsRef<Path>) -> Result<Self, OutputError> {
        let collection = Collection { path: path.as_ref().to_path_buf(), entries: Vec::new() };
        collection.write()?;
        Ok(collection)
    }

    /// An existing collection.
    ///
    /// # Errors
    /// [`OutputError::Io`], [`OutputError::Format`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, OutputError> {
        let path = path.as_ref();
        let text = fs::read_to_string(path).map_err(OutputError::io("read", path))?;
        if !text.contains("type=\"Collection\"") {
            return Err(OutputError::format(path, "not a ParaView collection"));
        }
        let mut entries = Vec::new();
        for tag in text.split('<').filter(|tag| tag.starts_with("DataSet ")) {
            let attribute = |key: &str| tag.split_once(key).and_then(|(_, rest)| rest.split('"').next());
            let time = attribute(" timestep=\"").and_then(|t| t.parse().ok());
            let (Some(time), Some(file)) = (time, attribute(" file=\"")) else {
                return Err(OutputError::format(
                    path,
                    format!("an entry without time or file: <{}", tag.trim()),
                ));
            };
            entries.push((time, file.to_string()));
        }
        Ok(Collection { path: path.to_path_buf(), entries })
    }

    /// Continues a collection after `time` \[s\]: later entries go, and their files; so do
    /// entries whose file is not there.
    ///
    /// A missing collection is a new one.
    ///
    /// # Errors
    /// [`OutputError::Io`], [`OutputError::Format`].
    pub fn resume(path: impl AsRef<Path>, time: f64) -> Result<Self, OutputError> {
        let path = path.as_ref();
        if !path.exists() {
            return Self::create(path);
        }
        let mut collection = Self::read(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let parts = collection.entries.into_iter().partition(|entry| entry.0 <= time);
        let (mut kept, later): (Vec<_>, Vec<_>) = parts;
        kept.retain(|(_, file)| folder.join(file).exists());
        collection.entries = kept;
        collection.write()?;
        later.iter().for_each(|(_, file)| collection.remove_file(file));
        Ok(collection)
    }

    /// Adds the field file `file`, a path relative to the collection, at time `time` \[s\]; one of that name is
    /// replaced.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    pub fn add(&mut self, time: f64, file: impl Into<String>) -> Result<(), OutputError> {
        let file = file.into();
        self.entries.retain(|(_, former)| *former != file);
        self.entries.push((time, file));
        self.write()
    }

    /// Takes the field file `file` out of the collection and removes it.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    pub fn remove(&mut self, file: &str) -> Result<(), OutputError> {
        if self.entries.iter().any(|(_, name)| name == file) {
            self.entries.retain(|(_, name)| name != file);
            self.write()?;
            self.remove_file(file);
        }
        Ok(())
    }

    /// Removes a field file, and its pieces if it names some. Whatever is left over is overwritten by the run or does no
    /// harm.
    fn remove_file(&self, file: &str) {
        let path = self.resolve(file);
        let folder = path.parent().unwrap_or(Path::new(""));
        let is_list = path.extension().is_some_and(|extension| extension == "pvtu");
        for piece in pieces_of(&path).ok().filter(|_| is_list).unwrap_or_default() {
            let _ = fs::remove_file(folder.join(piece));
        }
        let _ = fs::remove_file(&path);
    }

    /// Writes the file again if it is not there.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    pub fn restore(&self) -> Result<(), OutputError> {
        if self.path.exists() { Ok(()) } else { self.write() }
    }

    /// The first field file of the collection that is not there.
    pub fn missing(&self) -> Option<PathBuf> {
        self.entries.iter().map(|(_, file)| self.resolve(file)).find(|path| !path.exists())
    }

    /// Times \[s\] and files, relative to the collection.
    pub fn entries(&self) -> &[(f64, String)] {
        &self.entries
    }

    /// Where the file `file` of an entry is.
    pub fn resolve(&self, file: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(file)
    }

    fn write(&self) -> Result<(), OutputError> {
        write_atomic(&self.path, |to| {
            writeln!(to, "<?xml version=\"1.0\"?>")?;
            writeln!(to, "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">")?;
            writeln!(to, "<Collection>")?;
            for (time, file) in &self.entries {
                writeln!(to, "<DataSet timestep=\"{}\" part=\"0\" file=\"{file}\"/>", number(*time))?;
            }
            writeln!(to, "</Collection>\n</VTKFile>")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::testing::scratch;

    #[test]
    fn resuming_drops_what_comes_later() {
        let directory = scratch("pvd");
        let path = directory.join("fields.pvd");
        let mut collection = Collection::create(&path).unwrap();
        for n in 1..=5 {
            let file = format!("f{n}.vtu");
            fs::write(directory.join(&file), "").unwrap();
            collection.add(0.1 * f64::from(n), file).unwrap();
        }
        assert_eq!(Collection::read(&path).unwrap(), collection);
        let resumed = Collection::resume(&path, 0.1 * 3.0).unwrap();
        assert_eq!(resumed.entries(), &collection.entries()[..3]);
        assert_eq!(Collection::read(&path).unwrap(), resumed);
        assert!(directory.join("f3.vtu").exists() && !directory.join("f4.vtu").exists());
        assert!(Collection::resume(directory.join("new.pvd"), 0.0).unwrap().entries().is_empty());
    }

    #[test]
    fn other_files_are_refused() {
        let directory = scratch("pvd-other");
        let path = directory.join("fields.pvd");
        fs::write(&path, "<html/>").unwrap();
        assert!(Collection::read(&path).is_err());
        fs::write(&path, "<VTKFile type=\"Collection\"><DataSet file=\"a\"/></VTKFile>").unwrap();
        assert!(Collection::read(&path).unwrap_err().to_string().contains("without time"));
    }
}
