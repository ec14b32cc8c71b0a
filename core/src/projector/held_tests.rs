//! Tests of `held.rs`.

use alloc::vec::Vec;
use core::convert::Infallible;

use super::*;
use crate::contact::Settings;
use crate::driver::Actuators;
use crate::guard::Guarded;
use crate::illusion::{Display, DisplayWire, Tracks};
use crate::projector::{FrameReport, Target};
use crate::skin::{Condition, Layout, Module};
use crate::units::{Board, Channel, Point};

#[derive(Default)]
struct Boards(u32);

impl Actuators for Boards {
    type Error = Infallible;

    fn apply(&mut self, _update: &Guarded) -> Result<(), Infallible> {
        self.0 += 1;
        Ok(())
    }

    fn all_off(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

#[derive(Default)]
struct Seen {
    frames: Vec<(Instant, u32, usize)>,
    onsets: Vec<(Instant, Vec<Target>)>,
    taxels: u32,
}

impl Observer for Seen {
    fn frame(&mut self, report: &FrameReport<'_>) {
        let contacts = report.contacts.len();
        self.frames.push((report.at, report.number, contacts));
    }
    fn onset(&mut self, at: Instant, targets: &[Target]) {
        self.onsets.push((at, targets.to_vec()));
    }
    fn taxel(&mut self, _: Instant, _: usize, _: Condition) {
        self.taxels += 1;
    }
}

fn projector() -> Projector {
    let wire = |n: u8| DisplayWire {
        place: Point::new(10.0 * f32::from(n), 0.0),
        board: Board(0),
        channel: Channel(n),
    };
    let display = Display::new(&[wire(0), wire(1)]).unwrap();
    let layout = Layout::single(Module::grid("pad", 4, 4, 4.7).unwrap()).unwrap();
    let settings = Settings {
        clusters: 2,
        ..Settings::default()
    };
    let builder = Projector::builder(layout, display).compression(settings);
    builder.build().unwrap()
}

fn contact(x: f32) -> Contact {
    Contact {
        id: 1,
        module: 0,
        place: Point::new(x, 0.0),
        intensity: 100.0,
        level: 1,
        members: 3,
        ..Contact::default()
    }
}

fn at(ms: u64) -> Instant {
    Instant::from_micros(1000 * ms)
}

#[test]
fn contacts_of_another_loop_are_carried_on_felt_and_grow_old() {
    carried(0);
}

/// Their time is the earliest that it may be, and they are carried on from when they likely were there.
#[test]
fn contacts_whose_time_is_not_known_are_carried_on_from_when_they_likely_were() {
    carried(15);
}

/// Contacts that come at once, as of `later` milliseconds before they were there.
fn carried(later: u64) {
    let (mut projector, mut boards, mut seen) = (projector(), Boards::default(), Seen::default());
    // 14 mm/s to the right.
    let along = |at: Instant| 0.000_014 * at.as_micros() as f32 - 2.0;
    for ms in later..300 {
        let read = ms - later;
        // Nothing is read any more after 190 ms.
        if read.is_multiple_of(10) && read < 200 {
            let contacts = [contact(along(at(ms)))];
            let later = Duration::from_millis(later);
            let held = projector.hold(at(read), later, &contacts, &mut seen);
            held.unwrap();
        }
        let _ = projector.turn(at(ms), &mut boards, &mut seen);
    }
    assert_eq!(seen.frames.len(), 20);
    assert_eq!(seen.frames[1], (at(10), 1, 1));
    assert!(boards.0 > 0 && seen.taxels == 0);
    let shown = |(when, targets): &&(Instant, Vec<Target>)| *when > at(100) && !targets.is_empty();
    let (when, targets) = seen.onsets.iter().find(shown).unwrap();
    let there = projector.map().apply(Point::new(along(*when), 0.0)).x;
    let onset = targets[0].place.x;
    assert!((onset - there).abs() < 0.03, "{onset} for {there}");
    // Its age counts from the reading.
    let guard = projector.guard();
    assert_eq!(guard.heard(), Some(at(190)));
    // Switching takes time: the guard stops so early that the outputs are off after 100 ms, and waits for half of them.
    let stops = (190..=290).find(|ms| guard.is_stale(at(*ms)));
    assert!(
        stops.is_some_and(|ms| (240..290).contains(&ms)),
        "{stops:?}"
    );
}

#[test]
fn contacts_that_are_not_carried_on_are_felt_where_their_newest_frame_had_them() {
    let (mut projector, mut boards, mut seen) = (projector(), Boards::default(), Seen::default());
    projector.tracks = Tracks::new(2, Duration::ZERO);
    let along = |ms: u64| 0.014 * ms as f32 - 2.0;
    for ms in 0..200 {
        if ms % 10 == 0 {
            let held = projector.hold(at(ms), Duration::ZERO, &[contact(along(ms))], &mut seen);
            held.unwrap();
        }
        let _ = projector.turn(at(ms), &mut boards, &mut seen);
    }
    let targets = seen
        .onsets
        .iter()
        .filter(|(_, targets)| !targets.is_empty());
    let late = targets.filter(|(when, _)| when.as_micros() % 10_000 > 0);
    let mut count = 0;
    for (when, targets) in late {
        let newest = along(when.as_micros() / 10_000 * 10);
        assert_eq!(
            targets[0].place,
            projector.map().apply(Point::new(newest, 0.0))
        );
        count += 1;
    }
    assert!(count > 0);
}

#[test]
fn what_is_none_of_this_loop_changes_nothing() {
    let (mut projector, mut seen) = (projector(), Seen::default());
    projector
        .hold(at(10), Duration::ZERO, &[contact(0.0)], &mut seen)
        .unwrap();
    let with = |change: fn(&mut Contact)| {
        let mut other = contact(1.0);
        change(&mut other);
        [other]
    };
    let mut refused = |ms: u64, contacts: &[Contact]| {
        let held = projector.hold(at(ms), Duration::ZERO, contacts, &mut seen);
        held.expect_err("foreign")
    };
    assert_eq!(refused(10, &[contact(1.0)]), ForeignContacts::Old);
    assert_eq!(refused(9, &[]), ForeignContacts::Old);
    let many = refused(20, &[contact(1.0); 64]);
    assert!(matches!(many, ForeignContacts::TooMany(_)));
    let module = with(|c| c.module = 1);
    assert_eq!(refused(20, &module), ForeignContacts::NoSuchModule(1));
    for change in [
        (|c| c.place.x = f32::NAN) as fn(&mut Contact),
        |c| c.place.y = f32::INFINITY,
        |c| c.intensity = -1.0,
        |c| c.intensity = f32::NAN,
    ] {
        assert_eq!(refused(20, &with(change)), ForeignContacts::NoNumber);
    }
    for level in [0, 2] {
        let mut other = contact(0.0);
        other.level = level;
        assert_eq!(refused(20, &[other]), ForeignContacts::Level(1));
    }
    assert_eq!(seen.frames.len(), 1);
    assert!(
        projector
            .hold(at(11), Duration::ZERO, &[], &mut seen)
            .is_ok()
    );
}
