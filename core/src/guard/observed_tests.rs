//! What the guard notes of stimuli that it leaves as they are, and what it books.

use alloc::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::guard::{CurrentControl, HARD, Plant, WornWire};
use crate::illusion::DisplayWire;
use crate::schedule::Reason;
use crate::units::{Channel, Duration, Milliamps, Point, Prescale, Ticks};

const THESIS: Plant = Plant {
    prescale: Prescale::new(30),
    wire_milliohm: 1900,
    peak: Milliamps(1970),
    bus: Duration::ZERO,
};

fn guard() -> Guard {
    let wire = |c: u8| DisplayWire {
        place: Point::new(f32::from(c), 0.0),
        board: Board(c / 4),
        channel: Channel(c % 4),
    };
    let wires: Vec<_> = (0..8).map(wire).collect();
    Guard::new(HARD, THESIS, &wires, WornWire::default()).unwrap()
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

fn observe(guard: &mut Guard, stimuli: &[Stimulus]) -> (Option<Observed>, Vec<Entry>) {
    let mut entries = Vec::new();
    let update = guard.observe(stimuli[0].at, Board(0), stimuli, |e| entries.push(e));
    (update, entries)
}

#[test]
fn what_is_asked_stays_and_the_reason_is_noted() {
    let mut guard = guard();
    let (update, entries) = observe(
        &mut guard,
        &[stimulus(2, 100, 0, 35_000), stimulus(1, 400, 0, 80_000)],
    );
    let channels = *update.unwrap().channels();
    assert_eq!(channels[1], Some(Setting { on: 256, off: 656 }));
    assert_eq!(channels[2], Some(Setting { on: 512, off: 612 }));
    // The board's other wires stand there as well, off; the other board's do not.
    assert_eq!(channels[0], Some(Setting { on: 0, off: 0 }));
    assert_eq!(channels[4], None);
    assert_eq!(entries[1].width(), entries[1].requested);
    assert_eq!(entries[1].until, Instant::from_micros(80_000));
    assert!(entries[1].reason.is_some());
    assert_eq!(entries[0].reason, None);
}

#[test]
fn an_observed_update_is_for_the_board_of_its_stimuli() {
    let asked = [stimulus(5, 100, 0, 35_000)];
    let update = guard().observe(Instant::ZERO, Board(1), &asked, |_| {});
    let update = update.unwrap();
    assert_eq!(update.board(), Board(1));
    assert_eq!(update.channels()[1], Some(Setting { on: 256, off: 356 }));
}

#[test]
fn a_stimulus_that_ends_as_it_begins_is_not_driven_and_takes_nothing() {
    let mut guard = guard();
    let (update, entries) = observe(&mut guard, &[stimulus(1, 400, 0, 0)]);
    assert!(update.is_none_or(|u| u.channels()[1].is_none_or(|s| s.on == s.off)));
    assert_eq!(entries[0].until, Instant::ZERO);
    assert_eq!(guard.next_expiry(), None);
    // What a whole burst of it would have been told is told of the next one as well: nothing is booked.
    let again = |guard: &mut Guard| observe(guard, &[stimulus(1, 400, 0, 35_000)]).1[0].reason;
    assert_eq!(again(&mut guard), again(&mut self::guard()));
    assert_eq!(guard.used(Instant::ZERO), {
        let mut fresh = self::guard();
        again(&mut fresh);
        fresh.used(Instant::ZERO)
    });
}

#[test]
fn ends_are_told_with_what_goes_on_and_nothing_is_told_without_an_end() {
    let mut guard = guard();
    observe(
        &mut guard,
        &[stimulus(1, 100, 0, 20_000), stimulus(2, 100, 0, 35_000)],
    );
    let early = Instant::from_micros(19_999);
    assert_eq!(guard.observe_expiry(early, Board(0)), None);
    let ended = guard.observe_expiry(Instant::from_micros(20_000), Board(0));
    let channels = *ended.unwrap().channels();
    assert_eq!(channels[1], Some(Setting { on: 0, off: 0 }));
    assert_eq!(channels[2], Some(Setting { on: 512, off: 612 }));
    assert_eq!(guard.next_expiry(), Some(Instant::from_micros(35_000)));
}

#[test]
fn a_latched_guard_notes_and_lets_all_pass() {
    let mut guard = guard();
    guard.latch(crate::guard::Cause::StaleInput);
    let (update, entries) = observe(&mut guard, &[stimulus(0, 100, 0, 35_000)]);
    assert!(update.is_some());
    assert_eq!(entries[0].reason, Some(Reason::Latched));
    assert_eq!(entries[0].width(), Ticks::new(100));
}

#[test]
fn what_flows_is_booked_so_that_the_prediction_passes_the_limits() {
    let (mut observed, mut guarded) = (guard(), guard());
    for turn in 0..100 {
        let asked = [stimulus(0, 140, turn * 58_500, 35_000)];
        observe(&mut observed, &asked);
        guarded.admit(asked[0].at, Board(0), &asked, |_| {});
        let end = asked[0].until;
        observed.observe_expiry(end, Board(0));
        guarded.expire(end, Board(0));
    }
    assert!(guarded.predicted().peak_c <= 43.0);
    assert!(
        observed.predicted().peak_c > 60.0,
        "{:?}",
        observed.predicted()
    );
}

proptest! {
    /// Where the guard has nothing to change, looking on is the same as letting through.
    #[test]
    fn observing_what_passes_is_admitting_it(
        asked in prop::collection::vec((0u16..4, 0u16..60, 1u64..34_000, 0u64..400_000), 1..30),
    ) {
        let (mut observed, mut guarded) = (guard(), guard());
        let mut at_us = 0;
        for (wire, width, length_us, pause_us) in asked {
            let stimuli = [stimulus(wire, width, at_us, length_us)];
            let mut passed = None;
            let update = guarded.admit(stimuli[0].at, Board(0), &stimuli, |e| passed = Some(e));
            guarded.confirm(&update, update.at());
            let (_, entries) = observe(&mut observed, &stimuli);
            prop_assert_eq!(passed.and_then(|e| e.reason), entries[0].reason);
            if entries[0].reason.is_some() {
                break;
            }
            prop_assert_eq!(passed, entries.first().copied());
            prop_assert!(core::mem::take(&mut observed.looks_on));
            // Here a wire ends with the next onset, however late that is: one that looks on does not mind.
            (guarded.overrun, guarded.overran) = (None, false);
            prop_assert_eq!(alloc::format!("{observed:?}"), alloc::format!("{guarded:?}"));
            at_us += length_us + pause_us;
        }
    }
}

#[test]
fn a_current_is_set_as_asked_up_to_full_scale_and_counted_once_it_was_set() {
    let control = CurrentControl {
        full_scale: Milliamps(1970),
        gain_ppm: 0,
        offset: Milliamps(0),
    };
    let mut guard = guard().with_current(control).unwrap();
    let asked = |wire: u16, milliamps: u32, at_us: u64| Stimulus {
        peak: Milliamps(milliamps),
        ..stimulus(wire, 50, at_us, 35_000)
    };
    let spent = |guard: &Guard| guard.wires[2].burst.map_or(0, |burst| burst.spent_nj);
    let at = |milliamps| Plant {
        peak: Milliamps(milliamps),
        ..THESIS
    };
    let length = Duration::from_millis(35);
    let (update, entries) = observe(&mut guard, &[asked(2, 985, 0), asked(3, 5000, 0)]);
    let update = update.unwrap();
    let mut currents = [None; 16];
    (currents[2], currents[3]) = (Some(Milliamps(985)), Some(Milliamps(1970)));
    assert_eq!(*update.currents(), currents);
    assert_eq!(entries[0].current, Some(Milliamps(985)));
    assert_eq!(entries[1].reason, Some(Reason::Current));
    // Nothing was known of it before.
    assert_eq!(spent(&guard), at(1970).energy_nj(50, length));
    guard.confirm_observed(&update);
    let ended = guard.observe_expiry(Instant::from_micros(35_000), Board(0));
    assert_eq!(*ended.unwrap().currents(), [None; 16]);
    let (again, _) = observe(&mut guard, &[asked(2, 985, 1_000_000)]);
    assert_eq!(spent(&guard), at(985).energy_nj(50, length));
    // While it is on, what is asked for is set all the same; the larger counts.
    guard.confirm_observed(&again.unwrap());
    let (risen, entries) = observe(&mut guard, &[asked(2, 1970, 1_010_000)]);
    assert_eq!(risen.unwrap().currents()[2], Some(Milliamps(1970)));
    assert_eq!(entries[0].reason, Some(Reason::Current));
}

#[test]
fn amplifiers_of_one_current_are_not_set() {
    let (update, entries) = observe(&mut guard(), &[stimulus(2, 100, 0, 35_000)]);
    assert_eq!(*update.unwrap().currents(), [None; 16]);
    assert_eq!(entries[0].current, None);
}
