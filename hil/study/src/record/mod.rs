//! Record of a session, a line of JSON each: the session, stimuli before they are played, every reply with what was
//! played before it, notes, stops.
//!
//! A session is begun again from these lines alone, and all that is said of it is computed from them. Each line has a
//! later time than the one before it, so a line that stands there twice is found.

mod bounds;

use palpate_files::{Protocol, TaskKind};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::session::{AnswerError, Reply, Session, Step, Stimulus, Trial};

/// Version of these lines; grows when a field changes its meaning.
pub const VERSION: u32 = 2;

/// A line of a record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Line {
    /// The session, the first line.
    Session(About),
    /// An interval before it is played: it counts as played until a reply tells how far it was.
    Playing(Playing),
    /// A hot pass before it is played: its bursts count as played, whatever became of it.
    Passing(Passing),
    /// A reply to a step.
    Reply(Said),
    /// A note of the experimenter.
    Note(Noted),
    /// The session was begun again.
    Resumed(Resumed),
    /// The participant or the guard stopped it: everything off.
    Stopped(Noted),
}

/// Facts of a session, its first line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// Version of the record: [`VERSION`].
    pub version: u32,
    /// Version of the program.
    pub palpate: String,
    /// Name of the protocol.
    pub protocol: String,
    /// SHA-256 of the values of the protocol's file, first 16 hex digits.
    pub protocol_digest: String,
    /// Number of the participant, from 1 on.
    pub participant: u32,
    /// Seed of its order.
    pub seed: u64,
    /// Name of the bench.
    pub bench: String,
    /// `emulated` or `real`.
    pub source: String,
    /// SHA-256 of the values of the limit table in force, first 16 hex digits.
    pub limits_digest: String,
    /// Places of the display's wires, mm.
    pub wires_mm: Vec<[f64; 2]>,
    /// Beginning of the session, UTC.
    pub began: String,
    /// Beginning of the session, milliseconds since 1970.
    pub began_unix_ms: u64,
    /// Uptime of the computer at the beginning: times of lines count from here. Records of version 1 have none.
    #[serde(default)]
    pub uptime: Uptime,
    /// `true` where a simulated person answers.
    pub simulated: bool,
    /// Share of the session's dose that the protocol takes at its strongest.
    pub dose_planned: f64,
}

/// A reading of the time that a computer has been on: a clock that no one sets.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Uptime {
    /// Origin of the count, one start of one computer. `None` where that is not known.
    pub start: Option<String>,
    /// Milliseconds since that origin.
    pub ms: u64,
}

impl Uptime {
    /// Milliseconds since an earlier reading; `None` where the two do not count from one start, or it is not known that they do.
    #[must_use]
    pub fn since(&self, earlier: &Self) -> Option<u64> {
        let is_one = self.start.is_some() && self.start == earlier.start;
        is_one.then(|| self.ms.saturating_sub(earlier.ms))
    }
}

/// A session that goes on after its program ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Resumed {
    /// Milliseconds since the session began.
    pub at_ms: u64,
    /// Version of the program.
    pub palpate: String,
    /// Uptime of the computer.
    pub uptime: Uptime,
}

/// An interval before it is played.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Playing {
    /// Milliseconds since the session began.
    pub at_ms: u64,
    /// Number of the trial.
    pub number: u32,
    /// Number of earlier beginnings of the trial.
    pub attempt: u32,
    /// The interval, with the bursts that it has at most: played from rest. Its schedule and path are not known yet.
    pub interval: Interval,
}

/// A hot pass of cold wires before it is played.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Passing {
    /// Milliseconds since the session began.
    pub at_ms: u64,
    /// The pass, with the bursts that it has at most. It has no stimulus.
    pub interval: Interval,
}

/// A line of text.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Noted {
    /// Milliseconds since the session began.
    pub at_ms: u64,
    /// Text of the note.
    pub text: String,
}

/// A reply to a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Said {
    /// Milliseconds since the session began.
    pub at_ms: u64,
    /// The reply.
    pub reply: Reply,
    /// The trial that it answers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trial: Option<Played>,
}

/// A trial that was played.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Played {
    /// Number of the trial, from 1 on; practice counts.
    pub number: u32,
    /// Number of earlier beginnings of the trial.
    pub attempt: u32,
    /// The task.
    pub task: TaskKind,
    /// `true` for practice, which does not count.
    pub practice: bool,
    /// The interval whose choice counts as yes.
    pub right: Option<u8>,
    /// The level that the method chose, dB.
    pub level_db: Option<f64>,
    /// Intervals that were played.
    pub intervals: Vec<Interval>,
    /// Time from which the answer could be given, ms since the session began.
    pub asked_ms: u64,
}

/// One interval that was played.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Stimulus of the interval.
    pub stimulus: Option<Stimulus>,
    /// Beginning of the interval, ms since the session began.
    pub began_ms: u64,
    /// The schedule as `hil run --schedule` writes it, without its head.
    pub schedule: Vec<Value>,
    /// True path of the stimulus: seconds, mm right and up on the display.
    pub path: Vec<[f64; 3]>,
    /// Bursts that the guard booked: wire, times on and off (microseconds since the interval began), energy (nJ).
    pub bursts: Vec<[u64; 4]>,
}

impl Line {
    /// Milliseconds since the session began; zero for its first line.
    #[must_use]
    pub const fn at_ms(&self) -> u64 {
        match self {
            Self::Session(_) => 0,
            Self::Playing(line) => line.at_ms,
            Self::Passing(line) => line.at_ms,
            Self::Reply(line) => line.at_ms,
            Self::Resumed(line) => line.at_ms,
            Self::Note(line) | Self::Stopped(line) => line.at_ms,
        }
    }
}

impl About {
    /// Difference from another session that would go on with this one: a sentence about the first; `None` for none.
    #[must_use]
    pub fn differs(&self, other: &Self) -> Option<String> {
        let of = |about: &Self| {
            let person = match about.simulated {
                true => "a simulated one",
                false => "a participant",
            };
            [
                ("protocol", about.protocol_digest.clone()),
                ("participant", about.participant.to_string()),
                ("seed", about.seed.to_string()),
                ("bench", about.bench.clone()),
                ("kind of bench", about.source.clone()),
                ("limits", about.limits_digest.clone()),
                ("places of wires", format!("{:?}", about.wires_mm)),
                ("person", person.into()),
            ]
        };
        let mut both = of(self).into_iter().zip(of(other));
        let ((what, own), (_, others)) = both.find(|(own, others)| own != others)?;
        Some(format!(
            "expected the {what} with which the session began, {own}, found {others}"
        ))
    }
}

impl Interval {
    /// End of the last burst, ms since the session began.
    fn until_ms(&self) -> u64 {
        let last = self
            .bursts
            .iter()
            .map(|[_, _, off_us, _]| off_us.div_ceil(1000));
        self.began_ms + last.max().unwrap_or(0)
    }
}

impl Played {
    /// A trial before its first interval.
    #[must_use]
    pub fn new(trial: &Trial) -> Self {
        Self {
            number: trial.number,
            attempt: trial.attempt,
            task: trial.task,
            practice: trial.practice,
            right: trial.right,
            level_db: trial.level_db,
            intervals: Vec::new(),
            asked_ms: 0,
        }
    }

    /// Tells whether these are the answers to this trial. Levels are not compared: texts of numbers are read to the
    /// last digit but one.
    fn is(&self, trial: &Trial) -> bool {
        let own = (self.number, self.attempt, self.task);
        own == (trial.number, trial.attempt, trial.task)
            && (self.practice, self.right) == (trial.practice, trial.right)
    }

    /// The conditions that were played, in their order.
    pub fn conditions(&self) -> impl Iterator<Item = &str> {
        self.intervals.iter().filter_map(|i| match &i.stimulus {
            Some(Stimulus::Condition(name)) => Some(name.as_str()),
            _ => None,
        })
    }

    /// The wires that were played, in their order, with their levels.
    pub fn wires(&self) -> impl Iterator<Item = (u16, f64)> {
        self.intervals.iter().filter_map(|i| match &i.stimulus {
            Some(Stimulus::Wire { wire, level_db }) => Some((*wire, *level_db)),
            _ => None,
        })
    }
}

/// Errors of a session's lines.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecordError {
    /// A line that cannot be read.
    #[error("line {line}: expected a line of a session's record: {why}")]
    Line {
        /// Number of the line, from 1 on.
        line: usize,
        /// Reason, in words.
        why: String,
    },
    /// The record begins with something else than a session.
    #[error("line 1: expected the session that the lines are of")]
    Head,
    /// Lines of another version.
    #[error("expected a record of version {VERSION}, found {0}")]
    Version(u32),
    /// An interval that was played for another trial than the open one.
    #[error(
        "line {line}: expected the trial that is open then: a line is missing or stands there twice, or the record is not of this protocol and seed"
    )]
    Trial {
        /// Number of the line, from 1 on.
        line: usize,
    },
    /// A reply that its protocol does not wait for.
    #[error("line {line}: {error}: the record is not of this protocol and seed")]
    Reply {
        /// Number of the line, from 1 on.
        line: usize,
        /// Reason why the session refuses the reply.
        error: AnswerError,
    },
}

/// A session's record.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Facts of the session.
    pub about: About,
    /// All lines after the session's.
    pub lines: Vec<Line>,
    /// Bytes of whole lines: the rest was being written when the program died.
    pub whole: usize,
}

impl Record {
    /// Reads a session's lines. An end without a line break was being written when the program died, and counts for nothing.
    ///
    /// # Errors
    /// [`RecordError`] with the line.
    pub fn read(text: &str) -> Result<Self, RecordError> {
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let mut numbered = (1..).zip(text[..whole].lines());
        let Some((_, head)) = numbered.next() else {
            return Err(RecordError::Head);
        };
        let Line::Session(about) = line(1, head)? else {
            return Err(RecordError::Head);
        };
        if about.version != VERSION {
            return Err(RecordError::Version(about.version));
        }
        let checked = |line: usize, found: Result<(), String>| {
            found.map_err(|why| RecordError::Line { line, why })
        };
        checked(1, bounds::of_session(&about))?;
        let (mut lines, mut before_ms) = (Vec::new(), 0);
        for (number, text) in numbered {
            let line = line(number, text)?;
            checked(
                number,
                bounds::of_line(&line, before_ms, about.wires_mm.len()),
            )?;
            before_ms = line.at_ms();
            lines.push(line);
        }
        Ok(Self {
            about,
            lines,
            whole,
        })
    }

    /// The session where its lines leave it.
    ///
    /// # Errors
    /// [`RecordError::Reply`] and [`RecordError::Trial`] for lines of another protocol or seed, that stand there twice, or are
    /// not all there.
    pub fn resumed(&self, protocol: Protocol) -> Result<Session, RecordError> {
        let mut session = Session::new(protocol, self.about.participant, self.about.seed);
        for (number, line) in (2..).zip(&self.lines) {
            let is_open = match (line, session.step()) {
                (Line::Playing(line), Step::Trial(trial)) => {
                    (line.number, line.attempt) == (trial.number, trial.attempt)
                }
                (Line::Playing(_), _) => false,
                (
                    Line::Reply(Said {
                        trial: Some(of), ..
                    }),
                    Step::Trial(trial),
                ) => of.is(trial),
                _ => true,
            };
            if !is_open {
                return Err(RecordError::Trial { line: number });
            }
            if let Line::Reply(said) = line {
                let taken = session.take(&said.reply);
                taken.map_err(|error| RecordError::Reply {
                    line: number,
                    error,
                })?;
            }
        }
        Ok(session)
    }

    /// Intervals that were about to be played and have no reply: they count as played.
    #[must_use]
    pub fn open(&self) -> Vec<Interval> {
        let after = self.lines.iter().rev();
        let after = after.take_while(|line| !matches!(line, Line::Reply(_)));
        let playing = after.filter_map(|line| match line {
            Line::Playing(playing) => Some(playing.interval.clone()),
            _ => None,
        });
        let mut open: Vec<Interval> = playing.collect();
        open.reverse();
        open
    }

    /// The session's time at a reading of uptime, ms. It stood still while no program had it open, unless the computer has
    /// been on since.
    #[must_use]
    pub fn now_ms(&self, uptime: &Uptime) -> u64 {
        let resumed = self.lines.iter().rev().find_map(|line| match line {
            Line::Resumed(resumed) => Some((resumed.at_ms, &resumed.uptime)),
            _ => None,
        });
        let (at_ms, then) = resumed.unwrap_or((0, &self.about.uptime));
        let passed = uptime.since(then).map_or(0, |ms| at_ms.saturating_add(ms));
        let of_replies = self.replies().filter_map(|said| said.trial.as_ref());
        let played = of_replies.flat_map(|played| &played.intervals);
        let played = played.map(Interval::until_ms).max().unwrap_or(0);
        let open = self.open();
        let unanswered = open.iter().chain(self.passes()).map(Interval::until_ms);
        let unanswered = unanswered.max().unwrap_or(0);
        passed.max(self.last_ms()).max(played).max(unanswered)
    }

    /// The time of its last line, ms since the session began.
    #[must_use]
    pub fn last_ms(&self) -> u64 {
        self.lines.last().map_or(0, Line::at_ms)
    }

    /// Replies in their order.
    pub fn replies(&self) -> impl Iterator<Item = &Said> {
        self.lines.iter().filter_map(|line| match line {
            Line::Reply(said) => Some(said),
            _ => None,
        })
    }

    /// Hot passes in their order.
    pub fn passes(&self) -> impl Iterator<Item = &Interval> {
        self.lines.iter().filter_map(|line| match line {
            Line::Passing(passing) => Some(&passing.interval),
            _ => None,
        })
    }

    /// Trials that were answered and count, with their answers.
    pub fn counted(&self) -> impl Iterator<Item = (&Played, &crate::session::Answer)> {
        self.replies()
            .filter_map(|said| match (&said.trial, &said.reply) {
                (Some(played), Reply::Answer(answer)) if !played.practice => Some((played, answer)),
                _ => None,
            })
    }
}

/// A line by its number.
fn line(number: usize, text: &str) -> Result<Line, RecordError> {
    serde_json::from_str(text).map_err(|e| RecordError::Line {
        line: number,
        why: e.to_string(),
    })
}

#[cfg(test)]
mod tests;
