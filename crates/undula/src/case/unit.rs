//! Values with a unit, such as `120 mmHg`: the number in SI units that is nearest to their exact value.
//!
//! | | |
//! | --- | --- |
//! | units | `m`, `s`, `min`, `h`, `d`, `g`, `N`, `dyn`, `Pa`, `bar`, `atm`, `Torr`, `mmHg`, `cmH2O`, `J`, `W`, `Hz`, `l`, `L`, `P`, `St`, `rad`, `deg`, `°` |
//! | prefixes | `G`, `M`, `k`, `h`, `d`, `c`, `m`, `µ` or `u`, `n`, where they are usual |
//! | products | `Pa s`, `Pa*s`, `Pa·s`, `m/s`, `kg/m/s^2`, `kg/(m s^2)` |
//! | powers | `m^2`, `m²`, `m2`, `s^-1`, `s⁻¹` |

mod decimal;
mod reader;
mod symbols;

use super::literal::number_length;
use reader::{is_exponent, parse};
use std::fmt;
use symbols::{Unit, symbol};

/// Exponents of m, kg, s and rad in a unit.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Dimension(pub [i32; 4]);

/// What quantities are called, with a value as an example.
const QUANTITIES: &[([i32; 4], &str, &str)] = &[
    ([0, 0, 0, 0], "a pure number", "0.4"),
    ([1, 0, 0, 0], "a length", "1 mm"),
    ([2, 0, 0, 0], "an area", "1 cm^2"),
    ([3, 0, 0, 0], "a volume", "1 ml"),
    ([0, 1, 0, 0], "a mass", "1 g"),
    ([0, 0, 1, 0], "a time", "1 ms"),
    ([0, 0, -1, 0], "a frequency", "50 Hz"),
    ([1, 0, -1, 0], "a velocity", "30 cm/s"),
    ([1, 0, -2, 0], "an acceleration", "9.81 m/s^2"),
    ([-3, 1, 0, 0], "a density", "1.06 g/cm^3"),
    ([-1, 1, -2, 0], "a pressure", "120 mmHg"),
    ([-1, 1, -1, 0], "a dynamic viscosity", "4 mPa s"),
    ([2, 0, -1, 0], "a kinematic viscosity or a flux in the plane", "1e-6 m^2/s"),
    ([3, 0, -1, 0], "a flux in space", "5 l/min"),
    ([1, 1, -2, 0], "a force", "1 N"),
    ([0, 1, -2, 0], "a force per length", "1 N/m"),
    ([-3, 1, -1, 0], "a flow resistance in the plane", "1 Pa s/m^2"),
    ([-4, 1, -1, 0], "a flow resistance in space", "1 Pa s/m^3"),
    ([0, 0, 0, 1], "an angle", "30 deg"),
];

/// Quantities that are other ones in the plane, where all is per length of what lies behind it: power of the length.
const PER_LENGTH: &[([i32; 4], i32, &str)] = &[
    ([3, 0, -1, 0], -1, "a flux is an area per time"),
    ([1, 1, -2, 0], -1, "a force is one per length"),
    ([2, 1, -2, 0], -1, "an energy is one per length"),
    ([2, 1, -3, 0], -1, "a power is one per length"),
    ([-4, 1, -1, 0], 1, "the flux of a flow resistance is an area per time"),
    ([4, -1, 2, 0], -1, "the volume of a compliance is an area"),
];

impl Dimension {
    /// That of a unit as in the table of keys, such as `kg/m³`; empty: that of pure numbers. `None` if it is no unit.
    pub fn of(unit: &str) -> Option<Dimension> {
        match unit {
            "" => Some(Dimension::default()),
            _ => parse(unit).ok().map(|unit| unit.dimension),
        }
    }

    fn row(self) -> Option<&'static ([i32; 4], &'static str, &'static str)> {
        QUANTITIES.iter().find(|(exponents, ..)| *exponents == self.0)
    }
}

impl fmt::Display for Dimension {
    /// What it is called, with its SI unit.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [m, kg, s, rad] = self.0;
        let powers = [("kg", kg), ("m", m), ("s", s), ("rad", rad)].into_iter().filter(|(_, n)| *n != 0);
        let unit: Vec<String> =
            powers.map(|(m, n)| if n == 1 { m.into() } else { format!("{m}^{n}") }).collect();
        match (self.row(), unit.is_empty()) {
            (Some((_, name, _)), true) => f.write_str(name),
            (Some((_, name, _)), false) => write!(f, "{name} [{}]", unit.join(" ")),
            (None, _) => write!(f, "a value in {}", unit.join(" ")),
        }
    }
}

/// A text that is a number followed by a unit, taken apart: sign, digits and unit. `None` if it is no such text.
fn split(text: &str) -> Option<(f64, &str, &str)> {
    let text = text.trim();
    let sign = if text.starts_with('-') { -1.0 } else { 1.0 };
    let text = text.strip_prefix(['-', '+']).unwrap_or(text);
    let length = number_length(text.as_bytes());
    let (digits, unit) = (&text[..length], text[length..].trim_start());
    let is_number = digits.parse::<f64>().is_ok();
    let is_unit = unit.starts_with(|c: char| c.is_alphabetic() || c == '°')
        && unit
            .replace("^-", "")
            .chars()
            .all(|c| c.is_alphanumeric() || is_exponent(c) || " *·⋅/()^°".contains(c));
    (is_number && is_unit).then_some((sign, digits, unit))
}

/// Whether what stands behind the number in `text` begins with a name that is no unit but satisfies `holds`.
pub(super) fn begins_with(text: &str, holds: impl Fn(&str) -> bool) -> bool {
    split(text).is_some_and(|(_, _, unit)| {
        let name = unit.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
        !is_unit(name) && holds(name)
    })
}

/// The value of `text` in SI units with its dimension, if it is a number followed by a unit.
///
/// # Errors
/// An unknown unit.
pub(super) fn quantity(text: &str) -> Option<Result<(f64, Dimension), String>> {
    let (sign, digits, unit) = split(text)?;
    Some(in_si(digits, unit).map(|(value, dimension)| (sign * value, dimension)))
}

/// The number `digits` times `unit` in SI units, with its dimension.
///
/// # Errors
/// An unknown unit, or a value that is not finite.
pub(super) fn in_si(digits: &str, unit: &str) -> Result<(f64, Dimension), String> {
    let Unit { factor, dimension } = parse(unit)?;
    let value = factor.of(digits)?;
    if value.is_finite() { Ok((value, dimension)) } else { Err("expected a finite value".into()) }
}

/// What is wrong with a value of dimension `given` where one in `unit` is expected; `None` if nothing is.
pub(super) fn mismatch(given: Dimension, unit: &str) -> Option<String> {
    let expected = Dimension::of(unit)?;
    if given == expected {
        return None;
    }
    if unit.is_empty() {
        return Some(format!("expected a pure number, without a unit; this is {given}"));
    }
    let mut plane = PER_LENGTH.iter().filter(|(space, power, _)| {
        let [m, rest @ ..] = *space;
        *space == given.0 && [&[m + power], &rest[..]].concat() == expected.0
    });
    if let Some((_, power, reason)) = plane.next() {
        let how = if *power < 0 { "divide" } else { "multiply" };
        return Some(format!(
            "this is {given}, expected a value in {unit}: in the plane {reason}; {how} by the length behind the plane"
        ));
    }
    let (name, example) = match expected.row() {
        Some((_, name, example)) => (format!("{name} [{unit}]"), (*example).to_string()),
        None => (format!("a value in {unit}"), format!("1 {unit}")),
    };
    Some(format!("this is {given}; expected {name}, such as \"{example}\""))
}

/// Whether `name` is the symbol of a unit.
pub(super) fn is_unit(name: &str) -> bool {
    symbol(name).is_some()
}

#[cfg(test)]
mod tests;
