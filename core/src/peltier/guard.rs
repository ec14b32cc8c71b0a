//! The guard of a Peltier module: the last stage before the bridge. It holds the current back, or switches it off.
//!
//! Limits are engineering limits for a research device, not a certificate. The thermostat at [`PeltierLimits::thermostat_c`]
//! is hardware of its own: no line of this file switches it.

use crate::physics::{PeltierParameters, Thermistor, ZERO_CELSIUS_K};
use crate::units::{Duration, Instant};

use super::Reading;
use super::thermistor::{SensorFault, celsius};

/// Limits of a module on a fingertip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeltierLimits {
    /// Coldest and warmest face, degrees C.
    pub face_c: [f64; 2],
    /// Fastest change of the face, K/s.
    pub ramp_k_s: f64,
    /// Most current that heats, A.
    pub heating_a: f64,
    /// Most current that cools, A.
    pub cooling_a: f64,
    /// Warmest sink, degrees C.
    pub sink_c: f64,
    /// Oldest reading with which a current may flow; a bridge lets go by itself when no update has come for as long.
    pub stale: Duration,
    /// Temperature of the face at which an independent thermostat cuts the bridge, degrees C.
    pub thermostat_c: f64,
}

/// The limits in force: constants that no file changes.
pub const LIMITS: PeltierLimits = PeltierLimits {
    face_c: [15.0, 41.0],
    ramp_k_s: 3.0,
    heating_a: 1.0,
    cooling_a: 1.0,
    sink_c: 45.0,
    stale: Duration::from_millis(100),
    thermostat_c: 43.0,
};

/// Largest error of a thermistor's temperature, once its lag is led, K: its tolerance, the converter and the estimate.
pub const UNCERTAINTY_K: f64 = 0.5;
/// Band below the limit of a temperature over which the current falls to nothing, K.
const TAPER_K: f64 = 1.0;
/// Readings from which a rate is told: a tenth of a second.
const KEPT: usize = 11;
/// A sensor must have been good for so long before a current flows again.
const GOOD_FOR: Duration = Duration::from_millis(1000);

/// Reasons for which a current is not the one asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum PeltierReason {
    /// No current is asked for.
    Off,
    /// A thermistor tells nothing.
    Sensor(SensorFault),
    /// The face would leave its range.
    Face,
    /// The face would change too fast.
    Ramp,
    /// The most that may flow.
    Current,
    /// The sink would become too warm.
    Sink,
}

impl PeltierReason {
    /// Every reason, by its number.
    pub const ALL: [Self; 8] = [
        Self::Off,
        Self::Sensor(SensorFault::Open),
        Self::Sensor(SensorFault::Short),
        Self::Sensor(SensorFault::Stale),
        Self::Face,
        Self::Ramp,
        Self::Current,
        Self::Sink,
    ];

    /// Number on the link of a driver unit.
    pub const fn number(self) -> u8 {
        match self {
            Self::Off => 0,
            Self::Sensor(SensorFault::Open) => 1,
            Self::Sensor(SensorFault::Short) => 2,
            Self::Sensor(SensorFault::Stale) => 3,
            Self::Face => 4,
            Self::Ramp => 5,
            Self::Current => 6,
            Self::Sink => 7,
        }
    }

    /// The word of records.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Off => "stopped",
            Self::Sensor(fault) => fault.word(),
            Self::Face => "face",
            Self::Ramp => "ramp",
            Self::Current => "current",
            Self::Sink => "sink",
        }
    }
}

/// A current that the guard has passed. Only the guard can make one: its fields are private and there is no other
/// constructor.
///
/// ```compile_fail
/// # use palpate_core::{peltier::GuardedCurrent, units::Instant};
/// let forged = GuardedCurrent { at: Instant::ZERO, until: Instant::FAR_FUTURE, milliamps: 5000 };
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GuardedCurrent {
    at: Instant,
    until: Instant,
    milliamps: i32,
}

impl GuardedCurrent {
    /// Time at which the current is to take effect.
    pub const fn at(&self) -> Instant {
        self.at
    }

    /// Time at which a bridge that has heard nothing since lets go by itself.
    pub const fn until(&self) -> Instant {
        self.until
    }

    /// Current through the module, mA; positive cools the face.
    pub const fn milliamps(&self) -> i32 {
        self.milliamps
    }

    /// Current through the module, A; positive cools the face.
    pub(super) fn amps(&self) -> f64 {
        f64::from(self.milliamps) * 1e-3
    }
}

/// Temperatures from both thermistors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// The face, degrees C, led by the thermistor's lag.
    pub(super) face_c: f64,
    /// The sink, degrees C.
    pub(super) sink_c: f64,
    /// Rate of the face's temperature, K/s.
    rate_k_s: f64,
}

/// The current, A, that pumps `watts` out of the face: the smaller root of S T I - I^2 R / 2 - K (Th - T) = watts. Where
/// none does, the one that pumps most.
pub(super) fn current(of: &PeltierParameters, seen: &Seen, watts: f64) -> f64 {
    let seebeck_v = of.seebeck_v_k * (seen.face_c + ZERO_CELSIUS_K);
    let against = watts + of.conductance_w_k * (seen.sink_c - seen.face_c);
    let root = seebeck_v * seebeck_v - 2.0 * of.resistance_ohm * against;
    (seebeck_v - libm::sqrt(root.max(0.0))) / of.resistance_ohm
}

/// The guard.
#[derive(Clone, Debug)]
pub(super) struct CurrentGuard {
    parameters: PeltierParameters,
    thermistor: Thermistor,
    /// Times and temperatures of the face, the newest last.
    course: [(Instant, f64); KEPT],
    kept: usize,
    seen: Option<Seen>,
    fault: Option<SensorFault>,
    /// Time since which the sensors are good.
    good: Option<Instant>,
    /// The face when it was told last, degrees C.
    last_c: f64,
}

impl CurrentGuard {
    pub(super) const fn new(parameters: PeltierParameters, thermistor: Thermistor) -> Self {
        Self {
            parameters,
            thermistor,
            course: [(Instant::ZERO, 0.0); KEPT],
            kept: 0,
            seen: None,
            fault: None,
            good: None,
            last_c: BODY_C,
        }
    }

    /// Temperatures from the sensors; `None` after a fault or without a reading.
    pub(super) const fn seen(&self) -> Option<Seen> {
        self.seen
    }

    pub(super) fn warmest_c(&self) -> f64 {
        let p = &self.parameters;
        match self.seen {
            Some(seen) => seen.face_c + UNCERTAINTY_K,
            None => {
                let (sink, skin) = (p.conductance_w_k, p.skin_w_k);
                let passive_c = (sink * LIMITS.sink_c + skin * BODY_C) / (sink + skin);
                passive_c.max(self.last_c + UNCERTAINTY_K)
            }
        }
    }

    /// Fault of the sensors, present or within the last second.
    pub(super) const fn fault(&self) -> Option<SensorFault> {
        self.fault
    }

    pub(super) fn see(&mut self, now: Instant, reading: &Reading) {
        let read = match now.since(reading.at) > LIMITS.stale {
            true => Err(SensorFault::Stale),
            false => celsius(&self.thermistor, reading.face)
                .and_then(|face| Ok((face, celsius(&self.thermistor, reading.sink)?))),
        };
        let (face_c, sink_c) = match read {
            Ok(read) => read,
            Err(fault) => {
                self.fault = Some(fault);
                (self.good, self.seen, self.kept) = (None, None, 0);
                return;
            }
        };
        let rate_k_s = self.rate(reading.at, face_c);
        let good = *self.good.get_or_insert(now);
        if self.fault.is_some() && now.since(good) < GOOD_FOR {
            return;
        }
        self.fault = None;
        let face_c = face_c + self.parameters.sensor_s * rate_k_s;
        self.last_c = face_c;
        self.seen = Some(Seen {
            face_c,
            sink_c,
            rate_k_s,
        });
    }

    /// Rate of the face's temperature, K/s, with this reading the newest.
    fn rate(&mut self, at: Instant, face_c: f64) -> f64 {
        let newest = self.kept.checked_sub(1).map(|last| self.course[last].0);
        if newest.is_none_or(|newest| newest < at) {
            if self.kept == KEPT {
                self.course.copy_within(1.., 0);
                self.kept -= 1;
            }
            self.course[self.kept] = (at, face_c);
            self.kept += 1;
        }
        let (then, before_c) = self.course[0];
        let seconds = at.since(then).as_secs_f64();
        if seconds < 0.05 {
            return 0.0;
        }
        (face_c - before_c) / seconds
    }

    /// The update that switches the current off.
    pub(super) fn off(&self, now: Instant) -> GuardedCurrent {
        self.pass(now, 0.0)
    }

    fn pass(&self, now: Instant, amps: f64) -> GuardedCurrent {
        GuardedCurrent {
            at: now,
            until: now + LIMITS.stale,
            // Towards nothing, so that rounding passes no limit.
            milliamps: libm::trunc(amps * 1e3) as i32,
        }
    }

    /// Admits as much of the `asked` current, A, as may flow, with the reason where that is less.
    pub(super) fn admit(
        &self,
        now: Instant,
        asked: f64,
    ) -> (GuardedCurrent, Option<PeltierReason>) {
        let Some(seen) = self.seen else {
            let reason = self.fault.map_or(PeltierReason::Off, PeltierReason::Sensor);
            return (self.off(now), Some(reason));
        };
        if !asked.is_finite() {
            return (self.off(now), Some(PeltierReason::Off));
        }
        let (row, rows) = match asked < 0.0 {
            true => (LIMITS.heating_a, self.heating(&seen)),
            false => (LIMITS.cooling_a, self.cooling(&seen)),
        };
        let (mut most, mut reason) = (asked.abs(), None);
        for (row, why) in [(row, PeltierReason::Current)].into_iter().chain(rows) {
            if most > row {
                (most, reason) = (row.max(0.0), Some(why));
            }
        }
        (self.pass(now, most.copysign(asked)), reason)
    }

    /// Most current that heats, A, by row.
    fn heating(&self, seen: &Seen) -> [(f64, PeltierReason); 3] {
        let [_, high] = LIMITS.face_c;
        let warming_w = 2.0 * self.parameters.skin_w_k * (BODY_C - seen.face_c).max(0.0);
        let left_w = self.parameters.face_j_k * LIMITS.ramp_k_s - warming_w;
        let ramp = match seen.rate_k_s > LIMITS.ramp_k_s {
            true => 0.0,
            false => -current(&self.parameters, seen, -left_w),
        };
        let face = taper(high - UNCERTAINTY_K - seen.face_c);
        [
            (ramp, PeltierReason::Ramp),
            (LIMITS.heating_a * face, PeltierReason::Face),
            // A sink is warmed by cooling alone.
            (f64::INFINITY, PeltierReason::Sink),
        ]
    }

    /// Most current that cools, A, by row.
    fn cooling(&self, seen: &Seen) -> [(f64, PeltierReason); 3] {
        let [low, _] = LIMITS.face_c;
        let cooling_w = 2.0 * self.parameters.skin_w_k * (seen.face_c - BODY_C).max(0.0);
        let left_w = self.parameters.face_j_k * LIMITS.ramp_k_s - cooling_w;
        let ramp = match seen.rate_k_s < -LIMITS.ramp_k_s {
            true => 0.0,
            false => current(&self.parameters, seen, left_w),
        };
        let face = taper(seen.face_c - low - UNCERTAINTY_K);
        let sink = taper(LIMITS.sink_c - UNCERTAINTY_K - seen.sink_c);
        [
            (ramp, PeltierReason::Ramp),
            (LIMITS.cooling_a * face, PeltierReason::Face),
            (LIMITS.cooling_a * sink, PeltierReason::Sink),
        ]
    }
}

/// The body behind the skin, degrees C.
const BODY_C: f64 = 33.0;

/// The part of a current that may flow so many kelvin before a limit.
fn taper(left_k: f64) -> f64 {
    (left_k / TAPER_K).clamp(0.0, 1.0)
}
