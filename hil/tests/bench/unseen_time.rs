//! Time in which neither the run nor its guardian could act: on waking it counts as on, and the stop is latched.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use nix::sys::signal::Signal;

use crate::rig::{OFF_MS, is_soon, on_bench};
use crate::run::freeze;

/// How long nothing moves: many times any limit.
const FROZEN: Duration = Duration::from_millis(1000);
/// What a run is given to end after that.
const END: Duration = Duration::from_secs(6);

/// Both processes are frozen in a burst, and the clock keeps that time or loses it.
fn frozen(clock_stops: bool) {
    on_bench(1, |bench| {
        let feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_for_burst();
        feed.paused.store(true, Ordering::Release);
        let began = Instant::now();
        freeze(&[run.id(), run.guardian()], FROZEN, || {
            feed.paused.store(false, Ordering::Release);
            if clock_stops {
                let lost = began.elapsed().as_nanos() as i64;
                bench.clock.lost_ns.store(lost, Ordering::Release);
            }
        });
        let frozen_ms = began.elapsed().as_secs_f64() * 1e3;
        is_soon(Duration::from_secs(1), || !bench.is_on());
        // One that noticed nothing goes on, and would do so for long.
        is_soon(Duration::from_millis(500), || !bench.latched().is_empty());
        run.signal(Signal::SIGINT);
        let said = run.finish(END);
        bench.assert_off_within(frozen_ms + OFF_MS, 0);
        assert_ne!(bench.latched(), "", "{said:?}");
        assert!(![Some(0), Some(130)].contains(&said.status), "{said:?}");
    });
}

#[test]
fn a_suspended_machine_stops_the_run() {
    frozen(true);
}

#[test]
fn a_frozen_run_and_guardian_stop() {
    frozen(false);
}
