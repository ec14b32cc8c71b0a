//! Warmth on the fingertip: a Peltier module under the wires as a second kind of actuator.
//!
//! A [`Regulator`] takes a reading of two thermistors and the temperature that shall be felt, and returns a current that
//! its guard has passed ([`GuardedCurrent`]). A driver of an H-bridge takes nothing else:
//! [`Actuators`](crate::driver::Actuators)`<GuardedCurrent>`. Positive current cools the face.
//!
//! What the face does to the wires' budget is the wires' guard's to say: [`Guard::warm`](crate::guard::Guard::warm).

mod control;
mod guard;
mod material;
mod thermistor;

pub use guard::{GuardedCurrent, LIMITS, PeltierLimits, PeltierReason, UNCERTAINTY_K};
pub use material::Material;
pub use thermistor::SensorFault;

use crate::physics::{PeltierParameters, Thermistor};
use crate::units::{Duration, Instant};

use control::Control;
use guard::CurrentGuard;

/// Time between two turns of a regulator: 100 Hz.
pub const PERIOD: Duration = Duration::from_millis(10);
/// Rate at which the aim moves, K/s; it leaves a fifth of the ramp row to overshoot.
const SLEW_K_S: f64 = 2.4;
/// Distance that the aim keeps from the limits of the face, K.
const CLEAR_K: f64 = 1.0;

/// Codes of both thermistors, converted together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// Time of the conversion.
    pub at: Instant,
    /// Code of the face's thermistor.
    pub face: u16,
    /// Code of the sink's thermistor.
    pub sink: u16,
}

/// Request for the face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// The temperature to be felt, degrees C.
    pub face_c: f64,
    /// The warmest that the wires bear now, degrees C: what [`Guard::warm`](crate::guard::Guard::warm) returned.
    pub ceiling_c: f64,
}

/// A turn of the regulator.
#[derive(Clone, Debug, PartialEq)]
pub struct Regulated {
    /// Current for the driver to set.
    pub update: GuardedCurrent,
    /// The face, degrees C, led by the thermistor's lag; `None` where no sensor tells it.
    pub face_c: Option<f64>,
    /// Temperature that the control aims at now, degrees C; `None` without an aim.
    pub aim_c: Option<f64>,
    /// The reason for which the current is not the one that the control asked for.
    pub reason: Option<PeltierReason>,
}

/// PI control of the face behind its guard. No clock, no memory but its own.
#[derive(Clone, Debug)]
pub struct Regulator {
    control: Control,
    guard: CurrentGuard,
    aim_c: Option<f64>,
    turned: Option<Instant>,
}

impl Regulator {
    /// A regulator of this module, off.
    pub fn new(parameters: PeltierParameters, thermistor: Thermistor) -> Self {
        Self {
            control: Control::new(parameters),
            guard: CurrentGuard::new(parameters, thermistor),
            aim_c: None,
            turned: None,
        }
    }

    /// Time at which the next turn is due.
    pub fn next(&self) -> Instant {
        self.turned.map_or(Instant::ZERO, |at| at + PERIOD)
    }

    /// The warmest that the face can be now, degrees C, by the bounds of the thermistor's lag and error. Without a
    /// working sensor no current flows, and the face counts as warm as it last was, or as a sink at its limit makes it.
    pub fn warmest_c(&self) -> f64 {
        self.guard.warmest_c()
    }

    /// The sink, degrees C; `None` where no sensor tells it.
    pub fn sink_c(&self) -> Option<f64> {
        self.guard.seen().map(|seen| seen.sink_c)
    }

    /// Looks at a reading, the newest there is.
    pub fn see(&mut self, now: Instant, reading: &Reading) {
        self.guard.see(now, reading);
    }

    /// Takes a turn with the last reading; without anything `wanted` it switches off.
    pub fn turn(&mut self, now: Instant, wanted: Option<Wanted>) -> Regulated {
        let passed_s = self.turned.map_or(PERIOD, |at| now.since(at)).as_secs_f64();
        self.turned = Some(now);
        let seen = self.guard.seen();
        let (Some(seen), Some(wanted)) = (seen, wanted) else {
            self.aim_c = None;
            self.control.reset();
            let reason = match seen {
                Some(_) => PeltierReason::Off,
                None => self
                    .guard
                    .fault()
                    .map_or(PeltierReason::Off, PeltierReason::Sensor),
            };
            return Regulated {
                update: self.guard.off(now),
                face_c: seen.map(|seen| seen.face_c),
                aim_c: None,
                reason: Some(reason),
            };
        };
        let [low, high] = LIMITS.face_c;
        let end_c = wanted.face_c.min(wanted.ceiling_c);
        let end_c = end_c.clamp(low + CLEAR_K, high - CLEAR_K);
        let from_c = self.aim_c.unwrap_or(seen.face_c);
        let most = SLEW_K_S * passed_s;
        let step = (end_c - from_c).clamp(-most, most);
        let aim_c = from_c + step;
        self.aim_c = Some(aim_c);
        let asked = self
            .control
            .current(&seen, aim_c, step / passed_s.max(1e-6));
        let (update, reason) = self.guard.admit(now, asked);
        self.control.learn(asked, update.amps(), passed_s);
        Regulated {
            update,
            face_c: Some(seen.face_c),
            aim_c: Some(aim_c),
            reason,
        }
    }
}

#[cfg(test)]
mod tests;
