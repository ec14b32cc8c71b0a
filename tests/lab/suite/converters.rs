//! A real bench whose currents are set, over an I2C node: what is left in its converters when a run dies.

use std::time::Duration;

use super::tools::{in_lab, scene, sh};
use super::ward::Ward;

/// What a bench with a converter says of it.
const DAC: &str = "\n[dac]\naddresses = [0x48]\ngain_tolerance = 0.01\noffset_tolerance_ma = 5.0\n";

/// Codes of a converter, as another program on the bus reads them.
fn codes(node: &str) -> Vec<String> {
    let read = |channel: u8| {
        sh(&format!(
            "i2ctransfer -f -y {node} w1@0x48 {:#x} r2",
            0x10 | channel
        ))
    };
    (0..8)
        .map(|channel| read(channel).trim().to_owned())
        .collect()
}

#[test]
fn a_run_that_is_killed_leaves_no_output_on_and_no_current_set() {
    if !in_lab("a bench with [dac] on an I2C node") {
        return;
    }
    let press = scene("press.toml");
    let mut ward = Ward::open(&press, &["--bench", "set-current"]);
    let text = std::fs::read_to_string(ward.bench()).unwrap();
    let text = text.replace("current_ma = 990.0", "current_ma = 1970.0");
    std::fs::write(ward.bench(), text + DAC).unwrap();
    let mut run = ward.run(&press, &[]);
    let node = ward.emulator.number().to_owned();
    let set = codes(&node);
    assert!(set.iter().any(|code| code != "0x00 0x00"), "{set:?}");
    run.child.kill().unwrap();
    run.child.wait().unwrap();
    ward.wait_for_outputs(false).unwrap();
    // Outputs are off; the converters follow.
    ward.emulator.hear(Duration::from_millis(200));
    let left = codes(&node);
    assert!(left.iter().all(|code| code == "0x00 0x00"), "{left:?}");
    assert!(
        ward.latch().read().is_some(),
        "a run that was killed is a stop"
    );
    ward.unlatch();
    ward.emulator.stop();
}
