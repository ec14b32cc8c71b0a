//! Every key of a bench, changed on hardware and on an emulated bench.

use std::path::Path;

use serde_json::Value;

use super::*;

/// A bench of hardware.
const REAL: &str = r#"
name = "real"
description = "Hardware"
kind = "real"
display = "three-in-line"
limits = "default"
wire = { kind = "final-75um", alloy = "low" }

[real]
can = ["can0"]
i2c = ["/dev/i2c-1"]

[drive]
current_ma = 1970.0
supply_limit_ma = 4000.0

[[outputs]]
board = 0x40
channel = 0

[[outputs]]
board = 0x40
channel = 1

[[outputs]]
board = 0x40
channel = 2
"#;

fn bench(text: &str) -> Loaded<Bench> {
    let source = Source::new("real.toml", text);
    let value = Bench::read(&source).unwrap();
    Loaded { value, source }
}

fn set(bench: &str, key: &str, value: &str) -> Result<Loaded<Bench>, FileError> {
    let mut overrides = Overrides::default();
    overrides.bench("--set", key, value);
    self::bench(bench).with(&overrides)
}

/// Every key that a bench can have, with those of tables inside it and of the first entry of a list.
fn keys() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/schemas/bench.json");
    let schema = std::fs::read_to_string(folder).unwrap();
    let schema: Value = serde_json::from_str(&schema).unwrap();
    let (mut keys, mut pending) = (Vec::new(), vec![(String::new(), schema.clone())]);
    while let Some((key, of)) = pending.pop() {
        let referred = |of: &Value| {
            let name = of["$ref"].as_str()?.rsplit('/').next()?;
            Some(schema["$defs"][name].clone())
        };
        let either = of["anyOf"].as_array().into_iter().flatten();
        let more = either.chain([&of]).filter_map(referred);
        pending.extend(more.map(|of| (key.clone(), of)));
        if of["items"].is_object() {
            pending.push((format!("{key}[0]"), of["items"].clone()));
        }
        for (name, inner) in of["properties"].as_object().into_iter().flatten() {
            let dot = if key.is_empty() { "" } else { "." };
            let inside = format!("{key}{dot}{name}");
            keys.push(inside.clone());
            pending.push((inside, inner.clone()));
        }
    }
    keys.sort();
    keys.dedup();
    keys
}

#[test]
fn on_hardware_every_key_but_a_limit_and_an_address_is_a_fact() {
    let keys = keys();
    for needed in [
        "drive.current_ma",
        "outputs[0].channel",
        "displays[0].outputs[0].board",
        "dac.addresses",
    ] {
        assert!(keys.iter().any(|key| key == needed), "{needed}: {keys:?}");
    }
    assert!(keys.len() > 60, "{keys:?}");
    for key in keys {
        let mut permitted = LIMITS.iter().chain(&ADDRESSES).chain(&CHOICES);
        let may = permitted.any(|permitted| *permitted == key);
        for value in ["1", "10.0", "\"x\"", "true", "{}"] {
            let refused = set(REAL, &key, value).err();
            let fact = refused.as_ref().is_some_and(|error| {
                error.expected == FACT
                    && error.path == "--set"
                    && error.key.as_deref() == Some(&*key)
            });
            assert_eq!(fact, !may, "{key} = {value}: {refused:?}");
        }
    }
    // A whole table, an index, and the text that the file has.
    for (key, value) in [
        ("drive", "{ current_ma = 10.0, supply_limit_ma = 4000.0 }"),
        ("outputs[0]", "{ board = 0x41, channel = 0 }"),
        ("drive.current_ma", "1970.0"),
        ("real.can", "[\"can1\"]"),
    ] {
        assert_eq!(set(REAL, key, value).unwrap_err().expected, FACT, "{key}");
    }
}

#[test]
fn on_hardware_a_limit_is_tightened_and_never_loosened() {
    for (key, tighter, looser) in [
        ("drive.supply_limit_ma", "3000.0", "4000.1"),
        ("real.heartbeat_ms", "20", "31"),
        ("real.transfer_ms", "20", "31"),
        ("real.realtime", "true", "false"),
    ] {
        set(REAL, key, tighter).unwrap();
        let refused = set(REAL, key, looser).unwrap_err();
        assert_eq!(
            (refused.path.as_str(), refused.key.as_deref()),
            ("--set", Some(key))
        );
        assert!(refused.expected.contains("on hardware"), "{refused}");
    }
    let folder = std::env::temp_dir().join(format!("palpate-hardware-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let table = |name: &str, ms: &str| {
        let path = folder.join(format!("{name}.toml"));
        let text =
            format!("name = \"{name}\"\ndescription = \"A table\"\n[burst]\nlength_ms = {ms}\n");
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let (short, long) = (table("short", "30.0"), table("long", "40.0"));
    set(REAL, "limits", &short).unwrap();
    let own = REAL.replace("limits = \"default\"", &format!("limits = \"{short}\""));
    set(&own, "limits", &short).unwrap();
    for looser in [&long, "default"] {
        let refused = set(&own, "limits", looser).unwrap_err();
        assert!(
            refused.expected.contains("no looser than `short`"),
            "{refused}"
        );
    }
    let _ = std::fs::remove_dir_all(&folder);
}

#[test]
fn an_emulated_bench_takes_changes_and_becomes_no_hardware_by_them() {
    let emulated = "name = \"e\"\ndescription = \"Emulated\"\n";
    set(emulated, "drive.current_ma", "10.0").unwrap();
    for key in keys() {
        for value in ["1", "10.0", "\"x\"", "true", "{}"] {
            let refused = set(emulated, &key, value).err();
            let is_fact = refused.as_ref().is_some_and(|e| e.expected == FACT);
            assert!(!is_fact, "{key} = {value}: {refused:?}");
        }
    }
    let mut overrides = Overrides::default();
    overrides.bench("--unit", "unit.address", "\"10.0.0.2\"");
    overrides.bench("--key", "unit.key", "\"unit.key\"");
    bench(emulated).with(&overrides).unwrap();
    overrides.bench("--set", "drive.current_ma", "10.0");
    let refused = bench(emulated).with(&overrides).unwrap_err();
    assert_eq!(refused.key.as_deref(), Some("drive.current_ma"));
}
