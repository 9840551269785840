//! The JSON Schema of case files, from the table of keys: editors complete keys and values with it, and mark unknown ones.

use serde_json::{Map, Value, json};
use undula::case::keys::{KEYS, Key};

/// Stands for a name that a case chooses.
const NAME: &str = "NAME";

/// The schema, draft 7, which editors for TOML read.
///
/// Keys and names of values are those of the program. Numbers may be texts, with a unit or as an expression, so that
/// their types say little: `undula check` says the rest.
pub fn schema() -> Value {
    let mut whole = table();
    whole["$schema"] = json!("http://json-schema.org/draft-07/schema#");
    whole["title"] = json!("Case of Undula");
    for key in KEYS.iter() {
        let parts: Vec<&str> = key.key.split('.').collect();
        let Some((last, tables)) = parts.split_last() else { continue };
        let mut place = &mut whole;
        for part in tables {
            place = child(place, part);
        }
        match *last {
            NAME => place["additionalProperties"] = of_key(key),
            last => place["properties"][last] = of_key(key),
        }
    }
    whole
}

/// A table without keys so far.
fn table() -> Value {
    json!({ "type": "object", "properties": {}, "additionalProperties": false })
}

/// The table of a name within a table.
fn child<'a>(place: &'a mut Value, part: &str) -> &'a mut Value {
    if part == NAME {
        if !place["additionalProperties"].is_object() {
            place["additionalProperties"] = table();
        }
        return &mut place["additionalProperties"];
    }
    let properties = place["properties"].as_object_mut();
    properties.expect("a table has properties").entry(part).or_insert_with(table)
}

fn of_key(key: &Key) -> Value {
    let unit = if key.unit.is_empty() { String::new() } else { format!(" [{}]", key.unit) };
    let mut about = Map::new();
    let text = format!("{}{unit}; default: {}", key.about, key.default);
    about.insert("description".into(), json!(text));
    let choices = key.choices();
    let types = if choices.is_empty() {
        // Numbers, numbers with units, expressions, pairs of these, and what is smaller than a table.
        json!({ "type": ["number", "string", "boolean", "array", "object"] })
    } else {
        let names: Vec<Value> =
            choices.iter().map(|(name, about)| json!({ "const": name, "description": about })).collect();
        let list = json!({ "type": "array", "items": { "anyOf": names } });
        // Some take a number or `none` instead of a name.
        json!({ "anyOf": [{ "anyOf": names }, list, { "const": "none" }, { "type": ["number", "boolean", "object"] }] })
    };
    about.extend(types.as_object().cloned().unwrap_or_default());
    Value::Object(about)
}
