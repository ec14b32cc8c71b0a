//! Keeps `fixtures/schemas` current: run the tests with `PALPATE_WRITE_SCHEMAS=1` to write them anew.

use std::path::Path;

use schemars::Schema;
use schemars::transform::{RecursiveTransform, Transform};
use serde_json::Value;

use super::limits::Limiting;
use super::{
    ActivationFile, AlloyFile, BandFile, Bench, EvidenceFile, LayoutFile, PersonFile, PriorsFile,
    Protocol, Quarantine, Recipe, Scene, TextureTable, Wearer, WireFile,
};

/// A key that may be left out altogether has no default to speak of, and neither has a name.
fn only_stated_defaults(schema: &mut Schema) {
    let none = |value: &Value| value.is_null() || value.as_str() == Some("");
    if schema.get("default").is_some_and(none) {
        schema.remove("default");
    }
}

#[test]
fn shipped_schemas_are_current() {
    let schemas = [
        ("activation", schemars::schema_for!(ActivationFile)),
        ("alloy", schemars::schema_for!(AlloyFile)),
        ("band", schemars::schema_for!(BandFile)),
        ("bench", schemars::schema_for!(Bench)),
        ("evidence", schemars::schema_for!(EvidenceFile)),
        ("layout", schemars::schema_for!(LayoutFile)),
        ("limits", schemars::schema_for!(Limiting)),
        ("person", schemars::schema_for!(PersonFile)),
        ("priors", schemars::schema_for!(PriorsFile)),
        ("protocol", schemars::schema_for!(Protocol)),
        ("quarantine", schemars::schema_for!(Quarantine)),
        ("recording", schemars::schema_for!(Recipe)),
        ("scene", schemars::schema_for!(Scene)),
        ("textures", schemars::schema_for!(TextureTable)),
        ("wearer", schemars::schema_for!(Wearer)),
        ("wire", schemars::schema_for!(WireFile)),
    ];
    for (name, mut schema) in schemas {
        RecursiveTransform(only_stated_defaults).transform(&mut schema);
        let text = serde_json::to_string_pretty(&schema).unwrap() + "\n";
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/schemas");
        let path = folder.join(format!("{name}.json"));
        if std::env::var_os("PALPATE_WRITE_SCHEMAS").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        let shipped = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            shipped == text,
            "{} is out of date: run the tests with PALPATE_WRITE_SCHEMAS=1",
            path.display()
        );
    }
}
