//! The display's half of the loop: at each onset the newest contacts become stimuli, pass the guard and
//! go out; at each end they go off.

use alloc::boxed::Box;
use alloc::vec;

use crate::driver::Actuators;
use crate::guard::Guard;
use crate::illusion::{Calibration, Display, Drive, Illusion, Mixer, Planned, Sharing, Target};
use crate::render::{RenderSettings, Renderer, Stated};
use crate::schedule::{Share, Stimulus, Timing};
use crate::texture::Control;
use crate::units::{Board, Duration, Instant, Ticks};

use super::pass::Passing;
use super::strokes::Strokes;
use super::update::Update;
use super::weave::Texture;
use super::{Cause, Observer};

/// Settings of an output: how stimuli are made.
#[derive(Debug)]
pub struct OutputSettings {
    /// Stimulus duration and onset asynchrony.
    pub timing: Timing,
    /// Law from a contact to activations.
    pub illusion: Box<dyn Illusion>,
    /// Rule by which several contacts share wires.
    pub sharing: Sharing,
    /// Calibration of this person by wire.
    pub calibration: Calibration,
    /// Strokes that are known beforehand; while one runs, live contacts wait.
    pub strokes: Box<[Planned]>,
    /// Conversion of activation to duty.
    pub drive: Drive,
    /// Division of a level into width and current.
    pub share: Share,
    /// Renderer in place of all but timing, strokes and current:
    /// pulses that are felt at the contacts within what heat allows.
    pub render: Option<RenderSettings>,
}

/// The output half, alone or in the loop: targets on the display become stimuli, which pass the guard.
///
/// Alone, it takes targets from code. [`Self::hear`] says that they are alive: without it for 100 ms everything goes
/// off and stays off until [`Self::reset`].
///
/// ```
/// use palpate_core::driver::Actuators;
/// use palpate_core::guard::Guarded;
/// use palpate_core::illusion::{Display, Target, DisplayWire};
/// use palpate_core::projector::{Cause, Output};
/// use palpate_core::units::{Board, Channel, Instant, Point};
///
/// /// A driver that counts the updates of its only board.
/// struct Count(u32);
///
/// impl Actuators for Count {
///     type Error = core::convert::Infallible;
///
///     fn apply(&mut self, _update: &Guarded) -> Result<(), Self::Error> {
///         self.0 += 1;
///         Ok(())
///     }
///
///     fn all_off(&mut self) -> Result<(), Self::Error> {
///         Ok(())
///     }
/// }
///
/// let wire = |n: u8| DisplayWire {
///     place: Point::new(10.0 * f32::from(n), 0.0),
///     board: Board(0),
///     channel: Channel(n),
/// };
/// let display = Display::new(&[wire(0), wire(1)]).unwrap();
/// let mut output = Output::builder(display).build().unwrap();
/// let between = Target { place: Point::new(5.0, 0.0), weight: 1.0 };
/// let (mut board, mut now) = (Count(0), Instant::ZERO);
/// while now < Instant::from_micros(585_000) {
///     output.hear(now);
///     output.turn(now, &[between], None, &mut board, &mut ()).unwrap();
///     now = output.next();
/// }
/// assert_eq!(board.0, 10); // five onsets, five ends
/// output.all_off(now, Cause::End, &mut board, &mut ()).unwrap();
/// ```
#[derive(Debug)]
pub struct Output {
    display: Display,
    pub(super) timing: Timing,
    pub(super) drive: Drive,
    share: Share,
    pub(super) calibration: Calibration,
    mixer: Mixer,
    pub(super) renderer: Option<Renderer>,
    pub(super) strokes: Strokes,
    pub(super) texture: Option<Texture>,
    pub(super) pass: Option<Passing>,
    pub(super) guard: Guard,
    /// Pulse width by wire; the same memory for every onset.
    pub(super) widths: Box<[Ticks]>,
    /// Time for which each wire is on, where nothing else says.
    lengths: Box<[Duration]>,
    /// Stimuli of one board at one onset.
    stimuli: Box<[Stimulus]>,
    /// Highest board number in use.
    pub(super) boards: u8,
    /// Cause for which everything was switched off, as long as it is not known to be off.
    pub(super) unsettled: Option<Cause>,
    pub(super) next_onset: Instant,
}

impl Output {
    /// An output that drives nothing yet; the first onset is due at once.
    pub fn new(display: Display, settings: OutputSettings, guard: Guard) -> Self {
        let n = display.wires().len();
        let blank = settings.share.stimulus(Ticks::ZERO);
        let boards = display.wires().iter().map(|w| w.board.0).max().unwrap_or(0);
        Self {
            timing: settings.timing,
            drive: settings.drive,
            share: settings.share,
            calibration: settings.calibration,
            mixer: Mixer::new(settings.illusion, settings.sharing, n),
            strokes: Strokes::new(&settings.strokes),
            texture: None,
            pass: None,
            renderer: (settings.render).map(|render| Renderer::new(render, &guard, n)),
            guard,
            lengths: vec![settings.timing.duration; n].into(),
            widths: vec![Ticks::ZERO; n].into(),
            stimuli: vec![blank; n].into(),
            boards,
            unsettled: None,
            next_onset: Instant::ZERO,
            display,
        }
    }

    /// Tells that a surface of this hardness, 0 to 1, is met or left at
    /// `at`: a tap is felt, where a texture has the display to itself.
    pub fn tap(&mut self, at: Instant, hardness: f64) {
        self.texture.iter_mut().for_each(|t| t.tap(at, hardness));
    }

    /// The texture on this output, if there is one.
    pub(super) const fn texture(&self) -> Option<&Texture> {
        self.texture.as_ref()
    }

    /// Renderer of contacts, where the law chooses their pulses.
    pub const fn renderer(&self) -> Option<&Renderer> {
        self.renderer.as_ref()
    }

    /// The guard.
    pub const fn guard(&self) -> &Guard {
        &self.guard
    }

    /// The display.
    pub const fn display(&self) -> &Display {
        &self.display
    }

    /// Stimulus duration and onset asynchrony in force.
    pub const fn timing(&self) -> Timing {
        self.timing
    }

    pub(super) const fn drive(&self) -> Drive {
        self.drive
    }

    /// Pulse width of one wire for a contact on it with this weight, where the limits bear it.
    pub fn width(&self, weight: f32) -> Ticks {
        let published = || self.drive.width(weight);
        self.renderer
            .as_ref()
            .map_or_else(published, |r| r.width(weight))
    }

    /// Tells the watchdog that the source of targets was alive at `at`.
    pub fn hear(&mut self, at: Instant) {
        self.guard.hear(at);
    }

    pub(super) fn is_due(&self, now: Instant) -> bool {
        now >= self.next_onset
    }

    /// Tells whether targets handed in now can be rendered: an onset is due, and their source is alive.
    pub(super) fn takes_targets(&self, now: Instant) -> bool {
        self.is_due(now) && !self.guard.is_stale(now)
    }

    /// Time at which this half has to be called next, whatever comes in; earlier calls do no harm.
    pub fn next(&self) -> Instant {
        let texture = self
            .texture
            .as_ref()
            .map_or(Instant::FAR_FUTURE, Texture::next);
        let onset = self.next_onset.min(self.strokes.next()).min(texture);
        let guarded = [self.guard.next_expiry(), self.guard.deadline()];
        guarded.into_iter().flatten().fold(onset, Instant::min)
    }

    /// Ends what has ended and, when an onset is due, projects `targets` with the `texture` that is felt now. Of onsets
    /// that were missed, all but the newest are left out, and of that one each stimulus that would be over by now: the grid
    /// from t = 0 stands whatever happens. What a dead source wants is not projected.
    ///
    /// The guard only looks on where the actuators are emulated registers, which take [`Observed`](crate::guard::Observed):
    /// they get every stimulus as it is, and the observer hears what the guard would have changed, refused or stopped.
    ///
    /// Returns whether an onset was projected.
    ///
    /// # Errors
    /// The driver's first error, after switching everything off.
    pub fn turn<U: Update, A: Actuators<U> + ?Sized>(
        &mut self,
        now: Instant,
        targets: &[Target],
        texture: Option<&Control>,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<bool, A::Error> {
        match self.guard.watch(now) {
            Some(cause) if U::STOPS => self.all_off(now, cause, actuators, observer)?,
            Some(cause) => {
                if self.guard.latched().is_none() {
                    observer.observed_stop(now, cause);
                }
                self.guard.latch(cause);
            }
            None if !U::STOPS && self.guard.latched().is_some() => {
                // Nothing stopped: the guard looks on again once it would let a person start anew.
                let _ = self.guard.reset(now);
            }
            None => {}
        }
        let (targets, texture) = match self.guard.is_stale(now) {
            true => (&[][..], None),
            false => (targets, texture),
        };
        match self.project(now, targets, texture, actuators, observer) {
            Ok(onset) if self.guard.overran() => {
                let stopped = self.all_off(now, Cause::Overrun, actuators, observer);
                stopped.map(|()| onset)
            }
            Err(error) => {
                // The first error is told; errors of the all-off have no place beside it.
                let _ = self.all_off(now, Cause::ActuatorError, actuators, observer);
                Err(error)
            }
            projected => projected,
        }
    }

    fn project<U: Update, A: Actuators<U> + ?Sized>(
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
                weight: dab.weight,
            };
            if let Some(Texture::Contacts(weave)) = &mut self.texture {
                *weave = None; // the widths are the stroke's now
            }
            let stated = Stated::whole(dab.duration);
            self.activate(onset, &[target], Some(stated));
            self.render(
                now,
                (onset, Some(onset + dab.duration)),
                actuators,
                observer,
            )?;
            observer.onset(onset, &[target]);
            return Ok(true);
        }
        if self.is_due(now)
            && let Some(wire) = self.pass_due(now, targets, texture)
        {
            return self.heat(now, wire, actuators, observer);
        }
        if self.texture.as_ref().is_some_and(Texture::is_alone) {
            return self.run(now, texture, actuators, observer);
        }
        if !self.is_due(now) {
            if let Some(Texture::Contacts(Some(weave))) = &mut self.texture
                && let Some((at, until)) = weave.due(now)
            {
                self.render(now, (at, Some(until)), actuators, observer)?;
            } else {
                self.expire(now, actuators)?;
            }
            return Ok(false);
        }
        let onset = self.advance_grid(now);
        let turn = onset.as_micros() / self.timing.soa.as_micros();
        let targets = self.mixer.rendered(targets, turn);
        let woven = self.weave(onset, texture);
        self.activate(onset, targets, woven);
        let until = self.widen(onset);
        self.render(now, (onset, until), actuators, observer)?;
        observer.onset(onset, targets);
        Ok(true)
    }

    /// Switches off what has ended.
    pub(super) fn expire<U: Update, A: Actuators<U> + ?Sized>(
        &mut self,
        now: Instant,
        actuators: &mut A,
    ) -> Result<(), A::Error> {
        if self.guard.next_expiry().is_some_and(|end| end <= now) {
            for board in 0..=self.boards {
                let update = U::end(&mut self.guard, now, Board(board));
                self.apply(update, now, actuators)?;
            }
        }
        Ok(())
    }

    /// Puts the wires' stimuli through the guard and out, from an onset to an end or to each wire's own.
    pub(super) fn render<U: Update, A: Actuators<U> + ?Sized>(
        &mut self,
        now: Instant,
        (onset, until): (Instant, Option<Instant>),
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<(), A::Error> {
        for board in 0..=self.boards {
            let count = self.collect(now, Board(board), (onset, until));
            let (guard, stimuli) = (&mut self.guard, &self.stimuli[..count]);
            let update = U::begin(guard, onset, Board(board), stimuli, |entry| {
                self.pass.iter_mut().for_each(|pass| pass.answer(&entry));
                observer.entry(&entry);
            });
            self.apply(update, onset, actuators)?;
        }
        Ok(())
    }

    /// Puts an update on the outputs, asked for at `at`.
    fn apply<U: Update, A: Actuators<U> + ?Sized>(
        &mut self,
        update: Option<U>,
        at: Instant,
        actuators: &mut A,
    ) -> Result<(), A::Error> {
        if let Some(update) = update {
            actuators.apply(&update)?;
            update.confirm(&mut self.guard, actuators.confirmed(at));
        }
        Ok(())
    }

    /// The newest grid point not later than `now`; the next onset is the one after it.
    pub(super) fn advance_grid(&mut self, now: Instant) -> Instant {
        let soa = self.timing.soa.as_micros();
        let late = now.since(self.next_onset).as_micros() / soa;
        let onset = self.next_onset + Duration::from_micros(late.saturating_mul(soa));
        self.next_onset = onset + self.timing.soa;
        onset
    }

    /// Finds the pulse width of every wire and the time for which it is on, where that is not stated.
    fn activate(&mut self, onset: Instant, targets: &[Target], stated: Option<Stated>) {
        if let Some(renderer) = &mut self.renderer {
            let volleys = renderer.render(onset, targets, stated, &self.guard);
            let outputs = self.widths.iter_mut().zip(&mut self.lengths);
            for ((width, length), volley) in outputs.zip(volleys) {
                (*width, *length) = (volley.width, volley.length);
            }
            return;
        }
        let activation = self.mixer.activate(targets);
        for (wire, (width, &a)) in self.widths.iter_mut().zip(activation).enumerate() {
            *width = self.drive.width(self.calibration.apply(wire, a));
        }
        self.mixer.last(&mut self.lengths, self.timing.duration);
    }

    /// Stimuli of the active wires of one board that go on after `now`; returns how many.
    fn collect(
        &mut self,
        now: Instant,
        board: Board,
        (onset, until): (Instant, Option<Instant>),
    ) -> usize {
        let most = onset + self.guard.limits().burst;
        let mut count = 0;
        for (index, (wire, &width)) in self.display.wires().iter().zip(&self.widths).enumerate() {
            if wire.board != board || width.get() == 0 {
                continue;
            }
            let until = until.unwrap_or(onset + self.lengths[index]);
            if until.min(most) <= now {
                // The guard counts a burst from its onset: this one would be an overrun that no wire has seen.
                continue;
            }
            self.stimuli[count] = Stimulus {
                wire: index as u16, // a display has at most 256 wires
                at: onset,
                until,
                ..self.share.stimulus(width)
            };
            count += 1;
        }
        count
    }
}
