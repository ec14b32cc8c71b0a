//! What is kept of a session, a line of JSON each: the session, every reply with what was played before it, notes, stops.
//!
//! A session is begun again from these lines alone, and all that is said of it is computed from them.

use palpate_files::{Protocol, TaskKind};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::session::{AnswerError, Reply, Session, Stimulus, Trial};

/// Version of these lines; grows when a field changes what it says.
pub const VERSION: u32 = 1;

/// A line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Line {
    /// The first one.
    Session(About),
    /// What was said to a step.
    Reply(Said),
    /// What the experimenter noted.
    Note(Noted),
    /// The session was begun again.
    Resumed(Noted),
    /// The participant or the guard stopped it: everything off.
    Stopped(Noted),
}

/// What a session is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// [`VERSION`].
    pub version: u32,
    /// Version of the program.
    pub palpate: String,
    /// Name of the protocol.
    pub protocol: String,
    /// SHA-256 of the values of the protocol's file, first 16 hex digits.
    pub protocol_digest: String,
    /// From 1 on.
    pub participant: u32,
    /// What its order follows from.
    pub seed: u64,
    /// Name of the bench.
    pub bench: String,
    /// `emulated` or `real`.
    pub source: String,
    /// SHA-256 of the values of the limit table in force, first 16 hex digits.
    pub limits_digest: String,
    /// Where the display's wires lie, mm.
    pub wires_mm: Vec<[f64; 2]>,
    /// When it began, UTC.
    pub began: String,
    /// The same in milliseconds since 1970: times of lines count from here.
    pub began_unix_ms: u64,
    /// Whether a simulated person answers.
    pub simulated: bool,
    /// The share of the session's dose that it takes at its strongest.
    pub dose_planned: f64,
}

/// A line of text.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Noted {
    /// Milliseconds since the session began.
    pub at_ms: u64,
    /// What was noted.
    pub text: String,
}

/// A reply.
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

/// A trial as it was played.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Played {
    /// From 1 on, practice counts.
    pub number: u32,
    /// How often it was begun before.
    pub attempt: u32,
    /// The task.
    pub task: TaskKind,
    /// Whether it does not count.
    pub practice: bool,
    /// The interval whose choice counts as yes.
    pub right: Option<u8>,
    /// The level that the method chose, dB.
    pub level_db: Option<f64>,
    /// What was played.
    pub intervals: Vec<Interval>,
    /// When the answer could be given, ms since the session began.
    pub asked_ms: u64,
}

/// One interval as it was played.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// What it is.
    pub stimulus: Option<Stimulus>,
    /// When it began, ms since the session began.
    pub began_ms: u64,
    /// The schedule as `hil run --schedule` writes it, without its head.
    pub schedule: Vec<Value>,
    /// Where it truly went: seconds, mm right and up on the display.
    pub path: Vec<[f64; 3]>,
    /// What the guard booked: wire, when it went on and off (microseconds since the interval began), energy (nJ).
    pub bursts: Vec<[u64; 4]>,
}

impl Played {
    /// A trial of which nothing was played yet.
    #[must_use]
    pub fn of(trial: &Trial) -> Self {
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

/// What cannot be a session's lines.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecordError {
    /// A line that is none.
    #[error("line {line}: expected a line of a session's record: {why}")]
    Line {
        /// From 1 on.
        line: usize,
        /// What is wrong.
        why: String,
    },
    /// It begins with something else.
    #[error("line 1: expected the session that the lines are of")]
    Head,
    /// Lines of another version.
    #[error("expected a record of version {VERSION}, found {0}")]
    Version(u32),
    /// A reply that its protocol does not wait for.
    #[error("line {line}: {error}: the record is not of this protocol and seed")]
    Reply {
        /// From 1 on.
        line: usize,
        /// What was expected.
        error: AnswerError,
    },
}

/// A session's record.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// What it is.
    pub about: About,
    /// Everything after its head.
    pub lines: Vec<Line>,
    /// Bytes of whole lines: what comes after them was being written when the program died.
    pub whole: usize,
}

impl Record {
    /// Reads a session's lines. An end without a line break was being written when the program died, and counts for nothing.
    ///
    /// # Errors
    /// [`RecordError`] with the line.
    pub fn read(text: &str) -> Result<Self, RecordError> {
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let mut lines = Vec::new();
        for (number, line) in text[..whole].lines().enumerate() {
            let read = serde_json::from_str(line);
            let read = read.map_err(|e: serde_json::Error| RecordError::Line {
                line: number + 1,
                why: e.to_string(),
            })?;
            lines.push(read);
        }
        let head = (!lines.is_empty()).then(|| lines.remove(0));
        let Some(Line::Session(about)) = head else {
            return Err(RecordError::Head);
        };
        if about.version != VERSION {
            return Err(RecordError::Version(about.version));
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
    /// [`RecordError::Reply`] for lines of another protocol.
    pub fn resumed(&self, protocol: Protocol) -> Result<Session, RecordError> {
        let mut session = Session::new(protocol, self.about.participant, self.about.seed);
        for (number, line) in self.lines.iter().enumerate() {
            if let Line::Reply(said) = line {
                session
                    .take(&said.reply)
                    .map_err(|error| RecordError::Reply {
                        line: number + 2,
                        error,
                    })?;
            }
        }
        Ok(session)
    }

    /// Replies in their order.
    pub fn replies(&self) -> impl Iterator<Item = &Said> {
        self.lines.iter().filter_map(|line| match line {
            Line::Reply(said) => Some(said),
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
