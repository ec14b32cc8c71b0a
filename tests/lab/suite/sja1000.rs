//! Two SJA1000 controllers on one cable, with the kernel's own driver: a real bit rate, both directions,
//! and an interface that goes away and comes back under `hil emulate`.
//!
//! The controller model never sees a bus error, so its driver never reports bus-off.

use std::collections::BTreeSet;

use palpate_core::codec::uskin::{Message, decode};
use palpate_records::candump::read;

use super::emulator::Emulator;
use super::tools::{in_lab, sh, try_sh};

const BITRATE: u32 = 1_000_000;

/// Both controllers up at the boards' bit rate; `false` on a machine that has none.
fn controllers(test: &str) -> bool {
    if !in_lab(test) {
        return false;
    }
    if !try_sh("ip link show can1").status.success() {
        println!("SKIPPED {test}: no can0 and can1; the virtual machine of ci/lab has them");
        return false;
    }
    for name in ["can0", "can1"] {
        sh(&format!(
            "ip link set {name} down; ip link set {name} type can bitrate {BITRATE} && ip link set {name} up"
        ));
    }
    true
}

fn boards_heard_on(interface: &str) -> BTreeSet<(u8, u8)> {
    let log = sh(&format!("timeout 3 candump -L {interface} || true"));
    let frames = read(&log).unwrap().frames;
    let place = |logged: &palpate_records::candump::Logged| match decode(&logged.frame) {
        Ok(Message::Data(data)) => Some((data.place.sda, data.place.chip)),
        _ => None,
    };
    frames.iter().filter_map(place).collect()
}

#[test]
fn controllers_have_a_real_bit_rate_and_hear_each_other() {
    if !controllers("SJA1000") {
        return;
    }
    let about = sh("ip -details link show can0");
    assert!(
        about.contains("bitrate 1000000 sample-point 0.750"),
        "{about}"
    );
    assert!(
        about.contains("sja1000: tseg1") && about.contains("ERROR-ACTIVE"),
        "{about}"
    );
    for (from, to) in [("can0", "can1"), ("can1", "can0")] {
        let heard = sh(&format!(
            "(sleep 1; cansend {from} 104#93C0903EA392530F) & exec timeout 20 candump -n 1 -L {to}"
        ));
        assert!(heard.contains("104#93C0903EA392530F"), "{heard}");
    }
    // A bit rate cannot change under a running controller, and a restart is for bus-off only.
    assert!(
        !try_sh("ip link set can0 type can bitrate 500000")
            .status
            .success()
    );
    assert!(!try_sh("ip link set can0 type can restart").status.success());
}

#[test]
fn boards_on_a_controller_survive_its_going_down_and_up() {
    if !controllers("boards on an SJA1000") {
        return;
    }
    let mut emulator = Emulator::start(&["--can", "can0"]);
    assert_eq!(boards_heard_on("can1").len(), 16);
    sh("ip link set can0 down; sleep 1");
    assert!(emulator.is_alive());
    sh("ip link set can0 up");
    assert_eq!(boards_heard_on("can1").len(), 16);
    sh("cansend can1 20f#0701; sleep 0.5");
    assert!(boards_heard_on("can1").is_empty());
    let record = emulator.stop();
    assert!(record["can"][0]["lost"].as_u64().unwrap() > 0, "{record}");
}
