//! What needs a PID namespace of its own: `ci/hostile` asks for it, and nothing else does.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use crate::rig::{Bench, on_bench};

/// What a program is given to end.
const END: Duration = Duration::from_secs(20);

/// Where `unshare` is, if it may make such a namespace here.
fn unshare() -> Result<&'static Path, &'static str> {
    if std::env::var_os("PALPATE_NAMESPACES").is_none() {
        return Err("namespaces are left to ci/hostile");
    }
    let program = Path::new("/usr/bin/unshare");
    let tried = Command::new(program)
        .args(["--pid", "--fork", "true"])
        .status();
    match tried.is_ok_and(|status| status.success()) {
        true => Ok(program),
        false => Err("no PID namespace may be made here"),
    }
}

/// A run in a PID namespace of its own, with these options of `unshare`.
fn refused_in(options: &[&str]) {
    let program = match unshare() {
        Ok(program) => program,
        Err(why) => {
            eprintln!("SKIPPED bench: {why}");
            return;
        }
    };
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let scene = bench.scene(3.0);
        let words = Bench::run_words(&scene);
        let hil = env!("CARGO_BIN_EXE_hil");
        let words: Vec<&str> = options.iter().copied().chain([hil]).chain(words).collect();
        let said = bench.start_with(program, &words, None).finish(END);
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
