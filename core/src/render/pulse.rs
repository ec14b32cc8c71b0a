//! Single pulses of a texture, as wide as the response needs for the amplitude that is to be felt.

use crate::guard::Guard;
use crate::units::{Instant, Ticks};

use super::{Renderer, Stated, Volley, bearable};

/// Fewest pulses a second by which a texture's energy is shared out: a rarer pulse is felt alone.
const RAREST_HZ: f32 = 1.0;

/// Expected pulses of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Density {
    /// Pulses of one wire, each time that the surface passes it.
    pub pass: f32,
    /// Pulses a second of all wires together, on average.
    pub all_hz: f32,
}

impl Renderer {
    /// Replaces every width that is not zero by that of a texture's pulse between two times. All pulses of the texture
    /// bring as much energy a second as bursts on one wire at its level do.
    pub fn texture(
        &mut self,
        span: (Instant, Instant),
        density: Density,
        widths: &mut [Ticks],
        guard: &Guard,
    ) {
        let pattern = &self.settings.pattern;
        let soa_s = pattern.timing().soa.as_micros() as f32 * 1e-6;
        let bursts_hz = f32::from(pattern.pulses(false)) / soa_s;
        let part = bursts_hz / density.all_hz.max(RAREST_HZ);
        let amplitude = self.settings.texture * libm::sqrtf(part);
        let pulses = libm::roundf(density.pass).clamp(1.0, 255.0) as u8;
        self.pulse(span, (amplitude, pulses), widths, guard);
    }

    /// Replaces every width that is not zero by that of a tap's pulse between two times, which has this share of the
    /// largest amplitude.
    pub fn tap(
        &mut self,
        span: (Instant, Instant),
        share: f32,
        widths: &mut [Ticks],
        guard: &Guard,
    ) {
        let alone = 1;
        let largest = self.settings.answer(Some(alone)).largest();
        self.pulse(span, (share * largest, alone), widths, guard);
    }

    /// Replaces every width that is not zero by that of a pulse of this amplitude, one of so many, within what the guard
    /// leaves each wire and the fingertip.
    fn pulse(
        &mut self,
        (at, until): (Instant, Instant),
        (amplitude, pulses): (f32, u8),
        widths: &mut [Ticks],
        guard: &Guard,
    ) {
        let stated = Stated {
            woven: Some(pulses),
            ..Stated::whole(until.since(at))
        };
        let response = self.settings.answer(stated.woven);
        let states = self.amplitudes.iter_mut().zip(&mut self.volleys);
        let states = states.zip(&self.reserves).zip(&*widths);
        for (wire, (((mine, volley), reserve), width)) in states.enumerate() {
            *mine = match *width {
                Ticks::ZERO => 0.0,
                _ => {
                    let most = bearable(guard, reserve, wire, (at, stated.length), stated.booked);
                    let wanted = amplitude * self.settings.calibration.gain(wire);
                    wanted.min(response.amplitude(most))
                }
            };
            *volley = Volley {
                width: Ticks::ZERO,
                length: stated.length,
            };
        }
        self.widen(at, Some(stated), guard);
        self.spend(at, Some(stated), guard);
        for (width, volley) in widths.iter_mut().zip(&self.volleys) {
            *width = volley.width;
        }
    }
}

#[cfg(test)]
#[path = "pulse_tests.rs"]
mod tests;
