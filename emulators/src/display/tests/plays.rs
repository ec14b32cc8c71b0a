//! A wire that moves: parallel plays, strain that is straight between events, and skin that parts from the wire.

use super::*;
use palpate_core::physics::{Alloy, Bow, Mechanics, Mount, TissueParameters, WireParameters};

/// The R play alone, at 10 MPa: a wire whose martensite weighs nothing.
const R_ALONE: WireParameters = WireParameters {
    latent_heat: 0.0,
    mechanics: Mechanics {
        transformation_strain: 0.0,
        expansion_martensite: 11e-6,
        modulus_martensite_pa: 75e9,
        ..Mechanics::DEFAULT
    },
    reversible: 0.0,
    ..WireParameters::FINAL.loose()
};

/// Change of length in each of seven pulses, um, and temperature at the last edge.
fn seven(wire: &WireParameters, amps: f64) -> (Vec<f64>, f64) {
    let mut held = Wire::new(wire, &TissueParameters::DEFAULT, 33.0).unwrap();
    let mut changes = Vec::new();
    for pulse in 0..7 {
        let start = Nanos(pulse * PERIOD.0);
        let before = held.strain(start).total();
        held.set_current(start, amps);
        held.set_current(start + PULSE, 0.0);
        let after = held.strain(start + PULSE).total();
        changes.push((after - before) * wire.length_m * 1e6);
    }
    (changes, held.temperature(Nanos(6 * PERIOD.0) + PULSE))
}

#[test]
fn an_r_phase_alone_moves_as_computed_elsewhere() {
    for (amps, expected, last_c) in [
        (
            0.99,
            [0.116, 0.116, -0.165, -0.342, -0.321, -0.301, -0.282],
            41.30,
        ),
        (
            1.97,
            [-0.625, -1.786, -1.674, 0.449, 0.459, 0.458, 0.457],
            71.68,
        ),
    ] {
        let (changes, c) = seven(&R_ALONE, amps);
        println!("{amps} A: {changes:.3?}, {c:.2} C");
        // The band begins within the third pulse at 0.99 A: 6 mK there are 2 % of that pulse.
        let most = expected.iter().fold(0.0, |m, v| f64::max(m, f64::abs(*v)));
        for (found, expected) in changes.iter().zip(expected) {
            assert!((found - expected).abs() < 0.01 * most, "{changes:?}");
        }
        assert!((c / last_c - 1.0).abs() < 0.01, "{c}");
    }
}

/// A drive that warms a wire through all its bands and back, with pauses.
fn through_all_bands(pulse: u64) -> (Nanos, f64) {
    let burst = pulse / 9;
    let start = Nanos(pulse % 9 * PERIOD.0 + burst * 90_000_000);
    (start, [0.7, 0.99, 1.4, 1.97][(burst % 4) as usize])
}

/// The skin follows the strain wherever it is asked, though it is computed from the start of each stretch: neither a band
/// nor a parting bends it.
#[test]
fn skin_is_straight_between_events_and_parts_where_it_says() {
    let unequal = Alloy {
        austenite_finish_c: 83.0,
        ..Alloy::LOW
    };
    let (mut apart, mut moved) = (0, 0.0_f64);
    for (alloy, reversible, preload_n) in [
        (Alloy::LOW, 0.02, 1e-3),
        (unequal, 0.3, 1e-4),
        (Alloy::LOW, 0.0, 2e-5),
    ] {
        for base in [WireParameters::FINAL.loose(), WireParameters::FINAL] {
            let wire = WireParameters {
                alloy,
                reversible,
                mount: Mount {
                    preload_n,
                    ..Mount::DEFAULT
                },
                ..base
            };
            let tissue = TissueParameters::DEFAULT;
            let bow = Bow::new(&wire, &tissue).unwrap();
            let mut worn = Wire::new(&wire, &tissue, 33.0)
                .and_then(|w| w.worn(&tissue))
                .unwrap();
            let rest = worn.strain(Nanos::ZERO).total();
            for pulse in 0..72 {
                let (start, amps) = through_all_bands(pulse);
                worn.set_current(start, amps);
                worn.set_current(start + PULSE, 0.0);
                for later in [0, 700_000, 3_000_000] {
                    let at = start + PULSE + Nanos(later);
                    let found = worn.displacement_m(at);
                    let free = -bow.gain * wire.length_m * (worn.strain(at).total() - rest);
                    let expected = free.max(bow.parting_m);
                    assert!((found - expected).abs() < 1e-15, "{found} for {expected}");
                    apart += usize::from(free < bow.parting_m - 1e-9);
                    moved = moved.max(found);
                }
            }
        }
    }
    assert!(apart > 50 && moved > 1e-5, "{apart} {moved}");
}

/// Parting leaves temperatures and phases alone.
#[test]
fn wearing_a_wire_changes_nothing_in_it() {
    let tissue = TissueParameters::DEFAULT;
    let mut free = Wire::new(&WireParameters::FINAL.loose(), &tissue, 33.0).unwrap();
    let mut worn = free.clone().worn(&tissue).unwrap();
    for pulse in 0..72 {
        let (start, amps) = through_all_bands(pulse);
        for wire in [&mut free, &mut worn] {
            wire.set_current(start, amps);
            wire.set_current(start + PULSE, 0.0);
        }
    }
    let end = Nanos(1_000_000_000);
    assert!((free.temperature(end) - worn.temperature(end)).abs() < 1e-9);
    assert!((free.strain(end).total() - worn.strain(end).total()).abs() < 1e-12);
}
