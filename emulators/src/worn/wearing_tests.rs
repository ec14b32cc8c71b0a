//! Tests of `wearing.rs`.

use super::*;

const PERSON: Person = Person {
    vibration_um: 0.45,
    flutter_um: 5.0,
    np2_um: None,
    growth: [0.7, 1.0],
};
const SECOND: u64 = 1_000_000_000;

/// Onsets, a second apart, of the same current through two wires, 10 mm apart, with these seats.
fn onsets(seats: [&[[f64; 2]]; 2], seconds: u64) -> Vec<Felt> {
    let mut worn = Wearing::new(&WireParameters::FINAL, &TissueParameters::DEFAULT, 2).unwrap();
    worn.by(PERSON, &[(0.0, 0.0), (10.0, 0.0)]).unwrap();
    for (wire, points) in seats.iter().enumerate() {
        worn.seat(wire, points);
    }
    let felt = |second: u64| {
        for wire in &mut worn.wires {
            wire.set_current(Nanos(second * SECOND), 1.97);
            wire.set_current(Nanos(second * SECOND + 120_000), 0.0);
        }
        worn.onset(Nanos((second + 1) * SECOND)).unwrap()
    };
    (0..seconds).map(felt).collect()
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-6, "{found} for {expected}");
}

#[test]
fn a_part_of_the_motion_is_felt_as_much_weaker() {
    let (whole, half) = (onsets([&[], &[]], 1)[0], onsets([&[[0.0, 0.5]]; 2], 1)[0]);
    let less_db = 20.0 * libm::log10(2.0);
    close(
        half.levels.vibration_db,
        whole.levels.vibration_db - less_db,
    );
    close(half.levels.flutter_db, whole.levels.flutter_db - less_db);
    close(half.skin_um, whole.skin_um / 2.0);
    close(half.seconds, whole.seconds);
    close(half.energy_mm.0, 5.0);
}

#[test]
fn a_place_goes_to_the_wire_that_lies_on_the_skin() {
    let part: f64 = 0.25;
    let felt = onsets([&[], &[[0.0, part]]], 1)[0];
    close(felt.energy_mm.0, 10.0 * part * part / (1.0 + part * part));
    close(felt.amplitude_mm.0, 10.0 * part / (1.0 + part));
    close(onsets([&[], &[[0.0, 0.0]]], 1)[0].energy_mm.0, 0.0);
}

#[test]
fn a_finger_that_moves_changes_the_later_onsets_alone() {
    let even = onsets([&[], &[]], 4);
    let moved = onsets([&[], &[[1.9, 1.0], [2.0, 0.0]]], 4);
    assert_eq!(moved[0], even[0]);
    close(even[2].energy_mm.0, 5.0);
    assert!(moved[2].energy_mm.0 < 0.01, "{:?}", moved[2]);
    assert!(moved[3].energy_mm.0 < 0.01, "{:?}", moved[3]);
    // Vibration adds up over wires, and of flutter the strongest wire counts.
    let (moved, even) = (moved[2].levels, even[2].levels);
    let less_db = even.vibration_db - moved.vibration_db;
    assert!(
        (less_db - 10.0 * libm::log10(2.0)).abs() < 0.05,
        "{less_db}"
    );
    close(moved.flutter_db, even.flutter_db);
}
