//! A guard without thermal rows behind a whole one.

use alloc::vec::Vec;

use super::*;
use crate::random::RandomStream;
use crate::units::{Milliamps, Point, Ticks};

fn wires() -> Vec<DisplayWire> {
    let wire = |n: u8| DisplayWire {
        place: Point::new(f32::from(n), 0.0),
        board: Board(n / 8),
        channel: Channel(n % 8),
    };
    (0..16).map(wire).collect()
}

/// Stimuli that dwell, move, overlap and ask for too much.
fn hostile(s: &mut RandomStream, at: Instant, board: u8) -> Vec<Stimulus> {
    let one = |s: &mut RandomStream| Stimulus {
        wire: u16::from(board) * 8 + (s.next_u64() % 8) as u16,
        width: Ticks::new((s.next_u64() % 300) as u16),
        peak: Milliamps(990),
        at,
        until: at + Duration::from_micros(s.next_u64() % 80_000),
    };
    let count = s.next_u64() % 5;
    let mut stimuli: Vec<Stimulus> = Vec::new();
    for stimulus in (0..count).map(|_| one(s)) {
        if stimuli.iter().all(|other| other.wire != stimulus.wire) {
            stimuli.push(stimulus);
        }
    }
    stimuli
}

/// What a whole guard passed, as the unit is told it.
fn told(update: &Guarded) -> Vec<Stimulus> {
    let each = update.channels().iter().zip(update.ends()).enumerate();
    let told = each.filter_map(|(channel, (setting, end))| {
        let setting = (*setting)?;
        Some(Stimulus {
            wire: u16::from(update.board().0) * 8 + channel as u16,
            width: Ticks::new(setting.off - setting.on),
            peak: Milliamps(990),
            at: update.at(),
            until: *end,
        })
    });
    told.collect()
}

#[test]
fn what_a_whole_guard_passed_the_last_word_passes_unchanged() {
    let mut s = RandomStream::new(1, "hostile onsets");
    let (mut driven, mut limited) = (0, 0);
    for case in 0..1000u64 {
        let limits = Limits {
            supply: Milliamps(1000 + 500 * (case % 4) as u32),
            ..HARD
        };
        let mut whole =
            Guard::new(limits, Plant::default(), &wires(), WornWire::default()).unwrap();
        let heat = case % 4 == 3;
        let worn = heat.then(WornWire::default);
        let mut last = Guard::last_word(limits, Plant::default(), &wires(), worn).unwrap();
        assert_eq!((whole.has_heat(), last.has_heat()), (true, heat));
        let mut at = Instant::ZERO;
        for _ in 0..100 {
            at += Duration::from_micros(1000 + s.next_u64() % 60_000);
            let board = (s.next_u64() % 2) as u8;
            for board in 0..2 {
                let (ended, also) = (
                    whole.expire(at, Board(board)),
                    last.expire(at, Board(board)),
                );
                assert_eq!(ended, also);
            }
            let stimuli = hostile(&mut s, at, board);
            let mut count = |entry: Entry| limited += u32::from(entry.reason.is_some());
            let update = whole.admit(at, Board(board), &stimuli, &mut count);
            let stimuli = told(&update);
            let unchanged = |entry: Entry| assert_eq!(entry.reason, None, "{case} {entry:?}");
            let again = last.change(at, Board(board), &stimuli, unchanged);
            assert_eq!(again, update, "{case}");
            driven += stimuli.len();
        }
    }
    assert!(driven > 50_000 && limited > 50_000, "{driven} {limited}");
}

#[test]
fn a_change_leaves_wires_alone_that_it_does_not_name() {
    let mut guard = Guard::last_word(HARD, Plant::default(), &wires(), None).unwrap();
    let at = Instant::from_micros(1000);
    let stimulus = |wire, width, at: Instant| Stimulus {
        wire,
        width: Ticks::new(width),
        peak: Milliamps(990),
        at,
        until: at + Duration::from_millis(30),
    };
    guard.change(
        at,
        Board(0),
        &[stimulus(0, 100, at), stimulus(1, 100, at)],
        |_| (),
    );
    let later = at + Duration::from_millis(5);
    let update = guard.change(later, Board(0), &[stimulus(1, 0, later)], |_| ());
    assert_eq!(update.channels()[0], None);
    assert_eq!(update.channels()[1], Some(Setting { on: 256, off: 256 }));
    assert_eq!(guard.next_expiry(), Some(at + Duration::from_millis(30)));
    assert_eq!(update.ends()[1], later);
}
