//! Tests of `wire.rs`.

use super::*;

fn wire(name: &str) -> WireFile {
    WireFile::read(&Source::new(name, palpate_fixtures::wire(name).unwrap())).unwrap()
}

fn alloy(name: &str) -> AlloyFile {
    AlloyFile::read(&Source::new(name, palpate_fixtures::alloy(name).unwrap())).unwrap()
}

#[test]
fn the_shipped_files_are_the_programs_own_constants() {
    let (final_wire, first) = (wire("final-75um"), wire("first-100um"));
    assert_eq!(final_wire.parameters(&alloy("low")), WireParameters::FINAL);
    assert_eq!(first.parameters(&alloy("low")), WireParameters::FIRST);
    let high = final_wire.parameters(&alloy("high"));
    assert_eq!(high.alloy, Alloy::HIGH);
    assert!(high.check().is_ok());
}

#[test]
fn laws_are_chosen_and_nonsense_is_named() {
    let text = palpate_fixtures::wire("final-75um").unwrap();
    let read = |text: String| WireFile::read(&Source::new("w.toml", text));
    let plays = format!("{text}\n[hysteresis]\nlaw = \"plays\"\ncount = 5\nnarrowest = 0.2\n");
    let law = read(plays).unwrap().hysteresis;
    assert!(matches!(law, Hysteresis::Plays { count: 5, .. }));
    let none = format!("{text}\n[hysteresis]\nlaw = \"plays\"\ncount = 0\nnarrowest = 0.2\n");
    assert!(
        read(none)
            .unwrap_err()
            .to_string()
            .contains("hysteresis.count")
    );
    let thick = text.replace("diameter_um = 75.0", "diameter_um = 7500.0");
    let error = read(thick).unwrap_err().to_string();
    assert!(error.contains("w.toml:4: diameter_um: expected"), "{error}");
    let low = palpate_fixtures::alloy("low")
        .unwrap()
        .replace("= 78.0", "= 60.0");
    let error = AlloyFile::read(&Source::new("a.toml", low)).unwrap_err();
    assert!(error.to_string().contains("Mf < Ms < As < Af"), "{error}");
}
