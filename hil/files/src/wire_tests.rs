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
    for (name, parameters) in [
        ("taut", WireParameters::FINAL),
        ("loose", WireParameters::FINAL.loose()),
    ] {
        assert_eq!(wire(name).parameters(&alloy("low")), parameters);
    }
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

#[test]
fn crossing_bands_and_strains_beyond_the_geometry_are_named() {
    let text = palpate_fixtures::wire("loose").unwrap();
    for (old, new, said) in [
        (
            "heating_finish_c = 47.0",
            "heating_finish_c = 44.0",
            "plays[0].heating_finish_c: expected at least cooling_start_c, so that the bands do not cross: 45",
        ),
        (
            "cooling_finish_c = 35.0",
            "cooling_finish_c = 38.0",
            "plays[0].heating_start_c: expected at least cooling_finish_c, so that the bands do not cross: 38",
        ),
        (
            "heating_finish_c = 47.0",
            "heating_finish_c = 36.0",
            "plays[0].heating_finish_c: expected more than heating_start_c: 37",
        ),
        (
            "strain = 0.001 ",
            "strain = 0.09 ",
            "plays[0].strain: expected strains of all phases that come to 0.0987 at most: more bends a wire deeper than 0.2 of its length, found 0.1000 in all",
        ),
        (
            "reversible = 0.02",
            "reversible = 1.02",
            "reversible: expected a number from 0 to 1 of the martensite, found 1.02",
        ),
        (
            "stress_mpa_k = 15.0",
            "stress_mpa_k = 0.0",
            "plays[0].stress_mpa_k: expected a number from 0.1 to 100 MPa/K, found 0.0",
        ),
    ] {
        assert!(text.contains(old), "{old}");
        let source = Source::new("w.toml", text.replacen(old, new, 1));
        let error = WireFile::read(&source).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    let many = format!("{text}{}", "[[plays]]\nheating_start_c = 1\nheating_finish_c = 2\ncooling_start_c = 1\ncooling_finish_c = 0\nstress_mpa_k = 7\nstrain = 0\nlatent_heat_j_kg = 0\n".repeat(4));
    let error = WireFile::read(&Source::new("w.toml", many))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("plays: expected at most 4 plays beside the martensite, found 5"),
        "{error}"
    );
}

/// An alloy whose cooling band is wider than its heating band: a narrow hysteresis makes both cross.
#[test]
fn a_hysteresis_too_narrow_for_its_alloy_is_named() {
    let text = palpate_fixtures::wire("taut").unwrap();
    let text = format!("{text}\n[hysteresis]\nlaw = \"plays\"\ncount = 3\nnarrowest = 0.05\n");
    let source = Source::new("w.toml", text);
    let wire = WireFile::read(&source).unwrap();
    let mut wide = alloy("low");
    assert!(wire.fits(&source, &wide).is_ok());
    wide.martensite_finish_c = 20.0;
    let error = wire.fits(&source, &wide).unwrap_err().to_string();
    assert!(
        error.contains("hysteresis.narrowest: expected wider: with the alloy `low` the bands"),
        "{error}"
    );
}

/// Text of the shipped wire with a history, changed; what is said of it, alone or in its bench's bow.
fn refusal(changes: &[(&str, &str)], (sag_um, skin_kpa): (f64, f64)) -> String {
    let mut text = palpate_fixtures::wire("passed-50um").unwrap().to_owned();
    for (old, new) in changes {
        assert!(text.contains(old), "{old}");
        text = text.replacen(old, new, 1);
    }
    let source = Source::new("w.toml", text);
    let wire = match WireFile::read(&source) {
        Ok(wire) => wire,
        Err(e) => return e.to_string(),
    };
    let worn = WireParameters {
        mount: physics::Mount {
            sag_m: sag_um * 1e-6,
            ..physics::Mount::DEFAULT
        },
        ..wire.parameters(&alloy("low-free"))
    };
    let bench = Source::new("b.toml", format!("mount.sag_um = {sag_um}\n"));
    let tissue = physics::TissueParameters {
        modulus_pa: skin_kpa * 1e3,
        ..physics::TissueParameters::DEFAULT
    };
    match check_rest(&source, &bench, &worn, &tissue) {
        Ok(()) => String::new(),
        Err(e) => e.to_string(),
    }
}

#[test]
fn a_history_that_contradicts_itself_is_named_with_its_line() {
    assert_eq!(refusal(&[], (250.0, 100.0)), "");
    let cold = ("sag_state = \"cold\" ", "");
    for (change, said) in [
        (
            cold,
            "w.toml:9: state: expected no such key without `sag_state`, the state in which the bench's sag was measured: \"cold\" or \"passed\", found \"passed\"",
        ),
        (
            ("state = \"passed\"", "coldest_c = 20.0"),
            "w.toml:9: coldest_c: expected it beside state = \"passed\" alone: a cold wire has been colder, found 20.0",
        ),
        (
            ("state = \"passed\"", "state = \"passed\"\ncoldest_c = 40.0"),
            "w.toml:10: coldest_c: expected a number from -200 to 33 C, found 40.0",
        ),
        (
            (
                "[electrical]",
                "hysteresis = { law = \"plays\", count = 2, narrowest = 0.5 }\n[electrical]",
            ),
            "hysteresis.law: expected the law `play` beside `sag_state`: its shares turn one after the other, found \"plays\"",
        ),
        (
            ("strain = 0.001 ", "strain = 0.003 "),
            "plays[0].strain: expected a strain from 0 to 0.002, that of the martensite which it turns to: beside `sag_state` phases exclude one another, found 0.003",
        ),
        (
            ("latent_heat_j_kg = 4000.0", "latent_heat_j_kg = 14000.0"),
            "plays[0].latent_heat_j_kg: expected at most the martensite's latent heat, 12000 J/kg, found 14000.0",
        ),
    ] {
        let error = refusal(&[change], (250.0, 100.0));
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn a_rest_that_no_wire_can_have_is_named_with_its_line() {
    let pressed = refusal(
        &[
            ("sag_state = \"cold\"  ", "sag_state = \"passed\""),
            ("state = \"passed\"\n\n", "state = \"cold\"\n\n"),
        ],
        (60.0, 100.0),
    );
    assert!(
        pressed.contains("mechanical.bias_stress_mpa: expected more, or another `sag_state` or `state`: in a bow of 60 um the wire would be pressed at rest, and no state holds that, found 10.0"),
        "{pressed}"
    );
    let tight = refusal(
        &[
            ("bias_stress_mpa = 10.0", "bias_stress_mpa = 0.0"),
            (
                "transformation_strain = 0.002",
                "transformation_strain = 0.06",
            ),
            ("strain = 0.001 ", "strain = 0.0 "),
        ],
        (20.0, 1.0),
    );
    assert!(
        tight.contains("b.toml:1: mount.sag_um: expected a deeper bow, or another `sag_state` or `state` in w.toml: from 20 um the wire pulls itself past 90 % straight before its first pulse, found 20"),
        "{tight}"
    );
}
