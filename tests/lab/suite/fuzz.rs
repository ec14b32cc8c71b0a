//! A client that fuzzes the served node itself, through the kernel: ioctls with every kind of argument. How many,
//! `PALPATE_FUZZ` says.

use embedded_hal::i2c::I2c;
use linux_embedded_hal::I2cdev;
use palpate_core::codec::pca9685::PRE_SCALE;
use serde_json::Value;

use super::emulator::Emulator;
use super::tools::{in_lab, number_of, python, sh};

/// A register's bits that no write can set, and reading shows as zero: NXP, PCA9685 rev. 4, tables 4 to 9.
const fn reserved(register: u8) -> u8 {
    match register {
        0x01 => 0xE0,                             // MODE2
        0x02..=0x05 => 0x01,                      // subaddresses, all-call
        0x06..=0x45 if register % 2 == 1 => 0xE0, // LEDn_ON_H, LEDn_OFF_H
        0xFA..=0xFD => 0xFF,                      // write-only
        _ => 0,
    }
}

#[test]
fn random_ioctls_leave_node_and_emulator_in_order() {
    if !in_lab("ioctl fuzzing") {
        return;
    }
    let mut emulator = Emulator::start(&[]);
    let n = emulator.number().to_owned();
    let count = number_of("PALPATE_FUZZ", 2000);
    let said = python("fuzz_client.py", &format!("{n} {count}"));
    println!("fuzzing client: {}", said.trim());
    assert!(emulator.is_alive());
    // No state that the chip cannot be in.
    let mut chip = I2cdev::new(&emulator.node).unwrap();
    let mut held = [0; 256];
    for register in 0..=255 {
        let value = &mut held[usize::from(register)..][..1];
        let answer = chip.write_read(0x40_u8, &[register], value);
        let absent = (0x46..=0xF9).contains(&register); // not acknowledged
        assert_eq!(answer.is_err(), absent, "register {register:#x}");
        assert_eq!(
            held[usize::from(register)] & reserved(register),
            0,
            "register {register:#x}"
        );
    }
    drop(chip);
    assert!(held[usize::from(PRE_SCALE)] >= 3, "{held:?}");
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
