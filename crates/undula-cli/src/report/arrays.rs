//! Numbers inside of a page: little endian, all first bytes of the numbers before all second ones, deflated, in base64.

use base64::prelude::{BASE64_STANDARD, Engine};
use flate2::{Compression, write::ZlibEncoder};
use serde_json::{Value, json};
use std::io::Write;

/// The code of a number that is not finite.
const NONE: u16 = u16::MAX;

/// The largest code of a number.
const LARGEST: f64 = (NONE - 1) as f64;

/// Levels above make a page some percents smaller and take twice as long.
const LEVEL: u32 = 3;

/// Numbers with 64 bits.
pub fn doubles(values: &[f64]) -> anyhow::Result<Value> {
    packed("f64", &values.iter().map(|x| x.to_le_bytes()).collect::<Vec<_>>())
}

/// Numbers with 32 bits.
pub fn singles(values: impl Iterator<Item = f64>) -> anyhow::Result<Value> {
    packed("f32", &values.map(|x| (x as f32).to_le_bytes()).collect::<Vec<_>>())
}

/// Whole numbers, of which each is the difference to the one before.
pub fn integers(values: &[u32]) -> anyhow::Result<Value> {
    let mut before = 0;
    let difference = |&n: &u32| u32::wrapping_sub(n, std::mem::replace(&mut before, n)).to_le_bytes();
    packed("u32", &values.iter().map(difference).collect::<Vec<_>>())
}

/// Numbers below 256.
pub fn bytes(values: impl Iterator<Item = u8>) -> anyhow::Result<Value> {
    packed("u8", &values.map(|n| [n]).collect::<Vec<_>>())
}

/// The values of one quantity at some moments, with 16 bits each: `base + step (n − zero)`, and `n = 65535` for what is not
/// finite. The step is 1/65533 of the range of all values.
///
/// Of every moment the difference n to the moment before is taken, of that the difference d to the point before, and of
/// that 2d or −2d − 1, all modulo 2¹⁶.
pub fn film(frames: &[Vec<f64>]) -> anyhow::Result<Value> {
    let finite = frames.iter().flatten().copied().filter(|x| x.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
    let step = (high - low) / (LARGEST - 1.0);
    // Zero stays what it is.
    let (base, zero) = if low < 0.0 && high > 0.0 { (0.0, (-low / step).ceil()) } else { (low, 0.0) };
    let steps = |x: f64| if step > 0.0 { (x - base) / step } else { 0.0 };
    let code = |x: f64| if x.is_finite() { (zero + steps(x)).round() as u16 } else { NONE };
    let mut before = vec![0; frames.first().map_or(0, Vec::len)];
    let mut codes = Vec::with_capacity(frames.len() * before.len());
    for frame in frames {
        let mut left = 0u16;
        for (&x, before) in frame.iter().zip(&mut before) {
            let now = code(x);
            let step = now.wrapping_sub(std::mem::replace(before, now));
            let d = step.wrapping_sub(std::mem::replace(&mut left, step)) as i16;
            codes.push((((d << 1) ^ (d >> 15)) as u16).to_le_bytes());
        }
    }
    let mut value = packed("film", &codes)?;
    value["frames"] = json!(frames.len());
    value["base"] = json!(base);
    value["step"] = json!(step);
    value["zero"] = json!(zero);
    Ok(value)
}

/// The size of an array within a page \[B\].
pub fn size(value: &Value) -> usize {
    match value {
        Value::Object(entries) => entries.values().map(size).sum(),
        Value::Array(entries) => entries.iter().map(size).sum(),
        Value::String(text) => text.len(),
        _ => 0,
    }
}

fn packed<const W: usize>(kind: &str, numbers: &[[u8; W]]) -> anyhow::Result<Value> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(LEVEL));
    for byte in 0..W {
        let plane: Vec<u8> = numbers.iter().map(|number| number[byte]).collect();
        encoder.write_all(&plane)?;
    }
    Ok(json!({ "type": kind, "length": numbers.len(), "data": BASE64_STANDARD.encode(encoder.finish()?) }))
}
