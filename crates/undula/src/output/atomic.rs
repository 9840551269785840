//! Files that are never half written.

use super::OutputError;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes `path` by `fill` such that it holds the old content or the new one, whatever happens.
///
/// Missing parent directories are made. The content goes to a temporary file next to it, which is synced
/// and then renamed. Links are followed; a device or a pipe is written to as it is, never replaced.
///
/// # Errors
/// [`OutputError::Io`]; the temporary file is removed.
pub fn write_atomic<F>(path: impl AsRef<Path>, fill: F) -> Result<(), OutputError>
where
    F: FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
{
    let target = fs::canonicalize(path.as_ref()).unwrap_or_else(|_| path.as_ref().to_path_buf());
    let path = target.as_path();
    if fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir()) {
        let written = File::options().write(true).open(path).and_then(|file| {
            let mut file = BufWriter::new(file);
            fill(&mut file)?;
            file.flush()
        });
        return written.map_err(OutputError::io("write", path));
    }
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(parent).map_err(OutputError::io("create directory", parent))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let temporary = parent.join(format!(".{name}.tmp"));
    let written = File::create(&temporary).and_then(|file| {
        let mut file = BufWriter::with_capacity(1 << 18, file);
        fill(&mut file)?;
        file.into_inner().map_err(|e| e.into_error())?.sync_all()
    });
    if let Err(source) = written.and_then(|()| fs::rename(&temporary, path)) {
        let _ = fs::remove_file(&temporary);
        return Err(OutputError::Io { action: "write", path: path.to_path_buf(), source });
    }
    // Makes the rename itself durable; systems where directories cannot be opened do without.
    if let Ok(directory) = File::open(parent) {
        let _ = directory.sync_all();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::testing::scratch;

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_pipes_are_not_replaced() {
        use std::os::unix::fs::{FileTypeExt, symlink};
        let directory = scratch("directory-special");
        fs::create_dir_all(&directory).unwrap();
        let (file, link, pipe) = (directory.join("file"), directory.join("link"), directory.join("pipe"));
        fs::write(&file, "old").unwrap();
        symlink(&file, &link).unwrap();
        write_atomic(&link, |out| out.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&file).unwrap(), "new");

        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read_to_string(pipe).unwrap()
        });
        write_atomic(&pipe, |out| out.write_all(b"through")).unwrap();
        assert_eq!(reader.join().unwrap(), "through");
        assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
    }

    #[test]
    fn failed_writes_keep_the_old_content() {
        let directory = scratch("directory-atomic");
        let path = directory.join("a.txt");
        write_atomic(&path, |f| f.write_all(b"old")).unwrap();
        let result = write_atomic(&path, |f| {
            f.write_all(b"half of the n")?;
            Err(std::io::Error::other("disk full"))
        });
        assert!(result.unwrap_err().to_string().contains("a.txt: cannot write: disk full"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }
}
