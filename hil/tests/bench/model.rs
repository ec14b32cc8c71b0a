//! A model of a bench that takes part in nothing and reads no file: it says what a person has to do before anybody may drive.

use std::collections::BTreeMap;

use crate::damage::Kept;
use crate::run::Said;

/// Each reserve that stays booked takes 4 % of a session's dose: with fewer of them it is not spent.
const SPENT: u32 = 12;
/// Words of a run that a slow machine, or a skin that was not heard, has stopped.
const SLOW: [&str; 4] = ["late-tick", "stale-input", "overrun", "the run hung"];

/// An off that comes so much later than it was meant to is beyond the limit of a burst, milliseconds: bursts are 38 ms long, and
/// count as on for 56 ms at most.
const LATE_MS: f64 = 18.0;
/// The limit of a burst, milliseconds.
const BURST_MS: f64 = 50.0;

/// Observations of a run from outside.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Whether an output changed.
    pub drove: bool,
    /// Whether a stop is latched after it.
    pub is_latched: bool,
    /// For how long a wire was on in one go, by the chips' registers, milliseconds.
    pub longest_ms: f64,
    /// How late the machine was meanwhile, milliseconds.
    pub late_ms: f64,
}

impl Seen {
    /// Whether this machine was so late that a burst may have passed its limit, and by no more than was `said`. The run counts a
    /// burst from its onset to the moment at which its off is known: lateness lengthens it at both ends.
    fn explains(&self, said: &Said) -> bool {
        let used = said.err.split_once("most of all burst (");
        let used = used.and_then(|(_, rest)| rest.split_once(" %")?.0.parse().ok());
        let most_ms = self.longest_ms + 2.0 * self.late_ms;
        let is_so = |percent: f64| percent * BURST_MS / 100.0 <= most_ms;
        said.err.contains("LIMIT EXCEEDED") && self.late_ms >= LATE_MS && used.is_none_or(is_so)
    }
}

/// Knowledge of something that makes runs be refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Certainty {
    /// It is not so.
    #[default]
    No,
    /// Nobody can know: the next run says.
    Maybe,
    /// It is so.
    Yes,
}

/// The ends that a run may have which nothing forbids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum May {
    /// It ends in order.
    End,
    /// It ends in order, or says that heat cannot be kept; it leaves no stop.
    Lack,
    /// It ends in order or not; whether a stop is left, nobody can know.
    Fail,
    /// It drives nothing and fails.
    Refuse,
}

/// The state of a bench as a person knows it, and counts of what has happened there.
#[derive(Default)]
pub struct Model {
    /// Whether a stop is latched.
    pub stop: Certainty,
    /// Whether the ledger cannot be read, or the dose is spent.
    pub unreadable: Certainty,
    /// Whether a run was refused since the last person was there.
    pub is_seen: bool,
    /// The stop's record before it was damaged, and what was known then.
    pub whole: Option<(Kept, Certainty)>,
    /// Runs whose reserve may have stayed booked.
    pub booked: u32,
    /// Counts of what has happened, by name.
    pub counts: BTreeMap<&'static str, u64>,
}

impl Model {
    /// Counts something that has happened.
    pub fn count(&mut self, what: &'static str) {
        *self.counts.entry(what).or_default() += 1;
    }

    /// Whether every run is to be refused.
    pub fn is_refused(&self) -> bool {
        self.stop == Certainty::Yes || self.unreadable == Certainty::Yes
    }

    /// Fails where a run contradicts what is known, and learns from it.
    #[track_caller]
    pub fn judge(&mut self, said: &Said, seen: Seen, may: May) {
        let drove = seen.drove;
        let says = |words: &str| said.err.contains(words);
        let (stop, unreadable) = (
            self.stop == Certainty::Yes,
            self.unreadable == Certainty::Yes,
        );
        if drove {
            self.whole = None;
        }
        if stop || unreadable || may == May::Refuse {
            assert!(!drove, "it drove: {said:?}");
            assert!(matches!(said.status, Some(3 | 4)), "{said:?}");
            let is_stopped = self.stop != Certainty::No && says("stopped earlier");
            if is_stopped {
                self.stop = Certainty::Yes;
            }
            let is_told = is_stopped || unreadable && says("--forget-heat");
            assert!(is_told || may != May::End, "{said:?}");
            self.is_seen |= is_told;
            self.count("runs refused");
            return;
        }
        if says("stopped earlier") {
            assert!(
                self.stop == Certainty::Maybe && !drove,
                "a stop from nowhere: {said:?}"
            );
            self.stop = Certainty::Yes;
        } else if says("heat of earlier runs") {
            assert!(
                self.unreadable == Certainty::Maybe && !drove,
                "nothing was unreadable: {said:?}"
            );
            self.unreadable = Certainty::Yes;
        } else if says("has had a session's dose") {
            assert!(
                self.booked >= SPENT && !drove,
                "after {} reserves: {said:?}",
                self.booked
            );
            // Until a person forgets it, as with what cannot be read.
            self.unreadable = Certainty::Yes;
            self.count("doses spent");
        } else if said.status == Some(0) {
            self.stop = if may == May::Fail {
                Certainty::Maybe
            } else {
                Certainty::No
            };
        } else if may == May::Lack && said.status == Some(3) && says("heat cannot be kept") {
            self.stop = Certainty::No;
            self.booked += 1;
            self.count("runs that lacked a disk");
            return;
        } else {
            let is_slow = match said.status {
                Some(1) => seen.explains(said),
                _ => SLOW.iter().any(|words| says(words)),
            };
            assert!(is_slow || may == May::Fail, "{said:?}, {seen:?}");
            self.stop = if seen.is_latched {
                Certainty::Yes
            } else {
                Certainty::Maybe
            };
            self.booked += 1;
            self.count(if is_slow {
                "runs stopped, machine slow"
            } else {
                "runs that failed"
            });
            return;
        }
        self.is_seen |= said.status != Some(0);
        self.count(if said.status == Some(0) {
            "runs that ended in order"
        } else {
            "runs refused"
        });
    }
}

#[test]
fn a_limit_that_was_passed_is_believed_where_the_machine_was_late_and_no_further() {
    let said = |percent: &str| Said {
        status: Some(1),
        out: String::new(),
        err: format!("error: LIMIT EXCEEDED: 1 of 1 rows, most of all burst ({percent} % used)"),
    };
    for (late_ms, percent, is_believed) in [
        (17.0, "100", false),
        (18.0, "100", true),
        (18.0, "142", true),
        (18.0, "143", false),
        (60.0, "222", true),
    ] {
        let seen = Seen {
            drove: true,
            is_latched: true,
            longest_ms: 35.0,
            late_ms,
        };
        assert_eq!(seen.explains(&said(percent)), is_believed, "{seen:?}");
    }
}
