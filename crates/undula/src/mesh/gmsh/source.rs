//! The bytes of a file, read as lines of text or as binary numbers.

use crate::mesh::MeshError;
use std::fmt;
use std::path::Path;
use std::str::FromStr;

/// Where something stands in the file.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum At {
    /// Line of a text, from 1.
    Line(usize),
    /// Byte of a binary file, from 0.
    Byte(usize),
    /// Cell of a VTU file, from 0.
    Cell(usize),
    /// Point of a VTU file, from 0.
    Point(usize),
}

impl fmt::Display for At {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            At::Line(line) => write!(f, "line {line}"),
            At::Byte(byte) => write!(f, "byte {byte}"),
            At::Cell(cell) => write!(f, "cell {cell}"),
            At::Point(point) => write!(f, "point {point}"),
        }
    }
}

/// An error at a place of `path`.
pub(super) fn error(path: &Path, at: At, reason: String) -> MeshError {
    let path = path.to_path_buf();
    match at {
        At::Line(line) => MeshError::File { path, line, reason },
        At::Byte(byte) => MeshError::Binary { path, byte, reason },
        At::Cell(_) | At::Point(_) => MeshError::Item { path, item: at.to_string(), reason },
    }
}

/// How numbers are written between the lines that begin and end a section.
#[derive(Copy, Clone, PartialEq)]
pub(super) enum Encoding {
    /// As words of lines.
    Text,
    /// As bytes of a machine.
    Binary {
        /// The machine that wrote the file had the other order of bytes.
        swapped: bool,
        /// Bytes of a `size_t` of that machine: 4 or 8.
        wide: usize,
    },
}

/// A file and how far it has been read.
pub(super) struct Source<'a> {
    pub path: &'a Path,
    pub encoding: Encoding,
    bytes: &'a [u8],
    at: usize,
    /// Lines read so far.
    line: usize,
}

impl<'a> Source<'a> {
    pub fn new(bytes: &'a [u8], path: &'a Path) -> Self {
        // An editor may have put a byte order mark in front.
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        Source { path, encoding: Encoding::Text, bytes, at: 0, line: 0 }
    }

    /// The whole file.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// Goes back to the first byte.
    pub fn rewind(&mut self) {
        (self.at, self.line) = (0, 0);
    }

    pub fn is_binary(&self) -> bool {
        self.encoding != Encoding::Text
    }

    /// The place that has been reached.
    fn here(&self) -> At {
        if self.is_binary() { At::Byte(self.at) } else { At::Line(self.line.max(1)) }
    }

    /// An error at the place that has been reached.
    pub fn error(&self, reason: String) -> MeshError {
        error(self.path, self.here(), reason)
    }

    /// The next line that is not empty, of a binary file, too.
    pub fn line(&mut self) -> Option<Line<'a>> {
        while self.at < self.bytes.len() {
            let begin = self.here();
            let rest = &self.bytes[self.at..];
            let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            self.at += (length + 1).min(rest.len());
            self.line += 1;
            let text = rest[..length].trim_ascii();
            if !text.is_empty() {
                let at = if self.is_binary() { begin } else { self.here() };
                return Some(Line { path: self.path, at, text, rest: text });
            }
        }
        None
    }

    /// The next line, which must be there: `what` says for what.
    pub fn expect(&mut self, what: &str) -> Result<Line<'a>, MeshError> {
        self.line().ok_or_else(|| self.ends(what))
    }

    fn ends(&self, what: &str) -> MeshError {
        self.error(format!("the file ends where {what} should follow"))
    }

    /// Reads the line `$End…` of a section.
    pub fn end(&mut self, section: &str) -> Result<(), MeshError> {
        let end = format!("$End{section}");
        let line = self.expect(&format!("`{end}`"))?;
        if line.text == end.as_bytes() {
            return Ok(());
        }
        Err(line.error(format!("expected `{end}`, found `{}`", shown(line.text))))
    }

    /// Goes behind the line `$End…` of a section, or stays where there is none.
    pub fn skip(&mut self, section: &str) {
        let (end, begin) = (format!("$End{section}"), (self.at, self.line));
        if self.is_binary() {
            let found = self.bytes[self.at..].windows(end.len()).position(|w| w == end.as_bytes());
            return self.at += found.map_or(0, |i| i + end.len());
        }
        while let Some(line) = self.line() {
            if line.text == end.as_bytes() {
                return;
            }
        }
        (self.at, self.line) = begin;
    }

    /// The next numbers: those of a line of a text, or bytes of a binary file; `what` says what they are of.
    pub fn record(&mut self, what: &str) -> Result<Record<'_, 'a>, MeshError> {
        let line = if self.is_binary() { None } else { Some(self.expect(what)?) };
        Ok(Record { source: self, line })
    }

    /// The next `N` bytes in the order of this machine.
    fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N], MeshError> {
        let found: Option<[u8; N]> = self.bytes.get(self.at..self.at + N).and_then(|b| b.try_into().ok());
        let Some(mut bytes) = found else { return Err(self.ends(what)) };
        self.at += N;
        let foreign = matches!(self.encoding, Encoding::Binary { swapped: true, .. });
        // Files are read as if they were of a machine with the lower byte first.
        if foreign {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

/// The bytes as they appear in a message.
fn shown(bytes: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(bytes).chars().take(60).collect();
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

/// One line; its words are read from left to right.
pub(super) struct Line<'a> {
    path: &'a Path,
    pub at: At,
    /// Without surrounding white space.
    pub text: &'a [u8],
    rest: &'a [u8],
}

impl<'a> Line<'a> {
    /// The next word as a number; `what` says which.
    pub fn number<N: FromStr>(&mut self, what: &str) -> Result<N, MeshError> {
        let word = self.word().ok_or_else(|| self.error(format!("{what} is missing")))?;
        let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        number.ok_or_else(|| self.error(format!("expected {what}, found `{}`", shown(word))))
    }

    fn word(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest.trim_ascii_start();
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.rest = &rest[length..];
        (length > 0).then_some(&rest[..length])
    }

    /// What stands between the first double quote and the last. Where it is not UTF-8, every byte is a letter
    /// (Latin-1).
    pub fn quoted(&self) -> Result<String, MeshError> {
        let quote = |b: &u8| *b == b'"';
        let (a, b) = (self.text.iter().position(quote), self.text.iter().rposition(quote));
        match a.zip(b).filter(|(a, b)| a < b) {
            Some((a, b)) => {
                let name = &self.text[a + 1..b];
                let latin = |_| name.iter().map(|&b| char::from(b)).collect();
                Ok(std::str::from_utf8(name).map(String::from).unwrap_or_else(latin))
            }
            None => {
                Err(self.error(format!("expected a name in double quotes, found `{}`", shown(self.text))))
            }
        }
    }

    /// An error at this line.
    pub fn error(&self, reason: String) -> MeshError {
        error(self.path, self.at, reason)
    }
}

/// Numbers that belong together, read one after the other.
pub(super) struct Record<'s, 'a> {
    source: &'s mut Source<'a>,
    /// Of a text.
    line: Option<Line<'a>>,
}

impl Record<'_, '_> {
    /// Where it stands; of a binary file where the next number does.
    pub fn at(&self) -> At {
        self.line.as_ref().map_or_else(|| self.source.here(), |line| line.at)
    }

    /// The next number, an `int` of a binary file.
    pub fn int(&mut self, what: &str) -> Result<i64, MeshError> {
        match &mut self.line {
            Some(line) => line.number(what),
            None => Ok(i64::from(i32::from_le_bytes(self.source.take(what)?))),
        }
    }

    /// The next number, a `size_t` of a binary file.
    pub fn size(&mut self, what: &str) -> Result<u64, MeshError> {
        match (&mut self.line, self.source.encoding) {
            (Some(line), _) => line.number(what),
            (None, Encoding::Binary { wide: 4, .. }) => {
                Ok(u64::from(u32::from_le_bytes(self.source.take(what)?)))
            }
            _ => Ok(u64::from_le_bytes(self.source.take(what)?)),
        }
    }

    /// The next number, a `double` of a binary file.
    pub fn real(&mut self, what: &str) -> Result<f64, MeshError> {
        match &mut self.line {
            Some(line) => line.number(what),
            None => Ok(f64::from_le_bytes(self.source.take(what)?)),
        }
    }

    /// The next number as a coordinate, which must be finite.
    pub fn coordinate(&mut self, what: &str) -> Result<f64, MeshError> {
        let at = self.at();
        let x = self.real(what)?;
        if x.is_finite() {
            return Ok(x);
        }
        Err(error(self.source.path, at, format!("{what} is {x}, not a finite number")))
    }

    /// The next `n` numbers. No room is made beforehand, since `n` may come from a broken file.
    pub fn ints(&mut self, n: u64, what: &str) -> Result<Vec<i64>, MeshError> {
        (0..n).map(|_| self.int(what)).collect()
    }

    /// The next `n` numbers.
    pub fn sizes(&mut self, n: u64, what: &str) -> Result<Vec<u64>, MeshError> {
        (0..n).map(|_| self.size(what)).collect()
    }

    /// Leaves out `n` numbers of a binary file; nobody reads on in a line of a text.
    pub fn leave_reals(&mut self, n: u64, what: &str) -> Result<(), MeshError> {
        if self.line.is_none() {
            (0..n).try_for_each(|_| self.real(what).map(drop))?;
        }
        Ok(())
    }

    /// An error at the place of this record.
    pub fn error(&self, reason: String) -> MeshError {
        error(self.source.path, self.at(), reason)
    }
}
