//! A voice coil on an amplifier: a mass on a spring in a magnet's field, driven by whatever samples come.
//!
//! The equations are those of the [linear resonant actuator](super::lra), with any damping. The amplifier holds its voltage
//! from one sample to the next, so that the motion between two has a closed form: one matrix, the same for every sample.
//! Inductance is left out: at 0.1 mH and 8 Ohm it turns the current's phase by one degree at 250 Hz.

use core::f64::consts::TAU;

use super::lra::LraParameters;
use super::{Coil, MotorFault};

/// Place and speed below which a coil is at rest, m and m/s: far below what any skin feels.
const REST: (f64, f64) = (1e-15, 1e-12);

/// Motion from one sample to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step {
    /// Place by place and by speed, then speed by place and by speed.
    by: [[f64; 2]; 2],
}

impl Step {
    /// Motion of a mass with half its damping over the mass `gamma`, 1/s, over `h` seconds.
    fn new(omega: f64, gamma: f64, h: f64) -> Self {
        let square = gamma * gamma - omega * omega;
        let turn = libm::sqrt(square.abs());
        let (even, odd) = match turn * h {
            // At critical damping both forms meet.
            ..1e-9 => (1.0, h),
            angle if square < 0.0 => (libm::cos(angle), libm::sin(angle) / turn),
            angle => (libm::cosh(angle), libm::sinh(angle) / turn),
        };
        let fall = libm::exp(-gamma * h);
        Self {
            by: [
                [fall * (even + gamma * odd), fall * odd],
                [-fall * omega * omega * odd, fall * (even - gamma * odd)],
            ],
        }
    }
}

/// A voice coil at the output of an amplifier.
#[derive(Clone, Debug, PartialEq)]
pub struct VoiceCoil {
    parameters: LraParameters,
    /// Motion with a closed and with an open coil.
    closed: Step,
    open: Step,
    /// Time between two samples, s.
    sample_s: f64,
    /// Place of the mass from rest, m, and its speed, m/s.
    x: f64,
    v: f64,
    /// The coil and its heat.
    pub coil: Coil,
    /// The coil's fault; `None` of a whole one.
    pub fault: Option<MotorFault>,
    /// Sum of squared currents since the coil's heat was last brought up to date, A2, and their number.
    squares: f64,
    samples: u32,
}

impl VoiceCoil {
    /// A coil at rest, for samples at this rate.
    pub fn new(parameters: LraParameters, rate_hz: u32) -> Self {
        let (omega, h) = (TAU * parameters.resonance_hz, 1.0 / f64::from(rate_hz));
        Self {
            closed: Step::new(omega, parameters.damping(true), h),
            open: Step::new(omega, parameters.damping(false), h),
            sample_s: h,
            x: 0.0,
            v: 0.0,
            coil: Coil::new(parameters.ohm),
            fault: None,
            squares: 0.0,
            samples: 0,
            parameters,
        }
    }

    /// Lets one sample pass, V at the amplifier's output.
    pub fn sample(&mut self, volts: f64) {
        let p = &self.parameters;
        self.samples += 1;
        let is_open = matches!(self.fault, Some(MotorFault::Open | MotorFault::Short));
        let volts = if is_open { 0.0 } else { volts };
        if !is_open {
            let amps = (volts - p.force_n_a * self.v) / p.ohm;
            self.squares += amps * amps;
        }
        if self.fault == Some(MotorFault::Stuck) {
            self.v = 0.0;
            return;
        }
        let omega = TAU * p.resonance_hz;
        let rest = p.force_n_a / p.ohm / p.mass_kg * volts / (omega * omega);
        let Step { by: [place, speed] } = if is_open { self.open } else { self.closed };
        let (x, v) = (self.x - rest, self.v);
        self.x = rest + place[0] * x + place[1] * v;
        self.v = speed[0] * x + speed[1] * v;
    }

    /// Lets samples of silence pass. A coil at rest costs nothing.
    pub fn silence(&mut self, samples: u32) {
        for passed in 0..samples {
            if self.x.abs() < REST.0 && self.v.abs() < REST.1 {
                (self.x, self.v) = (0.0, 0.0);
                self.samples += samples - passed;
                return;
            }
            self.sample(0.0);
        }
    }

    /// Brings the coil's heat up to date.
    pub fn warm(&mut self) {
        let samples = f64::from(self.samples);
        if self.samples > 0 {
            let watts = self.squares / samples * self.parameters.ohm;
            self.coil.warm(watts, samples * self.sample_s);
        }
        (self.squares, self.samples) = (0.0, 0);
    }

    /// Amplitude of the motion at a frequency as it is now, m.
    pub fn amplitude_m(&self, hz: f64) -> f64 {
        libm::hypot(self.x, self.v / (TAU * hz))
    }

    /// Place of the mass from rest, m.
    pub const fn x_m(&self) -> f64 {
        self.x
    }
}

/// Amplitude of the mass after a long sine of this peak voltage and frequency, m.
pub fn steady_m(p: &LraParameters, peak: f64, hz: f64) -> f64 {
    let (omega0, omega) = (TAU * p.resonance_hz, TAU * hz);
    let force = p.force_n_a / p.ohm * peak / p.mass_kg;
    force
        / libm::hypot(
            omega0 * omega0 - omega * omega,
            2.0 * p.damping(true) * omega,
        )
}

#[cfg(test)]
#[path = "voice_coil_tests.rs"]
mod tests;
