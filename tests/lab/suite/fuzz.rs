//! A client that fuzzes the served node itself, through the kernel: ioctls with every kind of argument.

use serde_json::Value;

use super::emulator::Emulator;
use super::tools::{in_lab, python, sh};

#[test]
fn random_ioctls_leave_node_and_emulator_in_order() {
    if !in_lab("ioctl fuzzing") {
        return;
    }
    let mut emulator = Emulator::start(&[]);
    let n = emulator.number().to_owned();
    let said = python("fuzz_client.py", &format!("{n} 400"));
    println!("fuzzing client: {}", said.trim());
    assert!(emulator.is_alive());
    // Software reset: from wherever the client left the chip, to the data sheet's defaults.
    sh(&format!("i2ctransfer -a -y {n} w1@0x00 0x06"));
    let dump = sh(&format!(
        "i2ctransfer -y {n} w1@0x40 0xfe r1; i2ctransfer -y {n} w1@0x40 0x00 r1"
    ));
    assert_eq!(
        dump.split_whitespace().collect::<Vec<_>>(),
        ["0x1e", "0x11"]
    );
    let record: Value = emulator.stop();
    assert!(record["transfers"].as_u64().unwrap() > 100, "{record}");
}
