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
