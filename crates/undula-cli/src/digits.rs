//! Numbers with enough digits, whatever unit they are in.

/// `x` with at least `decimals` decimals; more where they would show fewer than four digits of a number of size `size`.
pub fn fixed(x: f64, size: f64, decimals: usize) -> String {
    let needed = if size.is_normal() { 3.0 - size.abs().log10().floor() } else { 0.0 };
    format!("{x:.*}", decimals.max(needed.max(0.0) as usize))
}

/// `x` with `digits` significant digits, without zeros at the end.
pub fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let rounded: f64 = format!("{x:.*e}", digits.saturating_sub(1)).parse().unwrap_or(x);
    if (1e-4..1e6).contains(&rounded.abs()) { rounded.to_string() } else { format!("{rounded:e}") }
}

/// `x` among numbers of size `size`, with up to `digits` digits of those: 0 where it is rounding.
pub fn among(x: f64, size: f64, digits: usize) -> String {
    if !size.is_normal() {
        return significant(x, digits);
    }
    let unit = 10f64.powi(size.abs().log10().floor() as i32 + 1 - digits as i32);
    if (x / unit).round() == 0.0 { "0".into() } else { significant(x, digits) }
}

#[cfg(test)]
mod tests {
    use super::{among, fixed, significant};

    #[test]
    fn rounding_among_larger_numbers_is_zero() {
        assert_eq!([among(-1.98326e-9, 0.4, 6), among(0.205, 0.4, 6)], ["0", "0.205"]);
        assert_eq!([among(-1.98326e-9, 1e-8, 6), among(0.0, 0.0, 6)], ["-1.98326e-9", "0"]);
    }

    #[test]
    fn significant_digits_are_counted_from_the_first() {
        assert_eq!([significant(8.412_345, 4), significant(0.034_999_9, 4)], ["8.412", "0.035"]);
        assert_eq!([significant(-1.5e-7, 3), significant(123_456.0, 3)], ["-1.5e-7", "123000"]);
        assert_eq!([significant(0.0, 3), significant(f64::NAN, 3)], ["0", "NaN"]);
    }

    #[test]
    fn small_numbers_keep_their_digits() {
        assert_eq!(fixed(3.0, 10.0, 3), "3.000");
        assert_eq!(fixed(2e-5, 1e-3, 3), "0.000020");
        assert_eq!(fixed(2.5e-9, 2.5e-9, 4), "0.000000002500");
        assert_eq!([fixed(0.0, 0.0, 4), fixed(123_456.789, 123_456.789, 2)], ["0.0000", "123456.79"]);
    }
}
