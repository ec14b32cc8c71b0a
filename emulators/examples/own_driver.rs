//! A driver of one's own on an emulated PCA9685: the pulses on the pin say whether the driver is right.
//!
//! `cargo run -p palpate-emulators --example own_driver`
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use std::error::Error;

use embedded_hal::i2c::I2c;
use palpate_emulators::display::i2c::{BusClock, I2cHandle, I2cSegment};
use palpate_emulators::display::pca9685::{Config, Pca9685, Pin};
use palpate_emulators::time::Nanos;

/// The driver under test: servos at 50 Hz.
struct Servos<I>(I);

impl<I: I2c> Servos<I> {
    fn start(&mut self) -> Result<(), I::Error> {
        self.0.write(0x40, &[0x00, 0x31])?; // MODE1: asleep, auto-increment
        self.0.write(0x40, &[0xFE, 121])?; // PRE_SCALE: 25 MHz / 4096 / 122
        self.0.write(0x40, &[0x00, 0x21]) // MODE1: awake
    }

    /// Gives output `n` pulses of `us` microseconds.
    fn pulse(&mut self, n: u8, us: u32) -> Result<(), I::Error> {
        let [low, high, ..] = (us * 25 / 122).to_le_bytes();
        self.0.write(0x40, &[0x06 + 4 * n, 0, 0, low, high])
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let chip = Pca9685::new(Config::new(0x40));
    let bus = I2cHandle::new(I2cSegment::new(BusClock::Fast, vec![chip]));
    let mut servos = Servos(bus.clone());
    servos.start()?;
    servos.pulse(3, 1500)?;

    // Virtual time passes until 100 ms, and hands over every edge on the way.
    let mut edges = Vec::new();
    bus.with(|segment| {
        segment.advance(Nanos::from_micros(100_000), &mut |_chip, edge| {
            edges.push(edge);
        });
    })?;

    for pulse in edges.chunks_exact(2) {
        let (rise, fall) = (pulse[0], pulse[1]);
        assert_eq!(
            (rise.channel.0, rise.pin, fall.pin),
            (3, Pin::High, Pin::Low)
        );
        let us = fall.at.since(rise.at).as_micros();
        assert!((1490..=1510).contains(&us), "{us} us");
        println!("{:>6} us  a pulse of {us} us", rise.at.as_micros());
    }
    Ok(())
}
