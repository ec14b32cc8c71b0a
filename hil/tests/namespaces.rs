//! A run that a PID namespace would take its guardian from. `cargo test` leaves this target out, since not everybody may make
//! such a namespace: `ci/hostile` runs it where one can be made, and counts it as skipped where none can.

// A failed expectation in a test is its message.
#![allow(clippy::unwrap_used, clippy::panic)]
// These tests live in real time.
#![allow(clippy::disallowed_methods)]
// The bench is the one of the other tests, which use all of it.
#![allow(dead_code)]
#![cfg(target_os = "linux")]

#[path = "bench/feed.rs"]
mod feed;
#[path = "bench/rig.rs"]
mod rig;
#[path = "bench/run.rs"]
mod run;

use std::path::Path;
use std::time::Duration;

use crate::rig::{Bench, on_bench};

/// What a program is given to end.
const END: Duration = Duration::from_secs(20);

/// A run in a PID namespace of its own, with these options of `unshare`.
fn refused_in(options: &[&str]) {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let scene = bench.scene(3.0);
        let words = Bench::run_words(&scene);
        let hil = env!("CARGO_BIN_EXE_hil");
        let words: Vec<&str> = options.iter().copied().chain([hil]).chain(words).collect();
        let said = bench
            .start_with(Path::new("/usr/bin/unshare"), &words, None)
            .finish(END);
        assert_eq!(said.status, Some(3), "{said:?}");
        assert!(
            said.err.contains("--init") && said.err.contains("real.oe"),
            "{said:?}"
        );
        assert!(bench.longest_on() <= 0.0, "it drove");
    });
}

#[test]
fn the_first_process_of_a_namespace_drives_no_hardware() {
    refused_in(&["--pid", "--fork", "--mount-proc"]);
}

#[test]
fn a_process_that_has_two_numbers_drives_no_hardware() {
    refused_in(&["--pid", "--fork"]);
}
