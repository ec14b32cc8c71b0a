//! Tests of `activations.rs`.

use palpate_core::units::Instant;
use palpate_files::{Scene, Setup, Source, load_bench, load_scene};
use palpate_records::trace::Event;

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
    let own = Activations::new(2);
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
fn a_law_that_chooses_pulses_is_refused() {
    let scene = load_scene("sphere-along").unwrap();
    let setup = Setup::join(scene, load_bench("emulated").unwrap()).unwrap();
    let error = EmulatedSession::activated(&setup, 1).err().unwrap();
    assert_eq!(error.key(), Some("illusion.model"));
}
