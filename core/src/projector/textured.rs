//! The output's textures: pulses that have the display to themselves, and bursts of contacts that are thinned out.

use crate::driver::Actuators;
use crate::render::{Density, Stated};
use crate::schedule::stagger;
use crate::texture::Control;
use crate::units::{Duration, Instant, Ticks};

use super::texture::Carrier;
use super::update::Update;
use super::weave::{Texture, Weave, gain};
use super::{Observer, Output};

/// Strength of the pulses that are due.
#[derive(Clone, Copy, Debug)]
enum Strength {
    /// A texture's level, at f_PWM in millihertz.
    Level(u32, Density),
    /// A share of the strongest pulse: a tap's.
    Share(f32),
}

/// Nominal oscillator of a chip over the slowest seen: all that a chip does may take as much longer.
const SLOWEST: (u64, u64) = (25, 23);

impl Output {
    /// Adds a texture on this carrier.
    pub fn carry(&mut self, carrier: Carrier) {
        let length = self.pulse_time();
        self.texture = Some(Texture::new(carrier, self.guard.prescale(), length));
    }

    /// Time for which a texture's single pulse is on. Between pulses all channels of the boards are off, so the counters
    /// are held and begin with the next pulse, as with a contact's burst. Each wire then needs the time to its own pulse's
    /// end at the slowest oscillator. Beside another display's wires a counter runs on, and a pulse needs a whole period.
    fn pulse_time(&self) -> Duration {
        let (prescale, widest) = (self.guard.prescale(), self.guard.widest());
        let wires = self.display().wires().iter();
        let last = wires.map(|wire| stagger(wire.channel, widest).1).max();
        let last_ns = u64::from(last.unwrap_or(0)) * prescale.tick_ns() * SLOWEST.0;
        let alone = Duration::from_micros(last_ns.div_ceil(1000 * SLOWEST.1));
        let period = Duration::from_micros(prescale.period_ns() / 1000);
        match self.guard.plant().bus {
            Duration::ZERO => alone.min(period),
            _ => period,
        }
    }

    /// Thins out the burst of an onset; returns the time for which it is on and the pulses that are left.
    pub(super) fn weave(&mut self, onset: Instant, texture: Option<&Control>) -> Option<Stated> {
        let Some(Texture::Contacts(weave)) = &mut self.texture else {
            return None;
        };
        let (length, prescale) = (self.timing.duration, self.guard.prescale());
        *weave = texture.map(|control| Weave::new(onset, length, prescale, control));
        weave.as_ref().map(|weave| weave.stated(&self.guard))
    }

    /// Widens what is left of a thinned-out burst where no renderer did; returns when its first pulses end.
    pub(super) fn widen(&mut self, onset: Instant) -> Option<Instant> {
        let Some(Texture::Contacts(Some(weave))) = &mut self.texture else {
            return None;
        };
        if self.renderer.is_none() {
            weave.widen(&mut self.widths, self.guard.widest());
        }
        weave.due(onset).map(|(_, until)| until)
    }

    /// Plays a texture that has the display to itself: its next period, and an onset without a contact where one is due.
    pub(super) fn run<U: Update, A: Actuators<U> + ?Sized>(
        &mut self,
        now: Instant,
        texture: Option<&Control>,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<bool, A::Error> {
        let onset = self.is_due(now).then(|| self.advance_grid(now));
        if let Some((at, until)) = self.pulse(now, texture) {
            self.render(now, (at, Some(until)), actuators, observer)?;
        } else {
            self.expire(now, actuators)?;
        }
        if let Some(onset) = onset {
            observer.onset(onset, &[]);
        }
        Ok(onset.is_some())
    }

    /// Finds the widths of the period or of the tap's pulse that is due; returns its beginning and its end.
    fn pulse(&mut self, now: Instant, texture: Option<&Control>) -> Option<(Instant, Instant)> {
        const PULSES: Ticks = Ticks::new(1);
        let Some(Texture::Train(train)) = &mut self.texture else {
            return None;
        };
        let mut due = None;
        if let Some((at, fired)) = train.due(now, texture) {
            for (out, fired) in self.widths.iter_mut().zip(fired) {
                *out = if *fired { PULSES } else { Ticks::ZERO };
            }
            let control = texture?;
            let strength = Strength::Level(control.rate_mhz, train.density(control));
            due = Some((at, train.ends(at), strength));
        }
        if let Some((at, share)) = train.tap_due(now) {
            self.widths.fill(PULSES);
            due = Some((at, train.ends(at), Strength::Share(share)));
        }
        let (at, until, strength) = due?;
        for (wire, width) in self.widths.iter_mut().enumerate() {
            if *width > Ticks::ZERO && !self.guard.has_time(wire, at, until) {
                *width = Ticks::ZERO;
                train.rest();
            }
        }
        let (span, widths) = ((at, until), &mut self.widths);
        match (&mut self.renderer, strength) {
            (Some(renderer), Strength::Level(_, density)) => {
                renderer.texture(span, density, widths, &self.guard);
            }
            (Some(renderer), Strength::Share(share)) => {
                renderer.tap(span, share, widths, &self.guard);
            }
            (None, _) => self.publish(strength),
        }
        Some((at, until))
    }

    /// Replaces widths that are not zero by those of a published law.
    fn publish(&mut self, strength: Strength) {
        let widest = self.guard.widest().get();
        let period_ns = self.guard.prescale().period_ns();
        // Rounded down: the widest stays within the limit.
        let width = |wire| match strength {
            Strength::Level(rate_mhz, _) => {
                let one = self.drive.width(self.calibration.apply(wire, 1.0)).get();
                let wide = (f32::from(one) * gain(rate_mhz, period_ns)) as u16;
                wide.min(widest).max(one)
            }
            Strength::Share(share) => {
                (f32::from(widest) * self.calibration.apply(wire, share).min(1.0)) as u16
            }
        };
        for (wire, out) in self.widths.iter_mut().enumerate() {
            if *out > Ticks::ZERO {
                *out = Ticks::new(width(wire));
            }
        }
    }
}
