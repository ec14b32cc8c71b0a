//! Motors behind a TCA9548A on an I2C node of the kernel: `hil doctor`, a run, and a run that is killed.

use std::fs::read_to_string;
use std::path::Path;

use serde_json::Value;

use super::tools::{hil, in_lab, scene, scratch, sh};
use super::ward::{Fate, Ward, now_ns, patiently};

/// Time in which every motor is at rest after a death: the guardian's heartbeat and its writes to eight drivers, which an MCP2221
/// takes one after the other.
const LIMIT_NS: u64 = 300_000_000;

/// Level of a driver's first step, of 4096.
const STEP: u64 = 33;

/// Motor, requested and applied level of every stimulus.
fn stimuli(file: &Path) -> Vec<[u64; 3]> {
    let text = read_to_string(file).unwrap();
    let lines = text.lines().skip(1);
    let entries = lines.map(|line| serde_json::from_str::<Value>(line).unwrap());
    let of = |entry: Value| {
        let number = |key: &str| entry[key].as_u64();
        let applied = number("off")? - number("on")?;
        Some([number("channel")?, number("requested")?, applied])
    };
    let each = entries.filter_map(of);
    each.filter(|[_, requested, _]| *requested > 0).collect()
}

#[test]
fn motors_behind_a_switch_are_found_and_driven_through_an_i2c_node() {
    if !in_lab("motors behind an I2C node") {
        return;
    }
    let (hil, coins) = (hil().display(), scene("coins.toml"));
    let [inside, outside] = ["in.jsonl", "out.jsonl"].map(scratch);
    sh(&format!(
        "{hil} run {coins} --bench lra-8 --quiet --schedule {}",
        inside.display()
    ));
    let ward = Ward::open_on("motors.toml", &coins, &["--bench", "lra-8"]);
    let bench = ward.bench().display();
    let found = sh(&format!("i2cdetect -y {}", ward.emulator.number()));
    assert!(found.contains("70: 70"), "{found}");
    let doctor = sh(&format!("{hil} doctor --bench {bench} || true"));
    for channel in 0..8 {
        let words = format!("channel {channel} of the switch at 0x70: a DRV2605L, at rest");
        assert!(doctor.contains(&words), "{doctor}");
    }
    let summary = sh(&format!(
        "{hil} run {coins} --bench {bench} --json --schedule {}",
        outside.display()
    ));
    let record = ward.emulator.stop();
    println!("emulated: {record}");
    let summary: Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["source"], "real");
    let (wanted, found) = (stimuli(&inside), stimuli(&outside));
    println!(
        "stimuli: {} in one process, {} through the node",
        wanted.len(),
        found.len()
    );
    let share = found.len() as f64 / wanted.len() as f64;
    assert!(wanted.len() > 50 && (0.8..=1.2).contains(&share));
    // The skin has no noise: a motor has its level, wherever the grid of onsets lies, but for scans that the machine cut in two.
    let near = |[motor, level, _]: &&[u64; 3]| {
        let mut others = wanted.iter().filter(|other| other[0] == *motor);
        others.any(|other| other[1].abs_diff(*level) <= 40)
    };
    let same = found.iter().filter(near).count();
    assert!(
        same as f64 >= 0.9 * found.len() as f64,
        "{same} of {}",
        found.len()
    );
    assert!(record["face_um"].as_f64().unwrap() > 20.0, "{record}");
    let driven = record["motors"].as_array().unwrap().iter();
    let bursts: u64 = driven.map(|motor| motor["bursts"].as_u64().unwrap()).sum();
    // The weakest levels are less than one step of a driver.
    let applied = found.iter().filter(|stimulus| stimulus[2] >= STEP).count() as u64;
    let why = |reason: &str| read_to_string(&outside).unwrap().matches(reason).count();
    let [heat, burst, duty] = ["coil-heat", "\"burst\"", "duty"].map(why);
    println!(
        "{applied} stimuli that the guard passed, {bursts} bursts, {same} at their level; \
         limited by heat of the coil {heat}, burst {burst}, duty {duty}"
    );
    assert!(
        applied > 50 && bursts.abs_diff(applied) <= applied / 10,
        "{applied} {record}"
    );
    assert_eq!(record["driving"], Value::Array(Vec::new()));
}

#[test]
fn a_run_on_motors_that_is_killed_leaves_none_on() {
    if !in_lab("a death with motors on") {
        return;
    }
    let coins = scene("coins.toml");
    let mut ward = Ward::open_on("motors.toml", &coins, &["--bench", "lra-8"]);
    patiently(|| {
        let mut run = ward.run(&coins, &["--quiet"]);
        ward.wait_for_outputs(true)?;
        let struck = now_ns();
        run.child.kill().unwrap();
        run.end();
        let fate = ward.fate(struck);
        println!("a killed run on motors: {fate:?}");
        assert!(
            matches!(fate, Fate::Off(Some(late)) if late <= LIMIT_NS),
            "{fate:?}"
        );
        assert!(ward.latch().read().is_some(), "the stop is latched");
        ward.unlatch();
        Ok(())
    });
    ward.emulator.stop();
}
