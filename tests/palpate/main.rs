//! All integration tests in one binary, to save linking.

// A failed expectation in a test is its message.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod allegro;
mod allocation;
mod captures;
mod circles;
mod compression;
mod current;
mod dac7578;
mod dbc;
mod diff;
mod driver;
mod edges;
mod external_clock;
mod faults;
mod felt;
mod finger_campaign;
mod finger_feels;
mod finger_pads;
mod fingers;
mod goldens;
mod guard;
mod hand;
mod haptic;
mod illusion;
mod link;
mod overrun;
mod panel;
mod paths;
mod pca9685;
mod policy;
mod recordings;
mod render;
mod rules;
mod scans;
mod shared_boards;
mod shown;
mod texture;
mod tidy;
mod tidy_words;
mod told;
mod unit;
mod warmth;
