//! The guard of vibration motors: voltage, displacement, heat of the coil and time on, in place of a wire's rows.
//!
//! Time, staleness, latch and overrun are those of every guard. A stimulus's width is its level: [`Ticks::PER_PERIOD`] is the
//! rated voltage.

use alloc::boxed::Box;

use crate::illusion::DisplayWire;
use crate::schedule::{Entry, Reason, Stimulus};
use crate::units::{Board, Duration, Instant, Ticks};

use super::admission::Passed;
use super::{Guard, Guarded, Limits, Plant, PlantError};

/// Limits of one kind of motor, with the figures by which the guard predicts it. `docs/vibration.md` has the source of
/// each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorLimits {
    /// Rated voltage, V: the root mean square of a resonant actuator's.
    pub rated_v: f64,
    /// Largest voltage at the beginning and at the end of a burst, V as [`Self::rated_v`].
    pub overdrive_v: f64,
    /// Longest overdrive at each of them, s.
    pub overdrive_s: f64,
    /// Amplitude of the contactor per volt once it is steady, um/V.
    pub travel_um_v: f64,
    /// Largest amplitude of the contactor, um.
    pub travel_um: f64,
    /// Rise of the coil after a long time, K per squared volt.
    pub rise_k_v2: f64,
    /// Time constant of that rise, s.
    pub coil_s: f64,
    /// Largest rise of the coil, K.
    pub rise_k: f64,
    /// Longest burst.
    pub burst: Duration,
    /// Largest part of ten seconds for which a motor may be on, 0 to 1.
    pub duty: f64,
}

impl MotorLimits {
    /// Tells whether every figure can be computed with: finite, above zero, a duty of at most 1.
    fn is_possible(&self) -> bool {
        let above = [
            self.rated_v,
            self.overdrive_v,
            self.overdrive_s,
            self.travel_um_v,
            self.travel_um,
            self.rise_k_v2,
            self.coil_s,
            self.rise_k,
            self.duty,
        ];
        let finite = above.iter().all(|v| v.is_finite() && *v > 0.0);
        finite && self.duty <= 1.0 && self.burst > Duration::ZERO
    }

    /// Voltage of a level.
    fn volts(&self, level: Ticks) -> f64 {
        self.rated_v * f64::from(level.get()) / f64::from(Ticks::PER_PERIOD)
    }

    /// Part of a rise that is left, or missing from its end, after a time.
    fn left(&self, span: Duration) -> f64 {
        libm::exp(-span.as_secs_f64() / self.coil_s)
    }

    /// Time on that a motor saves up at most, s: with a steady part of it, no ten seconds have more than the duty. A burst is
    /// booked at its onset and may reach into ten seconds that begin after that.
    fn saved_s(&self) -> f64 {
        let steady = STEADY * self.duty;
        let saved = self.duty * DUTY_WINDOW_S - steady * (DUTY_WINDOW_S + self.burst.as_secs_f64());
        saved.max(0.0)
    }

    /// Rise that overdrive at both ends of a burst adds at most, K.
    fn overdriven_k(&self) -> f64 {
        let part = 1.0 - libm::exp(-2.0 * self.overdrive_s / self.coil_s);
        self.rise_k_v2 * self.overdrive_v * self.overdrive_v * part
    }
}

/// Time over which the duty counts, s.
const DUTY_WINDOW_S: f64 = 10.0;
/// Part of the duty that a motor may take without a pause; the rest is saved up while it is off.
const STEADY: f64 = 0.8;

/// The guard's memory of one motor.
#[derive(Clone, Debug)]
struct Motor {
    /// Rise of the coil at `at`, K.
    rise_k: f64,
    /// End of the last burst, up to which the rise is booked.
    at: Instant,
    /// Time on that is left at `at`, s.
    left_s: f64,
}

/// The motors of a guard.
#[derive(Clone, Debug)]
pub(super) struct Motors {
    limits: MotorLimits,
    each: Box<[Motor]>,
}

impl Motors {
    fn new(limits: MotorLimits, count: usize) -> Self {
        let one = Motor {
            rise_k: 0.0,
            at: Instant::ZERO,
            left_s: limits.saved_s(),
        };
        Self {
            limits,
            each: alloc::vec![one; count].into(),
        }
    }

    /// Rise of a coil at `at`, K. A burst that is not over yet counts as over.
    fn rise_k(&self, index: usize, at: Instant) -> f64 {
        let motor = &self.each[index];
        motor.rise_k * self.limits.left(at.since(motor.at))
    }

    /// Time for which a motor may be on at `at`, s. A burst that is not over yet counts as over.
    fn left_s(&self, index: usize, at: Instant) -> f64 {
        let (l, motor) = (&self.limits, &self.each[index]);
        let refill = STEADY * l.duty * at.since(motor.at).as_secs_f64();
        (motor.left_s + refill).min(l.saved_s())
    }

    /// The highest level, its end and the reason for both, of a stimulus from `at` on.
    fn judge(&self, index: usize, at: Instant, s: &Stimulus) -> (Ticks, Instant, Option<Reason>) {
        let (l, mut until, mut reason) = (self.limits, s.until, None);
        let left = Duration::from_micros((1e6 * self.left_s(index, at)) as u64);
        if until.since(at) > left {
            (until, reason) = (at + left, Some(Reason::Duty));
        }
        let kept = l.left(until.since(at));
        let room_k = l.rise_k - self.rise_k(index, at) * kept - l.overdriven_k();
        let bounds = [
            (l.travel_um / l.travel_um_v, Reason::Displacement),
            (
                libm::sqrt(room_k.max(0.0) / (l.rise_k_v2 * (1.0 - kept))),
                Reason::CoilHeat,
            ),
        ];
        let mut level = s.width;
        for (most_v, why) in bounds {
            // Downwards, so that rounding passes no limit. Not a number bounds to nothing.
            let most = libm::floor(most_v / l.rated_v * f64::from(Ticks::PER_PERIOD)) as u16;
            if level.get() > most {
                (level, reason) = (Ticks::new(most), Some(why));
            }
        }
        (level, until, reason)
    }

    /// Books a burst of a level, with overdrive at both of its ends.
    fn book(&mut self, index: usize, level: Ticks, (at, until): (Instant, Instant)) {
        let (l, before) = (self.limits, self.rise_k(index, at));
        let used = 1.0 - STEADY * l.duty;
        let left_s = self.left_s(index, at) - used * until.since(at).as_secs_f64();
        let (volts, kept) = (l.volts(level), l.left(until.since(at)));
        let motor = &mut self.each[index];
        motor.rise_k =
            before * kept + l.rise_k_v2 * volts * volts * (1.0 - kept) + l.overdriven_k();
        motor.left_s = left_s;
        motor.at = until.max(motor.at);
    }

    /// Books the time for which a motor was on beyond its end.
    pub(super) fn late(&mut self, index: usize, width: u16, (until, off): (Instant, Instant)) {
        self.book(index, Ticks::new(width), (until, off));
    }
}

/// An update of the motors of one board that a guard of motors has passed. Only such a guard can make one.
///
/// A driver of motors takes no update of wires, and a driver of wires none of motors:
///
/// ```compile_fail
/// # use palpate_core::{driver::Actuators, guard::{Guarded, GuardedVibration}};
/// fn drive<M: Actuators<GuardedVibration>>(motors: &mut M, update: &Guarded) {
///     let _ = motors.apply(update);
/// }
/// ```
///
/// ```compile_fail
/// # use palpate_core::{driver::Actuators, guard::{Guarded, GuardedVibration}};
/// fn drive<W: Actuators<Guarded>>(wires: &mut W, update: &GuardedVibration) {
///     let _ = wires.apply(update);
/// }
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GuardedVibration(pub(super) Guarded);

impl GuardedVibration {
    /// Highest level, which is that of the rated voltage.
    pub const FULL: u8 = 127;

    /// Time at which the update is to take effect.
    pub const fn at(&self) -> Instant {
        self.0.at()
    }

    /// The board that the update is for.
    pub const fn board(&self) -> Board {
        self.0.board()
    }

    /// Returns true if any motor is to change.
    pub fn changes(&self) -> bool {
        self.0.changes()
    }

    /// Level of each motor by its channel, 0 to [`Self::FULL`], rounded down; `None` leaves a motor as it is.
    pub fn levels(&self) -> [Option<u8>; 16] {
        let level = |width: u16| {
            let share = u32::from(width) * u32::from(Self::FULL) / u32::from(Ticks::PER_PERIOD);
            share as u8 // at most 127
        };
        self.0
            .channels()
            .map(|set| set.map(|set| level(set.width())))
    }
}

impl Guard {
    /// A guard over motors at these places, which passes [`GuardedVibration`] and no update of wires. Of `limits` the
    /// staleness holds, of `plant` the bus and the period by which an end may be late.
    ///
    /// # Errors
    /// [`PlantError::Motor`] where a limit cannot be computed with.
    pub fn of_motors(
        limits: Limits,
        motors: MotorLimits,
        plant: Plant,
        places: &[DisplayWire],
    ) -> Result<Self, PlantError> {
        if !motors.is_possible() {
            return Err(PlantError::Motor);
        }
        let mut guard = Self::last_word(limits, plant, places, None)?;
        guard.limits.burst = motors.burst;
        guard.motors = Some(Box::new(Motors::new(motors, places.len())));
        Ok(guard)
    }

    /// Guard of motors of which nobody knows how an earlier guard has left them: each coil counts as warm as its limit allows,
    /// and no time on is saved up.
    #[must_use]
    pub fn after_unknown_use(mut self) -> Self {
        if let Some(motors) = &mut self.motors {
            let rise_k = motors.limits.rise_k;
            for motor in &mut motors.each {
                (motor.rise_k, motor.left_s) = (rise_k, 0.0);
            }
        }
        self
    }

    /// Limits of its motors; `None` for a guard of wires.
    pub fn motors(&self) -> Option<&MotorLimits> {
        self.motors.as_ref().map(|motors| &motors.limits)
    }

    /// The largest rise of a motor's coil that is predicted from `at` on, K; 0 for a guard of wires.
    pub fn coil_rise_k(&self, at: Instant) -> f64 {
        self.motors.as_ref().map_or(0.0, |motors| {
            let each = (0..motors.each.len()).map(|index| motors.rise_k(index, at));
            each.fold(0.0, f64::max)
        })
    }

    /// Used share of each limit of motors at `now`, the worst of all of them: its reason's word and the share; `None` for a guard
    /// of wires. A burst that is not over yet counts as over.
    pub fn motors_used(&self, now: Instant) -> Option<[(&'static str, f64); 4]> {
        let motors = self.motors.as_ref()?;
        let (l, saved_s) = (&motors.limits, motors.limits.saved_s());
        let [mut travel, mut burst, mut duty] = [0.0_f64; 3];
        for (index, motor) in self.wires.iter().enumerate() {
            let level = motor.now.map_or(0, |running| running.setting.width());
            travel = travel.max(l.volts(Ticks::new(level)) * l.travel_um_v / l.travel_um);
            let own = self.burst_at(index, now);
            let most = self.latest(&own).since(own.start).as_secs_f64();
            burst = burst.max(own.until(now).since(own.start).as_secs_f64() / most);
            // With a duty that saves nothing up, any time on is all there is.
            duty = match saved_s > 0.0 {
                true => duty.max(1.0 - motors.left_s(index, now) / saved_s),
                false => 1.0,
            };
        }
        let reasons = [
            Reason::Displacement,
            Reason::CoilHeat,
            Reason::Burst,
            Reason::Duty,
        ];
        let shares = [travel, self.coil_rise_k(now) / l.rise_k, burst, duty];
        Some(core::array::from_fn(|n| (reasons[n].word(), shares[n])))
    }

    /// Passes stimuli for the motors of one board, together, as [`Self::admit`] does for wires. `None` from a guard of wires.
    pub fn admit_vibration(
        &mut self,
        at: Instant,
        board: Board,
        stimuli: &[Stimulus],
        ledger: impl FnMut(Entry),
    ) -> Option<GuardedVibration> {
        self.motors.as_ref()?;
        let update = self.release(at, board);
        Some(GuardedVibration(self.pass(
            update,
            stimuli,
            Self::clamp_motor,
            ledger,
        )))
    }

    /// Switches off the motors of one board whose stimulus has ended by `at`. `None` from a guard of wires.
    pub fn expire_vibration(&mut self, at: Instant, board: Board) -> Option<GuardedVibration> {
        self.motors.as_ref()?;
        Some(GuardedVibration(self.expire(at, board)))
    }

    /// Confirms an update of motors, as [`Self::confirm`] does one of wires.
    pub fn confirm_vibration(&mut self, update: &GuardedVibration, at: Instant) {
        self.confirm(&update.0, at);
    }

    /// Passes the highest level and the latest end that the limits of motors leave of a stimulus, and books it.
    fn clamp_motor(&mut self, index: usize, at: Instant, s: &Stimulus) -> Passed {
        let nothing = |reason| Passed::nothing(s.until, reason);
        if self.latched().is_some() {
            return nothing(Some(Reason::Latched));
        }
        if s.width == Ticks::ZERO || s.until <= at {
            return nothing(None);
        }
        let latest = self.latest(&self.burst_at(index, at));
        let asked = Stimulus {
            until: s.until.min(latest),
            ..*s
        };
        if asked.until <= at {
            return nothing(Some(Reason::Burst));
        }
        let Some(motors) = &mut self.motors else {
            return nothing(None);
        };
        let (level, until, reason) = motors.judge(index, at, &asked);
        if level == Ticks::ZERO || until <= at {
            return nothing(reason);
        }
        motors.book(index, level, (at, until));
        self.extend_burst(index, at, until, 0);
        let cut = (asked.until < s.until).then_some(Reason::Burst);
        Passed::of_motor(level, until, reason.or(cut))
    }
}

#[cfg(test)]
#[path = "motors_tests.rs"]
mod tests;
