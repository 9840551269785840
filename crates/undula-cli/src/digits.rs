//! Numbers with enough digits, whatever unit they are in.

/// `x` with at least `decimals` decimals; more where they would show fewer than four digits of a number of size `size`.
pub fn fixed(x: f64, size: f64, decimals: usize) -> String {
    let needed = if size.is_normal() { 3.0 - size.abs().log10().floor() } else { 0.0 };
    format!("{x:.*}", decimals.max(needed.max(0.0) as usize))
}

#[cfg(test)]
mod tests {
    use super::fixed;

    #[test]
    fn small_numbers_keep_their_digits() {
        assert_eq!(fixed(3.0, 10.0, 3), "3.000");
        assert_eq!(fixed(2e-5, 1e-3, 3), "0.000020");
        assert_eq!(fixed(2.5e-9, 2.5e-9, 4), "0.000000002500");
        assert_eq!([fixed(0.0, 0.0, 4), fixed(123_456.789, 123_456.789, 2)], ["0.0000", "123456.79"]);
    }
}
