//! `hil unit` on the boards of an I2C node, and its host over UDP: a Raspberry Pi as the unit.

// These tests live in the lab's own time.
#![allow(clippy::disallowed_methods)]

use std::fs::File;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::Value;

use super::emulator::Emulator;
use super::tools::{hil, in_lab, scene, scratch, sh};
use super::ward::{Fate, HEARTBEAT_MS, fate, latch_of, now_ns, unlatch};

const ADDRESS: &str = "127.0.0.1:4817";
/// The guardian's own work on top of its patience.
const SLACK_NS: u64 = 40_000_000;

/// A unit's process, gone with this value.
struct Unit(Child);

impl Drop for Unit {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A unit on this adapter, once it serves.
fn serve(node: &str, key: &str) -> Unit {
    let said = scratch("unit.jsonl");
    let bench = scratch("unit-bench.toml");
    let text = std::fs::read_to_string(scene("bench.toml")).unwrap();
    let mut text = text.replace("/dev/i2c-0", node);
    // The PWM frequency that its host's scene needs, and what a burst bears at that.
    for (line, other) in [
        ("pwm_hz = 200.0\n", "pwm_hz = 65.63\n"),
        ("heartbeat_ms = 40\n", ""),
        ("transfer_ms = 40\n", ""),
    ] {
        assert!(text.contains(line), "{line}");
        text = text.replace(line, other);
    }
    std::fs::write(&bench, text).unwrap();
    let child = Command::new(hil())
        .args(["unit", "--json", "--key", key, "--at", ADDRESS, "--bench"])
        .arg(&bench)
        .stdin(Stdio::null())
        .stdout(File::create(&said).unwrap())
        .spawn()
        .unwrap();
    let mut unit = Unit(child);
    for _ in 0..600 {
        let told = std::fs::read_to_string(&said).unwrap();
        if told.contains("\"serving\"") {
            assert!(told.contains(node), "{told}");
            return unit;
        }
        assert!(
            unit.0.try_wait().unwrap().is_none(),
            "the unit has ended: {told}"
        );
        std::thread::sleep(Duration::from_millis(100));
    }
    panic!("the unit does not serve");
}

#[test]
fn a_unit_on_an_i2c_node_plays_and_leaves_nothing_on_when_it_is_killed() {
    if !in_lab("a driver unit on an I2C node") {
        return;
    }
    sh("ip link set lo up");
    let mut emulator = Emulator::start(&[]);
    unlatch(&emulator.node);
    let key = scratch("unit.key").display().to_string();
    let hil = hil().display();
    sh(&format!("rm -f {key}; {hil} unit --new-key {key}"));
    let mut unit = serve(&emulator.node, &key);
    let host = format!("{hil} run sphere-along --json --unit {ADDRESS} --key {key}");
    let summary: Value = serde_json::from_str(&sh(&host)).unwrap();
    println!("{}", summary["unit"]);
    assert!(summary["unit"]["begun"].as_u64().unwrap() > 0, "{summary}");
    assert_eq!(summary["unit"]["stops"], 0, "{summary}");
    emulator.hear_until_quiet(Duration::from_millis(200));
    let drove = |event: &Value| event["event"] == "driving";
    assert!(emulator.told.iter().any(drove), "nothing was driven");
    assert!(!emulator.is_driving);
    // Once more, and the unit dies in the middle of it.
    emulator.told.clear();
    let quiet = format!("{host} >/dev/null 2>&1");
    let mut again = Command::new("sh").args(["-c", &quiet]).spawn().unwrap();
    emulator.wait_for("driving");
    let struck_ns = now_ns();
    unit.0.kill().unwrap();
    let fate = fate(&mut emulator, struck_ns);
    println!("{fate:?}");
    let limit = HEARTBEAT_MS * 1_000_000 + SLACK_NS;
    assert!(
        matches!(fate, Fate::Off(ns) if ns.is_none_or(|ns| ns <= limit)),
        "{fate:?}"
    );
    assert!(
        !again.wait().unwrap().success(),
        "a host whose unit is gone"
    );
    let stopped = latch_of(&emulator.node).read();
    assert!(stopped.is_some(), "a unit that was killed is a stop");
    unlatch(&emulator.node);
    emulator.stop();
}
