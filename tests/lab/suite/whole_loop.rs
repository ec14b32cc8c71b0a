//! The whole loop through device nodes: `hil run` on a vcan interface and an I2C node, `hil emulate` in
//! another process behind them, against the same scene in one process and virtual time.
//!
//! What may differ, and how much: the wall clock cuts a scan in two now and then (the lab's processor is
//! emulated), and the grid of onsets lies elsewhere on the scene by up to one SOA.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::read_to_string;
use std::path::Path;

use serde_json::Value;

use super::tools::{hil, in_lab, scene, scratch, sh};
use super::ward::Ward;

/// Share of the contacts in one process that must come through the nodes, the same to the last digit. A scan that
/// the machine cut in two adds one that is half old and half new, and does not take one away.
const SAME_CONTACTS: f64 = 0.95;
/// Ticks by which a wire's pulse may differ at the same place of the scene: its path moves 0.2 mm in an SOA.
const TICKS: i64 = 12;
/// Share of stimuli that must lie within that band.
const SAME_STIMULI: f64 = 0.8;

/// Contacts as `place, intensity, members`, with their times, microseconds.
fn contacts(file: &Path) -> Vec<(i64, String)> {
    let text = read_to_string(file).unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let what = [cells[4], cells[5], cells[6], cells[8]].join(",");
        (cells[1].parse().unwrap(), what)
    };
    text.lines().skip(1).map(row).collect()
}

/// Onset and width of every stimulus, by channel.
fn stimuli(file: &Path) -> BTreeMap<u64, Vec<(i64, i64)>> {
    let mut by_channel: BTreeMap<u64, Vec<(i64, i64)>> = BTreeMap::new();
    for line in read_to_string(file).unwrap().lines().skip(1) {
        let entry: Value = serde_json::from_str(line).unwrap();
        let number = |key: &str| entry[key].as_i64();
        if let (Some(on), Some(off), Some(at)) = (number("on"), number("off"), number("t_us"))
            && off > on
        {
            let channel = by_channel.entry(entry["channel"].as_u64().unwrap());
            channel.or_default().push((at, off - on));
        }
    }
    by_channel
}

#[test]
fn the_loop_through_device_nodes_is_the_loop_in_one_process() {
    if !in_lab("the loop through vcan and an I2C node") {
        return;
    }
    let hil = hil().display();
    let scene = scene("loop.toml");
    let [inside_csv, outside_csv] = ["in.csv", "out.csv"].map(scratch);
    let [inside_plan, outside_plan] = ["in.jsonl", "out.jsonl"].map(scratch);
    sh(&format!(
        "{hil} run {scene} --quiet --set bench.wire.kind=final-75um --set bench.drive.current_ma=990 --record {} --schedule {}",
        inside_csv.display(),
        inside_plan.display()
    ));
    let ward = Ward::open(&scene, &[]);
    let summary = sh(&format!(
        "{hil} run {scene} --bench {} --json --record {} --schedule {}",
        ward.bench().display(),
        outside_csv.display(),
        outside_plan.display()
    ));
    let record = ward.emulator.stop();
    let summary: Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["source"], "real");

    let (inside, outside) = (contacts(&inside_csv), contacts(&outside_csv));
    let found: BTreeSet<&String> = outside.iter().map(|c| &c.1).collect();
    let same = inside.iter().filter(|c| found.contains(&c.1)).count();
    let share = |part: usize, of: usize| part as f64 / of.max(1) as f64;
    println!(
        "contacts: {} in one process, {same} of them the same among {} through the nodes",
        inside.len(),
        outside.len()
    );

    // Times of one run on the other's scale: contacts that both have.
    let times: BTreeMap<&String, i64> = inside.iter().map(|c| (&c.1, c.0)).collect();
    let mut shifts: Vec<i64> = outside
        .iter()
        .filter_map(|c| Some(c.0 - times.get(&c.1)?))
        .collect();
    shifts.sort_unstable();
    assert!(!shifts.is_empty(), "not one contact is the same");
    let shift = shifts[shifts.len() / 2];

    let (wanted, found) = (stimuli(&inside_plan), stimuli(&outside_plan));
    let (mut near, mut all) = (0, 0);
    for (channel, found) in &found {
        for (at, width) in found {
            let neighbours = wanted.get(channel).into_iter().flatten();
            let best = neighbours
                .filter(|w| (w.0 + shift - at).abs() <= 60_000)
                .map(|w| (w.1 - width).abs())
                .min();
            all += 1;
            near += usize::from(best.is_some_and(|ticks| ticks <= TICKS));
        }
    }
    let total: usize = wanted.values().map(Vec::len).sum();
    println!(
        "stimuli: {total} in one process, {all} through the nodes, {near} of them within {TICKS} ticks"
    );
    println!("emulated: {record}");

    assert!(share(same, inside.len()) >= SAME_CONTACTS);
    assert!(share(near, all) >= SAME_STIMULI);
    assert!((0.8..=1.2).contains(&share(all, total)));
    // Each stimulus became pulses, none of them longer than what was asked for, and all of it ended.
    let pulses = |w: &Value| w["pulses"].as_u64().unwrap();
    let wires = record["wires"].as_array().unwrap();
    assert!(wires.iter().map(pulses).sum::<u64>() as usize > all);
    let longest = wires.iter().map(|w| w["longest_us"].as_f64().unwrap());
    assert!(longest.fold(0.0, f64::max) <= 125.0, "{record}");
    assert_eq!(record["driving"], Value::Array(Vec::new()));
}
