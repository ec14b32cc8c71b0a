//! The watchdog: sensor age, tick lateness and link, and the cause for which everything stays off.

use crate::units::{Duration, Instant};

/// Why everything was switched off. The list is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// No sensor frame for longer than the limit while a wire was driven.
    StaleInput,
    /// The actuator bus reported an error.
    ActuatorError,
    /// The sensor bus reported an error.
    SensorError,
    /// The loop was called too late to end a stimulus in time.
    LateTick,
    /// The run ended.
    End,
}

impl Cause {
    /// The word that stands in a schedule file.
    pub const fn word(self) -> &'static str {
        match self {
            Self::StaleInput => "stale-input",
            Self::ActuatorError => "actuator-error",
            Self::SensorError => "sensor-error",
            Self::LateTick => "late-tick",
            Self::End => "end",
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
    /// Outputs are off within `stale`, `latency` of which the switching takes; at least half is for waiting.
    pub(super) fn new(stale: Duration, latency: Duration) -> Self {
        let (stale, latency) = (stale.as_micros(), latency.as_micros());
        Self {
            patience: Duration::from_micros(stale - latency.min(stale / 2)),
            heard: None,
            looked: None,
            latched: None,
        }
    }

    /// A sensor frame was received. Its time counts, not what it says: repeated rows are normal.
    pub(super) fn hear(&mut self, at: Instant) {
        self.heard = self.heard.max(Some(at));
    }

    /// Whether the newest frame is too old, or there is none.
    pub(super) fn is_stale(&self, now: Instant) -> bool {
        self.heard.is_none_or(|at| now.since(at) >= self.patience)
    }

    /// When sensor input gets too old.
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

    /// Keeps everything off from now on; the first cause is kept.
    pub(super) fn latch(&mut self, cause: Cause) {
        self.latched.get_or_insert(cause);
    }

    pub(super) const fn latched(&self) -> Option<Cause> {
        self.latched
    }

    /// Whether frames come and the loop runs.
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
mod tests {
    use super::*;

    const fn ms(ms: u64) -> Instant {
        Instant::from_micros(ms * 1000)
    }

    fn dog() -> Watchdog {
        Watchdog::new(Duration::from_millis(100), Duration::from_millis(10))
    }

    #[test]
    fn switching_time_is_taken_off_the_limit_up_to_half_of_it() {
        for (latency, patience) in [(0, 100), (10, 90), (50, 50), (51, 50), (1000, 50)] {
            let dog = Watchdog::new(Duration::from_millis(100), Duration::from_millis(latency));
            assert_eq!(dog.patience, Duration::from_millis(patience));
        }
    }

    #[test]
    fn age_counts_from_the_newest_frame_and_only_while_a_wire_is_driven() {
        let mut dog = dog();
        assert_eq!(dog.look(ms(0), Some(ms(35))), Some(Cause::StaleInput));
        assert_eq!(dog.look(ms(0), None), None);
        assert_eq!(dog.deadline(), Instant::ZERO);
        dog.hear(ms(20));
        dog.hear(ms(10));
        assert_eq!(dog.deadline(), ms(110));
        for (now, stale) in [(20, false), (109, false), (110, true), (111, true)] {
            assert_eq!(dog.is_stale(ms(now)), stale);
            let cause = stale.then_some(Cause::StaleInput);
            assert_eq!(dog.look(ms(now), Some(ms(100))), cause);
            assert_eq!(dog.look(ms(now), None), None);
        }
    }

    #[test]
    fn a_tick_is_late_once_an_end_is_long_past() {
        let mut dog = dog();
        dog.hear(ms(200));
        assert_eq!(dog.look(ms(189), Some(ms(100))), None);
        assert_eq!(dog.look(ms(190), Some(ms(100))), Some(Cause::LateTick));
        assert_eq!(dog.look(ms(190), None), None);
    }

    #[test]
    fn a_latch_keeps_its_first_cause() {
        let mut dog = dog();
        dog.latch(Cause::LateTick);
        dog.latch(Cause::SensorError);
        assert_eq!(dog.latched(), Some(Cause::LateTick));
        dog.open();
        assert_eq!(dog.latched(), None);
    }

    #[test]
    fn all_is_well_when_frames_come_and_somebody_looks() {
        let mut dog = dog();
        assert_eq!(dog.ready(ms(5)), Err(Cause::StaleInput));
        dog.hear(ms(5));
        assert_eq!(dog.ready(ms(5)), Err(Cause::LateTick));
        dog.look(ms(5), None);
        assert_eq!(dog.ready(ms(5)), Ok(()));
        dog.hear(ms(95));
        assert_eq!(dog.ready(ms(95)), Err(Cause::LateTick));
        dog.look(ms(6), None);
        dog.look(ms(5), None);
        assert_eq!(dog.ready(ms(95)), Ok(()));
    }

    #[test]
    fn causes_have_their_words() {
        let words = [
            (Cause::StaleInput, "stale-input"),
            (Cause::ActuatorError, "actuator-error"),
            (Cause::SensorError, "sensor-error"),
            (Cause::LateTick, "late-tick"),
            (Cause::End, "end"),
        ];
        for (cause, word) in words {
            assert_eq!(cause.word(), word);
        }
    }
}
