//! `hil test` and bare flags on device nodes: the scenes that a bench can run, and why it leaves the others out.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::tools::{hil, in_lab, scene, scratch, sh, text, try_sh};
use super::ward::Ward;

/// The suite's loop with expectations of its own.
fn with_expectations(name: &str, contacts_max: u32) -> PathBuf {
    let file = scratch(name);
    let text = std::fs::read_to_string(scene("loop.toml")).unwrap();
    let expect = format!("\n[expect]\ncontacts_max = {contacts_max}\nlimiter_events_max = 0\n");
    std::fs::write(&file, text + &expect).unwrap();
    file
}

/// The ward's bench with another line under `[real]`.
fn bench_with(ward: &Ward, line: &str) -> PathBuf {
    let file = scratch("bench-with.toml");
    let text = std::fs::read_to_string(ward.bench()).unwrap();
    std::fs::write(
        &file,
        text.replace("[real]\n", &format!("[real]\n{line}\n")),
    )
    .unwrap();
    file
}

#[test]
fn scenes_are_trials_by_what_the_bench_can_do() {
    if !in_lab("hil test on a real bench") {
        return;
    }
    let hil = hil().display();
    let ward = Ward::open(&scene("loop.toml"), &[]);
    // The emulated boards are touched in step with the run, as a robot that is told to would do it.
    let bench = bench_with(&ward, "touch = true");
    let bench = bench.display();
    let junit = scratch("trials.xml");
    let result =
        |out: &str| -> Value { serde_json::from_str::<Value>(out).unwrap()["trials"][0].clone() };

    let good = with_expectations("good.toml", 1);
    let out = sh(&format!(
        "{hil} test {} --bench {bench} --retries 0 --json --junit {}",
        good.display(),
        junit.display()
    ));
    assert_eq!(
        serde_json::from_str::<Value>(&out).unwrap()["source"],
        "real"
    );
    let trial = result(&out);
    assert_eq!(trial["verdict"], "ok", "{trial}");
    let measures = trial["measures"].as_array().unwrap();
    let of = |name: &str| measures.iter().find(|m| m["name"] == name).unwrap();
    assert_eq!(of("contacts in a frame")["value"], json!(1.0), "{trial}");
    let xml = std::fs::read_to_string(&junit).unwrap();
    assert!(xml.contains("tests=\"1\" failures=\"0\""), "{xml}");

    ward.stop_boards();
    let bad = with_expectations("bad.toml", 0);
    let line = format!(
        "{hil} test {} --bench {bench} --retries 0 --json",
        bad.display()
    );
    let failed = try_sh(&line);
    assert_eq!(failed.status.code(), Some(1), "{}", text(&failed.stderr));
    assert_eq!(result(&text(&failed.stdout))["verdict"], "failed");

    // What the bench lacks is named and nothing is run, which is no success.
    for (name, bench, lacks) in [
        ("stuck-amplifier", bench.to_string(), "fault injection"),
        ("sphere-along", ward.bench().display().to_string(), "touch"),
        ("allegro-four-buses", bench.to_string(), "4 CAN interfaces"),
    ] {
        let said = try_sh(&format!("{hil} test {name} --bench {bench} --json"));
        assert_eq!(said.status.code(), Some(1), "{}", text(&said.stderr));
        let trial = result(&text(&said.stdout));
        assert_eq!(trial["verdict"], "skipped", "{trial}");
        assert!(trial["why"][0].as_str().unwrap().contains(lacks), "{trial}");
    }
    let record = ward.emulator.stop();
    assert_eq!(record["driving"], json!([]), "{record}");
}

#[test]
fn addresses_on_the_command_line_and_real_time_priority() {
    if !in_lab("addresses on the command line") {
        return;
    }
    let hil = hil().display();
    let scene = scene("loop.toml");
    let ward = Ward::open(&scene, &[]);
    let node = &ward.emulator.node;
    let bare = sh(&format!(
        "{hil} run {scene} --bench {} --can vcan0 --i2c {node} --json",
        ward.bench().display()
    ));
    let bare: Value = serde_json::from_str(&bare).unwrap();
    assert_eq!(bare["source"], "real", "{bare}");
    // The lab's user is root: the loop takes real-time priority unless the bench says no.
    assert_eq!(bare["pacing"]["realtime"], true, "{bare}");
    for wanted in [true, false] {
        ward.stop_boards();
        let bench = bench_with(&ward, &format!("realtime = {wanted}"));
        let summary = sh(&format!(
            "{hil} run {scene} --bench {} --json",
            bench.display()
        ));
        let summary: Value = serde_json::from_str(&summary).unwrap();
        assert_eq!(summary["pacing"]["realtime"], wanted, "{summary}");
        println!("realtime = {wanted}: {}", summary["pacing"]);
    }
    let record = ward.emulator.stop();
    let wires = record["wires"].as_array().unwrap();
    let pulses: u64 = wires.iter().map(|w| w["pulses"].as_u64().unwrap()).sum();
    assert!(pulses > 100, "{record}");
    assert_eq!(record["driving"], json!([]), "{record}");
}
