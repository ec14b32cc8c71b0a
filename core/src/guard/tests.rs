//! Grids dense at the boundaries of the static limits.

use alloc::vec::Vec;

use super::*;
use crate::schedule::Reason;
use crate::units::{Milliamps, Point, Prescale, Ticks};

const THESIS: Plant = Plant {
    prescale: Prescale::new(30),
    wire_milliohm: 1900,
    peak: Milliamps(1970),
    bus: Duration::ZERO,
};

fn wires(n: u8) -> Vec<DisplayWire> {
    let wire = |c: u8| DisplayWire {
        place: Point::new(f32::from(c), 0.0),
        board: Board(0),
        channel: Channel(c),
    };
    (0..n).map(wire).collect()
}

fn guard(limits: Limits, plant: Plant) -> Guard {
    Guard::new(limits, plant, &wires(8), WornWire::default()).unwrap()
}

fn stimulus(wire: u16, width: u16, at_us: u64, length_us: u64) -> Stimulus {
    Stimulus {
        wire,
        width: Ticks::new(width),
        peak: Milliamps(1970),
        at: Instant::from_micros(at_us),
        until: Instant::from_micros(at_us + length_us),
    }
}

fn admit(guard: &mut Guard, stimuli: &[Stimulus]) -> (Guarded, Vec<Entry>) {
    let mut entries = Vec::new();
    let at = stimuli[0].at;
    // Each wire ends once; a guard that forgets to end one shall fail, not hang.
    for _ in 0..guard.wires.len() {
        if let Some(end) = guard.next_expiry().filter(|end| *end <= at) {
            guard.expire(end, Board(0));
        }
    }
    let update = guard.admit(at, Board(0), stimuli, |e| entries.push(e));
    (update, entries)
}

#[test]
fn the_thesis_burst_passes_unchanged() {
    let mut guard = guard(HARD, THESIS);
    let (update, entries) = admit(&mut guard, &[stimulus(3, 100, 0, 35_000)]);
    assert_eq!(update.channels()[3], Some(Setting { on: 768, off: 868 }));
    assert_eq!(entries[0].reason, None);
    assert_eq!(entries[0].width(), Ticks::new(100));
    assert_eq!(update.channels().iter().flatten().count(), 1);
}

#[test]
fn pulse_width_is_clamped_at_the_slowest_oscillator() {
    // 200 us / (31 / 23 MHz) = 148.4 ticks at PRE = 30.
    for width in [147, 148, 149, 150, 4095, 4096] {
        let mut guard = guard(
            HARD,
            Plant {
                peak: Milliamps(500),
                ..THESIS
            },
        );
        let mut asked = stimulus(0, width, 0, 35_000);
        asked.peak = Milliamps(500);
        let (_, entries) = admit(&mut guard, &[asked]);
        assert_eq!(entries[0].width().get(), width.min(148));
        assert_eq!(
            entries[0].reason,
            (width > 148).then_some(Reason::PulseWidth)
        );
        assert_eq!(entries[0].requested, Ticks::new(width));
    }
}

#[test]
fn ticks_are_those_of_the_boards_that_are_guarded() {
    for (prescale, most) in [(30, 148), (60, 75), (121, 37)] {
        let prescale = Prescale::new(prescale);
        let mut guard = guard(
            HARD,
            Plant {
                prescale,
                peak: Milliamps(500),
                ..THESIS
            },
        );
        assert_eq!(guard.prescale(), prescale);
        let mut asked = stimulus(0, 4095, 0, 35_000);
        asked.peak = Milliamps(500);
        let (_, entries) = admit(&mut guard, &[asked]);
        assert_eq!(entries[0].width().get(), most, "{prescale:?}");
    }
}

#[test]
fn a_burst_is_cut_at_50_ms() {
    // From its first edge to its last it may be longer by a pulse and the bus, 1.2 ms.
    for (length, kept) in [
        (48_799, 48_799),
        (48_800, 48_800),
        (48_801, 48_800),
        (900_000, 48_800),
    ] {
        let mut guard = guard(HARD, THESIS);
        let (_, entries) = admit(&mut guard, &[stimulus(0, 50, 0, length)]);
        assert_eq!(entries[0].until, Instant::from_micros(kept));
        let cut = (length > kept).then_some(Reason::Burst);
        assert_eq!(entries[0].reason, cut);
        assert_eq!(entries[0].requested_until, Instant::from_micros(length));
    }
}

#[test]
fn bursts_closer_than_20_ms_are_one_burst() {
    // 28 ms, then a pause: under 21.2 ms only 48.8 ms - elapsed is left of the burst.
    for (pause, second) in [(0, 20_800), (10_000, 10_800), (20_799, 1), (21_200, 30_000)] {
        let mut guard = guard(HARD, THESIS);
        admit(&mut guard, &[stimulus(0, 40, 0, 28_000)]);
        let at = 28_000 + pause;
        let (_, entries) = admit(&mut guard, &[stimulus(0, 40, at, 30_000)]);
        assert_eq!(
            entries[0].until.as_micros() - at,
            second,
            "pause {pause} us"
        );
        assert_eq!(
            entries[0].reason,
            (second < 30_000).then_some(Reason::Burst)
        );
    }
}

#[test]
fn a_burst_that_used_its_time_is_refused_until_the_gap() {
    let mut guard = guard(HARD, THESIS);
    admit(&mut guard, &[stimulus(0, 40, 0, 48_800)]);
    let (update, entries) = admit(&mut guard, &[stimulus(0, 40, 60_000, 30_000)]);
    assert_eq!(
        (entries[0].width(), entries[0].reason),
        (Ticks::ZERO, Some(Reason::Burst))
    );
    assert!(update.channels()[0].is_none_or(|s| s.on == s.off));
}

#[test]
fn burst_energy_stays_under_its_limit() {
    // 7.37 W, 148 ticks, 48.8 ms: 14.7 mJ at worst, narrowed to 10 mJ.
    let mut guard = guard(HARD, THESIS);
    let (_, entries) = admit(&mut guard, &[stimulus(0, 148, 0, 48_800)]);
    assert_eq!(entries[0].reason, Some(Reason::Burst));
    let width = entries[0].width().get();
    let energy = |w: u16| THESIS.energy_nj(w, Duration::from_micros(48_800));
    assert!(
        energy(width) <= 10_000_000 && energy(width + 1) > 10_000_000,
        "{width} ticks"
    );
}

#[test]
fn a_burst_that_takes_just_what_is_left_is_not_limited() {
    let asked = THESIS.energy_nj(100, Duration::from_micros(35_000));
    for (left, width, reason) in [
        (asked, 100, None),
        (asked - 1, 99, Some(Reason::Burst)),
        (asked / 101, 0, Some(Reason::Burst)),
    ] {
        let limits = Limits {
            burst_energy_nj: left,
            ..HARD
        };
        let mut guard = guard(limits, THESIS);
        let (_, entries) = admit(&mut guard, &[stimulus(0, 100, 0, 35_000)]);
        assert_eq!(
            (entries[0].width().get(), entries[0].reason),
            (width, reason)
        );
        // What was refused has begun no burst and warmed nothing.
        let rested = guard.predicted().peak_c == 33.0;
        assert_eq!(rested, width == 0);
        let long = Instant::from_micros(40_000 + 48_800);
        assert_eq!(
            guard.has_time(0, Instant::from_micros(40_000), long),
            width == 0
        );
    }
}

#[test]
fn of_rows_that_leave_the_same_the_first_is_the_reason() {
    // With next to nothing in a second, neither longer window matters: wire and fingertip have the same left.
    let limits = Limits {
        wire_1s_uw: 1000,
        fingertip_1s_uw: 1000,
        ..HARD
    };
    let mut guard = guard(limits, THESIS);
    let (_, entries) = admit(&mut guard, &[stimulus(0, 100, 0, 35_000)]);
    assert_eq!(entries[0].reason, Some(Reason::WirePower));
}

#[test]
fn a_dwelling_wire_is_held_to_45_mw_over_1_s_and_20_mw_over_10_s() {
    let mut guard = guard(HARD, THESIS);
    let mut spent: Vec<(u64, f64)> = Vec::new();
    for k in 0..400u64 {
        let at = k * 58_500;
        let (_, entries) = admit(&mut guard, &[stimulus(0, 100, at, 35_000)]);
        // It fades to a steady level and is never silent.
        assert!(
            entries[0].width().get() >= 10,
            "silent at {at} us: {:?}",
            entries[0]
        );
        // What nominal pulses deliver, spread over the burst as its mean.
        spent.push((at, 7.373_71 * entries[0].width().duty() * 35e-3));
        for (window_us, limit_w) in [(1_000_000u64, 0.045), (10_000_000, 0.020)] {
            let end = at + 35_000;
            let energy: f64 = spent
                .iter()
                .map(|&(t, e)| {
                    let overlap = (t + 35_000)
                        .min(end)
                        .saturating_sub(t.max(end.saturating_sub(window_us)));
                    e * overlap as f64 / 35_000.0
                })
                .sum();
            let mean = energy / (window_us as f64 * 1e-6);
            assert!(mean <= limit_w, "{mean} W over {window_us} us at {at} us");
        }
    }
    // And it is a limit, not a silence: the bucket refills at 17.2 mW, of which the pulse that may come
    // too many takes an eighth.
    let last_10s: f64 = spent
        .iter()
        .filter(|(t, _)| *t > 399 * 58_500 - 10_000_000)
        .map(|(_, e)| e)
        .sum();
    assert!(last_10s / 10.0 > 0.0145, "{} W", last_10s / 10.0);
}

#[test]
fn a_fingertip_is_held_to_110_mw_over_1_s_and_60_mw_over_60_s() {
    let mut guard = guard(HARD, THESIS);
    let mut spent: Vec<(u64, f64)> = Vec::new();
    let mut seen = false;
    for k in 0..1200u64 {
        let at = k * 58_500;
        let all: Vec<Stimulus> = (0..8).map(|w| stimulus(w, 60, at, 35_000)).collect();
        let (_, entries) = admit(&mut guard, &all);
        seen |= entries
            .iter()
            .any(|e| e.reason == Some(Reason::FingertipPower));
        let energy = entries
            .iter()
            .map(|e| 7.373_71 * e.width().duty() * 35e-3)
            .sum();
        spent.push((at, energy));
        for (window_us, limit_w) in [(1_000_000u64, 0.110), (60_000_000, 0.060)] {
            let since = (at + 35_000).saturating_sub(window_us);
            let energy: f64 = spent
                .iter()
                .filter(|(t, _)| *t >= since)
                .map(|(_, e)| e)
                .sum();
            assert!(energy / (window_us as f64 * 1e-6) <= limit_w);
        }
    }
    assert!(seen);
}

#[test]
fn unstaggered_wires_beyond_the_supply_are_refused() {
    // Two boards are not synchronised: their peaks add, and 3 A feed only one wire of 1.97 A.
    let mut pair = wires(2);
    pair[1].board = Board(1);
    let limits = Limits {
        supply: Milliamps(3000),
        ..HARD
    };
    let mut guard = Guard::new(limits, THESIS, &pair, WornWire::default()).unwrap();
    let mut entries = Vec::new();
    guard.admit(
        Instant::ZERO,
        Board(0),
        &[stimulus(0, 100, 0, 35_000)],
        |e| entries.push(e),
    );
    guard.admit(
        Instant::ZERO,
        Board(1),
        &[stimulus(1, 100, 0, 35_000)],
        |e| entries.push(e),
    );
    assert_eq!(entries[0].reason, None);
    assert_eq!(
        (entries[1].width(), entries[1].reason),
        (Ticks::ZERO, Some(Reason::SupplyCurrent))
    );
    // Staggered on one board, eight wires draw the current of one.
    let mut guard = Guard::new(limits, THESIS, &wires(8), WornWire::default()).unwrap();
    let all: Vec<Stimulus> = (0..8).map(|w| stimulus(w, 20, 0, 35_000)).collect();
    assert!(admit(&mut guard, &all).1.iter().all(|e| e.reason.is_none()));
}

#[test]
fn pulses_wide_enough_to_overlap_count_together() {
    // At 1526 Hz 200 us are 1150 ticks at the slowest oscillator: neighbours 256 apart overlap.
    let plant = Plant {
        prescale: Prescale::MIN,
        ..THESIS
    };
    let limits = Limits {
        supply: Milliamps(4000),
        ..HARD
    };
    let mut guard = Guard::new(limits, plant, &wires(8), WornWire::default()).unwrap();
    let asked: Vec<Stimulus> = (0..3).map(|w| stimulus(w, 600, 0, 1_000)).collect();
    let (_, entries) = admit(&mut guard, &asked);
    assert_eq!(entries[1].reason, None);
    assert_eq!(entries[2].reason, Some(Reason::SupplyCurrent));
}

#[test]
fn wires_without_a_stimulus_are_switched_off() {
    let mut guard = guard(HARD, THESIS);
    admit(
        &mut guard,
        &[stimulus(0, 50, 0, 35_000), stimulus(1, 50, 0, 35_000)],
    );
    let (update, _) = admit(&mut guard, &[stimulus(1, 50, 30_000, 10_000)]);
    assert_eq!(update.channels()[0], Some(Setting { on: 0, off: 0 }));
    assert_eq!(update.channels()[1], Some(Setting { on: 256, off: 306 }));
    let off = guard.release(Instant::from_micros(39_000), Board(0));
    assert_eq!(off.channels().iter().flatten().count(), 1);
    assert_eq!(off.channels()[1], Some(Setting { on: 256, off: 256 }));
}

#[test]
fn each_wire_ends_at_its_own_time() {
    let mut guard = guard(HARD, THESIS);
    admit(
        &mut guard,
        &[stimulus(0, 30, 0, 60_000), stimulus(1, 30, 0, 35_000)],
    );
    assert_eq!(guard.next_expiry(), Some(Instant::from_micros(35_000)));
    let none = guard.expire(Instant::from_micros(34_999), Board(0));
    assert!(none.channels().iter().all(Option::is_none));
    let first = guard.expire(Instant::from_micros(35_000), Board(0));
    assert_eq!(first.channels()[1], Some(Setting { on: 256, off: 256 }));
    assert_eq!(first.channels()[0], None);
    assert_eq!(guard.next_expiry(), Some(Instant::from_micros(48_800)));
    guard.all_off(Instant::from_micros(40_000));
    assert_eq!(guard.next_expiry(), None);
}

#[test]
fn a_latch_refuses_all_and_keeps_its_first_cause() {
    let mut guard = guard(HARD, THESIS);
    guard.latch(Cause::ActuatorError);
    guard.latch(Cause::LateTick);
    let (update, entries) = admit(&mut guard, &[stimulus(0, 100, 0, 35_000)]);
    assert_eq!(guard.latched(), Some(Cause::ActuatorError));
    assert_eq!(
        (entries[0].width(), entries[0].reason),
        (Ticks::ZERO, Some(Reason::Latched))
    );
    assert!(update.channels().iter().all(Option::is_none));
    assert_eq!(guard.reset(Instant::ZERO), Err(Cause::StaleInput));
    guard.hear(Instant::ZERO);
    assert_eq!(guard.watch(Instant::ZERO), None);
    assert_eq!(guard.reset(Instant::ZERO), Ok(()));
    assert_eq!(guard.latched(), None);
    let passed = admit(&mut guard, &[stimulus(0, 100, 0, 35_000)]).1;
    assert_eq!(passed[0].reason, None);
}

#[test]
fn the_watchdog_watches_what_is_driven() {
    let mut guard = guard(HARD, THESIS);
    let us = Instant::from_micros;
    assert!(guard.is_stale(us(0)) && guard.deadline().is_none() && guard.heard().is_none());
    guard.hear(us(1000));
    assert!(!guard.is_stale(us(1000)) && guard.heard() == Some(us(1000)));
    admit(&mut guard, &[stimulus(0, 50, 1000, 35_000)]);
    // 100 ms less what the switching takes, 12 ms.
    assert_eq!(guard.deadline(), Some(us(1000 + 100_000 - 12_042)));
    assert_eq!(guard.watch(us(88_957)), None);
    assert_eq!(guard.watch(us(88_958)), Some(Cause::StaleInput));
    guard.hear(us(100_000));
    assert_eq!(guard.watch(us(100_000)), None);
    assert_eq!(guard.watch(us(36_000 + 87_958)), Some(Cause::LateTick));
    guard.all_off(us(124_000));
    assert_eq!(guard.watch(us(124_000)), None);
    assert_eq!(guard.ready(us(124_000)), Ok(()));
}

#[test]
fn what_drives_nothing_is_ignored() {
    let mut guard = guard(HARD, THESIS);
    let (_, entries) = admit(
        &mut guard,
        &[stimulus(8, 100, 0, 35_000), stimulus(u16::MAX, 1, 0, 1)],
    );
    assert!(entries.is_empty());
    let (update, entries) = admit(
        &mut guard,
        &[stimulus(0, 0, 0, 35_000), stimulus(1, 5, 0, 0)],
    );
    assert!(update.channels().iter().all(Option::is_none));
    assert!(
        entries
            .iter()
            .all(|e| e.width() == Ticks::ZERO && e.reason.is_none())
    );
}

#[test]
fn an_update_says_when_and_where_and_leaves_other_boards_alone() {
    let mut pair = wires(2);
    pair[1].board = Board(1);
    let mut guard = Guard::new(HARD, THESIS, &pair, WornWire::default()).unwrap();
    assert_eq!(*guard.limits(), HARD);
    assert_eq!(guard.predicted().peak_c, 33.0);
    let both = [stimulus(0, 50, 0, 35_000), stimulus(1, 50, 0, 35_000)];
    let at = Instant::from_micros(7);
    let mut entries = 0;
    let update = guard.admit(at, Board(1), &both, |_| entries += 1);
    assert_eq!((update.at(), update.board(), entries), (at, Board(1), 1));
    assert_eq!(update.channels()[0], None);
    assert!(guard.predicted().peak_c > 33.5);
    let off = guard.release(at, Board(0));
    assert!(off.channels().iter().all(Option::is_none));
}

#[test]
fn what_is_switched_off_late_is_booked() {
    let mut late = guard(HARD, THESIS);
    let mut punctual = late.clone();
    for guard in [&mut late, &mut punctual] {
        guard.admit(
            Instant::ZERO,
            Board(0),
            &[stimulus(0, 100, 0, 20_000)],
            |_| (),
        );
    }
    punctual.expire(Instant::from_micros(20_000), Board(0));
    late.expire(Instant::from_micros(30_000), Board(0));
    assert!(late.predicted().peak_c > punctual.predicted().peak_c + 0.5);
    let mut dead = guard(HARD, THESIS);
    dead.admit(
        Instant::ZERO,
        Board(0),
        &[stimulus(0, 100, 0, 20_000)],
        |_| (),
    );
    dead.all_off(Instant::from_micros(30_000));
    assert_eq!(dead.predicted(), late.predicted());
    // The burst ended later, so the gap after it does too, and less is left of its energy.
    let again = [stimulus(0, 40, 45_000, 35_000)];
    assert_eq!(admit(&mut punctual, &again).1[0].reason, None);
    assert_eq!(admit(&mut late, &again).1[0].reason, Some(Reason::Burst));
}

#[test]
fn implausible_plants_are_refused() {
    for plant in [
        Plant {
            wire_milliohm: 0,
            ..THESIS
        },
        Plant {
            wire_milliohm: 1_000_001,
            ..THESIS
        },
        Plant {
            peak: Milliamps(0),
            ..THESIS
        },
        Plant {
            peak: Milliamps(100_001),
            ..THESIS
        },
    ] {
        assert_eq!(
            Guard::new(HARD, plant, &wires(1), WornWire::default()).err(),
            Some(PlantError::OutOfRange)
        );
    }
}
