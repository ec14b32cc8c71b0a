//! A texture on the wires, PWM period by PWM period, between the illusion and the guard.
//!
//! Two carriers. On the display, the pulses of (3.1) run by themselves. On contacts, f_PWM thins out each burst: its
//! first period always pulses, later ones where f_PWM has one, for all wires alike, so that their ratios and with
//! them the phantom's place stay. On both, pulses get wider by the root of how many are left out, as far as the guard
//! allows.

use crate::texture::{Control, Pulses};
use crate::units::{Duration, Instant, Prescale, Ticks};

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

    /// Widths of pulses that feel as strong as an unthinned burst's: the felt amplitude grows with the width and
    /// with the root of the number of pulses. None gets wider than `widest`; all grow alike.
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

    /// When period `n` begins.
    fn at(&self, n: u32) -> Instant {
        let since = Duration::from_micros(u64::from(n) * self.period_ns / 1000);
        (self.start + since).min(self.end)
    }

    /// The first period from `n` on that pulses, or does not.
    fn find(&self, n: u32, pulsing: bool) -> u32 {
        let bits = if pulsing { self.pulses } else { !self.pulses };
        n + bits.checked_shr(n).map_or(128, u128::trailing_zeros)
    }

    /// When the next pulses begin.
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

/// By how much pulses at `rate_mhz` are wider than those of every period: what is felt grows with the width and with
/// the root of the number of pulses, so rough textures get coarser, not weaker.
pub(super) fn gain(rate_mhz: u32, period_ns: u64) -> f32 {
    let part = (u64::from(rate_mhz) * period_ns).clamp(1, WHOLE) as f32;
    libm::sqrtf(WHOLE as f32 / part)
}

/// Pulses of (3.1) that run by themselves.
#[derive(Debug)]
pub(super) struct Train {
    pulses: Pulses,
    period: Duration,
    /// When the stroke began, while there is one.
    origin: Option<Instant>,
    /// Pulses that a wire's rest swallowed.
    rested: u64,
}

impl Train {
    /// When the next period begins.
    pub(super) fn next(&self) -> Instant {
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
        let mut at = self.next();
        if at > now {
            return None;
        }
        while at + self.period <= now {
            self.pulses.next(control);
            at = self.next();
        }
        Some((at, self.pulses.next(control)))
    }

    /// Counts a pulse that a wire's rest swallowed.
    pub(super) fn rest(&mut self) {
        self.rested += 1;
    }
}

/// What the output half keeps of a texture.
#[derive(Debug)]
pub(super) enum Texture {
    Train(Train),
    Contacts(Option<Weave>),
}

impl Texture {
    pub(super) fn new(carrier: Carrier, prescale: Prescale) -> Self {
        match carrier {
            Carrier::Display(pulses) => Self::Train(Train {
                pulses,
                period: Duration::from_micros(prescale.period_ns() / 1000),
                origin: None,
                rested: 0,
            }),
            Carrier::Contacts => Self::Contacts(None),
        }
    }

    /// Whether it has the display to itself.
    pub(super) const fn is_alone(&self) -> bool {
        matches!(self, Self::Train(_))
    }

    /// When it has something to do next.
    pub(super) fn next(&self) -> Instant {
        match self {
            Self::Train(train) => train.next(),
            Self::Contacts(weave) => weave.map_or(Instant::FAR_FUTURE, |w| w.next()),
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
mod tests {
    use super::*;
    use alloc::vec::Vec;

    /// 5.07904 ms.
    const CARRIER: Prescale = Prescale::new(30);
    const START: Instant = Instant::from_micros(58_500);
    const BURST: Duration = Duration::from_millis(35);

    fn weave(rate_hz: u32) -> Weave {
        let control = Control {
            delta_mu: Duration::ZERO,
            sigma: Duration::from_millis(1),
            rate_mhz: 1000 * rate_hz,
        };
        Weave::new(START, BURST, CARRIER, &control)
    }

    /// Beginnings and ends of its pulses since the burst began, played on time.
    fn played(mut weave: Weave) -> Vec<(u64, u64)> {
        let mut runs = Vec::new();
        while weave.next() < Instant::FAR_FUTURE {
            let (at, until) = weave.due(weave.next()).unwrap();
            runs.push((at.since(START).as_micros(), until.since(START).as_micros()));
        }
        runs
    }

    #[test]
    fn a_smooth_burst_is_whole_and_a_rough_one_has_every_third_period() {
        assert_eq!(played(weave(200)), [(0, 35_000)]);
        let third = [(0, 5_079), (15_237, 20_316), (30_474, 35_000)];
        assert_eq!(played(weave(66)), third);
        let half = played(weave(100));
        assert_eq!(half.first(), Some(&(0, 5_079)));
        assert_eq!(half.len(), 4);
    }

    #[test]
    fn every_burst_begins_with_a_pulse_and_pulses_grow_with_the_rate() {
        let mut before = 0;
        for rate_hz in 1..=1500 {
            let weave = weave(rate_hz);
            let pulses = weave.pulses.count_ones();
            assert!(weave.pulses & 1 == 1 && pulses >= before && pulses <= 7);
            before = pulses;
        }
        assert_eq!(before, 7);
    }

    #[test]
    fn fewer_pulses_are_wider_by_the_root() {
        let of = |rate_hz: u32| gain(1000 * rate_hz, CARRIER.period_ns());
        assert!((of(49) - 2.004_5).abs() < 1e-3, "{}", of(49));
        assert!((of(197) - 1.0).abs() < 1e-6 && (of(1500) - 1.0).abs() < 1e-6);
        assert!(of(0).is_finite());
    }

    #[test]
    fn missed_pulses_are_left_out() {
        let mut late = weave(66);
        let now = START + Duration::from_millis(17);
        let due = late.due(now).map(|(at, _)| at.since(START).as_micros());
        assert_eq!(due, Some(15_237));
        assert_eq!(late.due(START + Duration::from_millis(40)), None);
        assert_eq!(late.next(), Instant::FAR_FUTURE);
    }

    #[test]
    fn wires_widen_alike_and_never_past_the_limit() {
        let ticks = |values: [u16; 3]| values.map(Ticks::new);
        let widened = |rate_hz, widths| {
            let mut widths = ticks(widths);
            weave(rate_hz).widen(&mut widths, Ticks::new(148));
            widths
        };
        assert_eq!(widened(66, [0, 40, 80]), ticks([0, 61, 122])); // root of 7 / 3
        assert_eq!(widened(66, [0, 50, 100]), ticks([0, 74, 148]));
        assert_eq!(widened(200, [0, 50, 100]), ticks([0, 50, 100]));
        // What is too wide already, the guard narrows.
        assert_eq!(widened(66, [0, 50, 160]), ticks([0, 50, 160]));
        assert_eq!(widened(66, [0; 3]), ticks([0; 3]));
    }
}
