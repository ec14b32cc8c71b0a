//! A wire that moves the skin: straight between events, and parted from it where the bow says.

use super::*;
use palpate_core::physics::{Alloy, Bow, Curve, Law, Mount, TissueParameters, WireParameters};

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
        austenite_finish_c: 58.0,
        ..Alloy::LOW
    };
    let (mut apart, mut moved) = (0, 0.0_f64);
    for (alloy, reversible, preload_n) in [
        (Alloy::LOW, 0.02, 1e-3),
        (unequal, 0.3, 1e-4),
        (Alloy::LOW, 0.0, 2e-5),
    ] {
        for base in [trained(), WireParameters::FINAL] {
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
            let curve = Curve::new(&bow, &wire);
            let at_sag = Law::new(&wire, &tissue, 33.0).unwrap().rest_strain();
            // The bow's own strain is what phases and expansion leave.
            let free = |worn: &mut Wire, at: Nanos| {
                let strain = worn.strain(at);
                let longer = strain.phase + strain.thermal - at_sag;
                let piece = curve.pieces.iter().find(|piece| longer <= piece.high);
                piece.unwrap().u_at(longer)
            };
            let rest = free(&mut worn, Nanos::ZERO);
            for pulse in 0..72 {
                let (start, amps) = through_all_bands(pulse);
                worn.set_current(start, amps);
                worn.set_current(start + PULSE, 0.0);
                for later in [0, 700_000, 3_000_000] {
                    let at = start + PULSE + Nanos(later);
                    let found = worn.displacement_m(at);
                    let free = free(&mut worn, at);
                    let expected = free.max(bow.parting_m) - rest;
                    assert!((found - expected).abs() < 1e-13, "{found} for {expected}");
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
    let mut free = Wire::new(&trained(), &tissue, 33.0).unwrap();
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
