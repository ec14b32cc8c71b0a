//! Units as types: a duty is not a number of microseconds, a prescale is not a frequency.
//!
//! Integers wherever a value reaches a schedule, so that a schedule is the same bytes on every machine.
//! Positions are `f32` millimetres: a taxel pad is tens of millimetres wide and counts carry 16 bits.

use core::fmt;
use core::ops::{Add, AddAssign, Sub};

/// A span of time in whole microseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Duration(u64);

impl Duration {
    /// No time at all.
    pub const ZERO: Self = Self(0);

    /// Converts microseconds.
    pub const fn from_micros(us: u64) -> Self {
        Self(us)
    }

    /// Converts milliseconds; saturates at the largest representable span.
    pub const fn from_millis(ms: u64) -> Self {
        Self(ms.saturating_mul(1000))
    }

    /// Length in microseconds.
    pub const fn as_micros(self) -> u64 {
        self.0
    }

    /// Length in seconds, for display and physics.
    pub const fn as_secs_f64(self) -> f64 {
        self.0 as f64 * 1e-6
    }
}

/// Converts to whole microseconds: fractions are cut off, and a time longer than the range saturates.
impl From<core::time::Duration> for Duration {
    fn from(span: core::time::Duration) -> Self {
        Self(u64::try_from(span.as_micros()).unwrap_or(u64::MAX))
    }
}

impl From<Duration> for core::time::Duration {
    fn from(span: Duration) -> Self {
        Self::from_micros(span.0)
    }
}

/// A point in time: whole microseconds since the start of the run.
///
/// The core never asks what time it is; every call that depends on time takes one of these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Instant(u64);

impl Instant {
    /// The start of the run.
    pub const ZERO: Self = Self(0);
    /// Later than every run: "no deadline".
    pub const FAR_FUTURE: Self = Self(u64::MAX);

    /// Instant from microseconds since the start of the run.
    pub const fn from_micros(us: u64) -> Self {
        Self(us)
    }

    /// Microseconds since the start of the run.
    pub const fn as_micros(self) -> u64 {
        self.0
    }

    /// Time since `earlier`, or zero when `earlier` lies in the future.
    pub const fn since(self, earlier: Self) -> Duration {
        Duration(self.0.saturating_sub(earlier.0))
    }
}

impl Add<Duration> for Instant {
    type Output = Self;
    /// Saturates: a deadline past the end of time is [`Instant::FAR_FUTURE`].
    fn add(self, span: Duration) -> Self {
        Self(self.0.saturating_add(span.0))
    }
}

impl Add for Duration {
    type Output = Self;
    /// Saturates.
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl AddAssign<Duration> for Instant {
    fn add_assign(&mut self, span: Duration) {
        *self = *self + span;
    }
}

impl Sub<Duration> for Instant {
    type Output = Self;
    /// Saturates at the start of the run.
    fn sub(self, span: Duration) -> Self {
        Self(self.0.saturating_sub(span.0))
    }
}

impl fmt::Display for Instant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:06} s", self.0 / 1_000_000, self.0 % 1_000_000)
    }
}

/// A width in PWM ticks, 0 ..= 4096: a period of the PCA9685 has 4096 of them (data sheet 7.3.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Ticks(u16);

impl Ticks {
    /// Ticks in one PWM period.
    pub const PER_PERIOD: u16 = 4096;
    /// No pulse.
    pub const ZERO: Self = Self(0);

    /// `n` ticks, clamped to one period.
    pub const fn new(n: u16) -> Self {
        Self(if n > Self::PER_PERIOD {
            Self::PER_PERIOD
        } else {
            n
        })
    }

    /// The nearest number of ticks to the fraction `duty` of a period; NaN gives zero.
    pub fn from_duty(duty: f32) -> Self {
        // A float-to-int cast saturates and maps NaN to 0, which is the safe end here.
        Self::new(libm::rintf(duty * f32::from(Self::PER_PERIOD)) as u16)
    }

    /// The number of ticks.
    pub const fn get(self) -> u16 {
        self.0
    }

    /// The fraction of a period.
    pub fn duty(self) -> f64 {
        f64::from(self.0) / f64::from(Self::PER_PERIOD)
    }
}

/// Source of a board's ticks: the chip's own oscillator, or a clock of stated tolerance on its EXTCLK pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Clock {
    hz: u32,
    /// Parts per million; `None` for the internal oscillator, which promises nothing.
    tolerance_ppm: Option<u32>,
}

impl Clock {
    /// The internal oscillator, by its nominal frequency (data sheet 7.3.5). Real ones run at 23 to 27.4 MHz.
    pub const INTERNAL: Self = Self {
        hz: 25_000_000,
        tolerance_ppm: None,
    };
    /// The fastest clock that EXTCLK takes, Hz (data sheet table 17).
    pub const MOST_HZ: u32 = 50_000_000;
    /// The widest tolerance that can be stated, parts per million: the internal oscillator keeps nearly that.
    pub const MOST_PPM: u32 = 50_000;

    /// A clock on EXTCLK that stays within `tolerance_ppm` of `hz`. `None` if a chip cannot take it.
    pub const fn external(hz: u32, tolerance_ppm: u32) -> Option<Self> {
        if hz == 0 || hz > Self::MOST_HZ || tolerance_ppm > Self::MOST_PPM {
            return None;
        }
        Some(Self {
            hz,
            tolerance_ppm: Some(tolerance_ppm),
        })
    }

    /// Nominal frequency, Hz.
    pub const fn hz(self) -> u32 {
        self.hz
    }

    /// Tolerance of an external clock, parts per million; `None` for the internal oscillator.
    pub const fn tolerance_ppm(self) -> Option<u32> {
        self.tolerance_ppm
    }
}

/// The PRE_SCALE register of a PCA9685 and the clock it divides: together the true PWM frequency of a whole board.
///
/// `f = f_clock / (4096 (PRE + 1))` (data sheet 7.3.5): asking for 200 Hz of 25 MHz gives PRE = 30 and 196.89 Hz.
/// The true value is carried everywhere, the wish nowhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Prescale {
    pre: u8,
    clock: Clock,
}

impl Prescale {
    /// The smallest value the chip accepts (data sheet 7.3.5).
    pub const MIN: Self = Self::new(3);

    /// Prescale from a register value, on the internal oscillator; the chip clamps to 3, and so does this.
    pub const fn new(pre: u8) -> Self {
        Self {
            pre: if pre < 3 { 3 } else { pre },
            clock: Clock::INTERNAL,
        }
    }

    /// Returns this divider with another clock.
    #[must_use]
    pub const fn with_clock(self, clock: Clock) -> Self {
        Self { clock, ..self }
    }

    /// The divider of `clock` whose nominal frequency is nearest to `hz` (`round(f_clock / (4096 hz)) - 1`),
    /// clamped to the chip's 3 .. 255. `None` if `hz` is not a positive number.
    pub fn from_hz(clock: Clock, hz: f64) -> Option<Self> {
        if !(hz.is_finite() && hz > 0.0) {
            return None;
        }
        let pre = libm::rint(f64::from(clock.hz) / (4096.0 * hz)) - 1.0;
        let pre = pre.clamp(3.0, 255.0) as u8;
        Some(Self { pre, clock })
    }

    /// The register value.
    pub const fn get(self) -> u8 {
        self.pre
    }

    /// The clock that is divided.
    pub const fn clock(self) -> Clock {
        self.clock
    }

    /// Nominal length of one tick in nanoseconds: exact at 25 MHz, 40 ns per step; else rounded down.
    pub const fn tick_ns(self) -> u64 {
        (self.pre as u64 + 1) * 1_000_000_000 / self.clock.hz as u64
    }

    /// Nominal length of one period in nanoseconds: exact at 25 MHz, else rounded down.
    pub const fn period_ns(self) -> u64 {
        (self.pre as u64 + 1) * 4096 * 1_000_000_000 / self.clock.hz as u64
    }

    /// The longest stimulus up to `length` whose pulses can be counted: half a period short of a whole number of
    /// them, so that neither the bus nor the clock's tolerance makes one more or less. On the internal oscillator there
    /// is none, and `length` stays as it is.
    pub fn counted(self, length: Duration) -> Duration {
        if self.clock.tolerance_ppm.is_none() {
            return length;
        }
        let (length, period) = (length.as_micros() * 1000, self.period_ns());
        let pulses = ((length + period / 2) / period).max(1);
        Duration::from_micros((pulses * period - period / 2) / 1000)
    }

    /// Nominal frequency, Hz.
    pub fn hz(self) -> f64 {
        1e9 / self.period_ns() as f64
    }
}

/// Electric current in milliamperes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Milliamps(pub u32);

impl Milliamps {
    /// Current in amperes.
    pub fn amps(self) -> f64 {
        f64::from(self.0) * 1e-3
    }
}

/// A place in a plane, millimetres: origin at the centre, x right, y up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// Millimetres to the right.
    pub x: f32,
    /// Millimetres up.
    pub y: f32,
}

impl Point {
    /// A point from millimetres.
    pub const fn new(x: f32, y: f32) -> Self {
        Self { x, y }
    }

    /// Squared distance, mm². Differences first: an expanded square loses all digits at raw counts.
    pub fn distance2(self, other: Self) -> f32 {
        let (dx, dy) = (self.x - other.x, self.y - other.y);
        dx * dx + dy * dy
    }

    /// Distance, mm.
    pub fn distance(self, other: Self) -> f32 {
        libm::sqrtf(self.distance2(other))
    }
}

/// Index of a PCA9685 board on the actuator bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Board(pub u8);

/// Index of a PWM output of one board, 0 ..= 15.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Channel(pub u8);

#[cfg(test)]
#[path = "units_tests.rs"]
mod tests;
