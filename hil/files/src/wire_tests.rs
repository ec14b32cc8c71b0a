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
    for (name, parameters) in [
        ("final-75um", WireParameters::FINAL),
        ("first-100um", WireParameters::FIRST),
        ("taut", WireParameters::FINAL.taut()),
    ] {
        assert_eq!(wire(name).parameters(&alloy("low")), parameters);
    }
    let high = wire("final-75um").parameters(&alloy("high"));
    assert_eq!(high.alloy, Alloy::HIGH);
    assert!(high.check().is_ok());
}

#[test]
fn nonsense_is_named() {
    let text = palpate_fixtures::wire("final-75um").unwrap();
    for (old, new, said) in [
        (
            "diameter_um = 75.0",
            "diameter_um = 7500.0",
            "w.toml:5: diameter_um: expected",
        ),
        (
            "heating_finish_c = 47.0",
            "heating_finish_c = 44.0",
            "r_phase.heating_finish_c: expected at least cooling_start_c, so that the bands do not cross: 45",
        ),
        (
            "cooling_finish_c = 35.0",
            "cooling_finish_c = 38.0",
            "r_phase.heating_start_c: expected at least cooling_finish_c, so that the bands do not cross: 38",
        ),
        (
            "heating_finish_c = 47.0",
            "heating_finish_c = 36.0",
            "r_phase.heating_finish_c: expected more than heating_start_c: 37",
        ),
        (
            "strain = 0.001 ",
            "strain = 0.003 ",
            "r_phase.strain: expected a number from 0 to 0.002 of its length: martensite's, which R turns to, found 0.003",
        ),
        (
            "latent_heat_j_kg = 4000.0",
            "latent_heat_j_kg = 14000.0",
            "r_phase.latent_heat_j_kg: expected a number from 0 to 12000 J/kg: the martensite's, found 14000.0",
        ),
        (
            "transformation_strain = 0.002",
            "transformation_strain = 0.1",
            "mechanical.transformation_strain: expected a number from 0 to 0.0986",
        ),
        (
            "diameter_um",
            "reversible = 1.02\ndiameter_um",
            "reversible: expected a number from 0 to 1 of the martensite, found 1.02",
        ),
        (
            "stress_mpa_k = 15.0",
            "stress_mpa_k = 0.0",
            "r_phase.stress_mpa_k: expected a number from 0.1 to 100 MPa/K, found 0.0",
        ),
        (
            "[r_phase]",
            "[[plays]]",
            "plays: expected the R phase as [r_phase]: `hil check --migrate` writes it so",
        ),
        (
            "[r_phase]",
            "[hysteresis]\nlaw = \"play\"\n[r_phase]",
            "hysteresis: expected no law, phases follow one: `hil check --migrate` leaves it out",
        ),
        (
            "sag_state = \"cold\"",
            "",
            "w.toml:1: sag_state: expected the state in which the bench's sag was measured: \"cold\" or \"passed\"; `hil check --migrate --sag-state cold` writes it, found nothing",
        ),
    ] {
        assert!(text.contains(old), "{old}");
        let source = Source::new("w.toml", text.replacen(old, new, 1));
        let error = WireFile::read(&source).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    let low = palpate_fixtures::alloy("low").unwrap();
    let low = low.replace("= 53.42857142857143", "= 40.0");
    let error = AlloyFile::read(&Source::new("a.toml", low)).unwrap_err();
    assert!(error.to_string().contains("Mf < Ms < As < Af"), "{error}");
}

/// Text of a shipped wire, changed; what is said of it, alone or in its bench's bow.
fn refusal(changes: &[(&str, &str)], bow: (f64, f64)) -> String {
    refusal_at(33.0, changes, bow)
}

/// Refusal of such a wire on a finger of some temperature at rest.
fn refusal_at(rest_c: f64, changes: &[(&str, &str)], (sag_um, skin_kpa): (f64, f64)) -> String {
    let shipped = palpate_fixtures::wire("loose-50um").unwrap();
    let mut text = shipped.replace("\nstate = \"cold\"\n", "\nstate = \"passed\"\n");
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
        ..wire.parameters(&alloy("low"))
    };
    let bench = Source::new("b.toml", format!("mount.sag_um = {sag_um}\n"));
    let tissue = physics::TissueParameters {
        modulus_pa: skin_kpa * 1e3,
        body_c: rest_c,
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
    for (change, said) in [
        (
            ("state = \"passed\"", "coldest_c = 20.0"),
            "w.toml:9: coldest_c: expected it beside state = \"passed\" alone: a cold wire has been colder, found 20.0",
        ),
        (
            ("state = \"passed\"", "state = \"passed\"\ncoldest_c = 40.0"),
            "w.toml:10: coldest_c: expected a number from -200 to 36 C, found 40.0",
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

/// A finger is as warm as its bench says: martensite of a colder time weighs otherwise there.
#[test]
fn a_wire_rests_on_the_finger_of_its_bench() {
    let passed = |stress: &str, rest_c: f64| {
        let changes = [
            ("sag_state = \"cold\"  ", "sag_state = \"passed\""),
            (
                "state = \"passed\"\n\n",
                "state = \"passed\"\ncoldest_c = 25.0\n\n",
            ),
            ("bias_stress_mpa = 10.0", stress),
        ];
        refusal_at(rest_c, &changes, (250.0, 100.0))
    };
    let why = "w.toml:27: mechanical.bias_stress_mpa: expected more, or another `sag_state` or `state`: in a bow of 250 um the wire would be pressed at rest, and no state holds that, found";
    for (stress, held_c, pressed_c) in [("3.0", 33.0, 36.0), ("2.0", 26.0, 33.0)] {
        let line = format!("bias_stress_mpa = {stress}");
        assert_eq!(passed(&line, held_c), "");
        let error = passed(&line, pressed_c);
        assert!(error.contains(&format!("{why} {stress}")), "{error}");
    }
}
