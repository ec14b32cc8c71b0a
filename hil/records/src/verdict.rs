//! Verdict of a run, a trial or a comparison: one word, its reasons, and how graver ones win.

use std::io::{self, Write};

use serde::Serialize;

use crate::margin::Margin;

palpate_core::listed! {
    /// Verdict of a run, a trial or a comparison. Later ones are graver; where several apply, the gravest is the verdict.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Verdict: word {
        /// Done, and within all limits.
        #[default]
        Ok = "OK",
        /// Most of what touched lay beyond the part of the skin that the display shows.
        OffThePad = "OFF THE PAD",
        /// Most of what was to be felt was not.
        NotFelt = "NOT FELT",
        /// Something that was to be seen was not: a board that is silent, a capture that ends too early.
        Incomplete = "INCOMPLETE",
        /// The guard or a person ended it.
        Stopped = "STOPPED",
        /// A check failed, or a bus or device did.
        Failed = "FAILED",
        /// Something physically passed a row of the limit table.
        LimitExceeded = "LIMIT EXCEEDED",
        /// A temperature or a wire's bow left the range in which the model of wire and tissue means anything.
        BeyondTheModel = "BEYOND THE MODEL",
    }
}

impl Verdict {
    /// Word for programs.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::OffThePad => "off-the-pad",
            Self::NotFelt => "not-felt",
            Self::Incomplete => "incomplete",
            Self::Stopped => "stopped",
            Self::Failed => "failed",
            Self::LimitExceeded => "limit-exceeded",
            Self::BeyondTheModel => "beyond-the-model",
        }
    }

    /// Verdict of a [`Verdict::key`]; `None` for another word.
    pub fn of_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|verdict| verdict.key() == key)
    }

    /// Tells whether a run that ended so did all that it was to
    /// do; an expectation says whether a person has to feel it.
    pub const fn is_done(self) -> bool {
        matches!(self, Self::Ok | Self::OffThePad | Self::NotFelt)
    }

    /// Tells whether a person who wore the display may have been burnt.
    pub const fn is_harmful(self) -> bool {
        matches!(self, Self::LimitExceeded | Self::BeyondTheModel)
    }

    /// Some words in the verdict's colour on a terminal: green, yellow or red.
    pub fn paint(self, words: &str, colored: bool) -> String {
        if !colored {
            return words.to_owned();
        }
        let code = match self {
            Self::Ok => 32,
            Self::OffThePad | Self::NotFelt | Self::Incomplete | Self::Stopped => 33,
            Self::Failed | Self::LimitExceeded | Self::BeyondTheModel => 31,
        };
        format!("\x1b[1m\x1b[{code}m{words}\x1b[0m")
    }
}

/// A verdict and its reasons, that of the verdict first.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Conclusion {
    /// The verdict.
    pub verdict: Verdict,
    /// Reasons; for [`Verdict::Ok`], what a reader may wonder at.
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

    /// The verdict with its reason, then the other reasons, each in lines of at most [`COLUMNS`].
    ///
    /// # Errors
    /// Errors of the stream.
    pub fn write(&self, out: &mut dyn Write, colored: bool) -> io::Result<()> {
        let word = self.verdict.word();
        let text = wrapped(&self.line(), COLUMNS);
        let rest = text.strip_prefix(word).unwrap_or_default();
        writeln!(out, "{}{rest}", self.verdict.paint(word, colored))?;
        self.write_others(out, COLUMNS)
    }

    fn write_others(&self, out: &mut dyn Write, columns: usize) -> io::Result<()> {
        let mut others = self.why.iter().skip(1);
        others.try_for_each(|why| writeln!(out, "{}", wrapped(&format!("  also: {why}"), columns)))
    }

    /// The other reasons, then the verdict with its own: what stays in view on a terminal of so many columns.
    ///
    /// # Errors
    /// Errors of the stream.
    pub fn write_last(&self, out: &mut dyn Write, columns: usize, colored: bool) -> io::Result<()> {
        self.write_others(out, columns)?;
        let word = self.verdict.word();
        let text = wrapped(&self.line(), columns);
        let rest = text.strip_prefix(word).unwrap_or_default();
        writeln!(out, "{}{rest}", self.verdict.paint(word, colored))
    }
}

/// Columns of a terminal.
pub const COLUMNS: usize = 80;

/// Breaks a text into lines of at most this many columns, where its words allow; those after the first are indented.
#[must_use]
pub fn wrapped(text: &str, columns: usize) -> String {
    let start = text.len() - text.trim_start().len();
    let (mut out, mut filled) = (text[..start].to_owned(), start);
    for (index, word) in text.split_whitespace().enumerate() {
        let wide = word.chars().count();
        if index > 0 && filled + 1 + wide > columns {
            out.push_str("\n    ");
            filled = 4;
        } else if index > 0 {
            out.push(' ');
            filled += 1;
        }
        out.push_str(word);
        filled += wide;
    }
    out
}

#[cfg(test)]
#[path = "verdict_tests.rs"]
mod tests;
