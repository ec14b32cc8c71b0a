//! Two JSON objects, such as summaries, held against each other key by key.

use std::collections::BTreeMap;

use palpate_records::runs::{WEIGHTIEST, by_weight, values};
use serde_json::Value;

use super::difference::{Compared, Difference, Named, Tolerance};

/// Keys of what was measured on a machine at a time: they differ from run to run.
const OF_THE_MACHINE: [&str; 6] = ["wall_s", "frame_us", "took_s", "date", "version", "pacing"];
/// Keys that name the items of a list, so that another order is no difference.
const NAMES: [&str; 4] = ["name", "trial", "interface", "state"];
/// Places of a summary that repeat the value of another place, each with that place.
const TWINS: [(&str, &str); 7] = [
    ("/felt/error_energy_mm", "/felt_error_mm"),
    ("/felt/error_amplitude_mm", "/felt_error_amplitude_mm"),
    ("/felt/error_energy_all_mm", "/felt_error_mm/everywhere"),
    (
        "/felt/error_amplitude_all_mm",
        "/felt_error_amplitude_mm/everywhere",
    ),
    ("/felt/onsets_inside", "/felt_error_mm/onsets"),
    ("/felt/breaks", "/felt_error_mm/breaks"),
    ("/felt/jumps", "/felt_error_mm/jumps"),
];
/// Keys of a margin that follow from its other keys.
const OF_A_MARGIN: [&str; 2] = ["margin", "used"];

/// A value that holds no other, and its unit where its key or what it lies in says so.
struct Leaf<'v> {
    value: &'v Value,
    unit: &'v str,
}

/// Holds two values against each other. Timings, dates and versions are left out, and what says the same twice counts once.
pub fn compare_objects(a: &Value, b: &Value, tolerance: Tolerance) -> Compared {
    let (mut of_a, mut of_b) = (BTreeMap::new(), BTreeMap::new());
    flatten((a, ""), String::new(), &mut of_a);
    flatten((b, ""), String::new(), &mut of_b);
    for (twin, other) in TWINS {
        if [a, b].iter().all(|object| object.pointer(other).is_some()) {
            let twin = twin.trim_start_matches('/').replace('/', ".");
            let is_it = |key: &String| {
                let rest = key.strip_prefix(&*twin);
                rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
            };
            of_a.retain(|key, _| !is_it(key));
            of_b.retain(|key, _| !is_it(key));
        }
    }
    let keys: std::collections::BTreeSet<&String> = of_a.keys().chain(of_b.keys()).collect();
    let mut compared = Compared {
        figures: keys.len(),
        named: named(a, b, tolerance),
        ..Compared::default()
    };
    for key in keys {
        let (x, y) = (of_a.get(key), of_b.get(key));
        let numbers = x.zip(y);
        let numbers = numbers.and_then(|(x, y)| x.value.as_f64().zip(y.value.as_f64()));
        let unit = x.or(y).map_or("", |leaf| leaf.unit);
        let found = match numbers {
            Some((x, y)) if tolerance.equal(x, y) => continue,
            Some(both) => Difference::of_numbers(key.clone(), both, unit),
            None if x.map(|x| x.value) == y.map(|y| y.value) => continue,
            None => {
                let said = |leaf: Option<&Leaf<'_>>| {
                    let value = leaf.map(|leaf| leaf.value).filter(|v| !v.is_null());
                    value.map(ToString::to_string)
                };
                Difference {
                    figure: key.clone(),
                    a: said(x),
                    b: said(y),
                    ..Difference::default()
                }
            }
        };
        compared.differences.push(found);
    }
    compared.concluded()
}

/// The figures of two summaries that have a name; none of other objects.
fn named(a: &Value, b: &Value, tolerance: Tolerance) -> Vec<Named> {
    if ![a, b].iter().all(|object| object["margins"].is_array()) {
        return Vec::new();
    }
    let of = [&values(a), &values(b)];
    let weighty = by_weight().take(WEIGHTIEST.len());
    weighty
        .filter_map(|measured| Named::compare(measured, of, tolerance))
        .collect()
}

/// The unit that a key ends with, as far as it decides how a difference is told.
fn unit_of(key: &str) -> Option<&'static str> {
    let units = [("_db", "dB"), ("_c", "\u{b0}C"), ("_percent", "%")];
    let unit = units.iter().find(|(ending, _)| key.ends_with(ending));
    unit.map(|(_, unit)| *unit)
}

/// Every value that holds no other, by its path: `margins[pulse].worst`.
fn flatten<'v>(
    (value, unit): (&'v Value, &'v str),
    path: String,
    into: &mut BTreeMap<String, Leaf<'v>>,
) {
    match value {
        Value::Object(all) => {
            let unit = all.get("unit").and_then(Value::as_str).unwrap_or(unit);
            let is_margin = all.contains_key("worst") && all.contains_key("limit");
            for (key, value) in all {
                let derived = is_margin && OF_A_MARGIN.contains(&key.as_str());
                if derived || OF_THE_MACHINE.contains(&key.as_str()) {
                    continue;
                }
                let dot = if path.is_empty() { "" } else { "." };
                let unit = unit_of(key).unwrap_or(unit);
                flatten((value, unit), format!("{path}{dot}{key}"), into);
            }
        }
        Value::Array(items) => {
            for (n, value) in items.iter().enumerate() {
                let named = name(value).map(|name| format!("{path}[{name}]"));
                let named = named.filter(|named| {
                    // Two of one name are told by their number.
                    !into.keys().any(|key| key.starts_with(named.as_str()))
                });
                let path = named.unwrap_or_else(|| format!("{path}[{n}]"));
                flatten((value, unit), path, into);
            }
        }
        value => drop(into.insert(path, Leaf { value, unit })),
    }
}

/// Own name of an item of a list.
fn name(item: &Value) -> Option<&str> {
    NAMES.iter().find_map(|name| item.get(name)?.as_str())
}

#[cfg(test)]
#[path = "objects_tests.rs"]
mod tests;
