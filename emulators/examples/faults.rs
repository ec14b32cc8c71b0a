//! A driver of one's own on a bus that fails when it is told to: does it try again, and is the output right afterwards?
//!
//! `cargo run -p palpate-emulators --example faults`
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use embedded_hal::i2c::I2c;
use palpate_emulators::display::i2c::fault::{I2cFault, I2cFaultKind, I2cFaults, Shared};
use palpate_emulators::display::i2c::{BusClock, I2cHandle, I2cSegment};
use palpate_emulators::display::pca9685::{Config, Pca9685};

/// The driver under test: output 0 on for so many ticks of 4096, tried three times.
fn set<I: I2c>(bus: &mut I, ticks: u16) -> Result<u32, I::Error> {
    let [low, high] = ticks.to_le_bytes();
    let mut failed = 0;
    loop {
        match bus.write(0x40, &[0x06, 0, 0, low, high]) {
            Ok(()) => return Ok(failed),
            Err(error) if failed == 2 => return Err(error),
            Err(_) => failed += 1,
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let chip = Pca9685::new(Config::new(0x40));
    let bus = I2cHandle::new(I2cSegment::new(BusClock::Fast, vec![chip]));
    let mut faulty = Shared::new(I2cFault::new(bus.clone(), I2cFaults::default(), 1, "bus"));
    faulty.clone().write(0x40, &[0x00, 0x21])?; // awake, with auto-increment

    for (kind, ticks) in I2cFaultKind::ALL.into_iter().zip((1..).map(|n| 256 * n)) {
        faulty.with(|layer| layer.strike(kind));
        let outcome = match set(&mut faulty, ticks) {
            Ok(failed) => format!("done, {failed} failed"),
            Err(error) => format!("given up: {error}"),
        };
        faulty.with(I2cFault::free);
        let chip = |segment: &mut I2cSegment| {
            let chip = segment.chips().first();
            chip.map(|chip| u16::from_le_bytes([chip.register(0x08), chip.register(0x09)]))
        };
        let held = bus.with(chip)?.ok_or("no chip")?;
        println!("{kind:?}: {outcome}; the chip holds {held} of {ticks} ticks");
    }
    Ok(())
}
