//! Textures and strokes of several displays: each finger has its own, and boards stay with one wire at a time.

use std::collections::BTreeMap;

use palpate_core::units::Instant;
use palpate_files::Setup;
use palpate_records::story::Story;
use palpate_records::trace::{Event, event};
use palpate_run::{Input, Outcome, fits, run};

use super::fingers::entries;
use super::goldens::keep;

fn rubs() -> Outcome {
    let setup = Setup::load("allegro-rubs", "allegro-hand").unwrap();
    run(&setup, &Input::Scene, 1).unwrap()
}

#[test]
fn each_finger_feels_its_own_surface_and_no_limit_is_met() {
    let outcome = rubs();
    let s = &outcome.summary;
    assert_eq!(s.limiter_events, 0);
    assert!(s.margins.iter().all(|m| m.used() <= 1.0), "{:?}", s.margins);
    assert!(s.texture.is_none());
    let windows = s.displays.iter();
    let windows = windows.map(|d| d.texture.as_ref().map(|t| t.windows));
    let [index, middle, ring, thumb] = windows.collect::<Vec<_>>()[..] else {
        panic!("{:?}", s.displays);
    };
    assert!(
        index > Some(50) && middle > Some(50),
        "{index:?} {middle:?}"
    );
    assert_eq!((ring, thumb), (None, None));
    for display in &outcome.displays {
        let name = format!("allegro-rubs-{}", display.name);
        keep(&name, "schedule", &Story::schedule(&display.outcome.trace));
    }
}

/// Levels of intensity are found in the whole skin; without any, nothing that one finger feels changes another one's.
#[test]
fn a_finger_without_its_texture_leaves_the_others_alone() {
    let mut setup = Setup::load("allegro-rubs", "allegro-hand").unwrap();
    setup.scene.value.compression.ki = 1;
    let one = run(&setup, &Input::Scene, 1).unwrap();
    setup.fingers[1].texture = None;
    let other = run(&setup, &Input::Scene, 1).unwrap();
    let of = |outcome: &Outcome, finger: usize| entries(&outcome.displays[finger].outcome.trace);
    for finger in [0, 2, 3] {
        assert_eq!(of(&one, finger), of(&other, finger), "finger {finger}");
    }
    assert_ne!(of(&one, 1), of(&other, 1));
}

/// By the pins. The ring finger's strokes begin when their plan says, off the grid on which the thumb beside it is driven.
#[test]
fn strokes_of_one_finger_hold_the_other_one_of_its_board() {
    let outcome = rubs();
    let mut high: BTreeMap<u8, Vec<u8>> = BTreeMap::new();
    for event in &outcome.trace.events {
        match event {
            Event::Edge(event::Edge {
                board,
                channel,
                high: true,
                ..
            }) => {
                let on = high.entry(*board).or_default();
                on.push(*channel);
                assert_eq!(on.len(), 1, "{event:?} beside {on:?}");
            }
            Event::Edge(event::Edge { board, channel, .. }) => {
                high.entry(*board).or_default().retain(|c| c != channel);
            }
            _ => {}
        }
    }
    assert_eq!(high.len(), 2);
    let all = entries(&outcome.trace);
    let of = |board: u8, wires: std::ops::Range<u8>| {
        let of = all.iter().filter(move |e| e.board.0 == board);
        of.filter(move |e| wires.contains(&e.channel.0))
    };
    let within = |from: u64, to: u64, e: &palpate_core::schedule::Entry| {
        e.until > Instant::from_micros(from) && e.at < Instant::from_micros(to)
    };
    for (from, to) in [(3_000_000, 3_500_000), (6_000_000, 6_600_000)] {
        let ring = of(1, 0..8).filter(|e| within(from, to, e)).count();
        assert!(ring >= 4, "{ring} stimuli of the stroke at {from} us");
        let thumb = of(1, 8..16).filter(|e| within(from, to, e)).count();
        assert_eq!(thumb, 0, "the thumb waits from {from} us on");
        let after = of(1, 8..16).filter(|e| within(to, to + 300_000, e)).count();
        assert!(after > 0, "and goes on after {to} us");
        // The other board knows nothing of it.
        let others = of(0, 0..16).filter(|e| within(from, to, e)).count();
        assert!(others > 10, "{others} stimuli of the other board");
    }
}

#[test]
fn strokes_that_meet_on_a_board_are_refused() {
    let mut setup = Setup::load("allegro-rubs", "allegro-hand").unwrap();
    setup.fingers[3].strokes = setup.fingers[2].strokes.clone();
    setup.fingers[3].strokes.truncate(1);
    setup.fingers[3].strokes[0].start_s = 3.2;
    let error = fits(&setup).unwrap_err().to_string();
    let expected = "fingers[3].strokes[0].start_s: expected a stroke that begins at 3.5";
    assert!(error.contains(expected), "{error}");
    assert!(error.contains("one of display `ring`"), "{error}");
    // On another board it may.
    setup.fingers[3].strokes.clear();
    setup.fingers[0].strokes = setup.fingers[2].strokes.clone();
    fits(&setup).unwrap();
}
