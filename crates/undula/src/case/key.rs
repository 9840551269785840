//! A key of a case; dotted keys such as `boundary."solid.flap".condition`, whose parts are quoted where TOML needs it.

use crate::choice::Table;
use toml::de::DeValue;

/// A key of a case.
pub struct Key {
    /// Its tables and its name, with dots between them. `NAME` stands for a name that the case chooses.
    pub key: &'static str,
    /// SI unit; empty for words and pure numbers.
    pub unit: &'static str,
    /// The value that holds without the key, or where it comes from; `none`: nothing; `required`: there is none.
    pub default: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    pub(super) choices: Option<&'static dyn Table>,
}

impl Key {
    /// A key with numbers or expressions.
    pub(super) const fn data(
        key: &'static str,
        unit: &'static str,
        default: &'static str,
        about: &'static str,
    ) -> Key {
        Key { key, unit, default, about, choices: None }
    }
}

/// A part of a key in the table that stands for any name.
pub(super) const NAME: &str = "NAME";

/// All `keys`, those of fluids and solids once more for each of several: `solid.NAME.density` as `solid.density`.
pub(super) fn with_named(mut keys: Vec<&'static Key>) -> Vec<&'static Key> {
    for kind in ["fluid", "solid"] {
        let of_kind =
            |key: &Key| key.key.split_once('.').filter(|(table, _)| *table == kind).map(|(_, name)| name);
        let named = |key: &&'static Key| -> Option<&'static Key> {
            let name = of_kind(key)?;
            let default = if name == "region" { NAME } else { key.default };
            let key = Key { key: format!("{kind}.{NAME}.{name}").leak(), default, ..**key };
            Some(Box::leak(Box::new(key)))
        };
        let all: Vec<&'static Key> = keys.iter().filter_map(named).collect();
        let end = keys.iter().rposition(|key| of_kind(key).is_some()).map_or(0, |last| last + 1);
        keys.splice(end..end, all);
    }
    keys
}

/// One part of a key, in quotes unless it is of letters, digits, `-` and `_` only.
pub(crate) fn quote(part: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if !part.is_empty() && part.chars().all(bare) {
        return part.into();
    }
    let escape = |c: char| match c {
        '"' | '\\' => format!("\\{c}"),
        c if c.is_control() => format!("\\u{:04X}", u32::from(c)),
        c => c.to_string(),
    };
    format!("\"{}\"", part.chars().map(escape).collect::<String>())
}

/// `path` with one part more.
pub(crate) fn join(path: &str, part: &str) -> String {
    if path.is_empty() { quote(part) } else { format!("{path}.{}", quote(part)) }
}

/// The key without its last part, `None` of one part.
pub(crate) fn parent(key: &str) -> Option<&str> {
    outside_quotes(key).filter(|(_, c)| *c == '.').last().map(|(i, _)| &key[..i])
}

/// The parts of a dotted key, in quotes where they are written so.
pub(crate) fn parts(key: &str) -> Vec<&str> {
    let mut parts = vec![];
    let mut begin = 0;
    for (dot, _) in outside_quotes(key).filter(|(_, c)| *c == '.') {
        parts.push(&key[begin..dot]);
        begin = dot + 1;
    }
    parts.push(&key[begin..]);
    parts
}

/// Keys of which `none` is a value like others: an override gives it and does not remove the key.
pub const WITH_NONE: [&str; 2] = ["stabilization.map", "boundary.NAME.backflow"];

/// Whether the key of these parts is one of them.
pub(super) fn takes_none(parts: &[String]) -> bool {
    let is = |key: &str| {
        key.split('.').count() == parts.len()
            && key.split('.').zip(parts).all(|(of, part)| of == NAME || of == part)
    };
    WITH_NONE.into_iter().any(is)
}

/// The parts of the key before the first `=` of an override, and the value behind it.
///
/// # Errors
/// What would be right.
pub(crate) fn split_override(text: &str) -> Result<(Vec<String>, &str), String> {
    let Some((equals, _)) = outside_quotes(text).find(|(_, c)| *c == '=') else {
        return Err("expected key=value, such as `time.step=0.01`".into());
    };
    let key = &text[..equals];
    let dots = outside_quotes(key).filter(|(_, c)| *c == '.').map(|(i, _)| i).chain([equals]);
    let mut parts = vec![];
    let mut begin = 0;
    for end in dots {
        let text = key[begin..end].trim();
        parts.push(part(text).ok_or_else(|| {
            let rule = "; a part with other characters than letters, digits, `-` and `_` stands in quotes, as in \
                        'boundary.\"in let\".condition=no-slip'";
            format!(
                "expected a dotted key before `=`, such as `time.step`{}",
                if text.is_empty() { "" } else { rule }
            )
        })?);
        begin = end + 1;
    }
    Ok((parts, &text[equals + 1..]))
}

/// One part as it is written.
fn part(text: &str) -> Option<String> {
    if text.starts_with(['"', '\'']) {
        return match DeValue::parse(text).ok()?.get_ref() {
            DeValue::String(s) => Some(s.to_string()),
            _ => None,
        };
    }
    let bare = !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || c == '-' || c == '_');
    bare.then(|| text.to_string())
}

/// The characters of `text` that are not in quotes, with their bytes.
fn outside_quotes(text: &str) -> impl Iterator<Item = (usize, char)> + '_ {
    let (mut quote, mut escaped) = (None, false);
    text.char_indices().filter(move |&(_, c)| {
        match quote {
            Some(_) if escaped => escaped = false,
            Some('"') if c == '\\' => escaped = true,
            Some(open) if c == open => quote = None,
            Some(_) => {}
            None if c == '"' || c == '\'' => quote = Some(c),
            None => return true,
        }
        false
    })
}

/// A key with a number or an array of numbers.
pub(super) const fn number(
    key: &'static str,
    unit: &'static str,
    default: &'static str,
    about: &'static str,
) -> Key {
    Key::data(key, unit, default, about)
}

/// A key with a text.
pub(super) const fn text(key: &'static str, default: &'static str, about: &'static str) -> Key {
    number(key, "", default, about)
}

/// A key with one of the names of a table.
pub(super) const fn word(
    key: &'static str,
    choices: &'static dyn Table,
    default: &'static str,
    about: &'static str,
) -> Key {
    Key { key, unit: "", default, about, choices: Some(choices) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_survive_quoting() {
        for name in
            ["walls", "in let", "solid.flap", "a=b", "\"", "\\", "Einströmung", "a'b", "tab\t", "in|et"]
        {
            let text = format!("{}.condition=no-slip", join("boundary", name));
            let (parts, value) = split_override(&text).unwrap();
            assert_eq!((parts, value), (vec!["boundary".into(), name.into(), "condition".into()], "no-slip"));
            let key = join(&join("boundary", name), "condition");
            assert_eq!(self::parts(&key), ["boundary", &quote(name), "condition"]);
            assert_eq!(parent(&key), Some(&*join("boundary", name)));
            assert_eq!(parent(&join("boundary", name)), Some("boundary"));
        }
        assert_eq!(parent("boundary"), None);
        let (parts, value) = split_override("boundary.'a.b' . Einströmung = \"x=y\"").unwrap();
        assert_eq!((parts.concat(), value), ("boundarya.bEinströmung".into(), " \"x=y\""));
        for wrong in ["a", "=1", "a..b=1", "a b=1", "\"a=1", "a.\"b\"c=1", "a\"b\"=1"] {
            assert!(split_override(wrong).is_err(), "{wrong}");
        }
    }
}
