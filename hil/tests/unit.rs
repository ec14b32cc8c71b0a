//! A driver unit against its host, whatever it is: the same suite on the model in this process and on the process
//! `hil unit`. Another kind of unit is another [`held::Subject`]: `tests/qemu` has images.

// A failed expectation in a test is its message.
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "unit/suite.rs"]
mod held;
#[path = "unit/process.rs"]
mod process;
#[path = "unit/subject.rs"]
mod subject;
#[path = "unit/warmth.rs"]
mod warmth;

use subject::{Model, Process};

#[test]
fn the_model_plays_what_it_is_told() {
    held::plays_what_it_is_told(Model::new());
}

#[test]
fn the_process_plays_what_it_is_told() {
    held::plays_what_it_is_told(Process::new());
}

#[test]
fn hostile_datagrams_drive_nothing_on_the_model() {
    held::drives_nothing_without_a_session(Model::new());
}

#[test]
fn hostile_datagrams_drive_nothing_on_the_process() {
    held::drives_nothing_without_a_session(Process::new());
}

#[test]
fn a_host_that_lies_gets_nothing_over_a_limit_on_the_model() {
    held::limits_a_host_that_lies(Model::new());
}

#[test]
fn a_host_that_lies_gets_nothing_over_a_limit_on_the_process() {
    held::limits_a_host_that_lies(Process::new());
}

/// A process with a Peltier module.
fn warm() -> Process {
    Process::on(&["--bench", "unit-whole"])
}

#[test]
fn the_model_shows_what_is_cold() {
    warmth::shows_what_is_cold(Model::new());
}

#[test]
fn the_process_shows_what_is_cold() {
    warmth::shows_what_is_cold(warm());
}

#[test]
fn the_model_bears_what_its_own_guard_bears() {
    warmth::bears_what_its_own_guard_bears(Model::new());
}

#[test]
fn the_process_bears_what_its_own_guard_bears() {
    warmth::bears_what_its_own_guard_bears(warm());
}

#[test]
fn the_model_lets_go_without_a_reading() {
    warmth::lets_go_without_a_reading(Model::new());
}

#[test]
fn the_process_lets_go_without_a_reading() {
    warmth::lets_go_without_a_reading(warm());
}
