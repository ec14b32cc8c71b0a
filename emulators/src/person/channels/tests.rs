//! The laws of `docs/felt.md`, section 5, and what must hold of any motion.

use super::*;
use core::f64::consts::TAU;

/// PRE_SCALE 30: the true period of the chip, s.
const T: f64 = 5.079_04e-3;

pub(super) fn person(a0: f64) -> Person {
    Person {
        vibration_um: a0,
        flutter_um: 1.0,
        np2_um: None,
        growth: [0.7, 1.0],
    }
}

pub(super) fn one() -> Perceiver {
    Perceiver::new(person(1.0), &[(0.0, 0.0)]).unwrap()
}

/// A displacement that rises evenly by `um` in `seconds`.
fn ramp(um: f64, seconds: f64) -> Stretch {
    Stretch {
        slopes: Stretch::sinking(seconds, -um / seconds, 1.0).slopes,
        ..Stretch::rest(seconds)
    }
}

/// A sine of 1 um from `from` on, in straight lines so short that no level changes by 0.001 dB.
pub(super) fn sine(perceiver: &mut Perceiver, hz: f64, from: f64, seconds: f64) {
    let step = 1.0 / (hz * 200.0);
    let count = (seconds / step).round() as usize;
    let at = |n: usize| libm::sin(TAU * hz * (from + n as f64 * step));
    for n in 0..count {
        perceiver.pass(0, &ramp(at(n + 1) - at(n), step));
    }
    perceiver.settle();
}

pub(super) fn db(amplitude: f64) -> f64 {
    20.0 * libm::log10(amplitude)
}

#[track_caller]
pub(super) fn near(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance,
        "expected {expected}, found {found}"
    );
}

/// Peak of both outputs for a lasting sine of 1 um.
fn response(hz: f64) -> Met {
    let mut perceiver = one();
    sine(&mut perceiver, hz, 0.0, 1.0);
    perceiver.onset();
    sine(&mut perceiver, hz, 1.0, 2.0 / hz);
    perceiver.wires[0].met
}

#[test]
fn both_filters_answer_sines_as_stated() {
    let p = [
        (40.0, -31.62),
        (100.0, -14.66),
        (125.0, -10.24),
        (196.89, -1.82),
        (250.0, 0.0),
        (393.78, -5.50),
        (500.0, -10.24),
    ];
    for (hz, expected) in p {
        near(db(response(hz).peak_p), expected, 0.02);
    }
    let n = [
        (10.0, -11.78),
        (20.0, -5.12),
        (40.0, 0.0),
        (80.0, -5.12),
        (196.89, -13.67),
    ];
    for (hz, expected) in n {
        near(db(response(hz).peak_n), expected, 0.02);
    }
}

#[test]
fn the_energy_of_a_sine_grows_with_its_length() {
    for (ms, expected) in [
        (20.0, -10.69),
        (100.0, -4.13),
        (200.0, -2.03),
        (500.0, -0.37),
    ] {
        let mut perceiver = one();
        sine(&mut perceiver, 250.0, 0.0, ms * 1e-3);
        // It rings on for a moment, which counts.
        perceiver.pass(0, &Stretch::rest(0.02));
        perceiver.settle();
        let felt = perceiver.felt(33.0).unwrap();
        near(felt.levels.vibration_db, expected, 0.02);
    }
}

/// Largest level of `count` equal steps every `spacing`, begun anew each `rest` if that is given, over 3 s.
fn train(count: usize, spacing: f64, rest: Option<f64>) -> Perceiver {
    let mut perceiver = one();
    let burst: Vec<Kick> = (0..count)
        .map(|n| Kick {
            at_s: n as f64 * spacing,
            um: 1.0,
        })
        .collect();
    let (length, times) = rest.map_or((0.5, 1), |rest| (rest, (3.0 / rest) as usize));
    for _ in 0..times {
        perceiver.kicks(0, &burst, length);
        perceiver.settle();
    }
    perceiver
}

fn threshold(perceiver: &Perceiver) -> f64 {
    // A level of 0 dB is a threshold of one step.
    libm::pow(
        10.0,
        -perceiver.felt(33.0).unwrap().levels.vibration_db / 20.0,
    )
}

#[test]
fn thresholds_of_steps_that_sink_are_as_stated() {
    let alone = [
        (1, 25.37),
        (2, 17.24),
        (3, 13.96),
        (4, 12.08),
        (5, 10.82),
        (7, 9.21),
        (39, 4.63),
    ];
    let relative = |found: f64, expected: f64| near(db(found / expected), 0.0, 0.02);
    for (count, expected) in alone {
        relative(threshold(&train(count, T, None)), expected);
    }
    relative(threshold(&train(4, 2.0 * T, None)), 13.13);
    relative(threshold(&train(3, 3.0 * T, None)), 15.18);
    for (ms, expected) in [
        (58.5, [4.62, 6.06, 8.66, 12.75]),
        (117.0, [6.11, 8.02, 11.46, 16.86]),
    ] {
        for (count, expected) in [7, 4, 2, 1].into_iter().zip(expected) {
            relative(threshold(&train(count, T, Some(ms * 1e-3))), expected);
        }
    }
    let peak = |count: usize| train(count, T, None).wires[0].met.peak_n;
    near(peak(1), 0.484, 0.001);
    near(peak(2), 0.744, 0.001);
    near(peak(7), 0.744, 0.001);
}

/// The default drive of the first round on the exact wire, moved by expansion as austenite with the gain that was fitted
/// then: section 5's row of the default bench. One burst, and bursts every 58.5 ms until 1.5 s.
#[test]
fn a_burst_of_the_exact_wire_is_felt_as_computed_elsewhere() {
    use crate::display::wire::Wire;
    use crate::time::Nanos;
    use palpate_core::physics::{TissueParameters, WireParameters};
    let (final_wire, tissue) = (WireParameters::FINAL.taut(), TissueParameters::DEFAULT);
    let um_per_k = 21.6 * final_wire.mechanics.expansion_austenite * final_wire.length_m * 1e6;
    let bursts = |count: u64| {
        let mut wire = Wire::new(&final_wire, &tissue, 33.0).unwrap();
        wire.keep_stretches();
        for burst in 0..count {
            for pulse in 0..7 {
                let at = Nanos(burst * 58_500_000 + pulse * 5_079_040);
                wire.set_current(at, 0.99);
                wire.set_current(at + Nanos(124_000), 0.0);
            }
        }
        let mut perceiver = Perceiver::new(
            Person {
                vibration_um: 0.26,
                flutter_um: 5.0,
                np2_um: None,
                growth: [0.7, 1.0],
            },
            &[(0.0, 0.0)],
        );
        let met = perceiver.as_mut().unwrap();
        wire.take_stretches(Nanos(count * 58_500_000), |stretch| {
            met.pass(
                0,
                &Stretch {
                    um_per_k,
                    ..*stretch
                },
            );
        });
        met.settle();
        let hottest = wire.peaks(wire.now()).wire_c;
        (hottest, met.felt(33.0).unwrap().levels)
    };
    let (wire_c, levels) = bursts(1);
    assert!((wire_c / 43.90 - 1.0).abs() < 0.01, "{wire_c}");
    near(levels.vibration_db, 0.44, 0.02);
    near(levels.flutter_db, -7.84, 0.02);
    let (wire_c, levels) = bursts(26);
    assert!((wire_c / 52.81 - 1.0).abs() < 0.01, "{wire_c}");
    near(levels.vibration_db, 6.42, 0.02);
}

/// Energies of wires add up, of NP I the strongest counts.
#[test]
fn wires_add_up_in_one_channel_only() {
    let level = |wires: usize| {
        let places = vec![(0.0, 0.0); wires];
        let mut perceiver = Perceiver::new(person(1.0), &places).unwrap();
        for wire in 0..wires {
            perceiver.kicks(wire, &[Kick { at_s: 0.0, um: 1.0 }], 0.05);
        }
        perceiver.settle();
        perceiver.felt(33.0).unwrap().levels
    };
    let (alone, four) = (level(1), level(4));
    near(
        four.vibration_db - alone.vibration_db,
        10.0 * libm::log10(4.0),
        1e-9,
    );
    near(four.flutter_db, alone.flutter_db, 1e-12);
}

#[test]
fn the_place_is_where_energy_and_peaks_are_since_the_onset() {
    let mut perceiver = Perceiver::new(person(1.0), &[(0.0, 1.0), (5.0, 1.0)]).unwrap();
    let kick = |um| [Kick { at_s: 0.001, um }];
    perceiver.kicks(0, &kick(2.0), 0.1);
    perceiver.kicks(1, &kick(1.0), 0.1);
    perceiver.settle();
    let felt = perceiver.felt(33.0).unwrap();
    near(felt.energy_mm.0, 1.0, 1e-9);
    near(felt.amplitude_mm.0, 5.0 / 3.0, 1e-9);
    assert!(felt.tap(), "one pulse is a tap");
    // After an onset only what comes then has a place, but the energy goes on.
    let before = felt.levels.vibration_db;
    perceiver.onset();
    perceiver.kicks(1, &kick(0.1), 0.05);
    perceiver.settle();
    let felt = perceiver.felt(33.0).unwrap();
    assert!(felt.levels.vibration_db > before - 2.6, "the leak is slow");
    assert!(felt.energy_mm.0 > 4.9, "{felt:?}");
}

#[test]
fn skin_that_is_cold_or_hot_feels_less_vibration() {
    let perceiver = train(7, T, None);
    let at = |c: f64| perceiver.felt(c).unwrap().levels;
    near(at(33.0).vibration_db - at(20.0).vibration_db, 8.0, 1e-9);
    near(at(33.0).vibration_db - at(44.0).vibration_db, 7.0, 1e-9);
    near(at(33.0).vibration_db, at(43.9).vibration_db, 1e-12);
    near(at(33.0).flutter_db, at(20.0).flutter_db, 1e-12);
}

#[test]
fn the_weaker_channel_counts_half_above_threshold_only() {
    let levels = |vibration_db, flutter_db| Levels {
        vibration_db,
        flutter_db,
        ..Levels::SILENT
    };
    near(
        levels(20.0, 20.0).intensity([0.5, 1.0]),
        10.0 + 0.5 * libm::sqrt(10.0),
        1e-9,
    );
    near(levels(0.0, -0.1).intensity([0.7, 1.0]), 1.0, 1e-12);
    near(levels(-0.1, -0.1).intensity([0.7, 1.0]), 0.0, 1e-12);
    assert!(levels(-1.0, 0.0).felt() && !levels(-0.1, -0.1).felt());
}

/// However a motion is cut into stretches and accounts, what is met is the same.
#[test]
fn cutting_time_changes_nothing() {
    let whole = train(7, T, None);
    let mut cut = one();
    let (mut lifted, step) = (0.0, 1.37e-3);
    for n in 0..7 {
        cut.lift(0, 1.0);
        lifted += 1.0;
        let mut left = if n == 6 { 0.5 - 6.0 * T } else { T };
        while left > 0.0 {
            let span: f64 = left.min(step);
            cut.pass(0, &Stretch::sinking(span, lifted, 40.0));
            lifted *= libm::exp(-40.0 * span);
            left -= span;
            cut.settle();
        }
    }
    let (a, b) = (whole.felt(33.0).unwrap(), cut.felt(33.0).unwrap());
    // The looks are at other times.
    near(a.levels.vibration_db, b.levels.vibration_db, 2e-3);
    near(a.energy / b.energy, 1.0, 1e-8);
    near(whole.energy / cut.energy, 1.0, 1e-8);
    for (a, b) in whole.wires[0].x.iter().zip(cut.wires[0].x) {
        near(*a, b, 1e-12);
    }
}

/// What bounds leave out is never the largest.
#[test]
fn bounds_leave_out_nothing_that_counts() {
    let mut perceiver = Perceiver::new(person(1.0), &[(0.0, 0.0), (3.0, 0.0)]).unwrap();
    for burst in 0..6 {
        for wire in 0..2 {
            let first = f64::from(wire) * 1.3e-3;
            let kicks: Vec<Kick> = (0..7)
                .map(|n| Kick {
                    at_s: first + f64::from(n) * T,
                    um: f64::from((burst * 5 + wire * 3) % 7),
                })
                .collect();
            perceiver.kicks(wire as usize, &kicks, 0.0585);
        }
        let end = perceiver.wires[0].now_s;
        let mut longest = perceiver.energy;
        for look in 0..=(end / LOOK_S) as usize {
            let t = [look as f64 * LOOK_S];
            let mut sum = [0.0];
            for wire in &perceiver.wires {
                wire.add_energies(&perceiver.shared.rule, &t, &mut sum);
            }
            longest = longest.max(perceiver.leaked(t[0], sum[0]));
        }
        let all = perceiver.wires.iter().map(|w| w.energy).sum();
        longest = longest.max(perceiver.leaked(end, all));
        near(perceiver.largest(end) / longest, 1.0, 1e-13);
        perceiver.settle();
    }
}

/// Where wires only drift, hardly any time is looked at, and the largest is the same to the bit.
#[test]
fn what_drifts_is_as_large_as_with_every_look() {
    let mut perceiver = Perceiver::new(person(1.0), &[(0.0, 0.0), (3.0, 0.0)]).unwrap();
    for burst in 0..40 {
        for wire in 0..2 {
            let (um, rate) = (20.0 / f64::from(1 + wire), 0.4 + f64::from(wire));
            let left = libm::exp(-rate * 0.117 * f64::from(burst));
            perceiver.pass(wire as usize, &Stretch::sinking(0.117, um * left, rate));
        }
        let end = perceiver.wires[0].now_s;
        let all = perceiver.wires.iter().map(|w| w.energy).sum();
        let mut longest = perceiver.energy.max(perceiver.leaked(end, all));
        for look in 0..=(end / LOOK_S) as usize {
            let (t, mut sum) = ([look as f64 * LOOK_S], [0.0]);
            for wire in &perceiver.wires {
                wire.add_energies(&perceiver.shared.rule, &t, &mut sum);
            }
            longest = longest.max(perceiver.leaked(t[0], sum[0]));
        }
        assert!(all > 0.0, "it drifts");
        // A first account begins with an edge, from which both filters ring.
        let falls_from = perceiver.falls_from(end).unwrap();
        assert!(
            falls_from <= if burst == 0 { 0.06 } else { 0.0 },
            "{falls_from}"
        );
        assert_eq!(
            perceiver.largest(end).to_bits(),
            longest.to_bits(),
            "{burst}"
        );
        perceiver.settle();
    }
}

#[test]
fn what_is_no_number_moves_nothing_and_no_person_is_impossible() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut perceiver = one();
        perceiver.lift(0, bad);
        perceiver.lift(7, 1.0);
        perceiver.pass(0, &Stretch::rest(bad));
        perceiver.pass(
            0,
            &Stretch {
                um_per_k: bad,
                ..Stretch::rest(0.01)
            },
        );
        perceiver.pass(0, &Stretch::sinking(0.01, bad, 40.0));
        perceiver.pass(0, &Stretch::sinking(0.01, 1.0, bad));
        perceiver.pass(
            0,
            &Stretch {
                slopes: [1e300; 17],
                ..Stretch::rest(0.01)
            },
        );
        perceiver.kicks(0, &[Kick { at_s: bad, um: bad }], 0.01);
        perceiver.settle();
        assert_eq!(perceiver.felt(33.0), None, "{bad}");
        perceiver.kicks(0, &[Kick { at_s: 0.0, um: 1.0 }], 0.05);
        perceiver.settle();
        assert!(perceiver.felt(bad).unwrap().levels.vibration_db.is_finite());
        for (a0, a_n, n) in [
            (bad, 1.0, 1.0),
            (-1.0, 1.0, 1.0),
            (1.0, bad, 1.0),
            (1.0, 1.0, bad),
        ] {
            let wrong = Person {
                vibration_um: a0,
                flutter_um: a_n,
                np2_um: None,
                growth: [n, 1.0],
            };
            assert!(Perceiver::new(wrong, &[]).is_err());
            let np2_um = Some(bad);
            let wrong = Person {
                np2_um,
                ..person(1.0)
            };
            assert!(Perceiver::new(wrong, &[]).is_err());
        }
    }
}

/// What the weave of a moving contact's texture does: pulses of a burst are left out, the others grow by the root.
#[test]
fn a_thinned_out_burst_that_is_widened_feels_as_strong() {
    let level = |periods: &[u8], um: f64| {
        let kick = |n: &u8| Kick {
            at_s: f64::from(*n) * T,
            um,
        };
        let kicks: Vec<Kick> = periods.iter().map(kick).collect();
        let mut perceiver = one();
        perceiver.kicks(0, &kicks, 0.0585);
        perceiver.settle();
        perceiver.felt(33.0).unwrap().levels.vibration_db
    };
    let whole = level(&[0, 1, 2, 3, 4, 5, 6], 10.0);
    for left in [
        &[0, 1, 2, 4, 5][..],
        &[0, 1, 3, 4, 6],
        &[0, 2, 4, 6],
        &[0, 3, 6],
    ] {
        let gain = libm::sqrt(7.0 / left.len() as f64);
        let (widened, plain) = (level(left, 10.0 * gain) - whole, level(left, 10.0) - whole);
        println!(
            "{} pulses: {widened:.2} dB widened, {plain:.2} dB not",
            left.len()
        );
        assert!(widened.abs() < 1.0 && plain < -1.0, "{widened} {plain}");
    }
}
