//! Checkpoints: everything needed to continue a run with the same bits.
//!
//! A checkpoint is an uncompressed `.npz` file: `numpy.load` opens it. Arrays of 64-bit numbers are its
//! members `NAME.npy`, the metadata is `metadata.json`. Every member carries a CRC-32, which is checked
//! upon reading.

use super::{OutputError, write_atomic};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// How many checkpoints of a run are kept.
const KEPT: usize = 2;

const METADATA: &str = "metadata.json";

/// An array of 64-bit numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum Array {
    /// Floating point, all bits kept.
    F64(Vec<f64>),
    /// Unsigned integers.
    U64(Vec<u64>),
}

/// The state of a run at the end of a step.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Checkpoint {
    /// JSON text; its content is up to the run.
    pub metadata: String,
    /// Arrays by name.
    pub arrays: BTreeMap<String, Array>,
}

/// A checkpoint found by [`Checkpoint::load_latest`].
#[derive(Debug)]
pub struct Latest {
    /// The state.
    pub checkpoint: Checkpoint,
    /// Its step.
    pub step: u64,
    /// Why newer checkpoints were passed over; empty if the newest one is sound.
    pub skipped: Vec<OutputError>,
}

impl Checkpoint {
    /// The floating-point array `name`.
    pub fn f64s(&self, name: &str) -> Option<&[f64]> {
        match self.arrays.get(name)? {
            Array::F64(values) => Some(values),
            Array::U64(_) => None,
        }
    }

    /// The integer array `name`.
    pub fn u64s(&self, name: &str) -> Option<&[u64]> {
        match self.arrays.get(name)? {
            Array::U64(values) => Some(values),
            Array::F64(_) => None,
        }
    }

    /// The file of step `step` in `directory`.
    pub fn path(directory: impl AsRef<Path>, step: u64) -> PathBuf {
        directory.as_ref().join(format!("checkpoint_{step:08}.npz"))
    }

    /// Saves the state after step `step` into `directory`, atomically, and removes all but the last two
    /// checkpoints there; those of later steps, left over from before a restart, go too.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    pub fn save(&self, directory: impl AsRef<Path>, step: u64) -> Result<PathBuf, OutputError> {
        self.save_instead(directory, step, None)
    }

    /// The same; of the last two one is that before step `instead_of`, if there is such a step.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    pub fn save_instead(
        &self,
        directory: impl AsRef<Path>,
        step: u64,
        instead_of: Option<u64>,
    ) -> Result<PathBuf, OutputError> {
        let directory = directory.as_ref();
        let path = Checkpoint::path(directory, step);
        // A zip archive is finished by going back in it, and complains where that fails: make it in memory.
        let mut bytes = io::Cursor::new(Vec::new());
        self.write(&mut bytes).map_err(OutputError::io("write", &path))?;
        write_atomic(&path, |file| file.write_all(bytes.get_ref()))?;
        let mut found = Checkpoint::list(directory)?;
        if let Some(at) = found.iter().position(|(n, _)| Some(*n) == instead_of && *n < step) {
            let (_, old) = found.remove(at);
            fs::remove_file(&old).map_err(OutputError::io("remove", old))?;
        }
        let (later, earlier): (Vec<_>, Vec<_>) = found.into_iter().partition(|(n, _)| *n > step);
        let surplus = earlier.len().saturating_sub(KEPT);
        for (_, old) in later.iter().chain(&earlier[..surplus]) {
            fs::remove_file(old).map_err(OutputError::io("remove", old))?;
        }
        Ok(path)
    }

    fn write<W: Write + io::Seek>(&self, file: &mut W) -> io::Result<()> {
        let mut zip = ZipWriter::new(file);
        let plain = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        zip.start_file(METADATA, plain)?;
        zip.write_all(self.metadata.as_bytes())?;
        for (name, array) in &self.arrays {
            let (kind, n) = match array {
                Array::F64(values) => ("<f8", values.len()),
                Array::U64(values) => ("<u8", values.len()),
            };
            zip.start_file(format!("{name}.npy"), plain.large_file(n > 1 << 28))?;
            zip.write_all(&npy_header(kind, n))?;
            let bytes: Vec<u8> = match array {
                Array::F64(values) => values.iter().flat_map(|x| x.to_le_bytes()).collect(),
                Array::U64(values) => values.iter().flat_map(|x| x.to_le_bytes()).collect(),
            };
            zip.write_all(&bytes)?;
        }
        zip.finish()?;
        Ok(())
    }

    /// Reads one checkpoint and checks it.
    ///
    /// # Errors
    /// [`OutputError::Io`]; [`OutputError::Format`] if it is truncated, damaged, or something else.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, OutputError> {
        let path = path.as_ref();
        let damaged = |message: String| {
            OutputError::format(path, format!("not a sound checkpoint ({message}); is the file truncated?"))
        };
        let file = File::open(path).map_err(OutputError::io("read", path))?;
        let mut zip = ZipArchive::new(BufReader::new(file)).map_err(|e| damaged(e.to_string()))?;
        let mut checkpoint = Checkpoint::default();
        for n in 0..zip.len() {
            let mut member = zip.by_index(n).map_err(|e| damaged(e.to_string()))?;
            let name = member.name().map_err(|e| damaged(e.to_string()))?.into_owned();
            let mut bytes = Vec::new();
            member.read_to_end(&mut bytes).map_err(|e| damaged(format!("{name}: {e}")))?;
            if name == METADATA {
                checkpoint.metadata = String::from_utf8(bytes).map_err(|e| damaged(e.to_string()))?;
            } else if let Some(name) = name.strip_suffix(".npy") {
                let array = npy_array(&bytes).ok_or_else(|| damaged(format!("array `{name}`")))?;
                checkpoint.arrays.insert(name.to_string(), array);
            }
        }
        Ok(checkpoint)
    }

    /// Reads the newest sound checkpoint of `directory`; `None` if there has never been one.
    ///
    /// # Errors
    /// The error of the newest checkpoint if none is sound.
    pub fn load_latest(directory: impl AsRef<Path>) -> Result<Option<Latest>, OutputError> {
        let mut skipped = Vec::new();
        for (step, path) in Checkpoint::list(directory)?.into_iter().rev() {
            match Checkpoint::load(&path) {
                Ok(checkpoint) => return Ok(Some(Latest { checkpoint, step, skipped })),
                Err(error) => skipped.push(error),
            }
        }
        match skipped.into_iter().next() {
            Some(newest) => Err(newest),
            None => Ok(None),
        }
    }

    /// Checkpoints in `directory` by step, ascending; none if there is no such directory.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    pub fn list(directory: impl AsRef<Path>) -> Result<Vec<(u64, PathBuf)>, OutputError> {
        let directory = directory.as_ref();
        let mut found = Vec::new();
        if !directory.exists() {
            return Ok(found);
        }
        for entry in fs::read_dir(directory).map_err(OutputError::io("list", directory))? {
            let path = entry.map_err(OutputError::io("list", directory))?.path();
            let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
            let step = name.strip_prefix("checkpoint_").and_then(|n| n.strip_suffix(".npz"));
            if let Some(step) = step.and_then(|n| n.parse().ok()) {
                found.push((step, path));
            }
        }
        found.sort();
        Ok(found)
    }
}

/// Header of a `.npy` file for a vector of `n` numbers, padded such that the data is aligned.
fn npy_header(kind: &str, n: usize) -> Vec<u8> {
    let mut text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({n},), }}");
    while !(10 + text.len() + 1).is_multiple_of(64) {
        text.push(' ');
    }
    text.push('\n');
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend((text.len() as u16).to_le_bytes());
    header.extend(text.as_bytes());
    header
}

/// The vector in a `.npy` file of [`npy_header`]; `None` if it is something else.
fn npy_array(bytes: &[u8]) -> Option<Array> {
    let length = u16::from_le_bytes(bytes.get(8..10)?.try_into().ok()?) as usize;
    let header = bytes.get(..10 + length)?;
    let data = &bytes[10 + length..];
    let (words, rest) = data.as_chunks::<8>();
    let array = match header {
        h if h == npy_header("<f8", words.len()) => {
            Array::F64(words.iter().map(|w| f64::from_le_bytes(*w)).collect())
        }
        h if h == npy_header("<u8", words.len()) => {
            Array::U64(words.iter().map(|w| u64::from_le_bytes(*w)).collect())
        }
        _ => return None,
    };
    rest.is_empty().then_some(array)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::testing::scratch;

    fn example(seed: u64) -> Checkpoint {
        let v =
            vec![0.1 + seed as f64, -0.0, f64::MIN_POSITIVE / 3.0, f64::NAN.copysign(-1.0), f64::INFINITY];
        let arrays = [
            ("v".to_string(), Array::F64(v)),
            ("counts".to_string(), Array::U64(vec![u64::MAX, seed])),
            ("none".to_string(), Array::F64(Vec::new())),
        ];
        Checkpoint { metadata: format!("{{\"time\": {seed}, \"π\": 3}}"), arrays: arrays.into() }
    }

    fn bits(checkpoint: &Checkpoint) -> Vec<u64> {
        checkpoint.f64s("v").unwrap().iter().map(|x| x.to_bits()).collect()
    }

    #[test]
    fn all_bits_come_back_and_two_are_kept() {
        let directory = scratch("checkpoint-bits");
        assert!(Checkpoint::load_latest(directory.join("missing")).unwrap().is_none());
        assert!(Checkpoint::load_latest(&directory).unwrap().is_none());
        for step in [5, 10, 15] {
            example(step).save(&directory, step).unwrap();
        }
        let steps: Vec<u64> =
            Checkpoint::list(&directory).unwrap().into_iter().map(|(step, _)| step).collect();
        assert_eq!(steps, [10, 15]);
        let latest = Checkpoint::load_latest(&directory).unwrap().unwrap();
        assert_eq!((latest.step, latest.skipped.len()), (15, 0));
        assert_eq!(latest.checkpoint.metadata, example(15).metadata);
        assert_eq!(bits(&latest.checkpoint), bits(&example(15)));
        assert_eq!(latest.checkpoint.u64s("counts"), Some(&[u64::MAX, 15][..]));
        assert_eq!(latest.checkpoint.f64s("none"), Some(&[][..]));
        assert_eq!((latest.checkpoint.f64s("counts"), latest.checkpoint.u64s("other")), (None, None));
    }

    #[test]
    fn checkpoints_of_an_abandoned_future_go() {
        let directory = scratch("checkpoint-future");
        [10, 15, 12].into_iter().for_each(|step| drop(example(step).save(&directory, step).unwrap()));
        assert_eq!(Checkpoint::load_latest(&directory).unwrap().unwrap().step, 12);
    }

    #[test]
    fn a_checkpoint_can_make_way_for_the_one_before_it() {
        let directory = scratch("checkpoint-instead");
        [5, 10, 12].into_iter().for_each(|step| drop(example(step).save(&directory, step).unwrap()));
        example(15).save_instead(&directory, 15, Some(12)).unwrap();
        let steps: Vec<u64> =
            Checkpoint::list(&directory).unwrap().into_iter().map(|(step, _)| step).collect();
        assert_eq!(steps, [10, 15]);
    }

    #[test]
    fn any_damage_is_found_and_the_previous_one_taken() {
        let directory = scratch("checkpoint-damage");
        example(1).save(&directory, 1).unwrap();
        let path = example(2).save(&directory, 2).unwrap();
        let good = fs::read(&path).unwrap();
        let mut bad: Vec<Vec<u8>> = (0..good.len()).step_by(13).map(|cut| good[..cut].to_vec()).collect();
        // One flipped bit in the numbers of `v`, found by its header.
        let header = npy_header("<f8", 5);
        let at = good.windows(header.len()).position(|w| w == header).unwrap() + header.len();
        for byte in [0, 9, 39] {
            bad.push(good.clone());
            bad.last_mut().unwrap()[at + byte] ^= 4;
        }
        for bytes in bad {
            fs::write(&path, bytes).unwrap();
            let latest = Checkpoint::load_latest(&directory).unwrap().unwrap();
            assert_eq!((latest.step, latest.skipped.len()), (1, 1));
            assert!(latest.skipped[0].to_string().contains("checkpoint_00000002.npz"));
        }
        fs::write(directory.join("checkpoint_00000001.npz"), "").unwrap();
        let message = Checkpoint::load_latest(&directory).unwrap_err().to_string();
        assert!(message.contains("checkpoint_00000002.npz: not a sound checkpoint"), "{message}");
    }
}
