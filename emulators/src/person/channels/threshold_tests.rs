//! Thresholds by area and duration, as stated in `docs/felt.md`, and NP II.

use super::super::tests::{db, near, one, person, sine};
use super::super::{Kick, Levels, Perceiver, Person};
use super::*;

/// Published 0.17 um at 0.1 cm2, at the areas of wires; both ends of the published exponent.
#[test]
fn thresholds_by_area_are_as_stated() {
    for (area_cm2, half, quarter) in [
        (0.0048, 0.776, 0.363),
        (0.0030, 0.981, 0.408),
        (0.0079, 0.605, 0.321),
        (0.02, 0.380, 0.254),
    ] {
        for (summation, expected) in [(0.5, half), (0.25, quarter)] {
            let published = AreaThreshold {
                um: 0.17,
                area_cm2: 0.1,
                summation,
            };
            let um = published.at(area_cm2);
            assert!((um - expected).abs() < 6e-4, "{area_cm2} cm2: {um}");
        }
    }
}

#[test]
fn a_doubled_area_takes_3_db_below_the_knee_and_half_of_it_above() {
    let db = |from: f64, to: f64| {
        let own = AreaThreshold {
            um: 0.6,
            area_cm2: from,
            summation: 0.5,
        };
        assert!((own.at(from) - 0.6).abs() < 1e-15);
        20.0 * libm::log10(own.at(to) / own.um)
    };
    assert!((db(0.0048, 0.0096) + 3.0103).abs() < 1e-4);
    assert!((db(0.1, 0.2) + 1.5051).abs() < 1e-4);
    assert!((db(0.4, 0.8) + 1.5051).abs() < 1e-4);
    assert!((db(0.05, 0.2) + 4.5154).abs() < 1e-4, "across the knee");
}

#[test]
fn an_area_that_cannot_be_has_no_threshold() {
    let own = AreaThreshold {
        um: 0.6,
        area_cm2: 0.0048,
        summation: 0.5,
    };
    for area in [0.0, -1.0, f64::NAN] {
        assert!(!own.at(area).is_finite(), "{area}");
    }
    assert!(
        !AreaThreshold {
            area_cm2: -1.0,
            ..own
        }
        .at(0.01)
        .is_finite()
    );
}

/// The threshold of a vibration by its length is that of its leaky energy: a_P (1 - e^(-t / 0.2 s))^(-1/2). The filters have
/// rung in before, so that nothing else counts.
#[test]
fn a_vibration_of_steady_amplitude_adds_up_over_its_length() {
    for (ms, expected) in [
        (10.0, 13.12),
        (30.0, 8.56),
        (100.0, 4.05),
        (200.0, 1.99),
        (500.0, 0.37),
    ] {
        let mut perceiver = one();
        sine(&mut perceiver, 250.0, 0.0, 0.04);
        let flutter_db = perceiver.felt(33.0).unwrap().levels.flutter_db;
        (perceiver.energy, perceiver.most) = (0.0, 0.0);
        sine(&mut perceiver, 250.0, 0.0, ms * 1e-3);
        let levels = perceiver.felt(33.0).unwrap().levels;
        near(levels.vibration_db, -expected, 0.02);
        near(levels.flutter_db, flutter_db, 1e-9);
    }
}

/// NP II goes by the strongest wire's peak: neither length nor further wires add to it.
#[test]
fn np2_feels_the_largest_peak_and_adds_up_nothing() {
    let levels = |wires: usize, np2_um, ms: f64| {
        let person = Person {
            np2_um,
            ..person(1.0)
        };
        let mut perceiver = Perceiver::new(person, &vec![(0.0, 0.0); wires]).unwrap();
        let kicks: Vec<Kick> = (0..(ms / 5.0) as usize)
            .map(|n| Kick {
                at_s: n as f64 * 5e-3,
                um: 1.0,
            })
            .collect();
        (0..wires).for_each(|wire| perceiver.kicks(wire, &kicks, ms * 1e-3));
        perceiver.settle();
        (
            perceiver.felt(33.0).unwrap().levels,
            perceiver.wires[0].met.peak_p,
        )
    };
    let (short, peak) = levels(1, Some(1.5), 30.0);
    near(short.np2_db, db(peak / 1.5), 1e-9);
    let (four, _) = levels(4, Some(1.5), 30.0);
    near(four.np2_db, short.np2_db, 1e-9);
    let (long, _) = levels(1, Some(1.5), 300.0);
    near(long.np2_db, short.np2_db, 0.05);
    assert!(long.vibration_db > short.vibration_db + 3.0);
    let (without, _) = levels(1, None, 30.0);
    near(without.np2_db, Levels::SILENT.np2_db, 1e-12);
    near(without.vibration_db, short.vibration_db, 1e-12);
    // The strength of vibration is that of the stronger channel.
    let felt = Levels {
        np2_db: 20.0,
        ..Levels::SILENT
    };
    near(felt.intensity([0.5, 1.0]), libm::sqrt(10.0), 1e-9);
    assert!(felt.felt());
}
