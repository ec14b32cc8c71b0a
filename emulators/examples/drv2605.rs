//! Eight resonant actuators behind a multiplexer: each is calibrated, driven for 100 ms and braked.
//!
//! `cargo run -p palpate-emulators --example drv2605`
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use std::error::Error;

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::I2c;
use palpate_emulators::display::i2c::{BusClock, I2cHandle, I2cSegment};
use palpate_emulators::haptic::Motor;
use palpate_emulators::haptic::drv2605::Drv2605;
use palpate_emulators::haptic::lra::{Lra, LraParameters};
use palpate_emulators::haptic::tca9548a::Tca9548a;

const MUX: u8 = 0x70;
const CHIP: u8 = 0x5A;

/// The driver under test: actuators of 2 Vrms and 175 Hz.
struct Actuators<I>(I);

impl<I: I2c + DelayNs> Actuators<I> {
    /// Calibrates an actuator; returns whether its chip found it.
    fn start(&mut self, channel: u8) -> Result<bool, I::Error> {
        self.0.write(MUX, &[1 << channel])?;
        for [register, value] in [
            [0x01, 0x07], // MODE: calibration
            [0x16, 0x53], // RATED_VOLTAGE
            [0x17, 0x8C], // OD_CLAMP
            [0x1A, 0xB6], // FEEDBACK: a resonant actuator
            [0x1B, 0x98], // CONTROL1: half waves of 2.9 ms
            [0x0C, 0x01], // GO
        ] {
            self.0.write(CHIP, &[register, value])?;
        }
        let mut byte = [1];
        while byte[0] & 1 != 0 {
            self.0.delay_ms(10);
            self.0.write_read(CHIP, &[0x0C], &mut byte)?;
        }
        self.0.write_read(CHIP, &[0x00], &mut byte)?;
        self.0.write(CHIP, &[0x01, 0x05])?; // MODE: real-time playback
        Ok(byte[0] & 0x08 == 0)
    }

    /// Drives an actuator, 0 to 127 of its rated amplitude.
    fn set(&mut self, channel: u8, level: u8) -> Result<(), I::Error> {
        self.0.write(MUX, &[1 << channel])?;
        self.0.write(CHIP, &[0x02, level])
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let coin = || Drv2605::new(Motor::Lra(Lra::new(LraParameters::COIN_10MM)));
    let mux = (0..8).fold(Tca9548a::new(MUX), |mux, channel| mux.with(channel, coin()));
    let segment = I2cSegment::new(BusClock::Fast, Vec::new());
    let mut bus = I2cHandle::new(segment.with_haptics(vec![mux], Vec::new()));
    bus.delay_ms(1);
    let mut actuators = Actuators(bus.clone());

    for channel in 0..8 {
        assert!(actuators.start(channel)?, "no actuator at {channel}");
        actuators.set(channel, 16 * channel + 15)?;
        bus.delay_ms(100);
        let um = |bus: &I2cHandle| {
            bus.with(|segment| {
                segment.advance(segment.now(), &mut |_, _| ());
                let mut chips = segment.muxes_mut()[0].chips();
                let chip = chips.nth(usize::from(channel));
                chip.map_or(0.0, |(_, chip)| chip.motor().amplitude_m() * 1e6)
            })
        };
        let driven = um(&bus)?;
        actuators.set(channel, 0)?;
        bus.delay_ms(40);
        let braked = um(&bus)?;
        println!(
            "actuator {channel}: {driven:>4.0} um after 100 ms, {braked:>4.0} um 40 ms after its end"
        );
        assert!(braked <= 0.1 * driven);
    }
    Ok(())
}
