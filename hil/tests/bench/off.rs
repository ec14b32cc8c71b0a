//! `hil off` does what it can: every board that answers is off, and the exit status says what is not known to be.

use std::fs;
use std::time::{Duration, Instant};

use palpate_tests::fake_bench::Mode;

use crate::rig::{Bench, OFF_MS, is_on, is_soon, now_ns, on_bench};

/// What a command is given to end.
const END: Duration = Duration::from_secs(20);
/// What a program needs to start.
const START_MS: f64 = 100.0;

/// A bench of two adapters that was left driving: nobody is there any more. The adapter that drives, and the other one.
fn left_driving(bench: &Bench) -> (usize, usize) {
    let _feed = bench.feed();
    let run = bench.run(30.0);
    let adapter = run.wait_for_burst();
    run.kill_both();
    run.finish(END);
    assert!(is_on(&bench.adapters[adapter]));
    (adapter, 1 - adapter)
}

/// Switches off beside an adapter that does not take part: the other one is off soon, and the status says so.
fn off_beside(bench: &Bench, adapter: usize, then: impl FnOnce()) {
    let at = now_ns();
    let off = bench.start(&["off", "--bench", "bench.toml"]);
    is_soon(Duration::from_secs(4), || !is_on(&bench.adapters[adapter]));
    // The adapter that takes no part may have been driving as well, and nothing reaches it.
    let passed_ms = now_ns().saturating_sub(at) as f64 * 1e-6;
    assert!(
        !is_on(&bench.adapters[adapter]),
        "still on after {passed_ms:.1} ms"
    );
    let most_ms = START_MS + OFF_MS + bench.lateness();
    assert!(
        passed_ms <= most_ms,
        "{passed_ms:.1} ms, at most {most_ms:.1} ms allowed"
    );
    then();
    let said = off.finish(END);
    assert_ne!(said.status, Some(0), "{said:?}");
}

#[test]
fn a_bench_that_was_left_driving_is_switched_off() {
    on_bench(2, |bench| {
        left_driving(bench);
        let at = now_ns();
        let said = bench.off(&["--bench", "bench.toml"]);
        assert_eq!(said.status, Some(0), "{said:?}");
        assert!(said.out.contains("was driving channels"), "{said:?}");
        bench.assert_off_within(START_MS + OFF_MS, at);
    });
}

#[test]
fn a_bench_whose_run_and_guardian_are_gone_is_refused_until_a_person_has_looked() {
    on_bench(2, |bench| {
        left_driving(bench);
        let refused = bench.run(1.0).finish(END);
        assert_eq!(refused.status, Some(4), "{refused:?}");
        let words = "stopped earlier: run and guardian ended without a word";
        assert!(refused.err.contains(words), "{refused:?}");
        let doctor = bench
            .start(&["doctor", "--bench", "bench.toml"])
            .finish(END);
        assert!(doctor.out.contains(words), "{doctor:?}");
        let kept = bench.off(&["--bench", "bench.toml"]);
        assert!(kept.out.contains("stays latched"), "{kept:?}");
        let cleared = bench.off(&["--bench", "bench.toml", "--unlatch"]);
        assert!(cleared.out.contains("the stop is cleared"), "{cleared:?}");
        let _feed = bench.feed();
        let said = bench.run(1.0).finish(END);
        assert_eq!(said.status, Some(0), "{said:?}");
    });
}

#[test]
fn an_adapter_that_is_missing_keeps_no_other_on() {
    on_bench(2, |bench| {
        let (adapter, missing) = left_driving(bench);
        fs::rename(bench.node(missing), bench.path("unplugged")).unwrap();
        off_beside(bench, adapter, || {});
    });
}

#[test]
fn an_adapter_that_hangs_keeps_no_other_on() {
    on_bench(2, |bench| {
        let (adapter, hanging) = left_driving(bench);
        bench.adapters[hanging].set_mode(Mode::Hangs);
        off_beside(bench, adapter, || {
            // Longer than anybody waits for it.
            std::thread::sleep(Duration::from_millis(1500));
        });
        bench.set_mode(Mode::Works);
    });
}

#[test]
fn a_run_of_another_name_is_ended_or_told_of() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let program = bench.path("another");
        fs::copy(env!("CARGO_BIN_EXE_hil"), &program).unwrap();
        let scene = bench.scene(30.0);
        let run = bench.start_with(&program, &Bench::run_words(&scene), None);
        run.wait_until_on();
        let said = bench.off(&["--bench", "bench.toml"]);
        let began = Instant::now();
        let drives = is_soon(Duration::from_millis(500), || bench.is_on());
        assert!(
            !drives || said.status != Some(0),
            "it drives again after {:?}: {said:?}",
            began.elapsed()
        );
    });
}
