//! How a comparison ended, in a word and with its reasons.

use serde::{Serialize, Serializer};

/// How it ended; later ones are graver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// All that was planned was seen, and was as planned.
    #[default]
    Ok,
    /// Something that was planned was not seen.
    Incomplete,
    /// Something was otherwise than planned.
    Failed,
}

impl Verdict {
    /// As people read it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Ok => "OK",
            Self::Incomplete => "INCOMPLETE",
            Self::Failed => "FAILED",
        }
    }

    /// As programs read it.
    const fn key(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Incomplete => "incomplete",
            Self::Failed => "failed",
        }
    }
}

impl Serialize for Verdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.key())
    }
}

/// A verdict and its reasons, that of the verdict first.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Conclusion {
    /// The verdict.
    pub verdict: Verdict,
    /// Why.
    pub why: Vec<String>,
}

impl Conclusion {
    /// Adds a finding. A graver one than those before becomes the verdict, and its reason the first.
    pub fn add(&mut self, verdict: Verdict, why: impl Into<String>) {
        let graver = verdict > self.verdict;
        let at = if graver { 0 } else { self.why.len() };
        self.why.insert(at, why.into());
        self.verdict = self.verdict.max(verdict);
    }

    /// The verdict and its reason in a line.
    pub fn line(&self) -> String {
        match self.why.first() {
            Some(why) => format!("{}: {why}", self.verdict.word()),
            None => self.verdict.word().to_owned(),
        }
    }
}
