//! A wire that was on for longer than its burst, because its bus did not answer: the run ends with that, and it is latched.

use std::time::{Duration, Instant};

use nix::libc;
use palpate_tests::fake_bench::Mode;

use crate::rig::{Bench, OFF_MS, is_soon, on_bench};

/// What a run is given to end once its bus answers.
const END: Duration = Duration::from_secs(6);
/// The exit status of a run that has passed a limit.
const LIMIT_EXCEEDED: i32 = 1;

/// One adapter does something else for a while in a burst: the run says that a limit was passed.
fn overrun(bench: &Bench, span: Duration, mode: Mode) {
    let _feed = bench.feed();
    let run = bench.run(30.0);
    let adapter = run.wait_for_burst();
    let failed = Instant::now();
    bench.adapters[adapter].set_mode(mode);
    std::thread::sleep(span);
    bench.adapters[adapter].set_mode(Mode::Works);
    let unreachable_ms = failed.elapsed().as_secs_f64() * 1e3;
    is_soon(Duration::from_secs(1), || !bench.is_on());
    let said = run.finish(END);
    bench.assert_off_within(unreachable_ms + OFF_MS, 0);
    assert_eq!(said.status, Some(LIMIT_EXCEEDED), "{said:?}");
    let all = format!("{}{}", said.out, said.err);
    assert!(all.contains("LIMIT EXCEEDED"), "{said:?}");
    assert_ne!(bench.latched(), "");
}

#[test]
fn an_adapter_that_hangs_in_a_burst_is_an_overrun() {
    on_bench(1, |bench| {
        overrun(bench, Duration::from_millis(450), Mode::Hangs)
    });
}

#[test]
fn a_bus_that_fails_for_long_in_a_burst_is_an_overrun() {
    let mode = Mode::Fails(libc::ENXIO as u16);
    on_bench(1, |bench| overrun(bench, Duration::from_millis(2500), mode));
}

#[test]
fn one_of_two_adapters_that_fails_in_a_burst_is_an_overrun() {
    let mode = Mode::Fails(libc::EIO as u16);
    on_bench(2, |bench| overrun(bench, Duration::from_millis(2000), mode));
}
