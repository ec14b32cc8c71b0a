//! An eccentric rotating mass: a small motor of direct current with an unbalanced weight.
//!
//! Its speed W follows J W' = K (V - K W) / R - b W - friction, with static friction at rest. Inductance is left out. A
//! steady voltage has a closed form; speed and voltage keep their signs apart, so braking by a reverse voltage works. The coil's
//! loss is that of the current at a stretch's end, so it is right for stretches that are short beside the spin-up.

use core::f64::consts::TAU;

use super::{Coil, Drive, MotorFault};

/// Parameters of an eccentric rotating mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErmParameters {
    /// Torque per current, N m/A, and back-EMF per speed, V s/rad.
    pub torque_nm_a: f64,
    /// Resistance of the coil, ohm.
    pub ohm: f64,
    /// Moment of inertia of rotor and weight, kg m2.
    pub inertia_kg_m2: f64,
    /// Friction of the turning rotor, N m, and the torque that starts it.
    pub friction_nm: f64,
    /// Torque that a resting rotor needs to start, N m.
    pub static_nm: f64,
    /// Unbalance, mass times distance, over the mass that it shakes, m: the amplitude far above any resonance.
    pub unbalance_m: f64,
}

impl ErmParameters {
    /// A coin of 10 mm and 3 V that turns at some 200 Hz, starts at some 1.2 V and needs some 60 ms to be fast. The figures are
    /// assumed, of the size that data sheets of such coins state.
    pub const COIN_10MM: Self = Self {
        torque_nm_a: 1.3e-3,
        ohm: 30.0,
        inertia_kg_m2: 2.2e-9,
        friction_nm: 4.0e-5,
        static_nm: 5.2e-5,
        unbalance_m: 4.0e-5,
    };
}

/// An eccentric rotating mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Erm {
    parameters: ErmParameters,
    /// Speed, rad/s.
    speed: f64,
    pub(super) coil: Coil,
    pub(super) fault: Option<MotorFault>,
}

impl Erm {
    /// A motor at rest.
    pub const fn new(parameters: ErmParameters) -> Self {
        Self {
            parameters,
            speed: 0.0,
            coil: Coil::new(parameters.ohm),
            fault: None,
        }
    }

    /// Speed, turns per second.
    pub fn hz(&self) -> f64 {
        self.speed.abs() / TAU
    }

    /// Back-EMF, V.
    pub fn emf(&self) -> f64 {
        self.parameters.torque_nm_a * self.speed.abs()
    }

    /// Amplitude of what it shakes, m: 0 at rest.
    pub fn amplitude_m(&self) -> f64 {
        if self.speed == 0.0 {
            0.0
        } else {
            self.parameters.unbalance_m
        }
    }

    /// Lets `seconds` pass under a drive. A wave is far faster than the rotor and turns nothing.
    pub fn pass(&mut self, drive: &Drive, seconds: f64) {
        if seconds.is_nan() || seconds <= 0.0 {
            return;
        }
        let volts = match (self.fault, *drive) {
            (Some(MotorFault::Open | MotorFault::Short), _) | (_, Drive::Open) => None,
            (_, Drive::Steady(volts)) => Some(volts),
            (_, Drive::Wave { .. }) => Some(0.0),
        };
        let mut left = seconds;
        // A rotor that comes to rest may start the other way: two stretches at most.
        for _ in 0..2 {
            left -= self.turn(volts, left);
            if left <= 0.0 {
                break;
            }
        }
        let p = &self.parameters;
        let amps = volts.map_or(0.0, |v| (v - p.torque_nm_a * self.speed) / p.ohm);
        self.coil.warm(amps * amps * p.ohm, seconds);
    }

    /// Turns for at most `seconds`, to where the rotor comes to rest; returns the time that took.
    fn turn(&mut self, volts: Option<f64>, seconds: f64) -> f64 {
        let p = &self.parameters;
        if self.fault == Some(MotorFault::Stuck) {
            self.speed = 0.0;
            return seconds;
        }
        let torque = volts.map_or(0.0, |v| p.torque_nm_a * v / p.ohm);
        if self.speed == 0.0 && torque.abs() <= p.static_nm {
            return seconds;
        }
        let way = if self.speed == 0.0 {
            torque.signum()
        } else {
            self.speed.signum()
        };
        let force = torque - way * p.friction_nm;
        let drag = volts.map_or(0.0, |_| p.torque_nm_a * p.torque_nm_a / p.ohm);
        let speed_after = |t: f64| match drag > 0.0 {
            true => {
                let end = force / drag;
                end + (self.speed - end) * libm::exp(-drag / p.inertia_kg_m2 * t)
            }
            false => self.speed + force / p.inertia_kg_m2 * t,
        };
        let after = speed_after(seconds);
        if after * way > 0.0 {
            self.speed = after;
            return seconds;
        }
        // It comes to rest within the stretch.
        let rest = match drag > 0.0 {
            true => {
                let end = force / drag;
                libm::log((self.speed - end) / -end) * p.inertia_kg_m2 / drag
            }
            false => -self.speed * p.inertia_kg_m2 / force,
        };
        self.speed = 0.0;
        rest.clamp(0.0, seconds)
    }
}

#[cfg(test)]
#[path = "erm_tests.rs"]
mod tests;
