//! A linear resonant actuator: a mass on a spring in a magnet's field, driven by a coil.
//!
//! With the coil's voltage V(t), its current is i = (V - Bl x') / R; inductance is left out. The mass follows
//!
//! ```text
//! m x'' + (c + Bl^2 / R) x' + k x = Bl / R V(t)
//! ```
//!
//! with the second damping only while the coil is closed. Under a cosine, a steady voltage or none the motion has a closed
//! form, so a stretch of any length is one step.

use core::f64::consts::TAU;

use super::{Coil, Drive, MotorFault};

/// Parameters of a linear resonant actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LraParameters {
    /// Resonance, Hz.
    pub resonance_hz: f64,
    /// Moving mass, kg.
    pub mass_kg: f64,
    /// Quality of the resonance with an open coil.
    pub quality: f64,
    /// Force per current, N/A, and back-EMF per speed, V s/m.
    pub force_n_a: f64,
    /// Resistance of the coil, ohm.
    pub ohm: f64,
}

impl LraParameters {
    /// A coin of 10 mm, 175 Hz and 2 Vrms. On a fixture of 100 g its mass gives 1.2 g of peak acceleration, as data sheets of
    /// this size state (1.0 to 1.4 g). Mass, quality and force constant are assumed so that they give that.
    pub const COIN_10MM: Self = Self {
        resonance_hz: 175.0,
        mass_kg: 1.5e-3,
        quality: 24.0,
        force_n_a: 0.45,
        ohm: 25.0,
    };

    fn omega(&self) -> f64 {
        TAU * self.resonance_hz
    }

    /// Half the damping over the mass, 1/s.
    pub(super) fn damping(&self, closed: bool) -> f64 {
        let mechanical = self.mass_kg * self.omega() / self.quality;
        let electrical = self.force_n_a * self.force_n_a / self.ohm;
        (mechanical + if closed { electrical } else { 0.0 }) / (2.0 * self.mass_kg)
    }

    /// Amplitude of the mass after a long cosine of this peak voltage at the resonance, m.
    pub fn steady_m(&self, peak: f64) -> f64 {
        let force = self.force_n_a / self.ohm * peak;
        force / (self.mass_kg * 2.0 * self.damping(true) * self.omega())
    }
}

/// A linear resonant actuator.
#[derive(Clone, Debug, PartialEq)]
pub struct Lra {
    parameters: LraParameters,
    /// Place of the mass from rest, m, and its speed, m/s.
    x: f64,
    v: f64,
    pub(super) coil: Coil,
    pub(super) fault: Option<MotorFault>,
}

/// Looks at a stretch's loss: evenly spaced over a half wave they give its mean exactly.
const LOOKS: u32 = 4;

impl Lra {
    /// An actuator at rest.
    pub const fn new(parameters: LraParameters) -> Self {
        Self {
            parameters,
            x: 0.0,
            v: 0.0,
            coil: Coil::new(parameters.ohm),
            fault: None,
        }
    }

    /// Parameters of the actuator.
    pub const fn parameters(&self) -> &LraParameters {
        &self.parameters
    }

    /// Place of the mass from rest, m.
    pub const fn x_m(&self) -> f64 {
        self.x
    }

    /// Speed of the mass, m/s.
    pub const fn v_m_s(&self) -> f64 {
        self.v
    }

    /// Amplitude of the motion as it is now, m.
    pub fn amplitude_m(&self) -> f64 {
        libm::hypot(self.x, self.v / self.parameters.omega())
    }

    /// Amplitude of the back-EMF as it is now, V.
    pub fn emf(&self) -> f64 {
        self.parameters.force_n_a * self.parameters.omega() * self.amplitude_m()
    }

    /// Phase by which a cosine's force goes with the speed of the mass as it is now, rad.
    pub fn speed_phase(&self) -> f64 {
        libm::atan2(self.parameters.omega() * self.x, self.v)
    }

    /// Lets `seconds` pass under a drive.
    pub fn pass(&mut self, drive: &Drive, seconds: f64) {
        if seconds.is_nan() || seconds <= 0.0 {
            return;
        }
        let drive = match self.fault {
            Some(MotorFault::Open | MotorFault::Short) => &Drive::Open,
            _ => drive,
        };
        let at = |t: f64| match self.fault {
            Some(MotorFault::Stuck) => (self.x, 0.0),
            _ => self.after(drive, t),
        };
        let mut squares = 0.0;
        if !matches!(drive, Drive::Open) {
            for look in 0..LOOKS {
                let t = seconds * (f64::from(look) + 0.5) / f64::from(LOOKS);
                let amps =
                    (drive.volts(t) - self.parameters.force_n_a * at(t).1) / self.parameters.ohm;
                squares += amps * amps;
            }
        }
        (self.x, self.v) = at(seconds);
        let watts = squares / f64::from(LOOKS) * self.parameters.ohm;
        self.coil.warm(watts, seconds);
    }

    /// Place and speed after `t` seconds of a drive.
    fn after(&self, drive: &Drive, t: f64) -> (f64, f64) {
        let p = &self.parameters;
        let (gamma, omega0) = (p.damping(!matches!(drive, Drive::Open)), p.omega());
        let per_volt = p.force_n_a / p.ohm / p.mass_kg;
        // The forced part, as x and v at the beginning and at t.
        let ((x0, v0), (x1, v1)) = match *drive {
            Drive::Open => ((0.0, 0.0), (0.0, 0.0)),
            Drive::Steady(volts) => {
                let x = per_volt * volts / (omega0 * omega0);
                ((x, 0.0), (x, 0.0))
            }
            Drive::Wave { peak, omega, phase } => {
                let (re, im) = (omega0 * omega0 - omega * omega, 2.0 * gamma * omega);
                let size = per_volt * peak / libm::hypot(re, im);
                let lag = phase - libm::atan2(im, re);
                let at = |t: f64| {
                    let (sin, cos) = libm::sincos(omega * t + lag);
                    (size * cos, -size * omega * sin)
                };
                (at(0.0), at(t))
            }
        };
        let (a, b) = (self.x - x0, self.v - v0);
        let turn = libm::sqrt(omega0 * omega0 - gamma * gamma);
        let (sin, cos) = libm::sincos(turn * t);
        let fall = libm::exp(-gamma * t);
        let x = fall * (a * cos + (b + gamma * a) / turn * sin);
        let v = fall * (b * cos - (omega0 * omega0 * a + gamma * b) / turn * sin);
        (x + x1, v + v1)
    }
}

#[cfg(test)]
#[path = "lra_tests.rs"]
mod tests;
