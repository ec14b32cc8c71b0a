//! The program on a bench of hardware that is not there: a preloaded library gives it adapters with chips, CAN sockets
//! and clocks, and takes them away. What counts is the record of what the chips were told.
//!
//! Where nothing can be preloaded every test says `SKIPPED bench: why` and passes; with `PALPATE_BENCH=required` it fails.

// A failed expectation in a test is its message.
#![allow(clippy::unwrap_used, clippy::panic)]
// These tests live in real time.
#![allow(clippy::disallowed_methods)]
#![cfg(target_os = "linux")]

#[path = "bench/audit.rs"]
mod audit;
#[path = "bench/basics.rs"]
mod basics;
#[path = "bench/bring_up.rs"]
mod bring_up;
#[path = "bench/campaign.rs"]
mod campaign;
#[path = "bench/damage.rs"]
mod damage;
#[path = "bench/feed.rs"]
mod feed;
#[path = "bench/guardian_faults.rs"]
mod guardian_faults;
#[path = "bench/hands.rs"]
mod hands;
#[path = "bench/hot_pass.rs"]
mod hot_pass;
#[path = "bench/lacks.rs"]
mod lacks;
#[path = "bench/ledger.rs"]
mod ledger;
#[path = "bench/model.rs"]
mod model;
#[path = "bench/motors.rs"]
mod motors;
#[path = "bench/motors_out.rs"]
mod motors_out;
#[path = "bench/names.rs"]
mod names;
#[path = "bench/off.rs"]
mod off;
#[path = "bench/overrun.rs"]
mod overrun;
#[path = "bench/pulse.rs"]
mod pulse;
#[path = "bench/rig.rs"]
mod rig;
#[path = "bench/run.rs"]
mod run;
#[path = "bench/sequences.rs"]
mod sequences;
#[path = "bench/steps.rs"]
mod steps;
#[path = "bench/study.rs"]
mod study;
#[path = "cli/study_page.rs"]
mod study_page;
#[path = "bench/unseen_time.rs"]
mod unseen_time;
