//! Mistakes in a case file, and how they are told.

use std::fmt;
use std::path::PathBuf;

/// Where a mistake was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// In the file, line and column counted from 1.
    File {
        /// Name as given by the user.
        name: String,
        /// Line.
        line: usize,
        /// Column in characters.
        column: usize,
    },
    /// In an override of the command line, the text after `--set`.
    Set(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::File { name, line, column } => write!(f, "{name}:{line}:{column}"),
            Place::Set(text) => write!(f, "--set {text}"),
        }
    }
}

/// One mistake: where, which key, which value, and what would be right.
///
/// Printed as ``fsi3.toml:12:10: time.scheme = "cn": expected one of `backward-euler`, …``.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct CaseError {
    /// Where.
    pub place: Place,
    /// Dotted key, empty for a mistake in the syntax.
    pub key: String,
    /// The value as written, if there is one.
    pub value: Option<String>,
    /// What is wrong and what would be right.
    pub message: String,
}

impl fmt::Display for CaseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.place)?;
        // An override already shows its key and value.
        let same = |(parts, _): (Vec<String>, &str)| {
            parts.iter().fold(String::new(), |path, part| super::key::join(&path, part)) == self.key
        };
        let shown = matches!(&self.place, Place::Set(text)
            if super::key::split_override(text).is_ok_and(same));
        if !shown && !self.key.is_empty() {
            match &self.value {
                Some(value) => write!(f, "{} = {value}: ", self.key)?,
                None => write!(f, "{}: ", self.key)?,
            }
        }
        f.write_str(&self.message)
    }
}

/// All mistakes of a case, in the order of the file; one per line when printed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct CaseErrors(pub Vec<CaseError>);

impl fmt::Display for CaseErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, error) in self.0.iter().enumerate() {
            write!(f, "{}{error}", if i == 0 { "" } else { "\n" })?;
        }
        Ok(())
    }
}

/// Why a case could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// Neither a built-in case nor a file.
    #[error("no such case or file: `{name}`{hint}")]
    NoSuchCase {
        /// What was asked for.
        name: String,
        /// A suggestion, ready to be appended.
        hint: String,
    },
    /// The file is there but cannot be read.
    #[error("cannot read {}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The case has mistakes.
    #[error(transparent)]
    Invalid(#[from] CaseErrors),
}

impl LoadError {
    /// Whether the user's input is at fault (exit code 2) rather than the system (exit code 1).
    pub fn is_bad_input(&self) -> bool {
        !matches!(self, LoadError::Unreadable { .. })
    }
}

/// `; did you mean `…`?` for the candidate closest to `word`, or nothing if none is close.
pub fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let lower = word.to_lowercase();
    let scored = candidates.into_iter().map(|c| (distance(&lower, &c.to_lowercase()), c));
    // A third of the letters may be wrong; a one-letter word suggests nothing.
    match scored.min_by_key(|(d, _)| *d) {
        Some((d, best)) if d <= word.chars().count().max(best.chars().count()) / 3 => {
            format!("; did you mean `{best}`?")
        }
        _ => String::new(),
    }
}

/// Number of insertions, deletions, replacements and swaps of neighbours that turn `a` into `b`.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![vec![0usize; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        rows[i][0] = i;
    }
    for j in 0..=b.len() {
        rows[0][j] = j;
    }
    for i in 1..=a.len() {
        for j in 1..=b.len() {
            let replace = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replace.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            rows[i][j] = best;
        }
    }
    rows[a.len()][b.len()]
}

/// `` `a`, `b`, `c` ``.
pub(crate) fn quoted<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    words.into_iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", ")
}

/// ``; did you mean `b`? There are `a`, `b` ``, or ``; there are `a`, `b` `` if none is close.
pub(crate) fn suggestion<'a>(word: &str, names: impl Iterator<Item = &'a str> + Clone) -> String {
    let hint = did_you_mean(word, names.clone());
    match (hint.is_empty(), quoted(names)) {
        (_, list) if list.is_empty() => "; there are none".into(),
        (true, list) => format!("; there are {list}"),
        (false, list) => format!("{hint} There are {list}"),
    }
}
