//! Value change dumps as digital signals: IEEE 1364-2005, 18.2, with what simulators and SystemVerilog add to it.
//!
//! Line by line, word by word, so that a dump of any length takes the memory of its edges. Times begin at the first stamp. An
//! unknown level (x) and the time between `$dumpoff` and `$dumpon` are not seen.

use std::io::Read;

use palpate_files::{FileError, LONGEST_LINE, Lines, Text};

use super::declared::{Declared, Wrong};
use super::edges::Capture;
use super::{MOST_CHANGES, too_long};

/// Most words of a declaration: a path of scopes has no more.
const MOST_WORDS: usize = 256;
/// Kinds of variables that are no levels.
const NO_LEVELS: [&str; 6] = [
    "real",
    "realtime",
    "shortreal",
    "string",
    "event",
    "parameter",
];

/// Expectation of what stands before the values.
const BODY: &str = "declarations that end with $enddefinitions";

/// The section that is read, up to its `$end`.
#[derive(Debug, PartialEq, Eq)]
enum Section {
    /// None, or one that holds values.
    Values,
    Skipped,
    /// A declaration, by its keyword.
    Words(String),
}

/// A value whose variable is the next word.
#[derive(Clone, Copy, Debug)]
enum Pending {
    Level(Option<bool>),
    NoLevel,
}

/// A dump as far as it was read.
struct Dump {
    capture: Capture,
    declared: Declared<String>,
    section: Section,
    words: Vec<String>,
    /// Length of a tick: numerator and denominator of nanoseconds.
    tick: Option<(u64, u64)>,
    in_body: bool,
    pending: Option<Pending>,
    zero: Option<i128>,
    now: u64,
    changes: usize,
    /// Time since which nothing is recorded.
    off: Option<u64>,
}

/// Reads a dump. One that is damaged gives what came before, with a note.
///
/// # Errors
/// [`FileError`] for wrong declarations, and more changes than are held.
pub(super) fn read(label: &str, input: impl Read) -> Result<Capture, FileError> {
    let mut lines = Lines::over(Text::new(label, input, LONGEST_LINE));
    let mut dump = Dump {
        capture: Capture::default(),
        declared: Declared::none(),
        section: Section::Values,
        words: Vec::new(),
        tick: None,
        in_body: false,
        pending: None,
        zero: None,
        now: 0,
        changes: 0,
        off: None,
    };
    let mut last = 0;
    loop {
        let wrong = match lines.advance() {
            Ok(None) => break,
            Ok(Some((number, line))) => {
                last = number;
                let mut words = line.split_ascii_whitespace();
                words.try_for_each(|word| dump.word(word)).err()
            }
            Err(error) if dump.in_body => {
                dump.cut(&error.to_string());
                break;
            }
            Err(error) => return Err(error),
        };
        let bad = |(expected, found): (&str, String)| FileError {
            line: Some(last),
            ..FileError::whole(label, expected, found)
        };
        if let Some(wrong) = wrong {
            let error = bad(wrong);
            if !dump.in_body {
                return Err(error);
            }
            dump.cut(&error.to_string());
            break;
        }
        if dump.changes > MOST_CHANGES {
            return Err(too_long(label, Some(last)));
        }
    }
    if !dump.in_body {
        return Err(FileError {
            line: Some(last.max(1)),
            ..FileError::whole(label, BODY, "none")
        });
    }
    let is_scaled = dump.tick.is_some();
    let mut capture = dump.finish();
    if !is_scaled {
        let note = format!("{label}: no $timescale: stamps are taken for nanoseconds");
        capture.notes.push(note);
    }
    capture.notes.extend(lines.note());
    Ok(capture)
}

impl Dump {
    fn word(&mut self, word: &str) -> Result<(), Wrong> {
        if word == "$end" {
            return self.end();
        }
        match self.section {
            Section::Skipped => return Ok(()),
            Section::Words(_) if self.words.len() == MOST_WORDS => {
                let found = format!("{MOST_WORDS} words");
                return Err(("a declaration that ends with $end", found));
            }
            Section::Words(_) => {
                self.words.push(word.to_owned());
                return Ok(());
            }
            Section::Values => {}
        }
        if let Some(pending) = self.pending.take() {
            if let Pending::Level(level) = pending {
                self.change(word, level);
            }
            return Ok(());
        }
        let unknown = || ("a keyword, a stamp or a value", quoted(word));
        let (first, rest) = word.split_at_checked(1).ok_or_else(unknown)?;
        match first {
            "$" => self.keyword(word),
            _ if !self.in_body => {
                return Err((BODY, quoted(word)));
            }
            "#" => return self.stamp(rest),
            "b" | "B" => {
                let last = rest.bytes().last().ok_or_else(unknown)?;
                self.pending = Some(Pending::Level(level(last).ok_or_else(unknown)?));
            }
            "r" | "R" | "s" | "S" => self.pending = Some(Pending::NoLevel),
            _ => {
                let level = first.bytes().next().and_then(level).ok_or_else(unknown)?;
                if rest.is_empty() {
                    return Err(unknown());
                }
                self.change(rest, level);
            }
        }
        Ok(())
    }

    fn keyword(&mut self, word: &str) {
        match word {
            "$dumpvars" | "$dumpall" => return,
            "$dumpoff" => {
                self.off.get_or_insert(self.now);
                return;
            }
            "$dumpon" => {
                self.recorded_again();
                return;
            }
            "$enddefinitions" => self.in_body = true,
            "$upscope" => self.declared.leave(),
            "$var" | "$scope" | "$timescale" => {
                self.words.clear();
                self.section = Section::Words(word.to_owned());
                return;
            }
            _ => {}
        }
        self.section = Section::Skipped;
    }

    fn end(&mut self) -> Result<(), Wrong> {
        let section = std::mem::replace(&mut self.section, Section::Values);
        let Section::Words(keyword) = section else {
            return Ok(());
        };
        let words = std::mem::take(&mut self.words);
        match keyword.as_str() {
            "$scope" => self
                .declared
                .enter(words.last().cloned().unwrap_or_default())?,
            "$timescale" => {
                let text = words.concat();
                let tick = tick(&text);
                let expected = "a $timescale of 1 and more s, ms, us, ns, ps or fs";
                self.tick = Some(tick.ok_or_else(|| (expected, quoted(&text)))?);
            }
            _ => self.variable(&words)?,
        }
        Ok(())
    }

    /// Declares a variable of one bit; others have no level.
    fn variable(&mut self, words: &[String]) -> Result<(), Wrong> {
        let [kind, width, code, name, index @ ..] = words else {
            let expected = "a kind, a width, a code and a name behind $var";
            return Err((expected, quoted(&words.join(" "))));
        };
        if width != "1" || NO_LEVELS.contains(&kind.as_str()) {
            return Ok(());
        }
        let name = [name].into_iter().chain(index).map(String::as_str);
        self.declared.add(code.clone(), name)
    }

    fn stamp(&mut self, text: &str) -> Result<(), Wrong> {
        let expected = "a stamp that is a whole number";
        let found = || (expected, format!("`#{}`", shortened(text)));
        let stamp: i128 = text.parse().map_err(|_| found())?;
        let since = stamp.saturating_sub(*self.zero.get_or_insert(stamp));
        let (up, down) = self.tick.unwrap_or((1, 1));
        let ns = since.saturating_mul(i128::from(up)) / i128::from(down);
        let ns = u64::try_from(ns.max(0)).unwrap_or(u64::MAX);
        self.now = self.now.max(ns);
        Ok(())
    }

    fn change(&mut self, code: &str, level: Option<bool>) {
        let Some(place) = self.declared.place(code) else {
            return;
        };
        let signal = &mut self.declared.signals[place];
        self.changes += usize::from(signal.change(self.now, level));
    }

    fn recorded_again(&mut self) {
        if let Some(from) = self.off.take() {
            self.capture.unrecorded.push((from, self.now));
        }
    }

    /// Notes that the rest was not read.
    fn cut(&mut self, why: &str) {
        self.capture.notes.push(format!(
            "{why}; {} changes until {:.6} s were read",
            self.changes,
            self.now as f64 * 1e-9
        ));
    }

    fn finish(mut self) -> Capture {
        self.recorded_again();
        let (up, down) = self.tick.unwrap_or((1, 1));
        let Capture {
            unrecorded, notes, ..
        } = self.capture;
        Capture {
            unrecorded,
            notes,
            ..Capture::of_dump(self.declared.signals, up / down, self.now)
        }
    }
}

/// The beginning of a text in quotes.
fn quoted(text: &str) -> String {
    format!("`{}`", shortened(text))
}

fn shortened(text: &str) -> String {
    text.chars().take(60).collect()
}

/// A level by its sign; none within for an unknown one. Floating is not driven.
pub(super) fn level(sign: u8) -> Option<Option<bool>> {
    match sign {
        b'1' | b'h' | b'H' => Some(Some(true)),
        b'0' | b'l' | b'L' | b'z' | b'Z' => Some(Some(false)),
        b'x' | b'X' | b'u' | b'U' | b'w' | b'W' | b'-' => Some(None),
        _ => None,
    }
}

/// A time scale such as `10ns` as numerator and denominator of nanoseconds.
fn tick(text: &str) -> Option<(u64, u64)> {
    let unit_at = text.find(|c: char| !c.is_ascii_digit())?;
    let (count, unit) = text.split_at(unit_at);
    let count: u64 = count.parse().ok().filter(|n| (1..=1000).contains(n))?;
    Some(match unit.trim() {
        "s" => (count * 1_000_000_000, 1),
        "ms" => (count * 1_000_000, 1),
        "us" => (count * 1000, 1),
        "ns" => (count, 1),
        "ps" => (count, 1000),
        "fs" => (count, 1_000_000),
        _ => return None,
    })
}

#[cfg(test)]
#[path = "dump_tests.rs"]
mod tests;
