//! What a recording has with it makes the setup that was recorded.

use super::*;
use crate::{Overrides, load_bench, load_scene};

fn texts(setup: &Setup) -> impl Fn(&str) -> Option<String> {
    let changes = setup.changes();
    let text = |source: &Source| Some(source.text().to_owned());
    let all = [
        ("scene.toml", text(&setup.scene.source)),
        ("sensor.toml", text(&setup.sensor.source)),
        ("bench.toml", text(&setup.bench.source)),
        ("display.toml", text(&setup.display.source)),
        ("limits.toml", text(&setup.limits.source)),
        ("wire.toml", text(&setup.wire.source)),
        ("alloy.toml", text(&setup.alloy.source)),
        ("person.toml", text(&setup.person.source)),
        ("changes.toml", changes),
    ];
    move |name| all.iter().find(|(n, _)| *n == name)?.1.clone()
}

fn changed(set: &[&str]) -> Setup {
    let mut overrides = Overrides::default();
    for text in set {
        overrides.set("--set", text).unwrap();
    }
    let scene = load_scene("sphere-circle").unwrap().with(&overrides);
    let bench = load_bench("emulated").unwrap().with(&overrides);
    Setup::join(scene.unwrap(), bench.unwrap()).unwrap()
}

#[test]
fn the_values_of_a_setup_come_back_with_the_changes_of_its_options() {
    for set in [
        &[][..],
        &["layout=uskin-4x6", "illusion.model=energy", "length_s=3"],
        &["bench.drive.current_ma=700", "touches[0].force_n.mean=0.5"],
    ] {
        let setup = changed(set);
        assert_eq!(setup.changes().is_some(), !set.is_empty(), "{set:?}");
        let back = Setup::attached("a.mcap", texts(&setup)).unwrap();
        assert_eq!(back.scene.value, setup.scene.value, "{set:?}");
        assert_eq!(back.bench.value, setup.bench.value, "{set:?}");
        assert_eq!(back.sensor.value, setup.sensor.value, "{set:?}");
        assert_eq!(back.display.value, setup.display.value, "{set:?}");
        assert_eq!(back.limits.value, setup.limits.value, "{set:?}");
        assert_eq!(back.person.value, setup.person.value, "{set:?}");
    }
}

#[test]
fn a_file_that_is_missing_or_of_another_kind_is_named() {
    let setup = changed(&[]);
    let all = texts(&setup);
    let without = |missing: &'static str| {
        let all = &all;
        move |name: &str| (name != missing).then(|| all(name)).flatten()
    };
    for name in ["scene.toml", "bench.toml", "sensor.toml", "person.toml"] {
        let error = Setup::attached("a.mcap", without(name)).unwrap_err();
        let said = error.to_string();
        assert!(said.contains("a.mcap") && said.contains(name), "{said}");
    }
    let swapped = |name: &str| match name {
        "sensor.toml" => all("display.toml"),
        name => all(name),
    };
    let said = Setup::attached("a.mcap", swapped).unwrap_err().to_string();
    assert!(said.contains("a.mcap: sensor.toml"), "{said}");
    let odd = |name: &str| match name {
        "changes.toml" => Some("scene = 3".to_owned()),
        name => all(name),
    };
    let said = Setup::attached("a.mcap", odd).unwrap_err().to_string();
    assert!(said.contains("changes.toml"), "{said}");
}
