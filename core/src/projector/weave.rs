//! A texture on the wires, PWM period by PWM period, between the illusion and the guard.
//!
//! Two carriers. On the display, the pulses of (3.1) run by themselves. On contacts, f_PWM thins out each burst: its
//! first period always pulses, later ones where f_PWM has one, for all wires alike, so that their ratios and with
//! them the phantom's place stay. On both, fewer pulses are stronger, by the root of how many are left out: the renderer
//! finds the widths for that, and without it they grow in proportion, as far as the guard allows.

use crate::guard::Guard;
use crate::render::{Density, Stated};
use crate::texture::{Control, Pulses};
use crate::units::{Duration, Instant, Prescale, Ticks};

use super::tap::{Tap, Taps};
use super::texture::Carrier;

/// Nanoseconds times millihertz in one period of f_PWM.
const WHOLE: u64 = 1_000_000_000_000;

/// The periods of one burst that pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Weave {
    start: Instant,
    end: Instant,
    period_ns: u64,
    /// A bit for each period; bursts are shorter than 50 ms, periods longer than 0.6 ms.
    pulses: u128,
    next: u32,
}

impl Weave {
    /// A burst thinned out to the rate of `control`.
    pub(super) fn new(
        start: Instant,
        length: Duration,
        carrier: Prescale,
        control: &Control,
    ) -> Self {
        let period_ns = carrier.period_ns();
        let periods = (length.as_micros() * 1000).div_ceil(period_ns).min(128);
        let step = (u64::from(control.rate_mhz) * period_ns).min(WHOLE);
        let (mut pulses, mut phase) = (0, WHOLE - step);
        for period in 0..periods {
            phase += step;
            if phase >= WHOLE {
                phase -= WHOLE;
                pulses |= 1 << period;
            }
        }
        Self {
            start,
            end: start + length,
            period_ns,
            pulses,
            next: 0,
        }
    }

    /// Burst as the renderer needs it: the pulses that are left, and the part of its energy that the guard books for their
    /// stimuli.
    pub(super) fn stated(&self, guard: &Guard) -> Stated {
        const WIDTH: Ticks = Ticks::new(1000);
        let whole = Stated::whole(self.end.since(self.start));
        let (mut left, mut booked_nj) = (*self, 0);
        while left.next() < Instant::FAR_FUTURE
            && let Some((at, until)) = left.due(left.next())
        {
            booked_nj += guard.energy_nj(WIDTH, until.since(at));
        }
        Stated {
            woven: Some(self.pulses.count_ones() as u8), // at most 128
            booked: booked_nj as f32 / guard.energy_nj(WIDTH, whole.length).max(1) as f32,
            ..whole
        }
    }

    /// Widths of a published law's pulses that feel as strong as an unthinned burst's: the felt amplitude grows with the
    /// width and with the root of the number of pulses. None gets wider than `widest`; all grow alike.
    pub(super) fn widen(&self, widths: &mut [Ticks], widest: Ticks) {
        let length = self.end.since(self.start).as_micros() * 1000;
        let all = length.div_ceil(self.period_ns) as f32;
        let most = widths.iter().copied().max().unwrap_or(Ticks::ZERO);
        if most == Ticks::ZERO {
            return;
        }
        let room = f32::from(widest.get()) / f32::from(most.get());
        let gain = libm::sqrtf(all / self.pulses.count_ones().max(1) as f32).min(room);
        if gain > 1.0 {
            for width in widths {
                // Rounded down: the widest stays within the limit.
                *width = Ticks::new((f32::from(width.get()) * gain) as u16);
            }
        }
    }

    /// Start of period `n`.
    fn at(&self, n: u32) -> Instant {
        let since = Duration::from_micros(u64::from(n) * self.period_ns / 1000);
        (self.start + since).min(self.end)
    }

    /// The first period from `n` on that pulses, or does not.
    fn find(&self, n: u32, pulsing: bool) -> u32 {
        let bits = if pulsing { self.pulses } else { !self.pulses };
        n + bits.checked_shr(n).map_or(128, u128::trailing_zeros)
    }

    /// Start of the next pulses.
    pub(super) fn next(&self) -> Instant {
        let first = self.find(self.next, true);
        if first < 128 {
            self.at(first)
        } else {
            Instant::FAR_FUTURE
        }
    }

    /// The next pulses if they are due: beginning and end of periods that pulse without one between that does not.
    /// Pulses that were missed are left out.
    pub(super) fn due(&mut self, now: Instant) -> Option<(Instant, Instant)> {
        while self.next() <= now {
            let first = self.find(self.next, true);
            self.next = self.find(first, false);
            let end = self.at(self.next);
            if end > now {
                return Some((self.at(first), end));
            }
        }
        None
    }
}

/// Factor by which a published law's pulses at `rate_mhz` are wider than pulses of every period. The felt amplitude grows
/// with the width and with the root of the number of pulses, so rough textures get coarser, not weaker.
pub(super) fn gain(rate_mhz: u32, period_ns: u64) -> f32 {
    let part = (u64::from(rate_mhz) * period_ns).clamp(1, WHOLE) as f32;
    libm::sqrtf(WHOLE as f32 / part)
}

/// Pulses of (3.1) that run by themselves.
#[derive(Debug)]
pub(super) struct Train {
    pulses: Pulses,
    prescale: Prescale,
    period: Duration,
    /// Time for which a pulse is on.
    length: Duration,
    /// Start of the stroke, while there is one.
    origin: Option<Instant>,
    /// Pulses that a wire's rest swallowed.
    rested: u64,
    taps: Option<Taps>,
    tap: Option<Tap>,
    /// Taps that have begun.
    tapped: u64,
}

impl Train {
    /// Start of the next period or of the next pulse of a tap.
    pub(super) fn next(&self) -> Instant {
        let tap = self.tap.map_or(Instant::FAR_FUTURE, |tap| tap.next());
        self.next_period().min(tap)
    }

    fn next_period(&self) -> Instant {
        let since = self.pulses.at().since(Instant::ZERO);
        self.origin.map_or(Instant::FAR_FUTURE, |o| o + since)
    }

    /// The newest period that is due and the wires that pulse in it; older ones that were missed are left out. The
    /// first period of a texture is due at once.
    pub(super) fn due(
        &mut self,
        now: Instant,
        control: Option<&Control>,
    ) -> Option<(Instant, &[bool])> {
        let Some(control) = control else {
            self.origin = None;
            return None;
        };
        if self.origin.is_none() {
            self.pulses.restart();
            self.origin = Some(now);
        }
        let mut at = self.next_period();
        if at > now {
            return None;
        }
        while at + self.period <= now {
            self.pulses.next(control);
            at = self.next_period();
        }
        Some((at, self.pulses.next(control)))
    }

    /// Expected pulses of the texture.
    pub(super) fn density(&self, control: &Control) -> Density {
        self.pulses.density(control)
    }

    /// End of the pulses that begin at `at`.
    pub(super) fn ends(&self, at: Instant) -> Instant {
        at + self.length
    }

    /// Begins a tap, where taps are felt: a period after the texture's last one, since the chip's periods are not locked to ours.
    fn tap(&mut self, at: Instant, hardness: f64) {
        let at = match self.origin {
            Some(_) => at.max(self.next_period() + self.period),
            None => at,
        };
        if let Some(taps) = &self.taps {
            self.tap = Some(Tap::new(taps, at, hardness, self.prescale));
            self.tapped += 1;
        }
    }

    /// The pulse of a tap that is due: its beginning, and its strength as a share of the strongest.
    pub(super) fn tap_due(&mut self, now: Instant) -> Option<(Instant, f32)> {
        self.tap.as_mut()?.due(now, self.length)
    }

    /// Counts a pulse that a wire's rest swallowed.
    pub(super) fn rest(&mut self) {
        self.rested += 1;
    }
}

/// State of a texture in the output half.
#[derive(Debug)]
pub(super) enum Texture {
    Train(Train),
    Contacts(Option<Weave>),
}

impl Texture {
    /// A texture on boards of this PRE_SCALE, whose single pulses are on for `length`.
    pub(super) fn new(carrier: Carrier, prescale: Prescale, length: Duration) -> Self {
        match carrier {
            Carrier::Display(pulses, taps) => Self::Train(Train {
                pulses,
                taps,
                tap: None,
                prescale,
                tapped: 0,
                length,
                period: Duration::from_micros(prescale.period_ns() / 1000),
                origin: None,
                rested: 0,
            }),
            Carrier::Contacts => Self::Contacts(None),
        }
    }

    /// Tells whether the texture has the display to itself.
    pub(super) const fn is_alone(&self) -> bool {
        matches!(self, Self::Train(_))
    }

    /// Time at which the texture has something to do next.
    pub(super) fn next(&self) -> Instant {
        match self {
            Self::Train(train) => train.next(),
            Self::Contacts(weave) => weave.map_or(Instant::FAR_FUTURE, |w| w.next()),
        }
    }

    /// Tells that a surface of this hardness, 0 to 1, was met or left.
    pub(super) fn tap(&mut self, at: Instant, hardness: f64) {
        if let Self::Train(train) = self {
            train.tap(at, hardness);
        }
    }

    /// Taps that have begun.
    pub(super) const fn tapped(&self) -> u64 {
        match self {
            Self::Train(train) => train.tapped,
            Self::Contacts(_) => 0,
        }
    }

    /// Pulses that were left out for a wire to rest.
    pub(super) const fn rested(&self) -> u64 {
        match self {
            Self::Train(train) => train.rested,
            Self::Contacts(_) => 0,
        }
    }
}

#[cfg(test)]
#[path = "weave_tests.rs"]
mod tests;
