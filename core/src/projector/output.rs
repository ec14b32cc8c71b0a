//! The display's half of the loop: at each onset the newest contacts become stimuli, pass the guard and
//! go out; at each end they go off.

use alloc::boxed::Box;
use alloc::vec;

use crate::bus::Actuators;
use crate::guard::Guard;
use crate::illusion::{Calibration, Display, Drive, Illusion, Mixer, Planned, Sharing, Target};
use crate::schedule::{Stimulus, Timing};
use crate::texture::Control;
use crate::units::{Board, Duration, Instant, Milliamps, Ticks};

use super::strokes::Strokes;
use super::texture::Carrier;
use super::weave::{Texture, Weave, gain};
use super::{Cause, Observer};

/// How stimuli are made.
#[derive(Debug)]
pub struct OutputSettings {
    /// Stimulus duration and onset asynchrony.
    pub timing: Timing,
    /// From a contact to activations.
    pub illusion: Box<dyn Illusion>,
    /// How several contacts share wires.
    pub sharing: Sharing,
    /// What this person needs of each wire.
    pub calibration: Calibration,
    /// Smallest step of a contact that is rendered, as a part of the smallest gap between wires; 0
    /// renders every step.
    pub smallest_step: f32,
    /// Strokes that are known beforehand; while one runs, live contacts wait.
    pub strokes: Box<[Planned]>,
    /// Activation to duty.
    pub drive: Drive,
    /// Current while a pulse is high.
    pub peak: Milliamps,
}

/// The output half by itself: for whoever has targets or textures from elsewhere than this loop's sensors.
#[derive(Debug)]
pub struct Output {
    display: Display,
    timing: Timing,
    drive: Drive,
    peak: Milliamps,
    calibration: Calibration,
    mixer: Mixer,
    strokes: Strokes,
    texture: Option<Texture>,
    guard: Guard,
    /// Pulse width by wire; the same memory for every onset.
    widths: Box<[Ticks]>,
    /// Stimuli of one board at one onset.
    stimuli: Box<[Stimulus]>,
    /// Highest board number in use.
    boards: u8,
    next_onset: Instant,
}

impl Output {
    /// Nothing is driven yet; the first onset is due at once.
    pub fn new(display: Display, settings: OutputSettings, guard: Guard) -> Self {
        let n = display.wires().len();
        let blank = Stimulus {
            wire: 0,
            width: Ticks::ZERO,
            peak: settings.peak,
            at: Instant::ZERO,
            until: Instant::ZERO,
        };
        let boards = display.wires().iter().map(|w| w.board.0).max().unwrap_or(0);
        Self {
            timing: settings.timing,
            drive: settings.drive,
            peak: settings.peak,
            calibration: settings.calibration,
            mixer: Mixer::new(settings.illusion, settings.sharing, n),
            strokes: Strokes::new(&settings.strokes),
            texture: None,
            guard,
            widths: vec![Ticks::ZERO; n].into(),
            stimuli: vec![blank; n].into(),
            boards,
            next_onset: Instant::ZERO,
            display,
        }
    }

    /// With a texture on this carrier.
    pub fn carry(&mut self, carrier: Carrier) {
        self.texture = Some(Texture::new(carrier, self.guard.prescale()));
    }

    /// Pulses of a texture that were left out for a wire to rest.
    pub(super) fn rested(&self) -> u64 {
        self.texture.as_ref().map_or(0, Texture::rested)
    }

    pub(super) const fn guard(&self) -> &Guard {
        &self.guard
    }

    /// The guard, to tell it what was heard.
    pub const fn guard_mut(&mut self) -> &mut Guard {
        &mut self.guard
    }

    pub(super) const fn display(&self) -> &Display {
        &self.display
    }

    pub(super) const fn timing(&self) -> Timing {
        self.timing
    }

    pub(super) const fn drive(&self) -> Drive {
        self.drive
    }

    /// Whether an onset is due.
    pub(super) fn is_due(&self, now: Instant) -> bool {
        now >= self.next_onset
    }

    /// When this half has something to do next.
    pub fn next(&self) -> Instant {
        let texture = self
            .texture
            .as_ref()
            .map_or(Instant::FAR_FUTURE, Texture::next);
        let onset = self.next_onset.min(self.strokes.next()).min(texture);
        self.guard.next_expiry().map_or(onset, |end| end.min(onset))
    }

    /// Ends what has ended and, when an onset is due, projects `targets` with the `texture` that is felt now. An
    /// onset that was missed by more than half an SOA is left out: the grid from t = 0 stands whatever happens.
    ///
    /// Returns whether an onset was projected.
    ///
    /// # Errors
    /// The actuators' error; nothing has been switched off for it.
    pub fn poll<A: Actuators>(
        &mut self,
        now: Instant,
        targets: &[Target],
        texture: Option<&Control>,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<bool, A::Error> {
        if self.is_due(now) && self.strokes.hold(self.next_onset) {
            self.advance_grid(now);
        }
        if let Some((onset, dab)) = self.strokes.due(now) {
            let target = Target {
                place: dab.place,
                weight: 1.0,
            };
            if let Some(Texture::Contacts(weave)) = &mut self.texture {
                *weave = None; // the widths are the stroke's now
            }
            self.activate(&[target]);
            self.render(onset, onset + dab.duration, actuators, observer)?;
            observer.onset(onset, &[target]);
            return Ok(true);
        }
        if self.texture.as_ref().is_some_and(Texture::is_alone) {
            return self.run(now, texture, actuators, observer);
        }
        if !self.is_due(now) {
            if let Some(Texture::Contacts(Some(weave))) = &mut self.texture
                && let Some((at, until)) = weave.due(now)
            {
                self.render(at, until, actuators, observer)?;
            } else {
                self.expire(now, actuators)?;
            }
            return Ok(false);
        }
        let onset = self.advance_grid(now);
        let turn = onset.as_micros() / self.timing.soa.as_micros();
        let targets = self.mixer.rendered(targets, turn);
        self.activate(targets);
        let until = onset + self.timing.duration;
        let until = self.weave(onset, texture).unwrap_or(until);
        self.render(onset, until, actuators, observer)?;
        observer.onset(onset, targets);
        Ok(true)
    }

    /// Thins out the burst of an onset; returns when its first pulses end.
    fn weave(&mut self, onset: Instant, texture: Option<&Control>) -> Option<Instant> {
        let Some(Texture::Contacts(weave)) = &mut self.texture else {
            return None;
        };
        let prescale = self.guard.prescale();
        *weave = texture.map(|c| Weave::new(onset, self.timing.duration, prescale, c));
        let weave = weave.as_mut()?;
        weave.widen(&mut self.widths, self.guard.widest());
        weave.due(onset).map(|(_, until)| until)
    }

    /// A texture that has the display to itself: its next period, and an onset without a contact where one is due.
    fn run<A: Actuators>(
        &mut self,
        now: Instant,
        texture: Option<&Control>,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<bool, A::Error> {
        let onset = self.is_due(now).then(|| self.advance_grid(now));
        let mut due = None;
        if let Some(Texture::Train(train)) = &mut self.texture {
            if let Some((at, fired)) = train.due(now, texture) {
                let period_ns = self.guard.prescale().period_ns();
                let gain = texture.map_or(1.0, |c| gain(c.rate_mhz, period_ns));
                let width = |wire| {
                    let one = self.drive.width(self.calibration.apply(wire, 1.0));
                    // Rounded down: the widest stays within the limit.
                    let wide = (f32::from(one.get()) * gain) as u16;
                    Ticks::new(wide.min(self.guard.widest().get()).max(one.get()))
                };
                for (wire, (out, fired)) in self.widths.iter_mut().zip(fired).enumerate() {
                    *out = if *fired { width(wire) } else { Ticks::ZERO };
                }
                due = Some((at, train.next()));
            }
            if let Some((at, until)) = due {
                for (wire, width) in self.widths.iter_mut().enumerate() {
                    if *width > Ticks::ZERO && !self.guard.has_time(wire, at, until) {
                        *width = Ticks::ZERO;
                        train.rest();
                    }
                }
            }
        }
        if let Some((at, until)) = due {
            self.render(at, until, actuators, observer)?;
        } else {
            self.expire(now, actuators)?;
        }
        if let Some(onset) = onset {
            observer.onset(onset, &[]);
        }
        Ok(onset.is_some())
    }

    /// Switches off what has ended.
    fn expire<A: Actuators>(&mut self, now: Instant, actuators: &mut A) -> Result<(), A::Error> {
        if self.guard.next_expiry().is_some_and(|end| end <= now) {
            for board in 0..=self.boards {
                let update = self.guard.expire(now, Board(board));
                if update.channels().iter().any(Option::is_some) {
                    actuators.apply(&update)?;
                }
            }
        }
        Ok(())
    }

    /// The wires' stimuli, from an onset to an end, through the guard and out.
    fn render<A: Actuators>(
        &mut self,
        onset: Instant,
        until: Instant,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<(), A::Error> {
        for board in 0..=self.boards {
            let count = self.collect(Board(board), onset, until);
            let update = self
                .guard
                .admit(onset, Board(board), &self.stimuli[..count], |entry| {
                    observer.entry(&entry);
                });
            if update.channels().iter().any(Option::is_some) {
                actuators.apply(&update)?;
            }
        }
        Ok(())
    }

    /// Opens the guard's latch if nothing is wrong any more.
    pub(super) fn reset<A: Actuators>(
        &mut self,
        now: Instant,
        actuators: &mut A,
    ) -> Result<(), Cause> {
        // The outputs last: while another cause stands there is no need to trouble their bus.
        self.guard.ready(now)?;
        actuators.all_off().map_err(|_| Cause::ActuatorError)?;
        self.guard.reset(now)
    }

    /// Everything off, now, and the guard latched.
    pub(super) fn all_off<A: Actuators>(
        &mut self,
        now: Instant,
        cause: Cause,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<(), A::Error> {
        let result = actuators.all_off();
        self.guard.latch(cause);
        self.guard.all_off(now);
        for board in 0..=self.boards {
            observer.all_off(now, Board(board), cause);
        }
        result
    }

    /// The newest grid point not later than `now`; the next onset is the one after it.
    fn advance_grid(&mut self, now: Instant) -> Instant {
        let soa = self.timing.soa.as_micros();
        let late = now.since(self.next_onset).as_micros() / soa;
        let onset = self.next_onset + Duration::from_micros(late.saturating_mul(soa));
        self.next_onset = onset + self.timing.soa;
        onset
    }

    /// The pulse width of every wire.
    fn activate(&mut self, targets: &[Target]) {
        let activation = self.mixer.activate(targets);
        for (wire, (width, &a)) in self.widths.iter_mut().zip(activation).enumerate() {
            *width = self.drive.width(self.calibration.apply(wire, a));
        }
    }

    /// Stimuli of the active wires of one board; returns how many.
    fn collect(&mut self, board: Board, onset: Instant, until: Instant) -> usize {
        let mut count = 0;
        for (index, (wire, &width)) in self.display.wires().iter().zip(&self.widths).enumerate() {
            if wire.board != board || width.get() == 0 {
                continue;
            }
            self.stimuli[count] = Stimulus {
                wire: index as u16, // a display has at most 256 wires
                width,
                peak: self.peak,
                at: onset,
                until,
            };
            count += 1;
        }
        count
    }
}
