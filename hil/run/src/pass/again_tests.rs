//! Tests of `again.rs`: passes that a person asks for, and those that a cold face makes necessary.

use palpate_core::contact::Levels;
use palpate_core::schedule::Entry;
use palpate_files::Overrides;
use palpate_records::trace::{Event, event};

use super::*;
use crate::{EmulatedSession, Policy, Wish, build, pass};

fn setup(scene: &str, bench: &str, set: &[&str]) -> Setup {
    let mut overrides = Overrides::default();
    set.iter()
        .for_each(|text| overrides.set("--set", text).unwrap());
    let setup = Setup::load(scene, bench).unwrap();
    setup.with(&overrides).unwrap()
}

/// A session of a scene, played for some seconds with a wish at its beginning; its notes on passes, and its stimuli.
fn wished(setup: &Setup, seconds: u64) -> (Vec<String>, Vec<Entry>) {
    let mut session = EmulatedSession::scene(setup, 1, Policy::emulated(false)).unwrap();
    session.start(Instant::ZERO).unwrap();
    session.grant(Wish::HotPass, Instant::ZERO);
    session
        .advance(Instant::from_micros(seconds * 1_000_000))
        .unwrap();
    let events = &session.recorder().events;
    let notes = events.iter().filter_map(|event| match event {
        Event::Note(event::Note { text, .. }) => Some(text.clone()),
        _ => None,
    });
    let entries = events.iter().filter_map(|event| match event {
        Event::Schedule(entry) => Some(*entry),
        _ => None,
    });
    let notes = notes.filter(|text| text.starts_with("hot pass: "));
    (notes.skip(1).collect(), entries.collect())
}

#[test]
fn a_display_that_was_put_on_anew_is_passed_between_contacts() {
    let (notes, entries) = wished(&setup("idle", "emulated", &["length_s=30"]), 30);
    assert_eq!(
        notes,
        [
            "hot pass: each of 8 wires is heated in turn, at onsets without a contact; each is felt as a tap",
            "hot pass: 8 wires had their pulses; they are assumed passed",
        ]
    );
    // Each wire has the same bursts, one wire after the other.
    let driven: Vec<u8> = entries.iter().map(|entry| entry.channel.0).collect();
    assert!(
        driven.is_sorted() && driven.len().is_multiple_of(8),
        "{driven:?}"
    );
    assert_eq!(
        driven.iter().filter(|channel| **channel == 7).count(),
        driven.len() / 8
    );
}

#[test]
fn a_bench_that_forbids_it_and_a_guard_that_refuses_it_say_so() {
    let (notes, entries) = wished(
        &setup("idle", "emulated", &["bench.drive.hot_pass=false"]),
        5,
    );
    // The bench's own pass was left out too, so this is the first note.
    assert!(notes.is_empty() && entries.is_empty(), "{notes:?}");
    let mut strict = setup("idle", "emulated", &["length_s=20"]);
    pass::set_passed(&mut strict);
    strict.limits.value.limits.burst_energy_nj = 1_000_000;
    let mut session = EmulatedSession::scene(&strict, 1, Policy::emulated(false)).unwrap();
    session.start(Instant::ZERO).unwrap();
    session.grant(Wish::HotPass, Instant::ZERO);
    session.advance(Instant::from_micros(20_000_000)).unwrap();
    let told = session.recorder().events.iter().any(|event| {
        matches!(event, Event::Note(note) if note.text.contains("NOT PASSED: 0 of 8 wires"))
    });
    assert!(told, "{:?}", session.recorder().events);
}

#[test]
fn wires_under_a_cold_face_are_passed_once_it_is_warmer() {
    let mut warm = setup("idle", "warm", &[]);
    pass::set_passed(&mut warm);
    let mut projector = build(&warm, 1, Levels::Off).unwrap();
    let mut again = Again::new(&warm, &projector);
    let turns_c = again.turns_c.unwrap();
    assert!((22.0..32.5).contains(&turns_c), "{turns_c}");
    let mut look = |again: &mut Again, face_c: f64, ms: u64| {
        let at = Instant::from_micros(ms * 1000);
        again.look(&mut projector, || Some(face_c), at)
    };
    assert_eq!(look(&mut again, turns_c + 0.1, 0), None);
    let told = look(&mut again, turns_c - 0.1, 300).unwrap();
    assert!(
        told.contains("martensite comes back in the wires"),
        "{told}"
    );
    // Neither said twice, nor passed while it is cold.
    assert_eq!(look(&mut again, turns_c - 3.0, 600), None);
    assert_eq!(look(&mut again, turns_c + 0.9, 900), None);
    let told = look(&mut again, turns_c + 1.1, 1200).unwrap();
    assert!(told.contains("each of 8 wires is heated in turn"), "{told}");
    // It is on its way, however cold the face is now.
    assert_eq!(look(&mut again, turns_c - 3.0, 1500), None);
}
