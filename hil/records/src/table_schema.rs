//! Meaning of the columns of a CSV: types, units and words as a Frictionless Table Schema, a file beside the table, so
//! that no reader has to guess.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::contacts_csv;
use crate::trace::Header;

/// Version of the columns' meaning; grows when one changes what it says.
pub const VERSION: u32 = 1;

/// The columns of the contacts, in their order; the last is of a run with several displays alone.
const CONTACTS: &str = include_str!("contacts_schema.json");

/// A column: its name, type, unit (UCUM; 1 for a count) and what it says.
#[derive(Serialize, Deserialize)]
struct Field {
    name: &'static str,
    r#type: &'static str,
    unit: &'static str,
    description: &'static str,
    constraints: BTreeMap<&'static str, bool>,
}

#[derive(Serialize)]
struct Schema<'a> {
    #[serde(rename = "$schema")]
    standard: &'static str,
    version: u32,
    #[serde(flatten)]
    run: Option<Origin<'a>>,
    fields: Vec<Field>,
}

/// Origin of the table; a table of `hil contacts` has no run.
#[derive(Serialize)]
struct Origin<'a> {
    source: crate::trace::Source,
    #[serde(skip_serializing_if = "Option::is_none")]
    banner: Option<&'static str>,
    scene: &'a str,
    bench: &'a str,
    seed: u64,
    scene_digest: &'a str,
    limits_digest: &'a str,
}

/// The schema of a contacts CSV, as JSON.
pub fn contacts_schema(header: Option<&Header>) -> String {
    let mut fields: Vec<Field> = serde_json::from_str(CONTACTS).unwrap_or_default();
    let names = contacts_csv::HEADER
        .split(',')
        .chain([contacts_csv::DISPLAY]);
    debug_assert!(names.eq(fields.iter().map(|f| f.name)));
    if header.is_none_or(|h| h.displays.is_empty()) {
        fields.pop();
    }
    let schema = Schema {
        standard: "https://datapackage.org/profiles/2.0/tableschema.json",
        version: VERSION,
        run: header.map(|h| Origin {
            source: h.source,
            banner: h.source.banner(),
            scene: &h.scene,
            bench: &h.bench,
            seed: h.seed,
            scene_digest: &h.scene_digest,
            limits_digest: &h.limits_digest,
        }),
        fields,
    };
    // Plain structs of strings and integers: there is nothing that JSON could refuse.
    serde_json::to_string_pretty(&schema).unwrap_or_default() + "\n"
}

#[cfg(test)]
#[path = "table_schema_tests.rs"]
mod tests;
