//! Lines of a file with their numbers.

use crate::mesh::MeshError;
use std::path::Path;
use std::str::FromStr;

/// The non-empty lines of a text, one after the other.
pub(super) struct Lines<'a> {
    path: &'a Path,
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    last: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn new(text: &'a str, path: &'a Path) -> Self {
        Lines { path, lines: text.lines().enumerate(), last: 0 }
    }

    /// The next line that is not empty.
    pub(super) fn next(&mut self) -> Option<Line<'a>> {
        let (i, text) = self.lines.find(|(_, text)| !text.trim().is_empty())?;
        self.last = i + 1;
        Some(Line { path: self.path, number: i + 1, text: text.trim(), words: text.split_whitespace() })
    }

    /// The next line, which must be there: `what` says for what.
    pub(super) fn expect(&mut self, what: &str) -> Result<Line<'a>, MeshError> {
        let (path, line) = (self.path, self.last);
        self.next().ok_or_else(|| error(path, line, format!("the file ends where {what} should follow")))
    }

    /// Reads the line `$End…` of a section.
    pub(super) fn end(&mut self, section: &str) -> Result<(), MeshError> {
        let end = format!("$End{section}");
        let line = self.expect(&format!("`{end}`"))?;
        if line.text == end {
            Ok(())
        } else {
            Err(line.error(format!("expected `{end}`, found `{}`", line.text)))
        }
    }

    /// Skips to the line `$End…` of a section.
    pub(super) fn skip(&mut self, section: &str) -> Result<(), MeshError> {
        let end = format!("$End{section}");
        while self.expect(&format!("`{end}`"))?.text != end {}
        Ok(())
    }

    /// An error at the last line read.
    pub(super) fn error(&self, reason: String) -> MeshError {
        error(self.path, self.last.max(1), reason)
    }
}

/// One line; its words are read from left to right.
pub(super) struct Line<'a> {
    path: &'a Path,
    /// From 1.
    pub(super) number: usize,
    /// Without surrounding white space.
    pub(super) text: &'a str,
    words: std::str::SplitWhitespace<'a>,
}

impl Line<'_> {
    /// The next word as a number; `what` says which.
    pub(super) fn number<N: FromStr>(&mut self, what: &str) -> Result<N, MeshError> {
        let word = self.words.next().ok_or_else(|| self.error(format!("{what} is missing")))?;
        word.parse().map_err(|_| self.error(format!("expected {what}, found `{word}`")))
    }

    /// The next word as a coordinate, which must be finite.
    pub(super) fn coordinate(&mut self, what: &str) -> Result<f64, MeshError> {
        let x: f64 = self.number(what)?;
        if x.is_finite() { Ok(x) } else { Err(self.error(format!("{what} is {x}, not a finite number"))) }
    }

    /// The next `n` words as numbers.
    pub(super) fn numbers<N: FromStr>(&mut self, n: usize, what: &str) -> Result<Vec<N>, MeshError> {
        // No room is made beforehand, since `n` may come from a broken file.
        (0..n).map(|_| self.number(what)).collect()
    }

    /// An error at this line.
    pub(super) fn error(&self, reason: String) -> MeshError {
        error(self.path, self.number, reason)
    }
}

/// An error at line `line` of `path`.
pub(super) fn error(path: &Path, line: usize, reason: String) -> MeshError {
    MeshError::File { path: path.to_path_buf(), line, reason }
}
