//! The units that have a symbol, and their prefixes.

use super::Dimension;
use super::decimal::Factor;
use crate::case::error::{did_you_mean, quoted};

/// A unit: how many SI units it is.
#[derive(Clone, Debug, Default)]
pub(super) struct Unit {
    pub factor: Factor,
    pub dimension: Dimension,
}

/// Symbol, numerator, denominator and power of 10 of the factor, exponents of m, kg, s and rad, and usual prefixes.
type Row = (&'static str, u64, u64, i32, [i32; 4], &'static str);

const UNITS: &[Row] = &[
    ("m", 1, 1, 0, [1, 0, 0, 0], "kdcmµun"),
    ("s", 1, 1, 0, [0, 0, 1, 0], "mµun"),
    ("min", 60, 1, 0, [0, 0, 1, 0], ""),
    ("h", 3600, 1, 0, [0, 0, 1, 0], ""),
    ("d", 86400, 1, 0, [0, 0, 1, 0], ""),
    ("g", 1, 1, -3, [0, 1, 0, 0], "kmµun"),
    ("N", 1, 1, 0, [1, 1, -2, 0], "MkmµunG"),
    ("dyn", 1, 1, -5, [1, 1, -2, 0], ""),
    ("Pa", 1, 1, 0, [-1, 1, -2, 0], "GMkhmµun"),
    ("bar", 1, 1, 5, [-1, 1, -2, 0], "km"),
    ("atm", 101_325, 1, 0, [-1, 1, -2, 0], ""),
    ("Torr", 101_325, 760, 0, [-1, 1, -2, 0], ""),
    ("mmHg", 133_322_387_415, 1, -9, [-1, 1, -2, 0], ""),
    ("cmH2O", 980_665, 1, -4, [-1, 1, -2, 0], ""),
    ("J", 1, 1, 0, [2, 1, -2, 0], "MkmµunG"),
    ("W", 1, 1, 0, [2, 1, -3, 0], "MkmµunG"),
    ("Hz", 1, 1, 0, [0, 0, -1, 0], "GMk"),
    ("l", 1, 1, -3, [3, 0, 0, 0], "hdcmµun"),
    ("L", 1, 1, -3, [3, 0, 0, 0], "hdcmµun"),
    ("P", 1, 1, -1, [-1, 1, -1, 0], "cm"),
    ("St", 1, 1, -4, [2, 0, -1, 0], "cm"),
    ("rad", 1, 1, 0, [0, 0, 0, 1], "mµu"),
    ("deg", 1, 180, 0, [0, 0, 0, 1], ""),
    ("°", 1, 180, 0, [0, 0, 0, 1], ""),
];

/// Prefixes with their powers of 10; of the two signs for micro one is a Greek letter.
const PREFIXES: &[(char, i32)] = &[
    ('G', 9),
    ('M', 6),
    ('k', 3),
    ('h', 2),
    ('d', -1),
    ('c', -2),
    ('m', -3),
    ('µ', -6),
    ('μ', -6),
    ('u', -6),
    ('n', -9),
];

/// The unit with this symbol, with or without a prefix.
pub(super) fn symbol(name: &str) -> Option<Unit> {
    let unit = |row: &Row, prefix: i32| {
        let &(symbol, numerator, denominator, ten, dimension, _) = row;
        let pi = i32::from(matches!(symbol, "deg" | "°"));
        let factor =
            Factor { numerators: vec![numerator], denominators: vec![denominator], ten: ten + prefix, pi };
        Unit { factor, dimension: Dimension(dimension) }
    };
    if let Some(row) = UNITS.iter().find(|row| row.0 == name) {
        return Some(unit(row, 0));
    }
    let first = name.chars().next()?;
    let &(prefix, ten) = PREFIXES.iter().find(|(prefix, _)| *prefix == first)?;
    let rest = &name[prefix.len_utf8()..];
    let usual = |row: &&Row| row.0 == rest && row.5.contains(if prefix == 'μ' { 'µ' } else { prefix });
    UNITS.iter().find(usual).map(|row| unit(row, ten))
}

/// That there is no unit with the symbol `name`, and those that are like it.
pub(super) fn unknown(name: &str) -> String {
    let with_prefix =
        |row: &Row| row.5.chars().map(|prefix| format!("{prefix}{}", row.0)).collect::<Vec<_>>();
    let all: Vec<String> =
        UNITS.iter().flat_map(|row| [vec![row.0.to_string()], with_prefix(row)].concat()).collect();
    let alike = all.iter().filter(|unit| unit.to_lowercase() == name.to_lowercase()).map(String::as_str);
    let alike: Vec<&str> = alike.collect();
    let hint = match alike[..] {
        [] => did_you_mean(name, all.iter().map(String::as_str)),
        [unit] => format!("; did you mean `{unit}`?"),
        _ => format!("; did you mean one of {}?", quoted(alike)),
    };
    let hint = if hint.is_empty() { ";".into() } else { hint };
    format!("unknown unit `{name}`{hint} there are {}, with prefixes", quoted(UNITS.iter().map(|row| row.0)))
}
