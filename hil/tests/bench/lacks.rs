//! What programs lack is what the fake bench says, for the guardian and for others apart, and words say so.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use nix::libc;
use palpate_tests::fake_bench::{GUARDIAN, RUN, ScarcePage};

use crate::rig::{Bench, OFF_MS, is_soon, on_bench};
use crate::run::Said;

/// What a program is given to end.
const END: Duration = Duration::from_secs(6);

/// Something that a program may lack.
type Lack = fn(&ScarcePage) -> &AtomicU32;

/// Says who lacks it from now on.
fn lack(bench: &Bench, what: Lack, who: u32) {
    what(&bench.scarce).store(who, Ordering::Release);
}

/// What `hil off` says while it lacks something, and what a run comes to whose guardian does.
fn lacking(what: Lack, words: &str) {
    on_bench(1, |bench| {
        lack(bench, what, RUN);
        let said = bench.off(&["--bench", "bench.toml"]);
        assert_ne!(said.status, Some(0), "{said:?}");
        assert!(said.err.contains(words), "{said:?}");
        // This is no guardian.
        lack(bench, what, GUARDIAN);
        let said = bench.off(&["--bench", "bench.toml"]);
        assert_eq!(said.status, Some(0), "{said:?}");
        // A run has one, which says why it cannot guard, or dies.
        let said = bench.run(1.0).finish(END);
        assert_eq!(said.status, Some(3), "{said:?}");
        assert!(!bench.is_on() && bench.longest_on() == 0.0);
    });
}

#[test]
fn who_lacks_memory_says_so_and_drives_nothing() {
    lacking(|scarce| &scarce.memory, "memory allocation of ");
}

#[test]
fn who_lacks_threads_says_so_and_drives_nothing() {
    lacking(|scarce| &scarce.threads, "Resource temporarily unavailable");
}

#[test]
fn who_lacks_descriptors_says_so_and_drives_nothing() {
    lacking(|scarce| &scarce.descriptors, "Too many open files");
}

/// Kills a run whose guardian lacks something of its disk. Returns what the record said before it was lifted.
fn killed(bench: &Bench, what: Lack) -> (String, Said) {
    let _feed = bench.feed();
    let run = bench.run(30.0);
    run.wait_for_burst();
    lack(bench, what, GUARDIAN);
    let at = run.kill();
    assert!(is_soon(END, || !bench.is_on()));
    std::thread::sleep(Duration::from_millis(300));
    let meanwhile = bench.records().pop().unwrap().1;
    lack(bench, what, 0);
    let said = run.finish(END);
    bench.assert_off_within(OFF_MS, at);
    (meanwhile, said)
}

#[test]
fn a_disk_that_hangs_latches_when_it_goes_on() {
    on_bench(1, |bench| {
        let (meanwhile, said) = killed(bench, |scarce| &scarce.disk_hangs);
        assert!(meanwhile.contains("state=armed"), "{meanwhile}");
        assert!(bench.latched().contains("cause=the run died"), "{said:?}");
    });
}

#[test]
fn a_stop_opens_nothing() {
    on_bench(1, |bench| {
        let (meanwhile, said) = killed(bench, |scarce| &scarce.open_hangs);
        assert!(meanwhile.contains("cause=the run died"), "{said:?}");
    });
}

#[test]
fn a_disk_that_fails_is_told_of_and_keeps_the_stop_that_was_armed() {
    for (errno, words) in [
        (libc::ENOSPC, "No space left"),
        (libc::EIO, "I/O error"),
        (libc::EROFS, "Read-only file system"),
    ] {
        on_bench(1, |bench| {
            bench
                .scarce
                .disk_errno
                .store(errno as u32, Ordering::Release);
            let (meanwhile, said) = killed(bench, |scarce| &scarce.disk_fails);
            let armed = "cause=run and guardian ended without a word";
            assert!(meanwhile.contains(armed), "{meanwhile}");
            assert!(said.err.contains(words), "{said:?}");
            // Once it takes something again, the cause is there.
            assert!(bench.latched().contains("cause=the run died"), "{said:?}");
        });
    }
}
