//! Two fingers on two adapters: both are driven, what ends the run ends both, and a finger that fails takes no other one along
//! unless a wire was on for too long.

use std::fs;
use std::time::{Duration, Instant};

use nix::libc;
use nix::sys::signal::Signal;
use palpate_tests::fake_bench::Mode;

use crate::feed::{self, Feed};
use crate::rig::{Bench, OFF_MS, is_on, is_soon, now_ns, on_bench};
use crate::run::Run;

/// Time that a run is given to end.
const END: Duration = Duration::from_secs(9);
/// The guard's limit of one burst.
const BURST_MS: f64 = 50.0;
/// Both fingers are driven within this time of each other.
const BOTH: Duration = Duration::from_secs(4);

/// The bench with a display on each of its two adapters, a pad for each, and a scene of so many seconds that touches both.
fn hand(bench: &Bench, length_s: f64) {
    let text = fs::read_to_string(bench.path("bench.toml")).unwrap();
    let (head, _) = text.split_once("[[outputs]]").unwrap();
    let display = |(bus, name): (usize, &str)| {
        let output = |channel| format!("{{ bus = {bus}, board = 0x40, channel = {channel} }}");
        let outputs: Vec<String> = (0..8).map(output).collect();
        let outputs = outputs.join(", ");
        format!("[[displays]]\nname = \"{name}\"\noutputs = [{outputs}]\n")
    };
    let displays: String = [(0, "index"), (1, "thumb")].map(display).concat();
    fs::write(bench.path("bench.toml"), head.to_owned() + &displays).unwrap();
    let pad = |(number, board): (usize, u8)| {
        format!(
            "[[modules]]\nname = \"pad-{number}\"\ngrid = {{ rows = 4, columns = 4, pitch_mm = 4.7 }}\nplace_mm = [{}.0, 0.0]\nbus = 0\nboards = [{board}]\n",
            number * 30
        )
    };
    let pads: String = [(0, 4), (1, 5)].map(pad).concat();
    let layout = "kind = \"sensor\"\nname = \"two-pads\"\ndescription = \"Two pads\"\n";
    fs::write(bench.path("two-pads.toml"), layout.to_owned() + &pads).unwrap();
    let layout = format!("layout = {:?}\n", bench.path("two-pads.toml"));
    let finger =
        |(module, name)| format!("[[fingers]]\ndisplay = \"{name}\"\nmodules = [{module}]\n");
    let fingers: String = [(0, "index"), (1, "thumb")].map(finger).concat();
    let scene = layout + &feed::scene(length_s) + &fingers;
    fs::write(bench.path("hand.toml"), scene).unwrap();
}

/// Touches both pads.
fn feeds(bench: &Bench) -> [Feed; 2] {
    [("lo.rx", 4), ("lo-1.rx", 5)].map(|(name, board)| Feed::start(bench.path(name), board))
}

/// A run that drives both fingers.
#[track_caller]
fn driven(bench: &Bench) -> Run<'_> {
    let run = bench.start(&Bench::run_words("hand.toml"));
    run.wait_until_on();
    for page in &bench.adapters {
        assert!(is_soon(BOTH, || is_on(page)), "only one finger is driven");
    }
    run
}

#[test]
fn two_fingers_are_driven_and_end_in_order() {
    on_bench(2, |bench| {
        hand(bench, 2.0);
        let _feeds = feeds(bench);
        let said = driven(bench).finish(END);
        assert_eq!(said.status, Some(0), "{said:?}");
        bench.assert_off_within(BURST_MS, 0);
        assert_eq!(bench.latched(), "");
    });
}

#[test]
fn two_fingers_whose_run_is_killed_or_stopped_are_off() {
    for (signal, cause) in [
        (Signal::SIGKILL, Some("cause=the run died")),
        (Signal::SIGSTOP, Some("cause=the run hung")),
        (Signal::SIGINT, None),
    ] {
        on_bench(2, |bench| {
            hand(bench, 30.0);
            let _feeds = feeds(bench);
            let run = driven(bench);
            run.wait_for_burst();
            let at = now_ns();
            run.signal(signal);
            let said = run.finish(END);
            // A run that is stopped is noticed by its heartbeat, 30 ms.
            bench.assert_off_within(30.0 + OFF_MS, at);
            let latched = bench.latched();
            match cause {
                Some(cause) => assert!(latched.contains(cause), "{latched}{said:?}"),
                None => assert_eq!(latched, "", "{said:?}"),
            }
        });
    }
}

#[test]
fn two_fingers_whose_guardian_is_killed_end_with_outputs_off() {
    on_bench(2, |bench| {
        hand(bench, 30.0);
        let _feeds = feeds(bench);
        let run = driven(bench);
        run.wait_for_burst();
        let at = now_ns();
        crate::run::signal(run.guardian(), Signal::SIGKILL);
        let said = run.finish(END);
        bench.assert_off_within(OFF_MS, at);
        assert_eq!(said.status, Some(3), "{said:?}");
    });
}

#[test]
fn a_finger_whose_wire_was_on_for_too_long_ends_the_other_one() {
    on_bench(2, |bench| {
        hand(bench, 30.0);
        let _feeds = feeds(bench);
        let run = driven(bench);
        let adapter = run.wait_for_burst();
        let failed = Instant::now();
        bench.adapters[adapter].set_mode(Mode::Fails(libc::EIO as u16));
        std::thread::sleep(Duration::from_millis(1500));
        bench.adapters[adapter].set_mode(Mode::Works);
        let unreachable_ms = failed.elapsed().as_secs_f64() * 1e3;
        is_soon(Duration::from_secs(1), || !bench.is_on());
        let said = run.finish(END);
        bench.assert_off_within(unreachable_ms + OFF_MS, 0);
        let all = format!("{}{}", said.out, said.err);
        assert!(all.contains("LIMIT EXCEEDED"), "{said:?}");
        assert_eq!(said.status, Some(1), "{said:?}");
        let names = ["index: ", "thumb: "];
        let latched = bench.latched();
        assert!(latched.contains(names[adapter]), "{latched}");
    });
}

#[test]
fn a_finger_that_stays_on_is_the_guardians_once_the_other_one_has_ended() {
    on_bench(2, |bench| {
        hand(bench, 4.0);
        let _feeds = feeds(bench);
        let run = driven(bench);
        let adapter = run.wait_for_burst();
        let failed = Instant::now();
        bench.adapters[adapter].set_mode(Mode::Fails(libc::ENXIO as u16));
        assert!(run.ends_within(END), "it goes on");
        bench.adapters[adapter].set_mode(Mode::Works);
        let unreachable_ms = failed.elapsed().as_secs_f64() * 1e3;
        let said = run.finish(END);
        bench.assert_off_within(unreachable_ms + OFF_MS, 0);
        assert_ne!(said.status, Some(0), "{said:?}");
        assert_ne!(bench.latched(), "", "{said:?}");
    });
}
