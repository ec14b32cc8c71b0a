//! `hil pulse` on a bench: one wire is on once, what is kept of it counts for the next one, and what refuses a run refuses it.

use std::time::Duration;

use nix::sys::signal::Signal;
use palpate_tests::fake_bench::Mode;
use serde_json::Value;

use crate::feed::Feed;
use crate::rig::{Bench, is_soon, now_ns, on_bench};
use crate::run::Said;

/// Time that a command is given to end.
const END: Duration = Duration::from_secs(12);
/// The guard's limit of one burst.
const BURST_MS: f64 = 50.0;

/// The words of a pulse that is agreed to.
fn words(wire: &str) -> [&str; 6] {
    ["pulse", wire, "--bench", "bench.toml", "--yes", "--json"]
}

fn pulse(bench: &Bench, wire: &str) -> Said {
    bench.start(&words(wire)).finish(END)
}

/// Touches the skin of a pulse: it is listened to by one socket of the program, and then by another.
fn feeds(bench: &Bench) -> [Feed; 2] {
    [bench.feed(), Feed::start(bench.path("lo-1.rx"), 4)]
}

/// The object that a pulse prints.
#[track_caller]
fn object(said: &Said) -> Value {
    assert_eq!(said.status, Some(0), "{said:?}");
    serde_json::from_str(&said.out).unwrap()
}

/// Every time that a channel was on after a moment: adapter, channel and length, ms. All must be off.
#[track_caller]
fn driven(bench: &Bench, from_ns: u64) -> Vec<(usize, usize, f64)> {
    let mut all = Vec::new();
    for (adapter, page) in bench.adapters.iter().enumerate() {
        let record = page.record().unwrap();
        for channel in 0..16 {
            let mut since = None;
            for change in record.iter().filter(|change| change.at_ns >= from_ns) {
                match (change.widths[0][channel] != 0, since) {
                    (true, None) => since = Some(change.at_ns),
                    (false, Some(on)) => {
                        all.push((adapter, channel, (change.at_ns - on) as f64 * 1e-6));
                        since = None;
                    }
                    _ => {}
                }
            }
            assert!(since.is_none(), "channel {channel} is on");
        }
    }
    all
}

#[test]
fn one_wire_is_on_once_and_everything_is_off() {
    on_bench(2, |bench| {
        let _feeds = feeds(bench);
        // The last four wires hang on the second adapter.
        for (wire, adapter, channel) in [("3", 0, 3), ("6", 1, 6)] {
            let at = now_ns();
            let said = pulse(bench, wire);
            let object = object(&said);
            let driven = driven(bench, at);
            assert_eq!(driven.len(), 1, "{driven:?} {said:?}");
            assert_eq!((driven[0].0, driven[0].1), (adapter, channel));
            assert!(driven[0].2 <= BURST_MS, "{driven:?}");
            assert_eq!(object["sent"], true);
            assert_eq!(object["stimuli"], 1);
            assert_eq!(object["source"], "real");
            assert!(object["off_ms"].as_f64().unwrap() > 0.0, "{object}");
            assert!(!bench.is_on());
        }
        assert_eq!(bench.latched(), "");
    });
}

#[test]
fn a_pulse_is_judged_with_the_heat_of_the_one_before() {
    on_bench(1, |bench| {
        let _feeds = feeds(bench);
        let used = || object(&pulse(bench, "3"))["used"].clone();
        let (first, second) = (used(), used());
        let of = |used: &Value, row: &str| used[row].as_f64().unwrap();
        // One row of what is warm still, and one of the dose of the wearer.
        for row in ["skin_deep", "omega"] {
            let (first, second) = (of(&first, row), of(&second, row));
            assert!(first > 0.0 && second > first, "{row}: {first} {second}");
        }
        let forgotten = bench.off(&["--bench", "bench.toml", "--forget-heat", "fake"]);
        assert_eq!(forgotten.status, Some(0), "{forgotten:?}");
        assert_eq!(used(), first);
    });
}

#[test]
fn nothing_is_heated_that_was_not_agreed_to_or_is_not_there() {
    on_bench(1, |bench| {
        let _feeds = feeds(bench);
        let said = |words: &[&str]| bench.start(words).finish(END);
        let unasked = said(&["pulse", "3", "--bench", "bench.toml"]);
        assert_eq!(unasked.status, Some(2), "{unasked:?}");
        for words in ["wire 3 of bench `fake` (hardware)", "expected --yes"] {
            assert!(unasked.err.to_lowercase().contains(words), "{unasked:?}");
        }
        let wrong = pulse(bench, "8");
        assert_eq!(wrong.status, Some(2), "{wrong:?}");
        assert!(wrong.err.contains("0 to 7, found 8"), "{wrong:?}");
        assert!(bench.longest_on() <= 0.0, "it drove");
    });
}

#[test]
fn a_stop_a_run_a_dead_bus_and_a_silent_skin_refuse_it() {
    on_bench(1, |bench| {
        let silent = pulse(bench, "3");
        assert_eq!(silent.status, Some(3), "{silent:?}");
        assert!(silent.err.contains("no sensor frame came"), "{silent:?}");
        assert!(bench.longest_on() <= 0.0, "it drove");
        assert_eq!(bench.latched(), "", "a silent skin is no stop");

        let _ = std::fs::remove_file(bench.path("lo.rx"));
        let _feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_for_burst();
        let held = pulse(bench, "3");
        assert_eq!(held.status, Some(3), "{held:?}");
        run.kill();
        run.finish(END);

        let at = now_ns();
        let latched = pulse(bench, "3");
        assert_eq!(latched.status, Some(4), "{latched:?}");
        assert!(latched.err.contains("stopped earlier"), "{latched:?}");
        let cleared = bench.off(&["--bench", "bench.toml", "--unlatch"]);
        assert_eq!(cleared.status, Some(0), "{cleared:?}");

        bench.set_mode(Mode::Fails(nix::libc::ENXIO as u16));
        let dead = pulse(bench, "3");
        assert_eq!(dead.status, Some(3), "{dead:?}");
        bench.set_mode(Mode::Works);
        assert!(bench.longest_on_since(at) <= 0.0, "it drove");
    });
}

#[test]
fn a_pulse_that_is_interrupted_leaves_everything_off() {
    on_bench(1, |bench| {
        let _feeds = feeds(bench);
        let run = bench.start(&words("3"));
        assert!(is_soon(END, || bench.path("lo.rx").exists()));
        // The skin is heard for longer.
        std::thread::sleep(Duration::from_millis(200));
        run.signal(Signal::SIGINT);
        let said = run.finish(END);
        assert_eq!(said.status, Some(130), "{said:?}");
        assert!(said.err.contains("before the pulse"), "{said:?}");
        assert!(bench.longest_on() <= 0.0, "it drove");
        let run = bench.start(&words("3"));
        run.wait_until_on();
        run.signal(Signal::SIGINT);
        let said = run.finish(END);
        bench.assert_off_within(BURST_MS, 0);
        assert_eq!(bench.latched(), "", "{said:?}");
    });
}
