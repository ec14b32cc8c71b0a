//! Tests of `guarded.rs`.

use super::*;

fn read(changes: &[(&str, &str)]) -> Result<WireFile, FileError> {
    let mut text = palpate_fixtures::wire("final-75um").unwrap().to_owned();
    for (old, new) in changes {
        assert!(text.contains(old), "{old}");
        text = text.replacen(old, new, 1);
    }
    WireFile::read(&Source::new("w.toml", text))
}

#[test]
fn the_ends_of_every_range_are_read() {
    for changes in [
        [
            ("diameter_um = 75.0", "diameter_um = 50.0"),
            ("air_w_m2k = 172.0", "air_w_m2k = 240.0"),
            ("length_mm = 5.0", "length_mm = 3.0"),
        ],
        [
            ("diameter_um = 75.0", "diameter_um = 100.0"),
            ("air_w_m2k = 172.0", "air_w_m2k = 135.0"),
            ("length_mm = 5.0", "length_mm = 20.0"),
        ],
        [
            ("specific_heat_j_kgk = 460.0", "specific_heat_j_kgk = 322.0"),
            ("latent_heat_j_kg = 12000.0", "latent_heat_j_kg = 24000.0"),
            ("conductivity_w_mk = 18.0", "conductivity_w_mk = 19.0"),
        ],
        [
            ("specific_heat_j_kgk = 460.0", "specific_heat_j_kgk = 837.0"),
            ("air_w_m2k = 172.0", "air_w_m2k = 500.0"),
            ("length_mm = 5.0", "length_mm = 8.0"),
        ],
    ] {
        assert_eq!(read(&changes).err().map(|e| e.to_string()), None);
    }
}

#[test]
fn a_wire_without_rows_is_refused_with_line_and_range() {
    let why = "the guard has rows of heat for no other";
    for (change, said) in [
        (
            ("diameter_um = 75.0", "diameter_um = 49.9"),
            "a number from 50 to 100 um",
        ),
        (
            ("diameter_um = 75.0", "diameter_um = 100.1"),
            "a number from 50 to 100 um",
        ),
        (
            ("length_mm = 5.0", "length_mm = 2.9"),
            "a number from 3 to 20 mm",
        ),
        (
            ("length_mm = 5.0", "length_mm = 20.1"),
            "a number from 3 to 20 mm",
        ),
        (
            ("specific_heat_j_kgk = 460.0", "specific_heat_j_kgk = 321.0"),
            "a number from 322 to 837 J/kgK",
        ),
        (
            ("specific_heat_j_kgk = 460.0", "specific_heat_j_kgk = 838.0"),
            "a number from 322 to 837 J/kgK",
        ),
        (
            ("density_kg_m3 = 6450.0", "density_kg_m3 = 12900.0"),
            "a number from 161 to 418.5 J/kgK",
        ),
        (
            ("conductivity_w_mk = 18.0", "conductivity_w_mk = 17.9"),
            "a number from 18 to 500 W/mK",
        ),
        (
            ("air_w_m2k = 172.0", "air_w_m2k = 171.9"),
            "a number from 172 to 2000 W/m2K",
        ),
        (
            ("latent_heat_j_kg = 12000.0", "latent_heat_j_kg = 24001.0"),
            "a number from 0 to 24000 J/kg",
        ),
    ] {
        let error = read(&[change]).unwrap_err().to_string();
        assert!(error.starts_with("w.toml:"), "{error}");
        assert!(error.contains(&format!("{said}: {why}")), "{error}");
    }
}

/// Thinner wires lose more to the same air.
#[test]
fn the_air_of_a_wire_is_that_of_its_diameter() {
    let thin = |air: &str| {
        read(&[
            ("diameter_um = 75.0", "diameter_um = 50.0"),
            ("air_w_m2k = 172.0", air),
        ])
    };
    assert!(thin("air_w_m2k = 240.0").is_ok());
    assert!(thin("air_w_m2k = 239.0").is_err());
}
