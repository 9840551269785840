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

/// Two numbers.
pub(super) fn pair(x: &[f64; 2]) -> String {
    format!("[{}, {}]", number(x[0]), number(x[1]))
}
