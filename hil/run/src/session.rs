//! A run between two turns: the loop between a sensor end and a display end, and every line of policy around it:
//! start, reading registers back, stops of the guard, recovery of a lost bus, silent boards, switching off.
//!
//! A session has no clock and no end of its own. Its memory is bounded where its recorder is, and frame times, which
//! need a stopwatch, are taken. Its holder decides when the next turn is: at once in virtual time, paced on a real
//! bench.

mod parts;

use palpate_core::driver::DriverError;
use palpate_core::projector::{Cause, LoopError, Projector};
use palpate_core::units::{Duration, Instant};
use palpate_records::trace::{Event, event};

use crate::display_end::DisplayEnd;
use crate::effort::{FrameTimes, Stopwatch};
use crate::failure::Failure;
use crate::pass::Again;
use crate::policy::{LatchPolicy, Policy, TICK};
use crate::recorder::Recorder;
use crate::skin_end::SkinEnd;
use crate::supervisor::Supervisor;

/// Time between two looks at the registers, between two bursts so that a slow answer delays no end of one.
const VERIFY: Duration = Duration::from_millis(250);
/// Longest delay of that check by wires that are driven without a pause.
const VERIFY_AT_LAST: Duration = Duration::from_millis(1000);

/// Result of a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// Another turn is due, at the latest at this time.
    Next(Instant),
    /// The run has ended before its time; [`Session::failure`] tells why.
    Last,
}

/// The loop with both of its ends.
pub struct Session<S, D> {
    projector: Projector,
    skin: S,
    display: D,
    policy: Policy,
    supervisor: Supervisor,
    recorder: Recorder,
    times: FrameTimes,
    again: Again,
    now: Instant,
    next: Instant,
    verified: Instant,
    failure: Option<Failure>,
    /// A wire was on for too long, and that is latched.
    exceeded: bool,
}

impl<S: SkinEnd, D: DisplayEnd> Session<S, D> {
    /// A session that has not begun. Frames are timed by `stopwatch`, where there is one.
    pub fn new(
        projector: Projector,
        (skin, display): (S, D),
        policy: Policy,
        recorder: Recorder,
        stopwatch: Option<Stopwatch>,
    ) -> Self {
        Self {
            supervisor: Supervisor::new(policy.give_up),
            times: FrameTimes::new(stopwatch),
            again: Again::default(),
            now: Instant::ZERO,
            next: Instant::ZERO,
            verified: Instant::ZERO,
            failure: None,
            exceeded: false,
            projector,
            skin,
            display,
            policy,
            recorder,
        }
    }

    /// Starts the boards at `now`: everything off, the period set, registers read back, outputs released. Returns
    /// when the first turn may come.
    ///
    /// # Errors
    /// A board that does not answer, where the policy does not wait for it.
    pub fn start(&mut self, now: Instant) -> Result<Instant, DriverError> {
        self.now = now;
        let pre_scale = self.projector.guard().prescale().get();
        let t_us = now.as_micros();
        let (banks, _) = self.display.parts();
        for board in banks.boards() {
            let board = board.0;
            self.recorder.events.push(Event::AllOff(event::AllOff {
                t_us,
                board,
                cause: "start",
            }));
            self.recorder.events.push(Event::PreScale(event::PreScale {
                t_us,
                board,
                pre_scale,
            }));
        }
        self.fail(false);
        let (banks, oe) = self.display.parts();
        self.next = match banks.start(now) {
            Ok(ready) => {
                oe.set_enabled(ready, true);
                ready
            }
            Err(e) if self.policy.waits_at_start => {
                self.lose(&e);
                now
            }
            Err(e) => return Err(e),
        };
        Ok(self.next)
    }

    /// Calls the loop once at `now`, with the work before and after it.
    ///
    /// # Errors
    /// [`Failure::Device`] for an emulator that contradicts itself. A run that ends in order is no error here:
    /// [`Turn::Last`], [`Session::failure`].
    pub fn turn(&mut self, now: Instant) -> Result<Turn, Failure> {
        self.now = now;
        self.skin.advance_to(now);
        self.display.advance_to(now, &mut self.recorder.events)?;
        if self.supervisor.is_lost() {
            return Ok(self.recover());
        }
        self.reopen();
        if self.projector.follows_touches() {
            self.projector.touched(self.recorder.touches_at(now));
        }
        let onset = match self.poll() {
            Ok(onset) => onset,
            Err(failure) => return Ok(self.end(failure)),
        };
        if self.has_exceeded() {
            return Ok(Turn::Last);
        }
        if onset {
            self.recorder.count(&self.projector);
        }
        self.display
            .look(now, onset, &self.projector, &mut self.recorder);
        let face_c = || self.display.face_c();
        if let Some(text) = self.again.look(&mut self.projector, face_c, now) {
            self.recorder.note(now, text);
        }
        self.supervisor.restart_boards(
            now,
            &mut self.skin,
            &self.projector,
            &mut self.recorder.events,
        );
        self.fail(false);
        self.recorder.trim();
        let next = self.projector.next().min(now + TICK);
        self.next = next.min(self.display.next_fault());
        Ok(Turn::Next(self.next))
    }

    /// Turns in virtual time until `until`, which is the time of none of them.
    ///
    /// # Errors
    /// As [`Self::turn`].
    pub fn advance(&mut self, until: Instant) -> Result<Turn, Failure> {
        while self.next < until {
            if self.turn(self.next)? == Turn::Last {
                return Ok(Turn::Last);
            }
        }
        Ok(Turn::Next(self.next))
    }

    /// Switches everything off at `end`.
    ///
    /// # Errors
    /// The driver's: not everything is known to be off. Outputs that are not known to be off count as on until now.
    pub fn switch_off(&mut self, end: Instant) -> Result<(), DriverError> {
        self.now = end;
        let (banks, _) = self.display.parts();
        let off = self
            .projector
            .all_off(end, Cause::End, banks, &mut self.recorder);
        match off {
            Ok(()) => {
                self.has_exceeded();
            }
            Err(_) => {
                self.cut();
                self.still_on();
            }
        }
        self.fail(true);
        self.recorder.tell_taxels();
        off
    }

    /// Switches everything off at `end`. A bus that does not take that is lost, and the failure of a run that had none.
    pub fn conclude(&mut self, end: Instant) {
        if let Err(e) = self.switch_off(end)
            && self.failure.is_none()
        {
            self.lose(&e);
            self.failure = Some(Failure::Device(e.to_string()));
        }
    }

    /// Does the scene's faults to emulated hardware.
    fn fail(&mut self, last: bool) {
        let skin = self.skin.emulated();
        let events = &mut self.recorder.events;
        self.display.fail(self.now, last, skin, events);
    }

    fn end(&mut self, failure: Failure) -> Turn {
        self.failure.get_or_insert(failure);
        Turn::Last
    }

    /// The actuator bus is lost: outputs are cut by the OE line, recovery follows.
    pub fn lose(&mut self, error: &DriverError) {
        self.cut();
        self.wait_for_bus(error);
    }

    /// Cuts outputs that could not be switched off. Without a line that does, they count as on until the bus answers.
    fn cut(&mut self) {
        let (banks, oe) = self.display.parts();
        oe.set_enabled(self.now, false);
        if oe.cuts() {
            let at = banks.confirmed(self.now);
            self.projector.settle(at, &mut self.recorder);
        }
    }

    fn wait_for_bus(&mut self, error: &DriverError) {
        let error = self.display.explain(error);
        let cut = self.display.parts().1.words();
        let events = &mut self.recorder.events;
        self.supervisor.lose(self.now, &error, cut, events);
    }

    /// Settles the guard's books where outputs were switched off by another way than the session's.
    pub fn settle(&mut self) {
        let (banks, _) = self.display.parts();
        let at = banks.confirmed(self.now);
        self.projector.settle(at, &mut self.recorder);
        self.has_exceeded();
    }

    /// Counts outputs that are not known to be off as on until now.
    pub fn still_on(&mut self) {
        let (banks, _) = self.display.parts();
        self.projector.still_on(banks.confirmed(self.now));
    }

    /// Tries to bring a lost bus back.
    fn recover(&mut self) -> Turn {
        let (banks, oe) = self.display.parts();
        let events = &mut self.recorder.events;
        match self.supervisor.recover(self.now, banks, oe, events) {
            Ok(Some(ready)) => {
                self.next = ready;
                self.settle();
                if self.exceeded {
                    return Turn::Last;
                }
            }
            Ok(None) => {
                self.fail(false);
                self.next = self.now + self.policy.retry;
            }
            Err(failure) => return self.end(failure),
        }
        Turn::Next(self.next)
    }

    /// Ends a stop of the guard that may end by itself, and keeps one that may not.
    fn reopen(&mut self) {
        let latched = self.projector.guard().latched();
        let Some(cause) = latched.filter(|_| self.display.registers().is_none()) else {
            return;
        };
        let passes = matches!(cause, Cause::ActuatorError | Cause::Rezero);
        if passes || self.policy.latch == LatchPolicy::Reopens {
            let (banks, _) = self.display.parts();
            self.supervisor
                .resume(self.now, &mut self.projector, banks, &mut self.recorder);
        } else if self.failure.is_none() {
            // Outputs stay off until a person has looked; the skin is still read and recorded.
            let cause = cause.to_string();
            self.recorder.note(self.now, format!("stopped: {cause}"));
            self.failure = Some(self.display.keep_stopped(&cause));
        }
    }

    /// Tells whether a wire was on for too long. On hardware that ends a run at once, with its outputs off, and is
    /// latched. Where stops end by themselves it is a stop like any other.
    fn has_exceeded(&mut self) -> bool {
        if self.policy.latch == LatchPolicy::Reopens {
            return false;
        }
        if let Some(cause) = self.overrun().filter(|_| !self.exceeded) {
            self.exceeded = true;
            self.recorder.note(self.now, format!("stopped: {cause}"));
            let kept = self.display.keep_stopped(&cause);
            self.failure.get_or_insert(kept);
        }
        self.exceeded
    }

    /// Switches everything off first, after a time until `now` in which the run did not act and of which its clock did
    /// not count `uncounted`. Outputs that were on count as on meanwhile. On hardware the stop stays latched for this
    /// cause; where stops end by themselves it is a stop like any other. Returns whether the run goes on.
    pub fn unseen(&mut self, now: Instant, uncounted: Duration, cause: &str) -> bool {
        self.now = now;
        let (banks, _) = self.display.parts();
        // Outputs that are lost here are tried again below.
        let _ = banks.all_off();
        self.projector.slept(now, uncounted);
        let (banks, _) = self.display.parts();
        let off = self
            .projector
            .all_off(now, Cause::LateTick, banks, &mut self.recorder);
        if let Err(error) = &off {
            self.cut();
            // A run that goes on lifts the line again once the bus answers.
            if self.policy.latch == LatchPolicy::Reopens && !self.supervisor.is_lost() {
                self.wait_for_bus(error);
            }
        }
        let stopped = match self.overrun() {
            Some(overrun) => format!("{cause}; {overrun}"),
            None => cause.to_owned(),
        };
        self.recorder.note(now, format!("stopped: {stopped}"));
        if self.policy.latch == LatchPolicy::Reopens {
            return true;
        }
        self.exceeded = true;
        let kept = self.display.keep_stopped(&stopped);
        self.failure.get_or_insert(kept);
        false
    }

    /// Words for the wire or motor that was on for too long, with the cause that stopped the run before, where it is known.
    pub fn overrun(&self) -> Option<String> {
        let guard = self.projector.guard();
        let found = guard.overrun()?;
        let ms = |span: Duration| span.as_micros().div_ceil(1000);
        let (on, most) = (ms(found.on), ms(guard.limits().burst));
        let actuator = match guard.motors() {
            Some(_) => "motor",
            None => "wire",
        };
        let overrun = format!(
            "overrun: {actuator} {} was on for {on} ms, allowed are {most} ms: its off came too late",
            found.wire
        );
        Some(match guard.latched() {
            Some(cause @ (Cause::StaleInput | Cause::LateTick)) => {
                format!("{cause}; {overrun}")
            }
            _ => overrun,
        })
    }

    /// Calls the loop; returns whether a stimulus began. A bus that fails is lost, and brought back later.
    fn poll(&mut self) -> Result<bool, Failure> {
        let before = self.recorder.frames;
        let begun = self.times.begin();
        let (now, display, recorder) = (self.now, &mut self.display, &mut self.recorder);
        let (projector, skin) = (&mut self.projector, &mut self.skin as &mut dyn SkinEnd);
        display.before_call(now, projector, &mut recorder.events);
        let polled = match display.registers() {
            Some(registers) => projector.poll(now, skin, registers, recorder),
            None => projector.poll(now, skin, display.parts().0, recorder),
        };
        display.after_call(now, projector.guard().heard());
        let frames = self.recorder.frames - before;
        self.times.add(begun, frames, &self.projector.work());
        let polled = match polled {
            Ok(onset) => self.verify().map(|()| onset),
            Err(LoopError::Actuator(e)) => Err(e),
            Err(LoopError::Sensor(e)) => {
                return Err(Failure::Device(format!("sensor bus: {e}")));
            }
            Err(LoopError::Scan(e)) => return Err(Failure::Device(format!("skin: {e}"))),
        };
        if polled.is_err() {
            self.cut();
        }
        let retries = self.display.parts().0.retries();
        self.supervisor
            .retried(self.now, retries, &mut self.recorder.events);
        Ok(polled.unwrap_or_else(|e| {
            self.wait_for_bus(&e);
            false
        }))
    }

    /// Reads registers back when that is due: a chip that fell back to reset values answers, but sleeps, and
    /// nothing on the bus says so.
    fn verify(&mut self) -> Result<(), DriverError> {
        let since = self.now.since(self.verified);
        let quiet = self.projector.guard().next_expiry().is_none();
        if since < VERIFY || !(quiet || since >= VERIFY_AT_LAST) {
            return Ok(());
        }
        self.verified = self.now;
        let (banks, _) = self.display.parts();
        banks.verify().inspect_err(|_| {
            // The error is on its way; recovery finds out whether this helped.
            let cause = Cause::ActuatorError;
            let _ = self
                .projector
                .all_off(self.now, cause, banks, &mut self.recorder);
        })
    }
}
