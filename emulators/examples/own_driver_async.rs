//! An async driver of one's own on an emulated PCA9685: no executor, and its waits take no time.
//!
//! `cargo run -p palpate-emulators --example own_driver_async`
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use std::error::Error;

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;
use palpate_emulators::display::i2c::{BusClock, I2cHandle, I2cSegment, immediate};
use palpate_emulators::display::pca9685::{Config, Pca9685, Pin};
use palpate_emulators::time::Nanos;

/// The driver under test: a lamp on output 0 that fades in.
struct Lamp<I, D> {
    i2c: I,
    delay: D,
}

impl<I: I2c, D: DelayNs> Lamp<I, D> {
    async fn start(&mut self) -> Result<(), I::Error> {
        self.i2c.write(0x40, &[0x00, 0x21]).await?; // MODE1: awake, auto-increment
        self.delay.delay_us(500).await; // the oscillator starts
        Ok(())
    }

    async fn fade_in(&mut self) -> Result<(), I::Error> {
        for step in 1..=4_u16 {
            let [low, high] = (step * 1000).to_le_bytes();
            self.i2c.write(0x40, &[0x06, 0, 0, low, high]).await?;
            self.delay.delay_ms(15).await;
        }
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let chip = Pca9685::new(Config::new(0x40));
    let bus = I2cHandle::new(I2cSegment::new(BusClock::Fast, vec![chip]));
    let played = immediate(play(bus.clone()));
    played.ok_or("the driver waits for something other than bus and delay")??;

    let mut rise = Nanos::ZERO;
    bus.with(|segment| {
        segment.advance(segment.now(), &mut |_chip, edge| {
            if edge.pin == Pin::High {
                rise = edge.at;
            } else {
                let us = edge.at.since(rise).as_micros();
                println!("{:>6} us  a pulse of {us} us", rise.as_micros());
            }
        });
    })?;
    Ok(())
}

/// The test's own future: bus and delay are the same handle.
async fn play(bus: I2cHandle) -> Result<(), Box<dyn Error>> {
    let mut lamp = Lamp {
        i2c: bus.clone(),
        delay: bus,
    };
    lamp.start().await?;
    lamp.fade_in().await?;
    Ok(())
}
