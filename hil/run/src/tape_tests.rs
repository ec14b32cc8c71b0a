//! Tests of `tape.rs`.

use super::*;
use palpate_files::Setup;

use crate::plan;
use crate::skin;

#[test]
fn a_tape_that_recorded_nothing_is_not_played() {
    let setup = Setup::load("sphere-along", "emulated").unwrap();
    let layout = plan::layout(&setup.sensor.value).unwrap();
    let mut tape = Tape::new(skin::emulated(&setup, &layout, 1).unwrap());
    assert!(!tape.is_exact());
    tape.advance_to(Instant::from_micros(50_000));
    while tape.receive().unwrap().is_some() {}
    assert!(tape.is_exact());
}

/// Frames of 300 ms, turn by turn, by one way of taking them or the other.
fn taken(tape: &mut Tape, at_once: bool) -> Vec<Received> {
    let mut frames = Vec::new();
    for ms in 1..=300 {
        tape.advance_to(Instant::from_micros(1000 * ms));
        if at_once {
            tape.receive_all(&mut |received| frames.push(*received))
                .unwrap();
        } else {
            frames.extend(std::iter::from_fn(|| tape.receive().unwrap()));
        }
    }
    frames
}

#[test]
fn frames_are_the_same_one_by_one_and_at_once_recorded_and_played() {
    let setup = Setup::load("allegro-four-buses", "emulated").unwrap();
    let layout = plan::layout(&setup.sensor.value).unwrap();
    let tape = || Tape::new(skin::emulated(&setup, &layout, 1).unwrap());
    let (mut one, mut all) = (tape(), tape());
    let recorded = taken(&mut one, false);
    assert!(recorded.len() > 5000, "{}", recorded.len());
    assert!(recorded.iter().any(|r| r.bus == 3));
    assert_eq!(taken(&mut all, true), recorded);
    for (tape, at_once) in [(&mut one, true), (&mut all, false)] {
        tape.rewind(Instant::from_micros(300_000));
        assert_eq!(taken(tape, at_once), recorded);
    }
}
