//! Keys of a kind of file by its schema, and values that stand in for a key while the rest of a broken file is read.

use serde_json::Value;

use super::change::{Step, steps};
use super::resolve::FileKind;

/// The schema of a kind of file.
pub(super) fn schema(kind: FileKind) -> Option<Value> {
    let text = palpate_fixtures::schema(kind.name())?;
    serde_json::from_str(text).ok()
}

/// The names of the keys at the top of such files.
pub(super) fn top_keys(schema: &Value) -> Vec<&str> {
    let tables = shapes(schema, schema).into_iter();
    let tables = tables.filter_map(|table| table["properties"].as_object());
    tables.flatten().map(|(key, _)| key.as_str()).collect()
}

/// Largest depth of keys in tables.
const DEEPEST: usize = 5;

/// The keys of a kind of file by their full paths, outer ones first; one of an array's tables stands for all.
#[must_use]
pub fn keys(kind: FileKind) -> Vec<String> {
    let schema = &schema(kind).unwrap_or_default();
    let mut found = Vec::new();
    let mut layer = vec![(String::new(), schema)];
    for _ in 0..DEEPEST {
        let mut next = Vec::new();
        for (path, here) in layer {
            let shapes = shapes(schema, here).into_iter();
            for (name, inner) in shapes.filter_map(|s| s["properties"].as_object()).flatten() {
                let key = match &*path {
                    "" => name.clone(),
                    path => format!("{path}.{name}"),
                };
                next.push((key.clone(), inner));
                let items = shapes_of_items(schema, inner);
                next.extend(items.map(|items| (format!("{key}[0]"), items)));
                found.push(key);
            }
        }
        layer = next;
    }
    found
}

/// Shapes of an array's items, behind a reference or among choices.
fn shapes_of_items<'s>(root: &'s Value, here: &'s Value) -> Option<&'s Value> {
    shapes(root, here).into_iter().find_map(|s| s.get("items"))
}

/// Values as TOML writes them that could stand at `key`, the likeliest first.
pub(super) fn placeholders(schema: &Value, key: &str) -> Vec<String> {
    let mut here = schema;
    for step in steps(key) {
        let found = shapes(schema, here);
        let found = found.into_iter().find_map(|shape| inside(shape, &step));
        here = found.unwrap_or(&Value::Null);
    }
    let stated = toml_text(&here["default"]);
    stated
        .into_iter()
        .chain(examples(schema, here, 0))
        .collect()
}

/// The schema of a step into a table or an array.
fn inside<'s>(shape: &'s Value, step: &Step<'_>) -> Option<&'s Value> {
    match step {
        Step::Key(name) => shape["properties"].get(name),
        Step::Index(_) => shape.get("items"),
    }
}

/// Schemas that describe a value: its own, the one that it refers to, or its choices.
fn shapes<'s>(root: &'s Value, here: &'s Value) -> Vec<&'s Value> {
    let name = |at: &'s Value| at["$ref"].as_str().and_then(|r| r.rsplit('/').next());
    let follow = |at: &'s Value| name(at).map_or(at, |name| &root["$defs"][name]);
    let here = follow(here);
    match here["anyOf"].as_array() {
        Some(choices) => choices.iter().map(follow).collect(),
        None => vec![here],
    }
}

fn toml_text(value: &Value) -> Option<String> {
    match value {
        Value::Null | Value::Object(_) => None,
        other => Some(other.to_string()),
    }
}

/// Values of a schema's type; `deep` bounds tables within tables.
fn examples(root: &Value, here: &Value, deep: usize) -> Vec<String> {
    let Some(here) = shapes(root, here).into_iter().next() else {
        return Vec::new();
    };
    let choices = here["oneOf"].as_array().into_iter().flatten();
    let named: Vec<String> = choices.filter_map(|c| toml_text(&c["const"])).collect();
    if !named.is_empty() || deep > 3 {
        return named;
    }
    if let Some(words) = here["enum"].as_array() {
        return words.iter().filter_map(toml_text).collect();
    }
    let kinds = &here["type"];
    let kind = kinds
        .as_str()
        .or_else(|| kinds.as_array()?.first()?.as_str());
    let texts: &[&str] = match kind {
        Some("number") => &["1.0", "0.5", "10.0", "100.0", "0.0"],
        Some("integer") => &["1", "0", "64"],
        Some("boolean") => &["false"],
        Some("string") => &["\"x\""],
        Some("array") => {
            let least = here["minItems"].as_u64().unwrap_or(0);
            let item = examples(root, &here["items"], deep + 1);
            let item = item.first().map_or("0", String::as_str);
            let of = |n: u64| format!("[{}]", vec![item; n as usize].join(", "));
            return [least, 1, 2].into_iter().map(of).collect();
        }
        Some("object") => return table(root, here, deep).into_iter().collect(),
        _ => &[],
    };
    texts.iter().map(|&text| text.to_owned()).collect()
}

/// A table with the keys that it must have.
fn table(root: &Value, here: &Value, deep: usize) -> Option<String> {
    let required = here["required"].as_array().into_iter().flatten();
    let mut entries = Vec::new();
    for key in required.filter_map(Value::as_str) {
        let value = examples(root, &here["properties"][key], deep + 1);
        entries.push(format!("{key} = {}", value.first()?));
    }
    Some(format!("{{ {} }}", entries.join(", ")))
}
