//! What the fingers of a real bench share while they run: one guardian, and the line that cuts all outputs. And the
//! actuators' end of one finger, which goes off alone.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use palpate_buses::guardian::{Guardian, Lost};
use palpate_buses::i2c::SharedLine;
use palpate_buses::pulse::{Pulse, Round};
use palpate_core::driver::{Driver, DriverError};
use palpate_core::units::{Board, Instant};
use palpate_run::Failure;
use palpate_run::display_end::{DisplayEnd, OutputEnable};

use super::bench::{clear_words, cut_words};
use super::clocked::Clocked;
use super::heat::Heat;

/// The guardian of several fingers. It hears of them only together: a finger that hangs ends in everything off.
pub(super) struct Warden {
    guardian: Mutex<Guardian>,
    round: Arc<Round>,
    /// Fingers that have their bus, a bit each: OE is released when all have it.
    ready: Mutex<u32>,
    all: u32,
    has_oe: bool,
    pub(super) heat: Heat,
}

/// A lock that a panic elsewhere does not close: who says off must never be kept out.
fn held<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Warden {
    pub(super) fn new(guardian: Guardian, heat: Heat, fingers: usize, has_oe: bool) -> Self {
        Self {
            guardian: Mutex::new(guardian),
            round: Arc::new(Round::new(fingers)),
            ready: Mutex::new(0),
            all: (0..fingers).fold(0, |all, finger| all | Round::bit(finger)),
            has_oe,
            heat,
        }
    }

    pub(super) const fn round(&self) -> &Arc<Round> {
        &self.round
    }

    pub(super) fn pulse(&self) -> Pulse {
        held(&self.guardian).pulse()
    }

    /// From here on the guardian waits for heartbeats. All loops are ready to turn.
    pub(super) fn begin(&self, now: Instant) {
        // A guardian that is gone ends the run at the first round.
        let _ = held(&self.guardian).beat(now);
    }

    /// A finger makes a turn.
    pub(super) fn beat(&self, finger: usize, now: Instant) -> Result<(), Lost> {
        match self.round.turned(Round::bit(finger)) {
            true => held(&self.guardian).beat(now),
            false => Ok(()),
        }
    }

    /// A finger's stop is to be latched now: the run may yet die before its end.
    fn latch(&self, cause: &str) {
        // A guardian that is gone ends the run at the next round.
        let _ = held(&self.guardian).latch(cause);
    }

    /// Whether no guardian is there that would switch off what is left on.
    pub(super) fn is_gone(&self) -> bool {
        held(&self.guardian).is_gone()
    }

    /// A finger has ended, off or not: the other fingers go on.
    pub(super) fn ended(&self, finger: usize) {
        self.round.ended(finger);
    }

    /// Something is wrong with the program itself: everything off by the guardian, now.
    pub(super) fn give_up(&self, cause: &str) {
        held(&self.guardian).hand_over(cause);
    }

    /// The run is over: what is `left` on is the guardian's to switch off, what was `stopped` stays latched.
    pub(super) fn part(&self, left: Option<&str>, stopped: Option<&str>) -> Result<(), String> {
        let mut guardian = held(&self.guardian);
        if let Some(cause) = left {
            guardian.hand_over(cause);
            return Err(cause.to_owned());
        }
        if let Some(cause) = stopped {
            guardian.stop(cause).map_err(|lost| lost.to_string())?;
        }
        guardian.end()
    }

    /// A finger has its bus, or has lost it: a channel that could not be switched off must not drive on.
    fn vote(&self, finger: usize, has_bus: bool) {
        let mut ready = held(&self.ready);
        match has_bus {
            true => *ready |= Round::bit(finger),
            false => *ready &= !Round::bit(finger),
        }
        // A guardian that is gone ends the run at the next round.
        let _ = held(&self.guardian).set_outputs(*ready == self.all);
    }
}

/// A finger's voice about the line that cuts all outputs.
pub(super) struct Vote {
    pub(super) warden: Arc<Warden>,
    pub(super) finger: usize,
}

impl OutputEnable for Vote {
    fn set_enabled(&self, _now: Instant, enabled: bool) {
        self.warden.vote(self.finger, enabled);
    }

    fn cuts(&self) -> bool {
        self.warden.has_oe
    }

    fn words(&self) -> &'static str {
        cut_words(self.warden.has_oe)
    }
}

/// The actuators' end of a finger.
pub(super) struct FingerEnd {
    pub(super) banks: Clocked<SharedLine>,
    pub(super) vote: Vote,
    /// Its display's name on the bench.
    pub(super) name: String,
    /// All adapters of the bench, for the way out of a stop.
    pub(super) adapters: Vec<PathBuf>,
    /// What the guard stopped it for.
    pub(super) stopped: Option<String>,
}

impl FingerEnd {
    /// Returns when no other finger's transfer is on its bus.
    pub(super) fn wait(&self) {
        if let Some(line) = self.banks.bus_of(Board(0)) {
            line.wait();
        }
    }
}

impl DisplayEnd for FingerEnd {
    fn parts(&mut self) -> (&mut dyn Driver, &dyn OutputEnable) {
        (&mut self.banks, &self.vote)
    }

    /// With the errno that the adapter gave.
    fn explain(&self, error: &DriverError) -> String {
        let fault = match error {
            DriverError::Bus(board, _) => self.banks.bus_of(*board),
            _ => None,
        };
        let fault = fault.and_then(SharedLine::last_fault);
        fault.map_or_else(|| error.to_string(), ToString::to_string)
    }

    /// The guardian's stop would end the other fingers too. It latches this one for the whole bench now, and says that
    /// all is off when the run is over.
    fn keep_stopped(&mut self, cause: &str) -> Failure {
        self.vote.warden.latch(&format!("{}: {cause}", self.name));
        self.stopped = Some(cause.to_owned());
        let clear = clear_words(&self.adapters);
        Failure::Guard(format!(
            "{cause}; its outputs are off and stay off. {clear}"
        ))
    }
}
