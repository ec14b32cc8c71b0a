//! can-utils and python-can, unchanged, on the interface that `hil emulate` serves.

use std::collections::BTreeSet;

use palpate_core::codec::uskin::{ChipPlace, Message, Reading, decode, encode};
use palpate_core::units::Instant;
use palpate_records::candump::{Logged, read, write_line};

use super::emulator::Emulator;
use super::tools::{here, in_lab, python, scratch, sh, text, try_sh, vcan};

/// What candump hears in a while, in its own log format.
fn heard(interface: &str, seconds: f64) -> Vec<Logged> {
    let log = sh(&format!("timeout {seconds} candump -L {interface} || true"));
    read(&log).unwrap().frames
}

/// The taxels of board 4, which the default scene's layout has.
fn senders(frames: &[Logged]) -> BTreeSet<(u8, u8, u8)> {
    let sender = |logged: &Logged| match decode(&logged.frame) {
        Ok(Message::Data(data)) => Some((data.board, data.place.sda, data.place.chip)),
        _ => None,
    };
    frames.iter().filter_map(sender).collect()
}

#[test]
fn candump_hears_every_taxel_and_cansend_stops_and_starts_the_boards() {
    if !in_lab("candump and cansend") {
        return;
    }
    let emulator = Emulator::start(&[]);
    let frames = heard("vcan0", 2.0);
    assert_eq!(senders(&frames).len(), 16, "{frames:?}");
    assert!(frames.iter().all(|f| f.frame.data().len() == 8));
    sh("cansend vcan0 20f#0701; sleep 0.5");
    assert!(heard("vcan0", 1.0).is_empty());
    sh("cansend vcan0 20f#0700");
    assert_eq!(senders(&heard("vcan0", 2.0)).len(), 16);
    let record = emulator.stop();
    assert_eq!(record["can"][0]["received"], 2, "{record}");
    assert_eq!(record["can"][0]["lost"], 0, "{record}");
}

#[test]
fn a_scene_begins_with_the_start_command_when_it_is_awaited() {
    if !in_lab("--await-start") {
        return;
    }
    let mut emulator = Emulator::start(&["--await-start"]);
    assert!(heard("vcan0", 1.0).is_empty());
    // Twice from its beginning: the same readings, taxel by taxel.
    let mut scans = Vec::new();
    for _ in 0..2 {
        let log = sh("(sleep 1; cansend vcan0 20f#0700) & exec timeout 60 candump -n 65 -L vcan0");
        let frames = read(&log).unwrap().frames;
        sh("cansend vcan0 20f#0701; sleep 0.5");
        emulator.wait_for("started");
        scans.push(frames[1..].iter().map(|f| f.frame).collect::<Vec<_>>());
    }
    assert_eq!(scans[0].len(), 64);
    assert_eq!(scans[0], scans[1]);
    emulator.stop();
}

#[test]
fn canplayer_replays_a_log_that_we_wrote() {
    if !in_lab("canplayer") {
        return;
    }
    vcan("vcan1");
    let mut log = String::new();
    let mut frames = Vec::new();
    for n in 0..160_u16 {
        let place = ChipPlace {
            sda: (n % 4) as u8,
            chip: (n / 4 % 4) as u8,
        };
        let reading = Reading {
            x: 49_202 + n,
            y: 16_318,
            z: 40_000 - n,
        };
        let frame = encode(4, place, reading).unwrap();
        write_line(
            &mut log,
            Instant::from_micros(u64::from(n) * 625),
            "vcan1",
            &frame,
        );
        frames.push(frame);
    }
    let file = scratch("ours.log");
    std::fs::write(&file, &log).unwrap();
    let back = sh(&format!(
        "(sleep 1; canplayer -I {}) & exec timeout 60 candump -n 160 -L vcan1",
        file.display()
    ));
    let back: Vec<_> = read(&back)
        .unwrap()
        .frames
        .iter()
        .map(|f| f.frame)
        .collect();
    assert_eq!(back, frames);
}

#[test]
fn cangen_floods_the_bus_and_the_boards_speak_on_afterwards() {
    if !in_lab("cangen") {
        return;
    }
    let mut emulator = Emulator::start(&[]);
    // Every kind of frame that cangen knows for classic CAN, as fast as it can, and then one identifier
    // that wins every arbitration.
    let flood =
        try_sh("timeout 3 cangen vcan0 -g 0 -i -m -R; timeout 2 cangen vcan0 -g 0 -i -I 000 -L 8");
    assert!(text(&flood.stderr).is_empty(), "{}", text(&flood.stderr));
    assert!(emulator.is_alive());
    sh("sleep 2"); // what waits for the emulated wire goes first
    // A random frame may have been a stop command.
    sh("cansend vcan0 20f#0700");
    assert_eq!(senders(&heard("vcan0", 3.0)).len(), 16);
    let record = emulator.stop();
    let can = &record["can"][0];
    println!("flood: {can}");
    assert!(can["received"].as_u64().unwrap() > 1000, "{record}");
    assert!(can["foreign"].as_u64().unwrap() > 100, "{record}");
}

#[test]
fn python_can_with_cantools_reads_our_dbc() {
    if !in_lab("python-can with cantools") {
        return;
    }
    let emulator = Emulator::start(&[]);
    let dbc = here().join("../../fixtures/dbc/uskin.dbc");
    let said = python("dbc_client.py", &format!("vcan0 {}", dbc.display()));
    assert_eq!(said.trim(), "ok");
    emulator.stop();
}

#[test]
fn four_buses_at_once() {
    if !in_lab("four interfaces") {
        return;
    }
    for n in 0..4 {
        vcan(&format!("vcan{n}"));
    }
    let emulator = Emulator::start(&["--scene", "allegro-four-buses"]);
    for n in 0..4 {
        let boards = |(board, _, _): (u8, u8, u8)| board;
        let senders = senders(&heard(&format!("vcan{n}"), 4.0));
        let boards: BTreeSet<u8> = senders.into_iter().map(boards).collect();
        assert!(boards.len() >= 3, "vcan{n}: {boards:?}");
    }
    emulator.stop();
}
