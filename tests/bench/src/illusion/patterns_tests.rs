//! Tests of `patterns.rs`.

use super::*;

#[test]
fn every_share_is_tried_once_and_every_burst_is_a_vibration() {
    assert_eq!(
        compositions(4, 3),
        [[1, 1, 2], [1, 2, 1], [2, 1, 1]].map(Vec::from)
    );
    // 7 over 2: ways to cut eight parts in three.
    assert_eq!(compositions(8, 3).len(), 21);
    let bursts = bursts();
    for (n, burst) in bursts.iter().enumerate() {
        let lasts_s = burst.spacing_s * (burst.parts.len() - 1) as f64;
        assert!((LASTS_S.0 - 1e-9..=LASTS_S.1 + 1e-9).contains(&lasts_s));
        assert!(!bursts[..n].contains(burst), "{}", burst.name());
    }
    assert!(bursts.iter().any(|b| b.is_even() && b.parts.len() == 3));
}

/// A wire that only expands is linear: three equal pulses in place of seven bring what the filters say, whatever the power.
#[test]
fn three_pulses_of_a_taut_wire_gain_three_decibels() {
    let setup = super::super::equal_power::setup(DRIVES[2], DRIVES[2].wires[1], &[]).unwrap();
    let worn = Worn::of(&setup).unwrap();
    let three = Burst {
        spacing_s: 0.01515,
        parts: vec![1; 3],
    };
    let gain = |watts| {
        worn.level_db(&three, watts).unwrap() - worn.level_db(&Burst::seven(), watts).unwrap()
    };
    let gains = [gain(6e-3), gain(9e-3)];
    assert!(gains.iter().all(|db| (db - 3.0).abs() < 0.1), "{gains:?}");
    assert!((gains[0] - gains[1]).abs() < 0.01, "{gains:?}");
}
