//! Designs against what follows by hand, and against runs of the same wire.

use super::*;
use palpate_core::physics::{Mechanics, Mount};

const PERSON: Person = Person {
    vibration_um: 0.26,
    flutter_um: 5.0,
    np2_um: None,
    growth: [0.7, 1.0],
};

fn pattern(amps: f64, pulses: u32, cadence_ms: f64) -> PulsePattern {
    PulsePattern {
        amps,
        pulses,
        cadence_s: cadence_ms / 1e3,
        watts: 0.02,
    }
}

fn designed(pattern: &PulsePattern) -> DesignOutcome {
    let wire = WireParameters::FINAL.taut();
    outcome(&wire, &TissueParameters::DEFAULT, pattern, PERSON, 4.0).unwrap()
}

/// Widths of the same energy as seven pulses of 1.62 mJ, and levels at equal mean power: docs/felt.md.
#[test]
fn fewer_larger_rarer_pulses_are_felt_better_at_equal_power() {
    let seven = designed(&pattern(0.99, 7, 58.5));
    for (other, db) in [
        (pattern(0.99, 4, 58.5), 2.5),
        (pattern(1.97, 2, 117.0), 9.0),
        (pattern(0.99, 7, 117.0), 3.6),
    ] {
        let gained = designed(&other).levels.vibration_db - seven.levels.vibration_db;
        assert!((gained - db).abs() < 0.15, "{other:?}: {gained}");
    }
    let width = pattern(1.97, 2, 117.0).width_s(1.9);
    assert!((width * 1e6 - 158.7).abs() < 0.5, "{width}");
}

#[test]
fn a_larger_wire_keeps_its_resistivity_and_its_crimps() {
    let wire = WireParameters::FINAL;
    let same = resized(&wire, wire.diameter_m, wire.length_m);
    assert!((same.resistance_ohm - wire.resistance_ohm).abs() < 1e-12);
    // The first module's wire: 1.4 Ohm, 46 % of the heat in it, 136 W/m2K.
    let thick = resized(&wire, 100e-6, 5e-3);
    assert!((thick.resistance_ohm - 1.4).abs() < 0.01, "{thick:?}");
    assert!((thick.wire_share - 0.46).abs() < 0.005, "{thick:?}");
    assert!((thick.air_h - 136.0).abs() < 1.0, "{thick:?}");
}

#[test]
fn the_limit_table_forbids_what_it_names() {
    for (pattern, row) in [
        (pattern(0.99, 1, 58.5), Some("pulse-width")),
        (pattern(1.97, 12, 117.0), Some("burst")),
        (pattern(1.97, 7, 50.0), Some("burst")),
        (
            PulsePattern {
                watts: 0.03,
                ..pattern(1.97, 2, 117.0)
            },
            Some("pulse-width"),
        ),
        (
            PulsePattern {
                watts: 0.021,
                ..pattern(1.97, 4, 117.0)
            },
            Some("wire-power"),
        ),
        (pattern(1.97, 4, 117.0), None),
    ] {
        assert_eq!(designed(&pattern).excluded, row, "{pattern:?}");
    }
    // The same power in fever.
    let tissue = TissueParameters {
        body_c: 37.0,
        ..TissueParameters::DEFAULT
    };
    let of = outcome(
        &WireParameters::FINAL,
        &tissue,
        &pattern(1.97, 7, 58.5),
        PERSON,
        10.0,
    )
    .unwrap();
    assert_eq!(of.excluded, Some("skin-peak"), "{of:?}");
}

#[test]
fn what_another_point_beats_in_everything_is_dominated() {
    let p = pattern(0.99, 7, 58.5);
    let made = |db: f64, skin_c: f64, amps: f64, excluded| {
        let levels = Levels {
            vibration_db: db,
            flutter_db: -200.0,
            np2_db: -200.0,
        };
        let of = DesignOutcome {
            levels,
            skin_c: [skin_c; 2],
            excluded,
            ..designed(&p)
        };
        (PulsePattern { amps, ..p }, of)
    };
    let points = [
        made(3.0, 40.0, 1.0, None),
        made(2.0, 40.0, 1.0, None), // weaker than the first at the same heat
        made(2.0, 39.0, 1.0, None), // cooler
        made(3.0, 40.0, 0.5, Some("bow")), // beats the first, and is no design
        made(3.0, 40.0, 1.0, None), // the first again
    ];
    assert_eq!(undominated(&points), [true, false, true, false, true]);
}

#[test]
fn a_wire_that_straightens_its_bow_is_no_design() {
    // 1 % of 8 mm are 80 um, a bow of 60 um has 1.1 um to give. Firm skin would hold it long before.
    let tissue = TissueParameters {
        modulus_pa: 5e3,
        ..TissueParameters::DEFAULT
    };
    let flat = |transformation_strain| {
        let wire = WireParameters {
            mount: Mount {
                sag_m: 60e-6,
                ..Mount::DEFAULT
            },
            mechanics: Mechanics {
                transformation_strain,
                ..Mechanics::DEFAULT
            },
            ..resized(&WireParameters::FINAL, 50e-6, 8e-3)
        };
        let hot = pattern(1.2, 4, 234.0);
        outcome(&wire, &tissue, &hot, PERSON, 4.0).unwrap()
    };
    assert_eq!(flat(0.01).excluded, Some("bow"), "{:?}", flat(0.01));
    assert_eq!(flat(0.001).excluded, None, "{:?}", flat(0.001));
}
