//! Oscillator and tick counter: exact rational time. Nothing here rounds twice.
//!
//! The phase is an integer: one oscillator cycle is 10^12 units, because a nanosecond at one millihertz is
//! 10^-12 cycles. A change of frequency adds what has passed to the phase and goes on from there, so an
//! instant computed after an hour of ticks is as exact as the first: at most one nanosecond late.

use crate::time::Nanos;

/// Phase units in one oscillator cycle.
const CYCLE: u128 = 1_000_000_000_000;
/// Ticks in one PWM period (data sheet 7.3.3).
pub(super) const PERIOD: u64 = 4096;

/// The frequency of a chip's internal oscillator: nominal 25 MHz (data sheet 7.3.5), 23 .. 27.4 MHz seen on
/// real lots, with an optional linear drift.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Oscillator {
    /// Frequency at the start of the run, millihertz.
    millihertz: u64,
    /// Change a second, millihertz.
    drift_millihertz_per_s: i64,
}

impl Default for Oscillator {
    fn default() -> Self {
        Self::NOMINAL
    }
}

impl Oscillator {
    /// The data sheet's 25 MHz.
    pub const NOMINAL: Self = Self::from_hz(25_000_000);
    /// Bounds that a drift never leaves, millihertz; the upper one is EXTCLK's limit (data sheet table 17).
    const BOUNDS: (u64, u64) = (1_000_000, 50_000_000_000);

    /// A constant frequency in hertz, clamped to 1 kHz .. 50 MHz.
    pub const fn from_hz(hz: u32) -> Self {
        Self {
            millihertz: Self::bound(hz as u64 * 1000),
            drift_millihertz_per_s: 0,
        }
    }

    /// A constant factor of the nominal frequency, resolved to a millihertz; nominal if not a number.
    pub fn from_factor(factor: f64) -> Self {
        let factor = if factor.is_finite() { factor } else { 1.0 };
        Self {
            // The cast saturates; the bound follows.
            millihertz: Self::bound(libm::rint(factor * 25e9) as u64),
            drift_millihertz_per_s: 0,
        }
    }

    /// Returns the oscillator with a linear drift in millihertz a second since the start of the run. It is sampled at
    /// the start of the counter and at the end of each period.
    pub const fn with_drift(mut self, millihertz_per_s: i64) -> Self {
        self.drift_millihertz_per_s = millihertz_per_s;
        self
    }

    /// Tells whether the frequency changes with time.
    pub(super) const fn drifts(self) -> bool {
        self.drift_millihertz_per_s != 0
    }

    /// Frequency at `t`, millihertz.
    pub(super) fn millihertz_at(self, t: Nanos) -> u64 {
        let moved = i128::from(self.drift_millihertz_per_s) * i128::from(t.0) / 1_000_000_000;
        let f = i128::from(self.millihertz) + moved;
        let (low, high) = (i128::from(Self::BOUNDS.0), i128::from(Self::BOUNDS.1));
        // Between the bounds, so the cast keeps the value.
        f.clamp(low, high) as u64
    }

    const fn bound(millihertz: u64) -> u64 {
        if millihertz < Self::BOUNDS.0 {
            Self::BOUNDS.0
        } else if millihertz > Self::BOUNDS.1 {
            Self::BOUNDS.1
        } else {
            millihertz
        }
    }
}

/// The prescaled 12-bit counter while it runs (data sheet 7.3.5).
#[derive(Clone, Debug)]
pub(super) struct Counter {
    /// Time at which `phase` was taken.
    anchor: Nanos,
    /// Phase at `anchor`, since the counter last started from zero.
    phase: u128,
    /// Clock in force, millihertz; zero when an external clock stands still.
    millihertz: u64,
    /// Phase units in one tick: (PRE + 1) cycles.
    per_tick: u128,
    /// The last tick whose effects are done, counted from the start.
    pub(super) tick: u64,
}

impl Counter {
    /// Starts from zero at `t`.
    pub(super) fn start(t: Nanos, pre: u8, millihertz: u64) -> Self {
        Self {
            anchor: t,
            phase: 0,
            millihertz,
            per_tick: (u128::from(pre) + 1) * CYCLE,
            tick: 0,
        }
    }

    /// Goes on at another frequency from `t`, phase kept exactly.
    pub(super) fn retune(&mut self, t: Nanos, millihertz: u64) {
        if millihertz != self.millihertz {
            self.phase += u128::from(t.since(self.anchor).0) * u128::from(self.millihertz);
            self.anchor = t;
            self.millihertz = millihertz;
        }
    }

    /// The tick the counter stands at, at `t`.
    pub(super) fn tick_at(&self, t: Nanos) -> u64 {
        let phase = self.phase + u128::from(t.since(self.anchor).0) * u128::from(self.millihertz);
        u64::try_from(phase / self.per_tick).unwrap_or(u64::MAX)
    }

    /// The first whole nanosecond at which the counter has reached `tick`; `None` if the clock stands still.
    pub(super) fn time_of(&self, tick: u64) -> Option<Nanos> {
        if self.millihertz == 0 {
            return None;
        }
        let missing = (u128::from(tick) * self.per_tick).saturating_sub(self.phase);
        let span = missing.div_ceil(u128::from(self.millihertz));
        Some(self.anchor + Nanos(u64::try_from(span).unwrap_or(u64::MAX)))
    }
}
