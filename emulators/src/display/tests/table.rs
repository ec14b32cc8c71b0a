//! Values that an independent computation of the same network gave, within 1 K.

use super::*;
use palpate_core::physics::{TissueParameters, WireParameters};

const MS: u64 = 1_000_000;

fn wire(share: f64, contact_h: f64) -> Wire {
    let tissue = TissueParameters {
        contact_h,
        ..TissueParameters::DEFAULT
    };
    let wire = WireParameters {
        wire_share: share,
        ..WireParameters::FINAL.taut()
    };
    at_constant_stress(&wire, &tissue)
}

#[test]
fn values_a_correct_model_gives() {
    // name, burst, cycle, length; per contact: wire peak, 0.1 mm, 0.4 mm, each for share 0.602 and 1.0.
    type Row = (&'static str, u64, u64, u64, [[[f64; 2]; 3]; 2]);
    let rows: [Row; 4] = [
        (
            "one burst",
            35,
            2000,
            2000,
            [
                [[70.6, 85.1], [34.4, 35.0], [33.1, 33.2]],
                [[64.1, 73.9], [35.0, 36.0], [33.2, 33.3]],
            ],
        ),
        (
            "round-robin",
            35,
            468,
            10_000,
            [
                [[71.0, 88.4], [35.8, 37.6], [34.0, 34.7]],
                [[65.8, 75.1], [36.7, 38.8], [34.1, 34.9]],
            ],
        ),
        (
            "dwelling",
            35,
            0,
            10_000,
            [
                [[119.0, 176.4], [53.5, 67.2], [41.4, 47.0]],
                [[94.0, 134.7], [56.7, 72.6], [42.7, 49.2]],
            ],
        ),
        (
            "continuous",
            10_000,
            10_000,
            10_000,
            [
                [[156.6, 239.0], [66.8, 89.4], [46.9, 56.1]],
                [[118.4, 175.2], [72.1, 98.1], [49.0, 59.7]],
            ],
        ),
    ];
    let mut worst: f64 = 0.0;
    for (name, burst, cycle, length, expected) in rows {
        let cycle = if cycle == 0 { 58_500_000 } else { cycle * MS };
        let train = edges(Nanos(burst * MS), Nanos(cycle), Nanos(length * MS));
        for (c, contact_h) in [2000.0, 10_000.0].into_iter().enumerate() {
            for (s, share) in [0.602, 1.0].into_iter().enumerate() {
                let mut w = wire(share, contact_h);
                play(&mut w, &train);
                let p = w.peaks(Nanos((length + 100) * MS));
                let got = [p.wire_c, p.shallow_c, p.deep_c];
                for (q, got) in got.into_iter().enumerate() {
                    let off = got - expected[c][q][s];
                    println!("{name} h{contact_h} s{share} {q}: {got:.3} ({off:+.3})");
                    worst = worst.max(off.abs());
                }
            }
        }
    }
    assert!(worst < 1.0, "{worst} K off the table");
}

#[test]
fn full_on_for_one_period() {
    for (share, expected) in [(0.602, 335.0), (1.0, 551.0)] {
        let mut w = wire(share, 2000.0);
        w.set_power(Nanos::ZERO, PULSE_W);
        w.set_power(PERIOD, 0.0);
        let peak = w.peaks(Nanos(100 * MS)).wire_c;
        println!("full on {share}: {peak:.3}");
        assert!((peak - expected).abs() < 1.0);
    }
}
