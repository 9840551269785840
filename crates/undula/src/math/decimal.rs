//! Numbers as people read them.

/// `x` as a decimal number that keeps `digits` digits of a number of the size `size`.
pub fn rounded(x: f64, size: f64, digits: i32) -> f64 {
    if !size.is_normal() || !x.is_finite() {
        return x;
    }
    let decimals = digits - 1 - size.abs().log10().floor() as i32;
    if decimals >= 0 {
        return format!("{x:.*}", decimals as usize).parse().unwrap_or(x);
    }
    let unit = 10_f64.powi(-decimals);
    (x / unit).round() * unit
}

/// The shortest text of `x`: `0.25`, `4.1e-7`.
pub fn shortest(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        size if (1e-4..1e7).contains(&size) || !x.is_finite() => x.to_string(),
        _ => format!("{x:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_the_digits_that_matter() {
        let text = |x, size, digits| shortest(rounded(x, size, digits));
        assert_eq!(text(0.412_345_678, 2.5, 5), "0.4123");
        assert_eq!(text(4.123_456_78e-7, 2.5e-6, 5), "4.123e-7");
        assert_eq!(text(-1e-18, 2.5e-6, 5), "0");
        assert_eq!(text(0.367_062_5, 6.25e-5, 3), "0.3670625");
        assert_eq!(text(123_456.789, 2e5, 3), "123000");
        assert_eq!(text(0.1 + 0.2, 0.1, 3), "0.3");
        assert_eq!(text(f64::NAN, 1.0, 3), "NaN");
        assert_eq!(text(0.5, 0.0, 3), "0.5");
    }
}
