//! The display end of a run: boards behind a bus, the line that cuts them, and the hardware on their outputs.

use palpate_core::driver::{Driver, DriverError, Traffic};
use palpate_core::projector::{Projector, Update};
use palpate_core::units::Instant;
use palpate_emulators::display::observed::RegisterWriter;
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::{Aside, Standing};
use palpate_files::Setup;
use palpate_records::i2c::Transfer;
use palpate_records::trace::{Event, Header};

use crate::failure::Failure;
pub use crate::output_enable::OutputEnable;
use crate::recorder::Recorder;
use crate::script::FaultReport;
use crate::skin_end::FaultySkin;
use crate::{Keep, Sound};

/// Transfers kept of a run's actuator bus, the last ones: some hours of them.
pub(crate) const I2C_LOG: usize = 1 << 20;

/// The display end of a session. Methods with an empty default concern emulated hardware alone.
pub trait DisplayEnd {
    /// Kind of update that its boards take.
    type Update: Update;

    /// The boards, and the line that cuts them.
    fn parts(&mut self) -> (&mut dyn Driver<Self::Update>, &dyn OutputEnable);

    /// Emulated registers, where the guard only looks on: its stops are noted and end nothing.
    fn registers(&mut self) -> Option<&mut RegisterWriter> {
        None
    }

    /// Prepares the display for a call of the loop.
    fn before_call(&mut self, now: Instant, projector: &mut Projector, events: &mut Vec<Event>) {
        let _ = (now, projector, events);
    }

    /// Finishes a call of the loop, whose newest reading was `heard` then.
    fn after_call(&mut self, now: Instant, heard: Option<Instant>) {
        let _ = (now, heard);
    }

    /// Counts of updates and channels that were written to the boards, and of those that had no need.
    fn traffic(&mut self) -> Traffic {
        self.parts().0.traffic()
    }

    /// Takes the transfers that crossed the display's bus since the last call; empty where no log is kept.
    fn take_transfers(&mut self) -> Vec<Transfer> {
        Vec::new()
    }

    /// Takes what a sound card of the display has played, where that is kept.
    fn take_sound(&mut self) -> Option<Sound> {
        None
    }

    /// Lets time pass until `now`.
    ///
    /// # Errors
    /// [`Failure::Device`] for an emulator that contradicts itself.
    fn advance_to(&mut self, now: Instant, events: &mut Vec<Event>) -> Result<(), Failure> {
        let _ = (now, events);
        Ok(())
    }

    /// Looks at wires and person after a turn that may have begun a stimulus.
    fn look(&mut self, now: Instant, onset: bool, projector: &Projector, recorder: &mut Recorder) {
        let _ = (now, onset, projector, recorder);
    }

    /// Lets scripted faults begin and end that are due at `now`; with `last` those that are on end.
    fn fail(&mut self, now: Instant, last: bool, skin: FaultySkin<'_>, events: &mut Vec<Event>) {
        let _ = (now, last, skin, events);
    }

    /// Time at which the next scripted fault begins or ends.
    fn next_fault(&self) -> Instant {
        Instant::FAR_FUTURE
    }

    /// Keeps what the outcome of a whole run shows of the hardware. Temperatures grow with the length of a run, except where a
    /// summary is all that is wanted.
    ///
    /// # Errors
    /// [`Failure::Device`] where the bus cannot keep a log.
    fn keep(&mut self, keep: Keep) -> Result<(), Failure> {
        let _ = keep;
        Ok(())
    }

    /// Emulates the hardware in its other state beside, from now on.
    fn compare(&mut self, setup: &Setup, header: &Header, aside: Option<Aside>) {
        let _ = (setup, header, aside);
    }

    /// Reports of the scene's faults on this display.
    fn faults(&self) -> Vec<FaultReport> {
        Vec::new()
    }

    /// Waits until an all-off of `end` has taken effect, and scores the last onset.
    ///
    /// # Errors
    /// Errors of [`Self::advance_to`].
    fn settle(
        &mut self,
        end: Instant,
        projector: &Projector,
        recorder: &mut Recorder,
    ) -> Result<(), Failure> {
        let _ = (end, projector, recorder);
        Ok(())
    }

    /// Time until which the bus is busy, where several displays share it.
    fn bus_now(&mut self) -> Nanos {
        Nanos(0)
    }

    /// State of the wires, where something measures them; with totals so far, if they are wanted.
    fn standing(&self, with_totals: bool) -> Option<Standing> {
        let _ = with_totals;
        None
    }

    /// Temperature of the face under the finger, degrees C; `None` without a module, or where nothing has told it yet.
    fn face_c(&self) -> Option<f64> {
        None
    }

    /// A driver's error in full.
    fn explain(&self, error: &DriverError) -> String {
        error.to_string()
    }

    /// Keeps a stop of the guard until a person has looked. Returns the failure that ends the run.
    fn keep_stopped(&mut self, cause: &str) -> Failure {
        Failure::Guard(cause.to_owned())
    }
}
