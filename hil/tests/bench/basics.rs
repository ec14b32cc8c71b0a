//! A run that begins, drives and ends, a run that is struck, and what the fake bench itself does.

use std::time::{Duration, Instant};

use nix::libc;
use nix::sys::signal::Signal;
use nix::time::ClockId;
use palpate_tests::fake_bench::Mode;
use std::sync::atomic::Ordering;

use crate::rig::{OFF_MS, is_soon, nanoseconds, now_ns, on_bench};

/// What a run is given to end.
const END: Duration = Duration::from_secs(6);
/// The guard's limit of one burst.
const BURST_MS: f64 = 50.0;
/// After which a guardian counts a silent run as hung, of benches that do not say it.
const HEARTBEAT_MS: f64 = 30.0;

#[test]
fn a_run_drives_bursts_and_ends_in_order() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let run = bench.run(1.5);
        run.wait_until_on();
        let said = run.finish(END);
        assert_eq!(said.status, Some(0), "{said:?}");
        bench.assert_off_within(BURST_MS, 0);
        assert!(bench.longest_on() > 5.0);
        assert_eq!(bench.latched(), "");
    });
}

#[test]
fn a_run_that_is_killed_in_a_burst_is_off_and_latched() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_for_burst();
        let at = run.kill();
        let said = run.finish(END);
        bench.assert_off_within(OFF_MS, at);
        assert!(bench.latched().contains("cause=the run died"), "{said:?}");
    });
}

#[test]
fn a_run_that_is_interrupted_ends_in_order() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_for_burst();
        let at = now_ns();
        run.signal(Signal::SIGINT);
        let said = run.finish(END);
        bench.assert_off_within(OFF_MS, at);
        assert_eq!(bench.latched(), "", "{said:?}");
    });
}

#[test]
fn a_run_that_is_stopped_in_a_burst_is_off_and_latched() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_for_burst();
        let at = now_ns();
        run.signal(Signal::SIGSTOP);
        let said = run.finish(END);
        assert_eq!(said.status, None, "{said:?}");
        bench.assert_off_within(HEARTBEAT_MS + OFF_MS, at);
        assert!(bench.latched().contains("cause=the run hung"), "{said:?}");
    });
}

#[test]
fn a_run_whose_guardian_is_killed_ends_with_outputs_off() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_for_burst();
        let at = now_ns();
        crate::run::signal(run.guardian(), Signal::SIGKILL);
        let said = run.finish(END);
        bench.assert_off_within(OFF_MS, at);
        assert_eq!(said.status, Some(3), "{said:?}");
    });
}

#[test]
fn a_bus_that_fails_for_a_moment_is_switched_off_when_it_answers() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_for_burst();
        let failed = Instant::now();
        bench.set_mode(Mode::Fails(libc::ENXIO as u16));
        std::thread::sleep(Duration::from_millis(300));
        bench.set_mode(Mode::Works);
        let unreachable_ms = failed.elapsed().as_secs_f64() * 1e3;
        assert!(is_soon(END, || !bench.is_on()));
        run.signal(Signal::SIGINT);
        run.finish(END);
        bench.assert_off_within(BURST_MS + unreachable_ms + OFF_MS, 0);
    });
}

#[test]
fn an_adapter_that_is_a_millisecond_late_is_driven() {
    on_bench(1, |bench| {
        bench.adapters[0].late_us.store(1000, Ordering::Release);
        let _feed = bench.feed();
        let run = bench.run(1.5);
        run.wait_until_on();
        let said = run.finish(END);
        assert_eq!(said.status, Some(0), "{said:?}");
        bench.assert_off_within(BURST_MS, 0);
    });
}

#[test]
fn an_adapter_fails_after_so_many_transfers() {
    on_bench(1, |bench| {
        let page = &bench.adapters[0];
        for (mode, words) in [
            (Mode::Fails(libc::EIO as u16), "EIO"),
            (Mode::Fails(libc::EREMOTEIO as u16), "EREMOTEIO"),
            (Mode::Fails(libc::ETIMEDOUT as u16), "ETIMEDOUT"),
            (Mode::Fails(libc::ENODEV as u16), "the adapter is gone"),
            (Mode::Lies, "was driving channels"),
        ] {
            page.set_mode(Mode::Works);
            page.set_mode_after(1, mode);
            let said = bench
                .start(&["doctor", "--bench", "bench.toml"])
                .finish(END);
            assert_eq!(page.mode(), mode);
            let all = said.out + &said.err;
            assert!(all.contains(words), "{words}: {all}");
        }
    });
}

#[test]
fn a_chip_that_is_absent_answers_nothing() {
    on_bench(1, |bench| {
        bench.adapters[0].absent.store(1, Ordering::Release);
        let said = bench.off(&["--bench", "bench.toml"]);
        assert_eq!(said.status, Some(3), "{said:?}");
        assert!(said.err.contains("no chip answers"), "{said:?}");
    });
}

#[test]
fn a_clock_that_jumps_ahead_ends_a_run() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_for_burst();
        bench
            .clock
            .lost_ns
            .store(-60_000_000_000, Ordering::Release);
        // Its own clock says that all of its time is over.
        run.finish(Duration::from_secs(2));
        assert!(!bench.is_on());
    });
}

#[test]
fn while_its_clock_stands_still_a_run_does_nothing() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_for_burst();
        let transfers = || bench.adapters[0].transfers.load(Ordering::Acquire);
        let now = nanoseconds(ClockId::CLOCK_MONOTONIC);
        bench.clock.still_ns.store(now as i64, Ordering::Release);
        // A turn that was on its way on a busy machine comes to its end.
        let rests = || {
            let before = transfers();
            std::thread::sleep(Duration::from_millis(100));
            transfers() == before
        };
        assert!(is_soon(END, rests));
        let before = transfers();
        std::thread::sleep(Duration::from_millis(300));
        assert_eq!(transfers(), before);
        bench.clock.still_ns.store(0, Ordering::Release);
        run.kill();
        run.finish(END);
        assert!(!bench.is_on());
    });
}

#[test]
fn the_time_of_day_is_the_bench_s() {
    on_bench(1, |bench| {
        let year = 365 * 86_400;
        bench
            .clock
            .realtime_ns
            .store(year * 1_000_000_000, Ordering::Release);
        let _feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_until_on();
        run.kill();
        run.finish(END);
        let latched = bench.latched();
        let at = latched.lines().find_map(|line| line.strip_prefix("at_s="));
        let at: u64 = at.unwrap().parse().unwrap();
        let now = nanoseconds(ClockId::CLOCK_REALTIME) / 1_000_000_000;
        assert!(at.abs_diff(now + year as u64) < 60, "{latched}");
    });
}
