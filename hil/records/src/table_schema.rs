//! Meaning of the columns of a CSV: types, units and words as a Frictionless Table Schema, a file beside the table, so
//! that no reader has to guess.

use serde::Serialize;

use crate::contacts_csv;
use crate::trace::Header;

/// Version of the columns' meaning; grows when one changes what it says.
pub const VERSION: u32 = 1;

/// A column: name, type (integer, number or string), unit (UCUM; 1 for a count) and what it says.
type Column = (&'static str, &'static str, &'static str, &'static str);

/// The columns of the contacts, in their order.
const CONTACTS: [Column; 10] = [
    (
        "frame",
        "integer",
        "1",
        "Zero-based number of the driving module's scan",
    ),
    (
        "time_us",
        "integer",
        "us",
        "End of the scan since the start of the run",
    ),
    ("module", "integer", "1", "Zero-based module of the layout"),
    (
        "contact",
        "integer",
        "1",
        "Identity that stays with a contact from frame to frame",
    ),
    (
        "x_mm",
        "number",
        "mm",
        "Place to the right of the module's centre",
    ),
    ("y_mm", "number", "mm", "Place above the module's centre"),
    (
        "intensity",
        "number",
        "1",
        "Interpolated relative reading, raw counts",
    ),
    ("level", "integer", "1", "Intensity level from 1 to K_I"),
    ("members", "integer", "1", "Taxels in the contact's cluster"),
    // Of a run with several displays alone.
    (
        contacts_csv::DISPLAY,
        "string",
        "1",
        "Display that the module belongs to",
    ),
];

#[derive(Serialize)]
struct Field {
    name: &'static str,
    r#type: &'static str,
    unit: &'static str,
    description: &'static str,
    constraints: Constraints,
}

#[derive(Serialize)]
struct Constraints {
    required: bool,
}

#[derive(Serialize)]
struct Schema<'a> {
    #[serde(rename = "$schema")]
    standard: &'static str,
    version: u32,
    #[serde(flatten)]
    run: Option<Run<'a>>,
    fields: Vec<Field>,
}

/// Origin of the table; a table of `hil contacts` has no run.
#[derive(Serialize)]
struct Run<'a> {
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
    let names = contacts_csv::HEADER
        .split(',')
        .chain([contacts_csv::DISPLAY]);
    debug_assert!(names.eq(CONTACTS.iter().map(|c| c.0)));
    let several = header.is_some_and(|h| !h.displays.is_empty());
    let columns = CONTACTS.len() - usize::from(!several);
    let schema = Schema {
        standard: "https://datapackage.org/profiles/2.0/tableschema.json",
        version: VERSION,
        run: header.map(|h| Run {
            source: h.source,
            banner: h.source.banner(),
            scene: &h.scene,
            bench: &h.bench,
            seed: h.seed,
            scene_digest: &h.scene_digest,
            limits_digest: &h.limits_digest,
        }),
        fields: CONTACTS[..columns]
            .iter()
            .map(|&(name, r#type, unit, description)| Field {
                name,
                r#type,
                unit,
                description,
                constraints: Constraints { required: true },
            })
            .collect(),
    };
    // Plain structs of strings and integers: there is nothing that JSON could refuse.
    serde_json::to_string_pretty(&schema).unwrap_or_default() + "\n"
}

#[cfg(test)]
#[path = "table_schema_tests.rs"]
mod tests;
