//! Tests of amplifiers whose current is set: what counts, what is refused, and that fixed ones stay as they were.

use super::*;
use crate::guard::{HARD, WornWire};
use crate::illusion::DisplayWire;
use crate::schedule::Entry;
use crate::units::{Board, Channel, Duration, Point, Ticks};
use alloc::vec::Vec;
use proptest::prelude::*;

const EXACT: CurrentControl = CurrentControl {
    full_scale: Milliamps(990),
    gain_ppm: 0,
    offset: Milliamps(0),
};

fn fixed() -> Guard {
    let wire = |n: u8| DisplayWire {
        place: Point::new(f32::from(n), 0.0),
        board: Board(0),
        channel: Channel(n),
    };
    Guard::new(
        HARD,
        Plant::default(),
        &[wire(0), wire(1)],
        WornWire::default(),
    )
    .unwrap()
}

fn set() -> Guard {
    fixed().with_current(EXACT).unwrap()
}

const fn asked(wire: u16, width: u16, milliamps: u32, at_us: u64) -> Stimulus {
    Stimulus {
        wire,
        width: Ticks::new(width),
        peak: Milliamps(milliamps),
        at: Instant::from_micros(at_us),
        until: Instant::from_micros(at_us + 35_000),
    }
}

/// Admits one stimulus, and confirms it where `arrives`.
fn admit(guard: &mut Guard, s: Stimulus, arrives: bool) -> Entry {
    let mut entries = Vec::new();
    while let Some(end) = guard.next_expiry().filter(|end| *end <= s.at) {
        let update = guard.expire(end, Board(0));
        guard.confirm(&update, end);
    }
    guard.hear(s.at);
    let update = guard.admit(s.at, Board(0), &[s], |entry| entries.push(entry));
    if arrives {
        guard.confirm(&update, update.at());
    } else {
        // What it ends has ended: only what it begins does not come.
        guard.wires.iter_mut().for_each(|wire| wire.ending = None);
    }
    entries.remove(0)
}

/// Energy, nJ, that the guard has booked on a wire since it was new.
fn booked(guard: &Guard, wire: usize) -> u64 {
    guard.wires[wire].burst.map_or(0, |burst| burst.spent_nj)
}

#[test]
fn energy_goes_with_the_square_of_the_larger_of_commanded_and_confirmed() {
    let full = Plant::default().energy_nj(50, Duration::from_millis(35));
    let at = |milliamps| {
        let plant = Plant {
            peak: Milliamps(milliamps),
            ..Plant::default()
        };
        plant.energy_nj(50, Duration::from_millis(35))
    };
    let mut guard = set();
    // Nothing is confirmed: the first one counts as the most there is.
    let entry = admit(&mut guard, asked(0, 50, 495, 0), true);
    assert_eq!(entry.current, Some(Milliamps(495)));
    assert_eq!(booked(&guard, 0), full);
    // From then on a quarter.
    admit(&mut guard, asked(0, 50, 495, 200_000), true);
    assert_eq!(booked(&guard, 0), at(495));
    assert!((full / 4).abs_diff(at(495)) <= 1);
    // A larger one counts whole, and a smaller one after it as that until it is confirmed.
    admit(&mut guard, asked(0, 50, 700, 400_000), false);
    assert_eq!(booked(&guard, 0), at(700));
    admit(&mut guard, asked(0, 50, 700, 600_000), true);
    admit(&mut guard, asked(0, 50, 300, 800_000), true);
    assert_eq!(booked(&guard, 0), at(700));
    admit(&mut guard, asked(0, 50, 300, 1_000_000), true);
    assert_eq!(booked(&guard, 0), at(300));
    // Another wire knows nothing of it.
    admit(&mut guard, asked(1, 50, 300, 1_200_000), true);
    assert_eq!(booked(&guard, 1), full);
}

#[test]
fn a_channel_that_goes_off_has_no_current_to_set() {
    let mut guard = set();
    let s = asked(0, 50, 300, 0);
    guard.hear(s.at);
    let on = guard.admit(s.at, Board(0), &[s], |_| {});
    assert_eq!(on.current(0), Some(Milliamps(300)));
    assert_eq!([on.current(1), on.current(16)], [None; 2]);
    let off = guard.release(s.until, Board(0));
    assert!(off.channels()[0].is_some());
    assert_eq!(off.current(0), None);
}

#[test]
fn what_is_told_of_a_schedule_is_what_was_booked() {
    let mut guard = set();
    let currents = [495, 495, 700, 300, 300, 990];
    let mut spent = Vec::new();
    let entries: Vec<_> = (0..)
        .zip(currents)
        .map(|(n, milliamps)| {
            let entry = admit(&mut guard, asked(0, 20, milliamps, 200_000 * n), true);
            spent.push(booked(&guard, 0));
            entry
        })
        .collect();
    let told = |entries: &[Entry]| -> Vec<_> {
        guard.booked(entries.iter()).map(|b| b.energy_nj).collect()
    };
    // Over and over: the last one's current, the full scale, is what the first one finds.
    assert_eq!(told(&entries), spent);
    // A stimulus without a pulse sets nothing.
    let (mut none, next) = (entries[2], entries[3]);
    none.off = none.on;
    assert_eq!(told(&[next, none]), [spent[4], 0]);
}

#[test]
fn an_all_off_leaves_no_current_confirmed() {
    let mut guard = set();
    admit(&mut guard, asked(0, 50, 300, 0), true);
    guard.all_off(Instant::from_micros(35_000));
    admit(&mut guard, asked(0, 50, 300, 200_000), true);
    let full = Plant::default().energy_nj(50, Duration::from_millis(35));
    assert_eq!(booked(&guard, 0), full);
}

#[test]
fn a_current_rises_only_once_the_last_pulse_of_the_wire_is_over() {
    let short = |width, milliamps, at_us: u64| Stimulus {
        until: Instant::from_micros(at_us + 10_000),
        ..asked(0, width, milliamps, at_us)
    };
    let mut guard = set();
    admit(&mut guard, short(20, 300, 0), true);
    // 10 ms on, and a period of 5.6 ms and the bus's millisecond may still bring a pulse.
    let early = admit(&mut guard, short(20, 400, 16_000), true);
    assert_eq!(early.current, Some(Milliamps(300)));
    assert_eq!(early.reason, Some(Reason::Current));
    // what is set already may be had again
    let same = admit(&mut guard, short(5, 300, 21_000), true);
    assert_eq!((same.current, same.reason), (Some(Milliamps(300)), None));
    let lower = admit(&mut guard, short(5, 200, 26_000), true);
    assert_eq!((lower.current, lower.reason), (Some(Milliamps(200)), None));
    let late = admit(&mut guard, asked(0, 5, 400, 160_000), true);
    assert_eq!((late.current, late.reason), (Some(Milliamps(400)), None));
    let over = admit(&mut guard, asked(0, 5, 1200, 360_000), true);
    assert_eq!(over.current, Some(Milliamps(990)));
    assert_eq!(over.reason, Some(Reason::Current));
    let full = admit(&mut guard, asked(0, 5, 990, 560_000), true);
    assert_eq!((full.current, full.reason), (Some(Milliamps(990)), None));
}

#[test]
fn what_an_amplifier_adds_counts() {
    let control = CurrentControl {
        full_scale: Milliamps(990),
        gain_ppm: 10_000,
        offset: Milliamps(5),
    };
    assert_eq!(control.most(Milliamps(495)), Milliamps(505)); // 4.95 mA of gain, rounded up
    let guard = fixed().with_current(control).unwrap();
    assert_eq!(guard.plant().peak, Milliamps(1005));
    let none = CurrentControl {
        full_scale: Milliamps(0),
        ..control
    };
    assert_eq!(
        fixed().with_current(none).err(),
        Some(PlantError::OutOfRange)
    );
    let absurd = CurrentControl {
        full_scale: Milliamps(u32::MAX),
        ..control
    };
    assert_eq!(
        fixed().with_current(absurd).err(),
        Some(PlantError::OutOfRange)
    );
}

proptest! {
    /// Whatever is asked and confirmed, a wire gets no more width than with fixed amplifiers of the full current, and no more
    /// energy is left to it than what truly flowed leaves.
    #[test]
    fn nothing_is_looser_than_what_flows(
        steps in prop::collection::vec((1_000..90_000u64, 0..2u16, 1..400u16, 1..1200u32, any::<bool>()), 1..40),
    ) {
        let mut guard = set();
        // By wire what the amplifier is set to, and what flowed at most since the start, nJ.
        let (mut amplifier, mut flowed, mut counted) = ([990; 2], [0_u64; 2], [0_u64; 2]);
        let mut at = 0;
        for (pause, wire, width, milliamps, arrives) in steps {
            at += pause;
            let s = asked(wire, width, milliamps, at);
            let before: Vec<u64> = (0..2).map(|w| guard.wires[w].power.left_pj_at(s.at)).collect();
            let entry = admit(&mut guard, s, arrives);
            let index = usize::from(wire);
            let set = entry.current.unwrap();
            prop_assert!(set.0 <= milliamps.min(990));
            let is_on = entry.off > entry.on;
            if is_on && arrives {
                amplifier[index] = set.0;
            }
            if is_on {
                let plant = Plant { peak: Milliamps(amplifier[index]), ..Plant::default() };
                let span = entry.until.since(entry.at);
                flowed[index] += if arrives { plant.energy_nj(entry.width().get(), span) } else { 0 };
            }
            let after = guard.wires[index].power.left_pj_at(s.at);
            counted[index] += before[index].saturating_sub(after) / 1000;
            prop_assert!(flowed[index] <= counted[index], "{} of {}", flowed[index], counted[index]);
            prop_assert!(booked(&guard, index) <= HARD.burst_energy_nj);
        }
    }
}
