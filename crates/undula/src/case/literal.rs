//! Numbers and words as TOML writes them.

/// Shortest decimal that reads back as `x`, always with a point or exponent.
pub(crate) fn number(x: f64) -> String {
    if x.is_nan() {
        return "nan".into();
    }
    if x.is_infinite() {
        return if x > 0.0 { "inf".into() } else { "-inf".into() };
    }
    let size = x.abs();
    if size != 0.0 && !(1e-3..1e7).contains(&size) {
        let text = format!("{x:e}");
        return if text.contains('.') { text } else { text.replace('e', ".0e") };
    }
    format!("{x:?}")
}

/// In quotes, with what TOML escapes.
pub(crate) fn string(s: &str) -> String {
    toml::Value::from(s).to_string()
}

/// An array of numbers.
pub(super) fn numbers(x: &[f64]) -> String {
    format!("[{}]", x.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", "))
}

/// Bytes of the number literal at the start of `bytes`.
pub(crate) fn number_length(bytes: &[u8]) -> usize {
    let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let mut length = digits(0);
    if bytes.get(length) == Some(&b'.') {
        length += 1;
        length += digits(length);
    }
    if matches!(bytes.get(length), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(length + 1), Some(b'+' | b'-')));
        if bytes.get(length + 1 + sign).is_some_and(u8::is_ascii_digit) {
            length += 1 + sign;
            length += digits(length);
        }
    }
    length
}
