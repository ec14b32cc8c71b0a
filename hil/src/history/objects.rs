//! Two JSON objects, such as summaries, held against each other key by key.

use std::collections::BTreeMap;

use serde_json::Value;

use super::difference::{Compared, Difference, Tolerance};

/// Keys of what was measured on a machine at a time: they differ from run to run.
const OF_THE_MACHINE: [&str; 6] = ["wall_s", "frame_us", "took_s", "date", "version", "pacing"];
/// What items of a list are called by, so that another order is no difference.
const NAMES: [&str; 3] = ["name", "trial", "interface"];

/// Holds two values against each other. Timings, dates and versions are left out.
pub fn compare_objects(a: &Value, b: &Value, tolerance: Tolerance) -> Compared {
    let (mut of_a, mut of_b) = (BTreeMap::new(), BTreeMap::new());
    flatten(a, String::new(), &mut of_a);
    flatten(b, String::new(), &mut of_b);
    let keys: std::collections::BTreeSet<&String> = of_a.keys().chain(of_b.keys()).collect();
    let mut compared = Compared {
        figures: keys.len(),
        ..Compared::default()
    };
    for key in keys {
        let (x, y) = (of_a.get(key), of_b.get(key));
        let numbers = x.zip(y).and_then(|(x, y)| x.as_f64().zip(y.as_f64()));
        let found = match numbers {
            Some((x, y)) if tolerance.equal(x, y) => continue,
            Some((x, y)) => Difference::of_numbers(key.clone(), x, y),
            None if x == y => continue,
            None => {
                let said = |v: Option<&&Value>| v.filter(|v| !v.is_null()).map(ToString::to_string);
                Difference {
                    figure: key.clone(),
                    a: said(x),
                    b: said(y),
                    change: None,
                    detail: String::new(),
                }
            }
        };
        compared.differences.push(found);
    }
    compared.concluded()
}

/// Every value that holds no other, by its path: `margins[pulse].worst`.
fn flatten<'v>(value: &'v Value, path: String, into: &mut BTreeMap<String, &'v Value>) {
    match value {
        Value::Object(all) => {
            for (key, value) in all
                .iter()
                .filter(|(key, _)| !OF_THE_MACHINE.contains(&key.as_str()))
            {
                let dot = if path.is_empty() { "" } else { "." };
                flatten(value, format!("{path}{dot}{key}"), into);
            }
        }
        Value::Array(items) => {
            for (n, value) in items.iter().enumerate() {
                let name = NAMES.iter().find_map(|name| value.get(name)?.as_str());
                let named = name.map(|name| format!("{path}[{name}]")).filter(|named| {
                    // Two of one name are told by their number.
                    !into.keys().any(|key| key.starts_with(named.as_str()))
                });
                flatten(value, named.unwrap_or_else(|| format!("{path}[{n}]")), into);
            }
        }
        leaf => drop(into.insert(path, leaf)),
    }
}

#[cfg(test)]
#[path = "objects_tests.rs"]
mod tests;
