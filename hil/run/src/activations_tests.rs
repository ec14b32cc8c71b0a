//! Tests of `activations.rs`.

use palpate_core::units::Instant;
use palpate_files::{Scene, Setup, Source, load_bench, load_scene};
use palpate_records::trace::{Event, event};

use super::*;
use crate::live::{EmulatedSession, press};

const OWN: &str = r#"
name = "own"
description = "Activations come from outside"
layout = "uskin-4x4"

[illusion]
model = "balanced"
intensity = false
"#;

fn setup() -> Setup {
    let source = Source::new("own.toml", OWN.to_owned());
    let value = Scene::read(&source).unwrap();
    let scene = palpate_files::Loaded { value, source };
    Setup::join(scene, load_bench("emulated").unwrap()).unwrap()
}

#[test]
fn only_activated_wires_are_driven_and_only_while_something_touches() {
    let (mut session, hands, activations) = EmulatedSession::activated(&setup(), 1).unwrap();
    let ready = session.start(Instant::ZERO).unwrap();
    activations
        .set(&[0.0, 0.0, 0.2, 0.0, 0.0, 0.1, 0.0, 0.0])
        .unwrap();
    let mut driven = |until_us| {
        session.advance(Instant::from_micros(until_us)).unwrap();
        let (events, _) = session.drain();
        let entries = events.into_iter().filter_map(|event| match event {
            Event::Schedule(entry) if entry.width().get() > 0 => Some(entry),
            _ => None,
        });
        entries.collect::<Vec<_>>()
    };
    assert!(ready < Instant::from_micros(700_000));
    assert!(driven(700_000).is_empty());
    hands[0].press(&[press(1.0, -2.0, 0.7, 19.5)]);
    let entries = driven(1_500_000);
    assert!(entries.len() > 8);
    assert!(entries.iter().all(|e| [2, 5].contains(&e.channel.0)));
    let width = |channel| {
        let one = entries.iter().find(|e| e.channel.0 == channel).unwrap();
        one.requested.get()
    };
    assert_eq!((width(2), width(5)), (20, 10));
    activations.set(&[0.0; 8]).unwrap();
    assert!(
        driven(2_000_000)
            .iter()
            .all(|e| e.at < Instant::from_micros(1_600_000))
    );
}

#[test]
fn what_is_no_activation_changes_nothing() {
    let own = Activations::new(2, Prescale::MIN, Duration::from_millis(38));
    own.set(&[0.5, 1.0]).unwrap();
    for wrong in [&[0.5][..], &[0.5, 1.1], &[-0.1, 0.0], &[f32::NAN, 0.0]] {
        assert!(matches!(own.set(wrong), Err(Failure::Input(_))));
    }
    let mut out = [9.0; 2];
    own.activate(Point::new(0.0, 0.0), &mut out);
    assert_eq!(out.map(f32::to_bits), [0.5, 1.0].map(f32::to_bits));
    own.activate(Point::new(f32::NAN, 0.0), &mut out);
    assert_eq!(out.map(f32::to_bits), [0; 2]);
}

#[test]
fn every_wire_has_the_pulses_that_it_is_given() {
    let (mut session, hands, activations) = EmulatedSession::activated(&setup(), 1).unwrap();
    session.start(Instant::ZERO).unwrap();
    session.advance(Instant::from_micros(700_000)).unwrap();
    hands[0].press(&[press(1.0, -2.0, 0.7, 19.5)]);
    activations.set(&[0.1; 8]).unwrap();
    // 38 ms at 196.9 Hz: the eighth pulse would begin within the last half period.
    assert_eq!(activations.most_pulses(), 7);
    let pulses = [1, 2, 3, 4, 5, 6, 7, 1];
    activations.set_pulses(Some(&pulses)).unwrap();
    let _ = session.drain();
    session.advance(Instant::from_micros(1_500_000)).unwrap();
    let (events, _) = session.drain();
    let mut rises = [0; 8];
    let mut onsets = 0;
    for event in &events {
        match event {
            Event::Edge(event::Edge {
                channel,
                high: true,
                ..
            }) => rises[usize::from(*channel)] += 1,
            Event::Schedule(e) if e.channel.0 == 0 && e.width().get() > 0 => onsets += 1,
            _ => {}
        }
    }
    assert!(onsets > 4, "{onsets}");
    assert_eq!(rises, pulses.map(|n| i32::from(n) * onsets));
    for wrong in [&[1; 7][..], &[0; 8], &[8; 8]] {
        let refused = activations.set_pulses(Some(wrong));
        assert!(matches!(refused, Err(Failure::Input(_))));
    }
    activations.set_pulses(None).unwrap();
}

#[test]
fn a_law_that_chooses_pulses_is_refused() {
    let scene = load_scene("sphere-along").unwrap();
    let setup = Setup::join(scene, load_bench("emulated").unwrap()).unwrap();
    let error = EmulatedSession::activated(&setup, 1).err().unwrap();
    assert_eq!(error.key(), Some("illusion.model"));
}
