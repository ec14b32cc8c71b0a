//! Vibration: motors at their resonance as a further kind of actuator, behind a guard of their own.
//!
//! A [`VibrationGuard`] turns asked levels into a [`GuardedVibration`]. A driver of motors takes nothing else:
//! [`Actuators`](crate::driver::Actuators)`<GuardedVibration>`. A driver of wires cannot take it:
//!
//! ```compile_fail,E0308
//! # use palpate_core::{driver::Actuators, guard::Guarded, vibration::GuardedVibration};
//! fn wires<A: Actuators<Guarded>>(driver: &mut A, update: &GuardedVibration) {
//!     let _ = driver.apply(update);
//! }
//! ```
//!
//! A driver of motors cannot take an update of wires:
//!
//! ```compile_fail,E0308
//! # use palpate_core::{driver::Actuators, guard::Guarded, vibration::GuardedVibration};
//! fn motors<A: Actuators<GuardedVibration>>(driver: &mut A, update: &Guarded) {
//!     let _ = driver.apply(update);
//! }
//! ```

use crate::units::{Duration, Instant};

/// Motors of one guard: the channels of one multiplexer.
pub const MOTORS: usize = 8;
/// Longest time for which one update may drive the motors; the caller admits the next one, or switches off, by then.
pub const HOLD: Duration = Duration::from_millis(100);

/// Limits of a motor and what the guard computes them with. Every value is the caller's, from a data sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorLimits {
    /// Rated voltage, V RMS.
    pub rated_v: f64,
    /// Contactor's displacement at resonance per volt, um/V.
    pub travel_um_v: f64,
    /// Largest displacement, um.
    pub travel_um: f64,
    /// Coil's settled rise of temperature per square volt, K/V^2.
    pub rise_k_v2: f64,
    /// Time constant of the coil's temperature, s.
    pub coil_s: f64,
    /// Largest rise of the coil's temperature, K.
    pub rise_k: f64,
}

/// Levels that the guard has passed. Its fields are private: the guard alone makes one.
///
/// ```compile_fail,E0451
/// # use palpate_core::{units::Instant, vibration::GuardedVibration};
/// let forged = GuardedVibration { at: Instant::ZERO, millivolts: [9000; 8] };
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GuardedVibration {
    at: Instant,
    millivolts: [u16; MOTORS],
}

impl GuardedVibration {
    /// Time at which the levels take effect.
    pub const fn at(&self) -> Instant {
        self.at
    }

    /// Time by which the driver has the next update or is off.
    pub fn until(&self) -> Instant {
        self.at + HOLD
    }

    /// Drive of every motor, mV RMS.
    pub const fn millivolts(&self) -> &[u16; MOTORS] {
        &self.millivolts
    }
}

/// The guard of up to eight equal motors: rated voltage, displacement and the coil's temperature.
#[derive(Clone, Debug)]
pub struct VibrationGuard {
    limits: MotorLimits,
    rise_k: [f64; MOTORS],
    last: GuardedVibration,
}

impl VibrationGuard {
    /// A guard of cold motors that are off at `now`; `None` unless every limit is finite and above zero.
    pub fn new(now: Instant, limits: MotorLimits) -> Option<Self> {
        let l = &limits;
        let values = [
            l.rated_v,
            l.travel_um_v,
            l.travel_um,
            l.rise_k_v2,
            l.coil_s,
            l.rise_k,
        ];
        let sound = values.iter().all(|value| value.is_finite() && *value > 0.0);
        sound.then_some(Self {
            limits,
            rise_k: [0.0; MOTORS],
            last: GuardedVibration {
                at: now,
                millivolts: [0; MOTORS],
            },
        })
    }

    /// Rise of every coil's temperature at the last update, K.
    pub const fn rise_k(&self) -> &[f64; MOTORS] {
        &self.rise_k
    }

    /// Passes as much of each `asked` part of the rated voltage, 0 to 1, as stays within all limits for [`HOLD`].
    /// Anything that is not a number drives nothing. A `now` before the last update's counts as that.
    pub fn admit(&mut self, now: Instant, asked: &[f64; MOTORS]) -> GuardedVibration {
        let l = self.limits;
        let at = now.max(self.last.at);
        let passed = libm::exp(-at.since(self.last.at).as_secs_f64() / l.coil_s);
        let held = libm::exp(-HOLD.as_secs_f64() / l.coil_s);
        let mut millivolts = [0; MOTORS];
        for motor in 0..MOTORS {
            let before_v = f64::from(self.last.millivolts[motor]) * 1e-3;
            let settled_k = l.rise_k_v2 * before_v * before_v;
            let rise_k = settled_k + (self.rise_k[motor] - settled_k) * passed;
            self.rise_k[motor] = rise_k;
            let room = (l.rise_k - rise_k * held).max(0.0) / (l.rise_k_v2 * (1.0 - held));
            let most = l
                .rated_v
                .min(l.travel_um / l.travel_um_v)
                .min(libm::sqrt(room));
            let asked = if asked[motor].is_finite() {
                asked[motor].clamp(0.0, 1.0)
            } else {
                0.0
            };
            // Towards nothing, so that rounding passes no limit.
            millivolts[motor] = ((asked * l.rated_v).min(most) * 1e3) as u16;
        }
        self.last = GuardedVibration { at, millivolts };
        self.last
    }
}

#[cfg(test)]
mod tests;
