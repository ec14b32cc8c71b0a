//! A hot pass in the loop: its bursts go the way of every stimulus, through the guard.

use crate::driver::Actuators;
use crate::texture::Control;
use crate::units::{Instant, Ticks};

use super::update::Update;
use super::{HotPass, Observer, Output, Passing, Projector, Target};

impl Output {
    /// Begins a hot pass of all wires at the next pause after `from`. Another one that is on its way ends there.
    pub fn pass(&mut self, pass: HotPass, from: Instant) {
        let wires = self.display().wires().len();
        self.pass = Some(Passing::new(pass, wires, from));
    }

    /// The newest hot pass, on its way or over.
    pub const fn passing(&self) -> Option<&Passing> {
        self.pass.as_ref()
    }

    /// The wire that a pass heats at this onset: nothing is felt now, nothing is on, and no stroke or stop comes between.
    pub(super) fn pass_due(
        &self,
        now: Instant,
        targets: &[Target],
        texture: Option<&Control>,
    ) -> Option<u16> {
        let passing = self.pass.as_ref()?;
        let wire = passing.due(now)?;
        let ends = now + passing.pass().burst + self.guard.surplus();
        let is_free = self.guard.next_expiry().is_none() && self.guard.latched().is_none();
        let is_heard = !self.guard.is_stale(now);
        let is_pause = targets.is_empty() && texture.is_none() && self.strokes.next() > ends;
        (is_free && is_heard && is_pause).then_some(wire)
    }

    /// Heats a wire from this onset of the grid on. Onsets before the burst's end are left out.
    ///
    /// # Errors
    /// The driver's first error.
    pub(super) fn heat<U: Update, A: Actuators<U> + ?Sized>(
        &mut self,
        now: Instant,
        wire: u16,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<bool, A::Error> {
        let onset = self.advance_grid(now);
        let Some(passing) = &mut self.pass else {
            return Ok(true);
        };
        let HotPass { width, burst, .. } = *passing.pass();
        let until = onset + burst;
        if until > now {
            passing.begin(onset);
            self.widths.fill(Ticks::ZERO);
            if let Some(own) = self.widths.get_mut(usize::from(wire)) {
                *own = width;
            }
            self.render(now, (onset, Some(until)), actuators, observer)?;
            let ends = until + self.guard.surplus();
            while self.next_onset < ends {
                self.next_onset += self.timing().soa;
            }
        }
        observer.onset(onset, &[]);
        Ok(true)
    }
}

impl Projector {
    /// Begins a hot pass, as [`Output::pass`] does.
    pub fn pass(&mut self, pass: HotPass, from: Instant) {
        self.output.pass(pass, from);
    }

    /// The newest hot pass, as [`Output::passing`] has it.
    pub const fn passing(&self) -> Option<&Passing> {
        self.output.passing()
    }
}
