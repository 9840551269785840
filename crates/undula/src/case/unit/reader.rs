//! From text to unit.

use super::Dimension;
use super::symbols::{Unit, symbol, unknown};

/// Largest exponent of a unit.
const LARGEST: i32 = 9;

/// Deepest nesting of parentheses.
const DEPTH: usize = 2;

/// Reads products of powers of units.
struct Reader<'a> {
    text: &'a str,
    position: usize,
}

/// The unit that `text` is.
pub(super) fn parse(text: &str) -> Result<Unit, String> {
    let mut reader = Reader { text, position: 0 };
    let unit = reader.product(0)?;
    match reader.rest().chars().next() {
        None => Ok(unit),
        Some(c) => Err(format!("`{c}` is not expected in the unit `{text}`")),
    }
}

/// Whether `c` is a part of an exponent in superscript.
pub(super) fn is_exponent(c: char) -> bool {
    "⁻⁰¹²³⁴⁵⁶⁷⁸⁹".contains(c)
}

impl<'a> Reader<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.position..]
    }

    /// Takes the characters that satisfy `holds`.
    fn take(&mut self, holds: impl Fn(char) -> bool) -> &'a str {
        let rest = self.rest();
        let length = rest.find(|c| !holds(c)).unwrap_or(rest.len());
        self.position += length;
        &rest[..length]
    }

    /// Factors with `*`, `/` or blanks between them, up to a closing parenthesis.
    fn product(&mut self, depth: usize) -> Result<Unit, String> {
        let mut unit = if self.rest().starts_with("1/") {
            self.position += 1;
            Unit::default()
        } else {
            self.power(depth)?
        };
        let mut divided = false;
        loop {
            let blank = !self.take(char::is_whitespace).is_empty();
            let sign = self.take(|c| "*·⋅/".contains(c));
            self.take(char::is_whitespace);
            let next = self.rest().chars().next();
            match sign {
                "" if next.is_none() || next == Some(')') || !blank => return Ok(unit),
                // Some read kg/m s as kg/(m s), others as kg s/m.
                "" if divided => {
                    let unit = self.text;
                    return Err(format!("`{unit}` has two meanings: write `a/(b c)`, `a/b/c` or `a/b*c`"));
                }
                "" | "*" | "·" | "⋅" | "/" => {}
                other => return Err(format!("`{other}` is not expected in the unit `{}`", self.text)),
            }
            let Unit { factor, dimension: Dimension(exponents) } = self.power(depth)?;
            divided = sign == "/" || (divided && sign.is_empty());
            let side = if sign == "/" { -1 } else { 1 };
            unit.factor.times(if side < 0 { factor.inverted() } else { factor });
            let sum = std::array::from_fn(|i| unit.dimension.0[i] + side * exponents[i]);
            unit.dimension = Dimension(sum);
        }
    }

    /// A symbol or a parenthesis with its exponent.
    fn power(&mut self, depth: usize) -> Result<Unit, String> {
        let text = self.text;
        let mut written = "";
        let base = if self.rest().starts_with('(') && depth < DEPTH {
            self.position += 1;
            let inner = self.product(depth + 1)?;
            if self.take(|c| c == ')').len() != 1 {
                return Err(format!("the unit `{text}` has a `(` without `)`"));
            }
            inner
        } else {
            let name = self.take(|c| (c.is_alphanumeric() && !is_exponent(c)) || c == '°');
            let plain = name.trim_end_matches(|c: char| c.is_ascii_digit());
            if name.is_empty() || (plain.is_empty() && symbol(name).is_none()) {
                return Err(format!("expected a unit in `{text}`, such as `m` or `mmHg`"));
            }
            match symbol(name) {
                Some(unit) => unit,
                None => {
                    written = &name[plain.len()..];
                    symbol(plain).ok_or_else(|| unknown(plain))?
                }
            }
        };
        let n = self.exponent(written)?;
        let mut unit = Unit::default();
        for _ in 0..n.abs() {
            let factor = base.factor.clone();
            unit.factor.times(if n < 0 { factor.inverted() } else { factor });
        }
        unit.dimension = Dimension(base.dimension.0.map(|m| m * n));
        Ok(unit)
    }

    /// The exponent at this place, or that which is `written` already; 1 if there is none.
    fn exponent(&mut self, written: &str) -> Result<i32, String> {
        let digits = if self.rest().starts_with('^') {
            self.position += 1;
            self.take(|c| c.is_ascii_digit() || c == '-').to_string()
        } else {
            let raised =
                self.take(is_exponent).chars().filter_map(|c| "⁰¹²³⁴⁵⁶⁷⁸⁹⁻".chars().position(|d| d == c));
            let plain: String = raised.map(|n| char::from_digit(n as u32, 10).unwrap_or('-')).collect();
            if plain.is_empty() && written.is_empty() { "1".into() } else { format!("{written}{plain}") }
        };
        let n = digits.parse::<i32>().ok().filter(|n| (1..=LARGEST).contains(&n.abs()));
        n.ok_or_else(|| {
            format!("expected an exponent from 1 to {LARGEST}, or the same below 0, in `{}`", self.text)
        })
    }
}
