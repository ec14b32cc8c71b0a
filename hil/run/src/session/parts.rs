//! Parts of a session, and its state between two turns.

use palpate_core::driver::Traffic;
use palpate_core::projector::Projector;
use palpate_core::units::Instant;
use palpate_files::Setup;

use super::Session;
use crate::display_end::DisplayEnd;
use crate::effort::FrameCost;
use crate::failure::Failure;
use crate::pass::Again;
use crate::picture::Look;
use crate::recorder::Recorder;
use crate::skin_end::SkinEnd;

impl<S: SkinEnd, D: DisplayEnd> Session<S, D> {
    /// Plans the hot pass that may come in the middle of a run on a setup's bench: once a person asks for it, or a cold face
    /// has brought martensite back.
    pub fn plan_passes(&mut self, setup: &Setup) {
        self.again = Again::new(setup, &self.projector);
    }

    /// Begins such a pass at the next onset without a contact. Returns what becomes of it, for a note.
    pub(crate) fn pass_again(&mut self, now: Instant) -> String {
        self.again.begin(&mut self.projector, now)
    }

    /// The time of the newest turn.
    pub const fn now(&self) -> Instant {
        self.now
    }

    /// Time at which the next turn is due.
    pub const fn next(&self) -> Instant {
        self.next
    }

    /// Failure that ended the run or will end it.
    pub const fn failure(&self) -> Option<&Failure> {
        self.failure.as_ref()
    }

    /// Notes the failure that ended the run, unless one is noted already.
    pub fn set_failure(&mut self, failure: Failure) {
        self.failure.get_or_insert(failure);
    }

    /// Takes out the failure that ended the run or will end it.
    pub const fn take_failure(&mut self) -> Option<Failure> {
        self.failure.take()
    }

    /// The loop.
    pub const fn projector(&self) -> &Projector {
        &self.projector
    }

    /// The loop, for work that sorts (its health) or changes nothing that is driven.
    pub const fn projector_mut(&mut self) -> &mut Projector {
        &mut self.projector
    }

    /// The sensor end.
    pub const fn skin(&mut self) -> &mut S {
        &mut self.skin
    }

    /// The display end.
    pub const fn display(&mut self) -> &mut D {
        &mut self.display
    }

    /// Recorder of the session: events, and their counts.
    pub const fn recorder(&mut self) -> &mut Recorder {
        &mut self.recorder
    }

    /// Display end, loop and recorder at once.
    pub const fn all(&mut self) -> (&mut D, &mut Projector, &mut Recorder) {
        (&mut self.display, &mut self.projector, &mut self.recorder)
    }

    /// Sensor end and recorder, for views.
    pub const fn seen(&self) -> (&S, &Recorder) {
        (&self.skin, &self.recorder)
    }

    /// Skin and recorder, and a look at the state now.
    pub const fn look(&self) -> (&S, &Recorder, Look<'_, D>) {
        let look = Look {
            display: &self.display,
            projector: &self.projector,
            now: self.now,
        };
        (&self.skin, &self.recorder, look)
    }

    /// Computing times of the frames since the last time.
    pub fn take_costs(&mut self) -> Vec<FrameCost> {
        self.times.take()
    }

    /// Keeps the costs of some frames in place of all of them.
    pub const fn thin_costs(&mut self, thin: bool) {
        self.times.thin = thin;
    }

    /// Counts of updates and channels that were written on the actuator buses, and of those that had no need.
    pub fn traffic(&mut self) -> Traffic {
        self.display.traffic()
    }
}
