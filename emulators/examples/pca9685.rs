//! An emulated PCA9685 under the published `pwm-pca9685` driver: what its outputs do, edge by edge.
//!
//! `cargo run -p palpate-emulators --example pca9685`
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use palpate_emulators::display::i2c::{BusClock, I2cHandle, I2cSegment};
use palpate_emulators::display::pca9685::{Config, Pca9685, Pin};
use palpate_emulators::time::Nanos;
use pwm_pca9685::{Address, Channel, Pca9685 as Driver};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let chip = Pca9685::new(Config::new(0x40));
    let bus = I2cHandle::new(I2cSegment::new(BusClock::Fast, vec![chip]));

    // As on a board, with the driver as published: a servo's pulse of 1 ms and a lamp at half, 50 Hz.
    let failed = |error| format!("{error:?}");
    let mut driver = Driver::new(bus.clone(), Address::default()).map_err(failed)?;
    driver.set_prescale(121).map_err(failed)?;
    driver.enable().map_err(failed)?;
    driver
        .set_channel_on_off(Channel::C0, 0, 205)
        .map_err(failed)?;
    driver
        .set_channel_on_off(Channel::C1, 1024, 3072)
        .map_err(failed)?;
    println!(
        "the driver's bytes are through at {} us",
        now(&bus)?.as_micros()
    );

    show(&bus, Nanos::from_micros(45_000))?;

    // The data sheet wants a restart after this, and the caller has to know: outputs end their cycle and stay dark.
    driver.set_prescale(60).map_err(failed)?;
    println!("another prescale at {} us", now(&bus)?.as_micros());
    show(&bus, Nanos::from_micros(90_000))?;
    driver.restart(&mut bus.clone()).map_err(failed)?;
    println!("a restart until {} us", now(&bus)?.as_micros());
    show(&bus, Nanos::from_micros(115_000))
}

fn now(bus: &I2cHandle) -> Result<Nanos, Box<dyn std::error::Error>> {
    Ok(bus.with(|segment| segment.now())?)
}

/// Lets virtual time pass until `to` and prints every edge on the way.
fn show(bus: &I2cHandle, to: Nanos) -> Result<(), Box<dyn std::error::Error>> {
    bus.with(|segment| {
        segment.advance(to, &mut |_, edge| {
            let level = if edge.pin == Pin::High { "high" } else { "low" };
            println!(
                "{:8} us  output {} {level}",
                edge.at.as_micros(),
                edge.channel.0
            );
        });
    })?;
    Ok(())
}
