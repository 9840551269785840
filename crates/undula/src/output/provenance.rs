//! Where a result comes from: program, day, processor, input.

use chrono::{SecondsFormat, Utc};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Which program computed a run, when, on which processor, from which input.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Provenance {
    /// Version of the library.
    pub version: String,
    /// Commit of the source that the program was built from, with `-dirty` if files were changed; `None` where the
    /// source was no repository.
    pub commit: Option<String>,
    /// When the summary was written: UTC as in RFC 3339, such as `2026-11-28T23:59:59Z`.
    pub date: String,
    /// Name of the processor, where the system tells.
    pub processor: Option<String>,
    /// [`hash`] of `case.toml` of the run.
    pub case_hash: Option<String>,
    /// [`hash`] of the mesh file; `None` where the mesh is built in.
    pub mesh_hash: Option<String>,
    /// [`hash`] of each file with a table of values, by its path; absent where there are none.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub table_hashes: BTreeMap<String, String>,
}

impl Provenance {
    /// That of now and here, with the `commit` that the program knows.
    pub fn now(commit: Option<String>) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            commit,
            date: Utc::now().to_rfc3339_opts(SecondsFormat::Secs, true),
            processor: processor(),
            case_hash: None,
            mesh_hash: None,
            table_hashes: BTreeMap::new(),
        }
    }
}

/// A number for `bytes`, as 32 hexadecimal digits: FNV-1a of 128 bits. It tells changes from each other and does not
/// protect from intent.
pub fn hash(bytes: &[u8]) -> String {
    let step = |hash: u128, byte: &u8| (hash ^ u128::from(*byte)).wrapping_mul((1 << 88) | 0x13b);
    let hash = bytes.iter().fold(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d, step);
    format!("{hash:032x}")
}

/// Name of the processor; known on Linux only.
pub fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("model name"))?;
    Some(line.trim_start_matches([' ', '\t', ':']).trim().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the authors of the hash (Fowler, Noll, Vo).
    #[test]
    fn hashes_are_those_of_fnv() {
        assert_eq!(hash(b""), "6c62272e07bb014262b821756295c58d");
        assert_eq!(hash(b"a"), "d228cb696f1a8caf78912b704e4a8964");
        assert_eq!(hash(b"foobar"), "343e1662793c64bf6f0d3597ba446f18");
    }

    #[test]
    fn dates_are_of_one_form() {
        let now = Provenance::now(Some("abc".into()));
        assert!(
            now.date.len() == 20 && now.date.ends_with('Z') && now.date.starts_with("20"),
            "{}",
            now.date
        );
        assert_eq!((now.version.as_str(), now.commit.as_deref()), (env!("CARGO_PKG_VERSION"), Some("abc")));
    }
}
