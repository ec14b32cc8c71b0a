//! Motors on a bench: drivers behind a switch in place of boards, and the same run, guardian, ways out and words.

use std::fs;
use std::time::Duration;

use nix::libc;
use nix::sys::signal::Signal;
use palpate_tests::fake_bench::{Mode, Switch};
use serde_json::Value;

use crate::rig::{Bench, OFF_MS, now_ns, on_bench};
use crate::run::{Run, Said};

/// Time that a command is given to end.
pub const END: Duration = Duration::from_secs(12);
/// Silence after which a guardian takes a run as hung, of benches that do not say it.
const HEARTBEAT_MS: f64 = 30.0;
/// Time that a run has to bring a dead bus back.
const GIVE_UP: Duration = Duration::from_secs(8);

/// A test on a bench of eight motors behind a switch at 0x70.
pub fn on_motors(test: impl Fn(&Bench)) {
    on_bench(1, |bench| {
        bench.adapters[0].put_motors(Switch::new(0x70, 8));
        fs::write(bench.path("motors.toml"), text(bench)).unwrap();
        test(bench);
    });
}

/// The bench's file.
fn text(bench: &Bench) -> String {
    let drivers: Vec<String> = (0..8)
        .map(|channel| format!("{{ switch = 0x70, channel = {channel} }}"))
        .collect();
    format!(
        "name = \"coins\"\ndescription = \"drivers of a fake bench\"\nkind = \"real\"\ndisplay = \"thimble-8\"\n\
         [real]\ncan = [\"lo\"]\ni2c = [{:?}]\n\
         [haptics]\nkind = \"lra\"\nrated_v = 1.8\nfull_v = 0.3\noverdrive_v = 2.7\nresonance_hz = 235.0\nohm = 25.0\n\
         travel_um = 300.0\ncalibration = [232, 166, 3]\ndrivers = [{}]\n",
        bench.node(0),
        drivers.join(", ")
    )
}

/// A scene of that length: a sphere rests between two motors.
pub fn scene(bench: &Bench, length_s: f64) -> String {
    let text = crate::feed::scene(length_s);
    let (before, after) = text.split_once("[illusion]\n").unwrap();
    let (_, touches) = after.split_once("[[touches]]").unwrap();
    let name = format!("coins-{length_s}.toml");
    fs::write(bench.path(&name), format!("{before}[[touches]]{touches}")).unwrap();
    name
}

fn run(bench: &Bench, length_s: f64) -> Run<'_> {
    let scene = scene(bench, length_s);
    bench.start(&["run", &scene, "--bench", "motors.toml", "--quiet"])
}

fn said(bench: &Bench, words: &[&str]) -> Said {
    bench.start(words).finish(END)
}

/// Channel and requested level of each motor at every onset of a schedule whose touch has lasted for a while.
fn onsets(path: &std::path::Path) -> Vec<Vec<(u64, u64)>> {
    let text = fs::read_to_string(path).unwrap();
    let entries = text
        .lines()
        .filter_map(|line| serde_json::from_str::<Value>(line).ok())
        .filter(|entry| entry["requested"].as_u64().is_some_and(|level| level > 0));
    let mut onsets: Vec<(u64, Vec<(u64, u64)>)> = Vec::new();
    for entry in entries {
        let at = entry["t_us"].as_u64().unwrap();
        let motor = (
            entry["channel"].as_u64().unwrap(),
            entry["requested"].as_u64().unwrap(),
        );
        match onsets.last_mut() {
            Some((same, motors)) if *same == at => motors.push(motor),
            _ => onsets.push((at, vec![motor])),
        }
    }
    let late = onsets.into_iter().filter(|(at, _)| *at > 1_200_000);
    late.map(|(_, motors)| motors).collect()
}

#[test]
fn motors_are_driven_as_on_the_emulated_bench_and_the_run_ends_in_order() {
    on_motors(|bench| {
        let scene = scene(bench, 2.5);
        let emulated = [
            "run",
            &scene,
            "--bench",
            "lra-8",
            "--schedule",
            "emulated.jsonl",
            "--quiet",
        ];
        assert_eq!(said(bench, &emulated).status, Some(0));
        let _feed = bench.feed();
        let run = bench.start(&[
            "run",
            &scene,
            "--bench",
            "motors.toml",
            "--schedule",
            "real.jsonl",
            "--json",
        ]);
        run.wait_until_on();
        let said = run.finish(END);
        assert_eq!(said.status, Some(0), "{said:?}");
        bench.assert_off_within(500.0, 0);
        assert_eq!(bench.latched(), "");
        let summary: Value = serde_json::from_str(&said.out).unwrap();
        assert_eq!(summary["source"], "real", "{summary}");
        let [real, emulated] =
            ["real.jsonl", "emulated.jsonl"].map(|name| onsets(&bench.path(name)));
        assert!(real.len() > 5 && real.len().abs_diff(emulated.len()) <= 1);
        // The skin's noise is another at each onset, and moves levels. Over the run it averages out.
        let strongest = |motors: &Vec<(u64, u64)>| motors.iter().copied().max_by_key(|m| m.1);
        let [real, emulated] = [real, emulated].map(|all| {
            let each: Vec<(u64, u64)> = all.iter().filter_map(strongest).collect();
            let mean = each.iter().map(|m| m.1 as f64).sum::<f64>() / each.len() as f64;
            (each.into_iter().map(|m| m.0).collect::<Vec<_>>(), mean)
        });
        assert!(
            real.0.iter().chain(&emulated.0).all(|motor| *motor == 1),
            "{real:?} {emulated:?}"
        );
        assert!(
            (real.1 / emulated.1 - 1.0).abs() < 0.1,
            "{real:?} {emulated:?}"
        );
    });
}

#[test]
fn a_run_that_is_killed_or_hangs_leaves_every_motor_off_and_the_stop_latched() {
    for (signal, limit_ms, cause) in [
        (Signal::SIGKILL, OFF_MS, "cause=the run died"),
        (Signal::SIGSTOP, HEARTBEAT_MS + OFF_MS, "cause=the run hung"),
    ] {
        on_motors(|bench| {
            let _feed = bench.feed();
            let run = run(bench, 30.0);
            run.wait_for_burst();
            let at = now_ns();
            run.signal(signal);
            let ended = run.finish(END);
            bench.assert_off_within(limit_ms, at);
            assert!(bench.latched().contains(cause), "{ended:?}");
            let refused = said(bench, &["run", "idle", "--bench", "motors.toml", "--quiet"]);
            assert_eq!(refused.status, Some(4), "{refused:?}");
            let off = ["off", "--bench", "motors.toml", "--unlatch"];
            let cleared = said(bench, &off);
            assert_eq!(cleared.status, Some(0), "{cleared:?}");
            assert!(cleared.out.contains("the stop is cleared"), "{cleared:?}");
        });
    }
}

#[test]
fn a_run_that_is_interrupted_ends_in_order() {
    on_motors(|bench| {
        let _feed = bench.feed();
        let run = run(bench, 30.0);
        run.wait_for_burst();
        let at = now_ns();
        run.signal(Signal::SIGINT);
        let ended = run.finish(END);
        assert_eq!(ended.status, Some(0), "{ended:?}");
        bench.assert_off_within(OFF_MS, at);
        assert_eq!(bench.latched(), "", "{ended:?}");
    });
}

#[test]
fn a_bus_that_dies_and_a_switch_that_sticks_end_the_run_with_their_words() {
    on_motors(|bench| {
        let _feed = bench.feed();
        let run = run(bench, 30.0);
        run.wait_for_burst();
        bench.set_mode(Mode::Fails(libc::ENXIO as u16));
        assert!(run.ends_within(GIVE_UP));
        let at = now_ns();
        bench.set_mode(Mode::Works);
        let ended = run.finish(END);
        // Nothing cuts a motor whose bus is dead: it shook for longer than a burst may last.
        assert_eq!(ended.status, Some(1), "{ended:?}");
        for words in [
            "overrun: motor ",
            "from the switch",
            "no chip answers (ENXIO)",
        ] {
            assert!(ended.err.contains(words), "{words}: {ended:?}");
        }
        bench.assert_off_within(OFF_MS, at);
    });
    on_motors(|bench| {
        let _feed = bench.feed();
        let run = run(bench, 30.0);
        run.wait_for_burst();
        bench.adapters[0].change(now_ns, |state| state.switch.stuck = 1 << 2);
        assert!(run.ends_within(GIVE_UP));
        let ended = run.finish(END);
        assert_eq!(ended.status, Some(3), "{ended:?}");
        assert!(ended.err.contains("the switch is stuck"), "{ended:?}");
        // The switch leaves no way to the others.
        bench.adapters[0].change(now_ns, |state| state.switch.stuck = 0);
        let off = said(bench, &["off", "--bench", "motors.toml"]);
        assert_eq!(off.status, Some(0), "{off:?}");
        assert!(!bench.is_on());
    });
}

#[test]
fn motors_that_were_left_driving_are_told_of_and_switched_off() {
    on_motors(|bench| {
        let _feed = bench.feed();
        let run = run(bench, 30.0);
        run.wait_for_burst();
        run.kill_both();
        run.finish(END);
        assert!(bench.is_on());
        let found = said(bench, &["doctor", "--bench", "motors.toml"]);
        assert!(found.out.contains("its driver drives it"), "{found:?}");
        let off = said(bench, &["off", "--bench", "motors.toml"]);
        assert_eq!(off.status, Some(0), "{off:?}");
        assert!(off.out.contains("0x70: was driving channels"), "{off:?}");
        assert!(!bench.is_on());
    });
}

#[test]
fn the_doctor_finds_every_driver_the_one_that_is_missing_and_a_switch_that_is_stuck() {
    on_motors(|bench| {
        let doctor = || said(bench, &["doctor", "--bench", "motors.toml"]).out;
        let fine = doctor();
        for channel in 0..8 {
            let words =
                format!("{channel}, channel {channel} of the switch at 0x70: a DRV2605L, at rest");
            assert!(fine.contains(&words), "{fine}");
        }
        bench.adapters[0].change(now_ns, |state| state.switch.unplug(5));
        let missing = doctor();
        let of = |channel: u8, out: &str| {
            let line = format!("motor       {channel}, ");
            out.lines().find(|l| l.contains(&line)).unwrap().to_owned()
        };
        assert!(of(5, &missing).starts_with("missing"), "{missing}");
        assert!(of(5, &missing).contains("no chip answers"), "{missing}");
        assert!(of(4, &missing).starts_with("ok"), "{missing}");
        bench.adapters[0].change(now_ns, |state| state.switch.stuck = 1 << 2);
        let stuck = doctor();
        assert!(
            stuck.contains("while every channel of the switch is closed"),
            "{stuck}"
        );
    });
}
