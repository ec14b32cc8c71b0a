//! Programs and libraries for I2C, unchanged, on the served node.

use linux_embedded_hal::I2cdev;
use palpate_core::codec::pca9685::{LED0_ON_L, MODE1, PRE_SCALE};
use pwm_pca9685::{Address, Channel, Pca9685};
use serde_json::Value;

use super::emulator::{Emulator, at};
use super::tools::{in_lab, python, sh, try_sh};

/// A bench's wire in a record.
fn wire(record: &Value, n: usize) -> (u64, f64) {
    let wire = &record["wires"][n];
    (
        wire["pulses"].as_u64().unwrap(),
        wire["longest_us"].as_f64().unwrap(),
    )
}

#[test]
fn i2c_tools_detect_read_set_and_dump() {
    if !in_lab("i2c-tools") {
        return;
    }
    let emulator = Emulator::start(&[]);
    let n = emulator.number();
    let listed = sh("i2cdetect -l");
    assert!(
        listed.contains(&format!("i2c-{n}")) && listed.contains("MCP2221"),
        "{listed}"
    );

    // The chip and its all-call address alone.
    let grid = sh(&format!("i2cdetect -y {n}"));
    let cells = grid.lines().skip(1).flat_map(|l| l[3..].split_whitespace());
    let found: Vec<&str> = cells.filter(|c| *c != "--").collect();
    assert_eq!(found, ["40", "70"], "{grid}");

    assert_eq!(
        sh(&format!("i2cget -y {n} 0x40 {PRE_SCALE:#x}")).trim(),
        "0x1e"
    );
    sh(&format!("i2cset -y {n} 0x40 {MODE1} 0x21"));
    assert_eq!(sh(&format!("i2cget -y {n} 0x40 {MODE1}")).trim(), "0x21");
    // A word, a block with a length of its own, and a combined transfer.
    sh(&format!("i2cset -y {n} 0x40 {LED0_ON_L} 0x0123 w"));
    assert_eq!(
        sh(&format!("i2cget -y {n} 0x40 {LED0_ON_L} w")).trim(),
        "0x0123"
    );
    sh(&format!("i2cset -y {n} 0x40 {LED0_ON_L} 0 0 100 0 i"));
    let read = sh(&format!("i2ctransfer -y {n} w1@0x40 {LED0_ON_L} r4"));
    assert_eq!(read.trim(), "0x00 0x00 0x64 0x00");
    // No chip there: an error, and the bus lives on.
    assert!(!try_sh(&format!("i2cget -y {n} 0x41 0")).status.success());

    let dump = sh(&format!("i2cdump -y {n} 0x40 b"));
    let row = |start: &str| {
        dump.lines()
            .find(|l| l.starts_with(start))
            .unwrap()
            .to_owned()
    };
    assert!(
        row("00:").starts_with("00: 21 04 e2 e4 e8 e0 00 00 64 00"),
        "{dump}"
    );
    assert!(row("f0:").contains("1e"), "{dump}");
    let record = emulator.stop();
    assert!(wire(&record, 0).0 > 0, "{record}");
}

#[test]
fn python_smbus2() {
    if !in_lab("smbus2") {
        return;
    }
    let emulator = Emulator::start(&[]);
    let said = python("smbus2_client.py", emulator.number());
    assert_eq!(said.trim(), "ok");
    emulator.stop();
}

#[test]
fn adafruit_circuitpython_pca9685_over_an_extended_bus() {
    if !in_lab("Adafruit CircuitPython PCA9685") {
        return;
    }
    let emulator = Emulator::start(&[]);
    let said = python("adafruit_client.py", emulator.number());
    assert_eq!(said.trim(), "ok");
    let record = emulator.stop();
    // 2.44 % of a period at PRE_SCALE 30: 100 ticks of 1.24 us.
    let (pulses, longest) = wire(&record, 3);
    assert!(pulses > 10, "{record}");
    assert!((longest - 124.0).abs() < 1.3, "{record}");
    assert_eq!(record["driving"], Value::Array(Vec::new()), "{record}");
}

#[test]
fn rust_pwm_pca9685_over_linux_embedded_hal() {
    if !in_lab("pwm-pca9685 over linux-embedded-hal") {
        return;
    }
    let emulator = Emulator::start(&[]);
    let bus = I2cdev::new(&emulator.node).unwrap();
    let mut pwm = Pca9685::new(bus, Address::default()).unwrap();
    pwm.set_prescale(30).unwrap();
    pwm.enable().unwrap();
    pwm.set_channel_on_off(Channel::C2, 0, 100).unwrap();
    sh("sleep 0.5");
    pwm.set_channel_full_off(Channel::C2).unwrap();
    drop(pwm); // the kernel keeps an adapter until its last client has closed the node
    let record = emulator.stop();
    let (pulses, longest) = wire(&record, 2);
    assert!(pulses > 10, "{record}");
    assert!((longest - 124.0).abs() < 0.1, "{record}");
}

#[test]
fn all_off_is_told_with_its_time() {
    if !in_lab("all-off events") {
        return;
    }
    let mut emulator = Emulator::start(&[]);
    let n = emulator.number().to_owned();
    sh(&format!("i2cset -y {n} 0x40 {MODE1} 0x21"));
    sh(&format!("i2cset -y {n} 0x40 {LED0_ON_L} 0 0 100 0 i"));
    let driving = emulator.wait_for("driving");
    sh(&format!("i2cset -y {n} 0x70 0xfd 0x10"));
    let off = emulator.wait_for("all_off");
    assert!(at(&off) > at(&driving), "{driving} {off}");
    let later = emulator.stop();
    assert_eq!(later["driving"], Value::Array(Vec::new()), "{later}");
}
