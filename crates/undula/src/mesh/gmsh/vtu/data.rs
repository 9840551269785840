//! Values of the arrays of a VTU file: text, base64 or bytes, compressed or not.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;
use std::io::Read;

/// How numbers are written in a file.
#[derive(Default)]
pub(super) struct Coding {
    /// The highest byte comes first.
    pub is_big: bool,
    /// Numbers of bytes have 64 bits instead of 32.
    pub is_wide: bool,
    /// In blocks of zlib.
    pub is_compressed: bool,
    /// Appended data are bytes, not base64.
    pub is_raw: bool,
}

/// Where the values of an array are.
pub(super) enum Format {
    /// As words in its element.
    Text,
    /// As base64 in its element.
    Inline,
    /// So many bytes behind the underscore.
    Appended(usize),
}

/// A named array.
pub(super) struct Array {
    pub name: String,
    pub components: usize,
    pub values: Values,
}

pub(super) enum Values {
    Whole(Vec<i64>),
    Real(Vec<f64>),
    Words(Vec<String>),
}

impl Array {
    /// Number of entries.
    pub fn len(&self) -> usize {
        let n = match &self.values {
            Values::Whole(x) => x.len(),
            Values::Real(x) => x.len(),
            Values::Words(x) => x.len(),
        };
        n / self.components
    }

    /// The values, if they are numbers.
    pub fn reals(&self) -> Option<Vec<f64>> {
        match &self.values {
            Values::Whole(x) => Some(x.iter().map(|&x| x as f64).collect()),
            Values::Real(x) => Some(x.clone()),
            Values::Words(_) => None,
        }
    }

    /// The values, if they are whole numbers.
    pub fn whole(&self) -> Option<Vec<i64>> {
        match &self.values {
            Values::Whole(x) => Some(x.clone()),
            Values::Real(x) if x.iter().all(|x| x.fract() == 0.0 && x.abs() < 1e15) => {
                Some(x.iter().map(|&x| x as i64).collect())
            }
            _ => None,
        }
    }
}

/// The values of an array of type `kind`.
pub(super) fn decode(
    coding: &Coding,
    kind: &str,
    format: &Format,
    text: &str,
    appended: &[u8],
) -> Result<Values, String> {
    let bytes = match format {
        Format::Text => return words(kind, text),
        Format::Inline => payload(coding, &from_base64(text.as_bytes())?)?,
        Format::Appended(offset) => {
            let rest = appended.get(*offset..).ok_or("it begins behind the end of the file")?;
            if coding.is_raw { payload(coding, rest)? } else { payload(coding, &from_base64(rest)?)? }
        }
    };
    numbers(kind, &bytes, coding.is_big)
}

/// Values written as words.
fn words(kind: &str, text: &str) -> Result<Values, String> {
    let words = || text.split_ascii_whitespace();
    if kind.starts_with("Float") {
        let real = |word: &str| word.parse().map_err(|_| format!("expected a number, found `{word}`"));
        return words().map(real).collect::<Result<_, _>>().map(Values::Real);
    }
    let whole =
        |word: &str| word.parse::<i64>().map_err(|_| format!("expected a whole number, found `{word}`"));
    let whole: Vec<i64> = words().map(whole).collect::<Result<_, _>>()?;
    if kind == "String" {
        let bytes: Vec<u8> = whole.iter().map(|&code| u8::try_from(code).unwrap_or(b'?')).collect();
        return Ok(Values::Words(strings(&bytes)));
    }
    Ok(Values::Whole(whole))
}

/// Words that each end with a byte 0.
fn strings(bytes: &[u8]) -> Vec<String> {
    let mut words: Vec<String> =
        bytes.split(|&b| b == 0).map(|word| String::from_utf8_lossy(word).into_owned()).collect();
    words.pop();
    words
}

/// Bytes of base64, which may consist of several parts, each filled up with `=`; it ends at the first other character.
fn from_base64(text: &[u8]) -> Result<Vec<u8>, String> {
    let is_code = |b: &u8| b.is_ascii_alphanumeric() || matches!(b, b'+' | b'/' | b'=');
    let code: Vec<u8> =
        text.iter().filter(|b| !b.is_ascii_whitespace()).take_while(|b| is_code(b)).copied().collect();
    let mut bytes = Vec::with_capacity(code.len() / 4 * 3);
    let mut part = &code[..];
    while !part.is_empty() {
        let padded = part.iter().position(|&b| b == b'=').map(|at| (at / 4 + 1) * 4);
        let (now, later) = part.split_at(padded.unwrap_or(part.len()).min(part.len()));
        bytes.extend(STANDARD.decode(now).map_err(|e| format!("no base64: {e}"))?);
        part = later;
    }
    Ok(bytes)
}

/// The data behind their header.
fn payload(coding: &Coding, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let ends = || "the file ends within it".to_string();
    let width = if coding.is_wide { 8 } else { 4 };
    let number = |i: usize| -> Result<usize, String> {
        let word =
            i.checked_mul(width).and_then(|at| bytes.get(at..at.checked_add(width)?)).ok_or_else(ends)?;
        let digits: Vec<u8> =
            if coding.is_big { word.to_vec() } else { word.iter().rev().copied().collect() };
        Ok(digits.iter().fold(0, |n: usize, &b| n.wrapping_mul(256) + usize::from(b)))
    };
    if !coding.is_compressed {
        let n = number(0)?;
        return bytes[width..].get(..n).map(<[u8]>::to_vec).ok_or_else(ends);
    }
    let (blocks, size) = match number(0)? {
        0 => return Ok(vec![]),
        blocks => (blocks, number(1)?),
    };
    let mut at = blocks.checked_add(3).and_then(|n| n.checked_mul(width)).ok_or_else(ends)?;
    let mut data = vec![];
    for block in 0..blocks {
        let end = at.checked_add(number(3 + block)?).ok_or_else(ends)?;
        let compressed = bytes.get(at..end).ok_or_else(ends)?;
        // No block is larger than it says.
        let mut inflated = ZlibDecoder::new(compressed).take(size as u64);
        inflated.read_to_end(&mut data).map_err(|e| format!("its data are damaged: {e}"))?;
        at = end;
    }
    Ok(data)
}

/// Numbers of the type `kind`.
fn numbers(kind: &str, bytes: &[u8], is_big: bool) -> Result<Values, String> {
    fn each<const N: usize, T>(bytes: &[u8], is_big: bool, of: fn([u8; N]) -> T) -> Vec<T> {
        let number = |chunk: &[u8]| {
            let mut word = [0; N];
            word.copy_from_slice(chunk);
            if is_big {
                word.reverse();
            }
            of(word)
        };
        bytes.chunks_exact(N).map(number).collect()
    }
    Ok(match kind {
        "Float64" => Values::Real(each(bytes, is_big, f64::from_le_bytes)),
        "Float32" => Values::Real(each(bytes, is_big, |b| f64::from(f32::from_le_bytes(b)))),
        "Int64" => Values::Whole(each(bytes, is_big, i64::from_le_bytes)),
        "UInt64" => Values::Whole(each(bytes, is_big, |b| u64::from_le_bytes(b) as i64)),
        "Int32" => Values::Whole(each(bytes, is_big, |b| i64::from(i32::from_le_bytes(b)))),
        "UInt32" => Values::Whole(each(bytes, is_big, |b| i64::from(u32::from_le_bytes(b)))),
        "Int16" => Values::Whole(each(bytes, is_big, |b| i64::from(i16::from_le_bytes(b)))),
        "UInt16" => Values::Whole(each(bytes, is_big, |b| i64::from(u16::from_le_bytes(b)))),
        "Int8" => Values::Whole(each(bytes, is_big, |b| i64::from(i8::from_le_bytes(b)))),
        "UInt8" => Values::Whole(each(bytes, is_big, |[b]| i64::from(b))),
        "String" => Values::Words(strings(bytes)),
        other => return Err(format!("numbers of the type `{other}` are not known")),
    })
}
