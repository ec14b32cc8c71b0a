//! The Peltier module of this board: a MAX8521 gives its current, and two thermistors tell its temperatures.
//!
//! The MAX8521 is an H-bridge of two switching regulators. Its CTLI pin sets the current: (V - 1.5 V)/(10 R_SENSE). PWM behind a
//! low pass makes that voltage. SHDN, low, ends all current; a resistor to ground holds it low while the processor resets.
//! Resistors at its MAXIP and MAXIN pins limit the current to 1 A in hardware.

use core::convert::Infallible;

use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use palpate_core::driver::Actuators;
use palpate_core::peltier::{GuardedCurrent, Reading};
use palpate_core::units::Instant;
use palpate_unit::Module;
use rp2040_hal::Adc;
use rp2040_hal::adc::AdcChannel;

/// Steps of the PWM: 30.5 kHz at 125 MHz.
pub const STEPS: u16 = 4096;
/// Voltage at CTLI with all steps, mV.
const SUPPLY_MV: i32 = 3300;
/// Steps that give 1500 mV at CTLI, which means no current.
const NOTHING: i32 = (1500 * STEPS as i32 + SUPPLY_MV / 2) / SUPPLY_MV;
/// R_SENSE, milliohms.
const SENSE_MOHM: i32 = 50;
/// Change of the current over all steps, mA.
const ALL_MA: i32 = SUPPLY_MV * 1000 / (10 * SENSE_MOHM);
/// Conversions per reading: the converter's noise is above a step of it.
const CONVERSIONS: u16 = 8;

/// Steps of the PWM for a current, mA; rounded towards no current.
fn steps(milliamps: i32) -> u16 {
    let steps = NOTHING + milliamps * i32::from(STEPS) / ALL_MA;
    steps.clamp(0, i32::from(STEPS)) as u16
}

/// The bridge and the thermistors.
pub struct Bridge<C, S, F, K> {
    /// CTLI.
    pub control: C,
    /// SHDN.
    pub shutdown: S,
    /// The converter, and the pins of face and sink.
    pub thermistors: (Adc, F, K),
}

impl<C: SetDutyCycle, S: OutputPin, F, K> Actuators<GuardedCurrent> for Bridge<C, S, F, K> {
    type Error = Infallible;

    fn apply(&mut self, update: &GuardedCurrent) -> Result<(), Infallible> {
        // Pins of the processor itself do not fail.
        let _ = self.control.set_duty_cycle(steps(update.milliamps()));
        let _ = match update.milliamps() {
            0 => self.shutdown.set_low(),
            _ => self.shutdown.set_high(),
        };
        Ok(())
    }

    fn all_off(&mut self) -> Result<(), Infallible> {
        let _ = self.shutdown.set_low();
        let _ = self.control.set_duty_cycle(steps(0));
        Ok(())
    }
}

impl<C: SetDutyCycle, S: OutputPin, F: AdcChannel, K: AdcChannel> Module for Bridge<C, S, F, K> {
    fn reading(&mut self, now: Instant) -> Reading {
        let (converter, face, sink) = &mut self.thermistors;
        let (mut codes, mut failed) = ([0; 2], false);
        for _ in 0..CONVERSIONS {
            let read = [converter.read(face), converter.read(sink)];
            failed |= read.iter().any(Result::is_err);
            for (sum, code) in codes.iter_mut().zip(read) {
                *sum += code.unwrap_or_default();
            }
        }
        let [face, sink] = codes.map(|sum| sum / CONVERSIONS);
        // A conversion that failed is none: as old as the start.
        let at = if failed { Instant::ZERO } else { now };
        Reading { at, face, sink }
    }
}
