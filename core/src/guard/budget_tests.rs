//! What is read is what the guard does.

use alloc::{format, vec::Vec};

use proptest::prelude::*;

use super::*;
use crate::guard::{HARD, Limits, Plant, Setting, WornWire};
use crate::illusion::DisplayWire;
use crate::schedule::{Entry, Stimulus};
use crate::units::{Board, Channel, Milliamps, Point, Prescale};

const WIRES: u16 = 4;

/// Two boards of two wires.
fn guard(limits: Limits, milliamps: u32) -> Guard {
    guard_at(Prescale::new(30), limits, milliamps)
}

fn guard_at(prescale: Prescale, limits: Limits, milliamps: u32) -> Guard {
    let wire = |c: u8| DisplayWire {
        place: Point::new(f32::from(c), 0.0),
        board: Board(c / 2),
        channel: Channel(c % 2),
    };
    let wires: Vec<_> = (0..WIRES as u8).map(wire).collect();
    let plant = Plant {
        prescale,
        wire_milliohm: 1900,
        peak: Milliamps(milliamps),
        bus: Duration::ZERO,
    };
    Guard::new(limits, plant, &wires, WornWire::default()).unwrap()
}

/// A table that leaves one row after another the tightest.
fn limits(tight: u8) -> Limits {
    let mut limits = HARD;
    match tight {
        0 => limits.burst_energy_nj = 900_000,
        1 => limits.skin_peak_mc = 34_200,
        2 => limits.skin_mean_mc = 33_300,
        3 => limits.skin_deep_mc = 33_200,
        4 => limits.dose_cem43_ms = 1,
        5 => limits.wire_1s_uw = 3_000,
        6 => limits.fingertip_1s_uw = 3_000,
        7 => limits.supply = Milliamps(1500),
        _ => {}
    }
    limits
}

fn stimulus(wire: u16, width: u16, at: u64, until: u64) -> Stimulus {
    Stimulus {
        wire,
        width: Ticks::new(width),
        peak: Milliamps(990),
        at: Instant::from_micros(at),
        until: Instant::from_micros(until),
    }
}

/// One stimulus through the guard, after all that has ended by then.
fn admit(guard: &mut Guard, s: Stimulus) -> Entry {
    for board in [Board(0), Board(1)] {
        guard.expire(s.at, board);
    }
    let mut entry = None;
    let board = Board(s.wire as u8 / 2);
    guard.admit(s.at, board, &[s], |e| entry = Some(e));
    entry.unwrap()
}

/// A guard with some history, the time after it, and a stimulus that could come next: wire, start, end.
fn history() -> impl Strategy<Value = (Guard, u16, u64, u64)> {
    let past = prop::collection::vec((0..WIRES, 0u16..200, 1u64..60_000, 0u64..600_000), 0..25);
    let next = (0..WIRES, 1u64..60_000, 400u32..2200, 0u8..9);
    (past, next).prop_map(|(past, (wire, length, milliamps, tight))| {
        let mut guard = guard(limits(tight), milliamps);
        let mut at = 0;
        for (wire, width, length, pause) in past {
            admit(&mut guard, stimulus(wire, width, at, at + length));
            at += length + pause;
        }
        for board in [Board(0), Board(1)] {
            guard.expire(Instant::from_micros(at), board);
        }
        (guard, wire, at, at + length)
    })
}

/// The widest of a budget, in ticks, that brings at most so much.
fn fits(guard: &Guard, budget: &WireBudget, at: Instant, nj: u64) -> u16 {
    let span = budget.until.since(at);
    let mut width = budget.widest.get();
    while width > 0 && guard.energy_nj(Ticks::new(width), span) > nj {
        width -= 1;
    }
    width
}

fn read(guard: &Guard, wire: u16, at: u64, until: u64) -> Option<WireBudget> {
    let [from, to] = [at, until].map(Instant::from_micros);
    guard.budget(usize::from(wire), from, to)
}

proptest! {
    #[test]
    fn what_keeps_to_the_budget_passes_unchanged((mut guard, wire, at, until) in history()) {
        let begun = Instant::from_micros(at);
        let Some(budget) = read(&guard, wire, at, until) else {
            let entry = admit(&mut guard, stimulus(wire, 100, at, until));
            prop_assert_eq!(entry.width(), Ticks::ZERO);
            return Ok(());
        };
        let width = fits(&guard, &budget, begun, budget.least().1);
        let mut asked = stimulus(wire, width, at, until);
        asked.until = budget.until;
        let entry = admit(&mut guard, asked);
        if budget.supply {
            prop_assert_eq!((entry.reason, entry.width()), (None, asked.width));
            prop_assert_eq!(entry.until, asked.until);
        } else if width > 0 {
            prop_assert_eq!(entry.reason, Some(Reason::SupplyCurrent));
        }
    }

    /// Where one row leaves less than the others, it is the one that changes what goes 2 % beyond it, and down to it.
    #[test]
    fn what_goes_beyond_one_row_is_narrowed_by_that_row((guard, wire, at, until) in history()) {
        let begun = Instant::from_micros(at);
        let Some(budget) = read(&guard, wire, at, until).filter(|b| b.supply) else {
            return Ok(());
        };
        let (row, least) = budget.least();
        let width = fits(&guard, &budget, begun, least + least / 50) + 1;
        prop_assume!(width <= budget.widest.get());
        let mut asked = stimulus(wire, width, at, until);
        asked.until = budget.until;
        let span = budget.until.since(begun);
        let beyond = |nj: u64| guard.energy_nj(asked.width, span) > nj;
        let others = budget.energy_nj.iter().filter(|r| r.0 != row);
        prop_assume!(others.clone().all(|r| !beyond(r.1)));
        let applied = admit(&mut guard.clone(), asked);
        prop_assert_eq!(applied.reason, Some(row));
        prop_assert!(applied.width() < asked.width);
        let wider = Ticks::new(applied.width().get() + 1);
        prop_assert!(guard.energy_nj(applied.width(), span) <= least);
        prop_assert!(guard.energy_nj(wider, span) + 1 >= least, "{wider:?} of {least}");
    }

    #[test]
    fn reading_changes_nothing((guard, wire, at, until) in history()) {
        let before = format!("{guard:?}");
        let _ = read(&guard, wire, at, until);
        let _ = guard.second_uw(usize::from(wire), Instant::from_micros(at));
        prop_assert_eq!(before, format!("{guard:?}"));
    }

    #[test]
    fn no_question_is_too_odd(
        (guard, ..) in history(),
        wire: usize,
        at: u64,
        until: u64,
        near in 0u64..10_000_000,
    ) {
        for (at, until) in [(at, until), (near, until), (at, near), (near, near)] {
            let [at, until] = [at, until].map(Instant::from_micros);
            for wire in [wire, 0] {
                let _ = guard.budget(wire, at, until);
                let _ = guard.second_uw(wire, at);
            }
        }
    }

    /// Whatever is asked for a second, no more than was read is booked of the rows of power.
    #[test]
    fn a_second_brings_no_more_power_than_was_read((mut guard, wire, at, _) in history()) {
        let begun = Instant::from_micros(at);
        let rows = guard.second_uw(usize::from(wire), begun).unwrap();
        let mut booked = 0;
        for burst in 0..17 {
            let at = at + burst * 58_500;
            let asked = stimulus(wire, 200, at, at + 35_000);
            let entry = admit(&mut guard, asked);
            booked += guard.energy_nj(entry.width(), entry.until.since(asked.at));
        }
        for (row, uw) in &rows[4..] {
            prop_assert!(booked <= uw * 1000 + 1000, "{booked} nJ of {uw} uW ({row:?})");
        }
    }
}

#[test]
fn at_rest_a_second_has_what_the_rows_of_one_second_say() {
    let rows = guard(HARD, 990).second_uw(0, Instant::ZERO).unwrap();
    let power = [
        (Reason::WirePower, HARD.wire_1s_uw),
        (Reason::FingertipPower, HARD.fingertip_1s_uw),
    ];
    for ((row, uw), (named, limit)) in rows[4..].iter().zip(power) {
        assert_eq!(*row, named);
        // One bucket serves both windows, so it has a little less than either.
        assert!(*uw <= limit && *uw > limit - limit / 20, "{row:?}: {uw}");
    }
}

#[test]
fn heat_that_flows_evenly_for_a_second_ends_at_the_limit() {
    for tight in [1, 2, 3] {
        let mut guard = guard(limits(tight), 990);
        let at = Instant::from_micros(7_000_000);
        let rows = guard.second_uw(0, at).unwrap();
        let (row, uw) = rows[..4]
            .iter()
            .fold(rows[0], |a, b| if b.1 < a.1 { *b } else { a });
        let latency = guard.plant.latency();
        let heat = guard.heat.as_mut().unwrap();
        let booking = heat.tissues[0].booking(at, at + SECOND, latency);
        let joules = uw as f64 * 1e-6;
        let reached = heat.tissues[0].heat(&mut heat.budget, booking, joules);
        let (limit, is) = match row {
            Reason::SkinPeak => (34.2, reached.peak_c),
            Reason::SkinMean => (33.3, reached.mean_c),
            _ => (33.2, reached.deep_c),
        };
        assert!(
            is <= limit + 1e-9 && is > limit - 0.001,
            "{row:?}: {is} of {limit}"
        );
    }
}

#[test]
fn each_row_is_the_least_where_its_limit_is_tight() {
    let rows = [
        Reason::Burst,
        Reason::SkinPeak,
        Reason::SkinMean,
        Reason::SkinDeep,
        Reason::Dose,
        Reason::WirePower,
        Reason::FingertipPower,
    ];
    for (tight, row) in (0..).zip(rows) {
        let mut guard = guard(limits(tight), 1970);
        let (least, nj) = read(&guard, 0, 7_000_000, 7_035_000).unwrap().least();
        assert_eq!(least, row);
        let applied = admit(&mut guard, stimulus(0, 140, 7_000_000, 7_035_000));
        assert_eq!(applied.reason, Some(row));
        let booked = guard.energy_nj(applied.width(), Duration::from_millis(35));
        assert!(
            booked <= nj && nj < booked + booked / 5,
            "{row:?}: {booked} of {nj}"
        );
    }
}

#[test]
fn of_rows_that_leave_the_same_the_first_is_named() {
    let mut budget = read(&guard(HARD, 990), 0, 0, 35_000).unwrap();
    budget.energy_nj.iter_mut().for_each(|row| row.1 = 1);
    assert_eq!(budget.least(), (Reason::Burst, 1));
}

#[test]
fn a_latched_guard_and_a_wire_that_is_not_there_have_no_budget() {
    let mut guard = guard(HARD, 990);
    assert!(read(&guard, 0, 0, 35_000).is_some());
    assert_eq!(read(&guard, WIRES, 0, 35_000), None);
    assert_eq!(read(&guard, 0, 35_000, 35_000), None);
    guard.latch(crate::guard::Cause::StaleInput);
    assert_eq!(read(&guard, 0, 0, 35_000), None);
}

#[test]
fn a_supply_that_another_board_uses_up_is_told() {
    let mut guard = guard_at(Prescale::new(3), limits(7), 990);
    assert!(read(&guard, 0, 0, 35_000).unwrap().supply);
    // With short periods a pulse may be on where the next wire of its board begins.
    admit(&mut guard, stimulus(2, 270, 0, 11_000));
    assert_eq!(
        guard.wires[2].now.map(|n| n.setting),
        Some(Setting { on: 0, off: 270 })
    );
    assert!(!read(&guard, 0, 10_000, 45_000).unwrap().supply);
    // The other wire of the board that is on ends with the onset.
    assert!(read(&guard, 3, 10_000, 45_000).unwrap().supply);
}

#[test]
fn what_is_sustained_for_ten_minutes_is_below_what_is_sustained_for_ten_seconds() {
    let guard = guard(HARD, 990);
    let of = |seconds: u64| guard.sustained_uw(Duration::from_millis(1000 * seconds));
    // 0.548 K/mW at ten minutes, and 41 C less the latent heat's part; for ten seconds the row of power says less.
    assert_eq!((of(600) + 50) / 100, 144);
    assert_eq!(of(10), of(1));
    assert!(
        of(10) > 16_000 && of(10) < limits(99).wire_10s_uw,
        "{}",
        of(10)
    );
}
