//! How a run, a trial or a comparison ended: one word, its reasons, and how graver ones win.

use std::io::{self, Write};

use serde::{Serialize, Serializer};

use crate::margin::Margin;

/// How it ended. Later ones are graver; where several apply, the gravest is the verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Done, and within all limits.
    #[default]
    Ok,
    /// Something that was to be seen was not: a board that is silent, a capture that ends too early.
    Incomplete,
    /// The guard or a person ended it.
    Stopped,
    /// A check failed, or a bus or device did.
    Failed,
    /// Something physically passed a row of the limit table.
    LimitExceeded,
}

impl Verdict {
    /// As people read it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Ok => "OK",
            Self::Incomplete => "INCOMPLETE",
            Self::Stopped => "STOPPED",
            Self::Failed => "FAILED",
            Self::LimitExceeded => "LIMIT EXCEEDED",
        }
    }

    /// As programs read it.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Incomplete => "incomplete",
            Self::Stopped => "stopped",
            Self::Failed => "failed",
            Self::LimitExceeded => "limit-exceeded",
        }
    }

    /// What [`Verdict::key`] says; `None` for another word.
    pub fn of_key(key: &str) -> Option<Self> {
        let all = [
            Self::Ok,
            Self::Incomplete,
            Self::Stopped,
            Self::Failed,
            Self::LimitExceeded,
        ];
        all.into_iter().find(|verdict| verdict.key() == key)
    }

    /// Some words in the verdict's colour on a terminal: green, yellow or red.
    pub fn paint(self, words: &str, colored: bool) -> String {
        if !colored {
            return words.to_owned();
        }
        let code = match self {
            Self::Ok => 32,
            Self::Incomplete | Self::Stopped => 33,
            Self::Failed | Self::LimitExceeded => 31,
        };
        format!("\x1b[1m\x1b[{code}m{words}\x1b[0m")
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
    /// Why; for [`Verdict::Ok`], what a reader may wonder at.
    pub why: Vec<String>,
}

impl Conclusion {
    /// Adds a finding. A graver one than those before becomes the verdict, and its reason the first.
    pub fn add(&mut self, verdict: Verdict, why: impl Into<String>) {
        let at = if verdict > self.verdict {
            0
        } else {
            self.why.len()
        };
        self.why.insert(at, why.into());
        self.verdict = self.verdict.max(verdict);
    }

    /// Adds the rows of the limit table that were passed, if any were.
    pub fn add_margins(&mut self, margins: &[Margin]) {
        let over: Vec<&Margin> = margins.iter().filter(|m| m.over()).collect();
        if let [worst, ..] = over.as_slice() {
            let text = format!(
                "{} of {} rows of the limit table, most of all {} ({} used)",
                over.len(),
                margins.len(),
                worst.of.name(),
                worst.used_words()
            );
            self.add(Verdict::LimitExceeded, text);
        }
    }

    /// The verdict and its reason in a line.
    pub fn line(&self) -> String {
        match self.why.first() {
            Some(why) => format!("{}: {why}", self.verdict.word()),
            None => self.verdict.word().to_owned(),
        }
    }

    /// The verdict with its reason, then the other reasons, a line each.
    ///
    /// # Errors
    /// What the stream says.
    pub fn write(&self, out: &mut dyn Write, colored: bool) -> io::Result<()> {
        let word = self.verdict.word();
        let line = self.line();
        let rest = line.strip_prefix(word).unwrap_or_default();
        writeln!(out, "{}{rest}", self.verdict.paint(word, colored))?;
        let others = self.why.iter().skip(1);
        others
            .into_iter()
            .try_for_each(|why| writeln!(out, "  also: {why}"))
    }
}

#[cfg(test)]
#[path = "verdict_tests.rs"]
mod tests;
