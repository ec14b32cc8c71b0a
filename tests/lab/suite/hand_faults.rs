//! What two displays of a bench share: a process that can hang, an OE line, a board.

// These tests live in the lab's own time.
#![allow(clippy::disallowed_methods)]

use std::collections::BTreeSet;
use std::os::unix::process::ExitStatusExt;
use std::time::Duration;

use nix::sys::signal::{Signal, kill};
use serde_json::Value;

use super::emulator::{Emulator, at};
use super::hands::{Hand, own_adapters};
use super::tools::{in_lab, scene, scratch};
use super::ward::{LIMIT_NS, TooSlow, now_ns, patiently, stop_thread};

/// Two periods of the chip: a channel that is on has gone high within it.
const PERIODS_NS: u64 = 11_000_000;

/// When outputs of these channels went high.
fn pulses(emulator: &Emulator, channels: std::ops::Range<u64>) -> Vec<u64> {
    let is_pulse = |told: &&Value| {
        let channel = told["channel"].as_u64();
        told["high"] == true && channel.is_some_and(|c| channels.contains(&c))
    };
    emulator.told.iter().filter(is_pulse).map(at).collect()
}

#[test]
fn a_finger_that_hangs_ends_in_everything_off() {
    if !in_lab("two displays, one hung") {
        return;
    }
    patiently(hung);
}

fn hung() -> Result<(), TooSlow> {
    let mut hand = Hand::open();
    let mut run = hand.run();
    hand.ward.emulator.hear(Duration::from_millis(300));
    hand.check_speed()?;
    stop_thread(run.pid(), "loop");
    let ended = run.end();
    hand.check_speed()?;
    assert_eq!(
        ended.signal(),
        Some(Signal::SIGKILL as i32),
        "{}",
        hand.ward.said()
    );
    hand.is_off();
    hand.is_latched("the run hung");
    Ok(())
}

#[test]
fn a_finger_without_its_bus_takes_the_oe_line_until_it_is_known_to_be_off() {
    if !in_lab("two displays, one OE line") {
        return;
    }
    patiently(cut);
}

fn cut() -> Result<(), TooSlow> {
    let press = std::fs::read_to_string(scene("press.toml")).unwrap();
    let fault =
        "\n[[faults]]\nat_s = 4.0\nuntil_s = 5.0\nkind = \"i2c-address-nack\"\nrate = 1.0\n";
    let faulty = scratch("thumb.toml");
    std::fs::write(&faulty, press + fault).unwrap();
    let faulty = faulty.display().to_string();
    let mut hand = Hand::wired(&faulty, &["--oe"], own_adapters);
    let mut run = hand.run();
    let from = at(&hand.thumb.wait_for("fault"));
    let until = at(&hand.thumb.wait_for("fault"));
    hand.ward.emulator.hear(Duration::from_millis(2000));
    hand.thumb.hear(Duration::from_millis(10));
    kill(run.pid(), Signal::SIGINT).unwrap();
    let ended = run.end();
    let said = hand.ward.said();
    hand.check_speed()?;
    assert!(ended.success(), "{ended}: {said}");
    hand.is_off();
    // The index's own bus is whole, and yet it is dark: the line is of both.
    for (name, emulator) in [("index", &hand.ward.emulator), ("thumb", &hand.thumb)] {
        let driven = |within: std::ops::Range<u64>| -> BTreeSet<u64> {
            let is_driven = |c: &u64| {
                pulses(emulator, *c..c + 1)
                    .iter()
                    .any(|t| within.contains(t))
            };
            (0..16).filter(is_driven).collect()
        };
        assert!(
            !driven(from - 500_000_000..from).is_empty(),
            "{name}: before; {said}"
        );
        // The emulated line is a pin of the index's bridge. On the thumb, whose chip has no line, the burst that its bus was
        // lost in stays on, and nothing else may begin.
        let held = match name {
            "thumb" => driven(from - PERIODS_NS..from),
            _ => BTreeSet::new(),
        };
        let meanwhile = driven(from + LIMIT_NS..until);
        assert!(
            meanwhile.is_subset(&held),
            "{name}: {meanwhile:?} meanwhile, {held:?} held; {said}"
        );
        assert!(
            !driven(until..u64::MAX).is_empty(),
            "{name}: afterwards; {said}"
        );
        println!("{name}: {meanwhile:?} on while its bus was lost");
    }
    Ok(())
}

#[test]
fn a_finger_that_is_stopped_leaves_its_neighbour_on_the_same_board_alone() {
    if !in_lab("two displays on one board") {
        return;
    }
    patiently(one_board);
}

fn one_board() -> Result<(), TooSlow> {
    let mut hand = Hand::wired(&scene("press.toml"), &[], |index, _| {
        (vec![index.node.clone()], [(0, 0), (0, 8)])
    });
    hand.slow_down();
    hand.silence_thumb();
    let scene = hand.scene.clone();
    let mut run = hand.ward.run(&scene, &[]);
    hand.ward.emulator.hear(Duration::from_millis(1500));
    // A silence between two bursts stops nothing.
    let mut silenced = 0;
    for n in 0..20 {
        silenced = now_ns();
        hand.silence_thumb();
        hand.ward.emulator.hear(Duration::from_millis(700 + 7 * n));
        if hand.ward.latch().read().is_some() {
            break;
        }
    }
    hand.ward.emulator.hear(Duration::from_millis(800));
    kill(run.pid(), Signal::SIGINT).unwrap();
    let ended = run.end();
    let said = hand.ward.said();
    hand.check_speed()?;
    assert_eq!(ended.code(), Some(4), "{said}");
    assert!(said.contains("display `thumb`: stale-input"), "{said}");
    hand.is_off();
    let late = |pulses: &[u64]| pulses.iter().filter(|t| **t > silenced + LIMIT_NS).count();
    let [index, thumb] = [0..8, 8..16].map(|channels| pulses(&hand.ward.emulator, channels));
    assert!(
        thumb.len() > 20 && late(&thumb) == 0,
        "{} thumb pulses, {} late; {said}",
        thumb.len(),
        late(&thumb)
    );
    assert!(
        late(&index) > 20,
        "{} index pulses afterwards; {said}",
        late(&index)
    );
    hand.is_latched("thumb: stale-input");
    Ok(())
}
