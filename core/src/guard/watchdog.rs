//! The watchdog: sensor age, tick lateness and link, and the cause for which everything stays off.

use crate::listed::listed;
use crate::units::{Duration, Instant};

listed! {
    /// Causes for which everything is switched off.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
    #[error("{}", self.word())]
    #[non_exhaustive]
    pub enum Cause: word {
        /// No sensor frame for longer than the limit while a wire was driven.
        #[error("{}: no sensor frame for 100 ms while a wire was driven", self.word())]
        StaleInput = "stale-input",
        /// The actuator bus reported an error.
        ActuatorError = "actuator-error",
        /// The sensor bus reported an error.
        SensorError = "sensor-error",
        /// The loop was called too late to end a stimulus in time.
        #[error("{}: this computer was too late to end a stimulus in time", self.word())]
        LateTick = "late-tick",
        /// The run ended.
        End = "end",
        /// The reference of the skin is taken anew.
        Rezero = "rezero",
        /// A wire was on for longer than a burst may be, because it went off too late.
        Overrun = "overrun",
    }
}

impl Cause {
    /// The cause to keep of this one and a later one: this one, except that an overrun replaces a failed bus.
    #[must_use]
    pub(crate) const fn followed_by(self, later: Self) -> Self {
        match (self, later) {
            (Self::ActuatorError, Self::Overrun) => Self::Overrun,
            (first, _) => first,
        }
    }
}

/// Sensor age and tick lateness against the limit, and the latch.
#[derive(Clone, Debug)]
pub(super) struct Watchdog {
    /// Age or lateness at which outputs go off, so that they are off within the limit.
    patience: Duration,
    /// Last received sensor frame.
    heard: Option<Instant>,
    /// Last time that anybody looked.
    looked: Option<Instant>,
    latched: Option<Cause>,
}

impl Watchdog {
    /// The watchdog of outputs that are off within `stale`. The switching takes `latency` of it, and at least half is
    /// for waiting.
    pub(super) fn new(stale: Duration, latency: Duration) -> Self {
        let (stale, latency) = (stale.as_micros(), latency.as_micros());
        Self {
            patience: Duration::from_micros(stale - latency.min(stale / 2)),
            heard: None,
            looked: None,
            latched: None,
        }
    }

    /// Notes that a sensor frame was received. Its time counts, not its content: repeated rows are normal.
    pub(super) fn hear(&mut self, at: Instant) {
        self.heard = self.heard.max(Some(at));
    }

    /// Time at which the newest frame was received.
    pub(super) const fn heard(&self) -> Option<Instant> {
        self.heard
    }

    /// Returns true if the newest frame is too old or none has come.
    pub(super) fn is_stale(&self, now: Instant) -> bool {
        self.heard.is_none_or(|at| now.since(at) >= self.patience)
    }

    /// Time at which sensor input gets too old.
    pub(super) fn deadline(&self) -> Instant {
        self.heard.map_or(Instant::ZERO, |at| at + self.patience)
    }

    /// The cause to stop for at `now` if a wire is driven until `end`.
    pub(super) fn look(&mut self, now: Instant, end: Option<Instant>) -> Option<Cause> {
        self.looked = self.looked.max(Some(now));
        let end = end?;
        if self.is_stale(now) {
            Some(Cause::StaleInput)
        } else {
            (now.since(end) >= self.patience).then_some(Cause::LateTick)
        }
    }

    /// Keeps everything off from now on, for a cause that another place has found.
    pub(super) fn latch(&mut self, cause: Cause) {
        let first = self.latched.unwrap_or(cause);
        self.latched = Some(first.followed_by(cause));
    }

    pub(super) const fn latched(&self) -> Option<Cause> {
        self.latched
    }

    /// Checks that frames come and that the loop runs.
    pub(super) fn ready(&self, now: Instant) -> Result<(), Cause> {
        if self.is_stale(now) {
            Err(Cause::StaleInput)
        } else if self.looked.is_none_or(|at| now.since(at) >= self.patience) {
            Err(Cause::LateTick)
        } else {
            Ok(())
        }
    }

    pub(super) fn open(&mut self) {
        self.latched = None;
    }
}

#[cfg(test)]
#[path = "watchdog_tests.rs"]
mod tests;
