//! A TOML text with its place: it parses, finds a key's line again, and words an error there.

use std::fmt::Display;
use std::ops::{Range, RangeInclusive};
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};
use toml::{Spanned, Value};

use super::change::{Change, Step, steps};
use super::error::FileError;
use super::format::Format;
use super::plain;
use super::reading::{MOST_SETTINGS, read_text};
use super::settings::Bounded;
use super::wording::{Misfit, inside};

/// Text of a file and its origin. It stays beside the value that was read, so that later checks can name a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    label: String,
    text: String,
    folder: Option<PathBuf>,
    changes: Vec<Change>,
}

impl Source {
    /// Text of a built-in file (or of a test): `label` names it in errors.
    #[must_use]
    pub fn new(label: impl Into<String>, text: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            text: text.into(),
            folder: None,
            changes: Vec::new(),
        }
    }

    /// Reads a file from disk.
    ///
    /// # Errors
    /// A file that cannot be read, is empty, or is not UTF-8 (with the line of the first wrong byte).
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let label = path.display().to_string();
        let text = read_text(path, "a settings file (TOML)", MOST_SETTINGS)?;
        if let Some(format) = Format::recognise(text.as_bytes()).filter(|f| *f != Format::Toml) {
            return Err(FileError::whole(
                label,
                "a settings file (TOML)",
                format.noun(),
            ));
        }
        if text.trim().is_empty() {
            return Err(FileError::whole(label, "a TOML file", "an empty file"));
        }
        Ok(Self {
            label,
            text,
            folder: path.parent().map(Path::to_path_buf),
            changes: Vec::new(),
        })
    }

    /// Name of this file in errors.
    #[must_use]
    pub fn label(&self) -> &str {
        &self.label
    }

    /// The text itself.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Values alone, in the order of their keys: texts that differ by comments, spaces or the order of keys have
    /// equal ones. Each text has its length in front, so that two different files never have equal ones.
    #[must_use]
    pub fn values(&self) -> String {
        let mut out = String::new();
        list(DeTable::parse_recoverable(&self.text).0.get_ref(), &mut out);
        out
    }

    /// The folder that relative names in this file start from; none for a built-in file.
    #[must_use]
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// Returns this file with these values in place of its own.
    pub(super) fn with(&self, changes: Vec<Change>) -> Self {
        Self {
            changes,
            ..self.clone()
        }
    }

    /// The values that stand in place of its own, in their order.
    pub(super) fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// The change that decides the value at `key`; the last one counts.
    fn change(&self, key: &str) -> Option<&Change> {
        self.changes.iter().rfind(|change| change.covers(key))
    }

    /// The change that made the table at `key`, which the file does not have.
    fn made(&self, key: &str) -> Option<&Change> {
        let table = Change {
            by: String::new(),
            key: key.into(),
            value: None,
        };
        let inside = |change: &&Change| change.value.is_some() && table.covers(&change.key);
        self.text_at(key)
            .is_none()
            .then(|| self.changes.iter().rfind(inside))?
    }

    /// Returns true if a value stands at `key`.
    pub(super) fn states(&self, key: &str) -> bool {
        match self.change(key) {
            Some(change) => change.value.is_some(),
            None => self.spans(key).is_some_and(|(_, value)| value.is_some()),
        }
    }

    /// The folder that a relative name at `key` starts from; none where a change stated the name.
    pub(super) fn folder_of(&self, key: &str) -> Option<&Path> {
        self.folder().filter(|_| self.change(key).is_none())
    }

    /// An error at `key`; its finding is read back from the text.
    #[must_use]
    pub fn bad(&self, key: &str, expected: impl Into<String>) -> FileError {
        let found = self.value_text(key).unwrap_or_else(|| "nothing".into());
        self.bad_found(key, expected, found)
    }

    /// An error at `key` with the finding in words.
    #[must_use]
    pub fn bad_found(
        &self,
        key: &str,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> FileError {
        let change = self.change(key).or_else(|| self.made(key));
        // Errors of core bring the word with them.
        let expected: String = expected.into();
        let expected = expected.strip_prefix("expected ").unwrap_or(&expected);
        FileError {
            path: change.map_or(&self.label, |change| &change.by).clone(),
            line: change.is_none().then(|| self.line_of(key)),
            key: Some(key.into()),
            expected: expected.into(),
            found: found.into(),
        }
    }

    /// Reads the whole text as a type.
    pub(super) fn read<T: DeserializeOwned>(&self) -> Result<T, FileError> {
        plain::read(&self.value()?).map_err(|(key, misfit)| self.misfit(&key, misfit))
    }

    fn misfit(&self, key: &str, misfit: Misfit) -> FileError {
        let key = misfit.field.map_or(key.into(), |field| inside(key, &field));
        match misfit.found {
            Some(found) => self.bad_found(&key, misfit.expected, found),
            None => self.bad(&key, misfit.expected),
        }
    }

    /// Value of the text, with all changes.
    pub(super) fn value(&self) -> Result<Value, FileError> {
        let table = plain::table(self.parse()?.get_ref());
        let table = table.map_err(|(key, expected)| self.bad(&key, expected))?;
        let mut value = Value::Table(table);
        for change in &self.changes {
            let applied = change.apply(&mut value);
            applied.map_err(|expected| self.bad(&change.key, expected))?;
        }
        Ok(value)
    }

    /// The text of one top-level string, before anything else is known about the file.
    pub(super) fn peek(&self, key: &str) -> Result<Option<String>, FileError> {
        if let Some(change) = self.change(key) {
            let value = change.value.as_deref();
            return Ok(value.map(|text| text.trim_matches('"').to_owned()));
        }
        let table = self.parse()?;
        Ok(table
            .get_ref()
            .get(key)
            .and_then(|value| value.get_ref().as_str().map(str::to_owned)))
    }

    /// The keys at the top of the file; none where it is no TOML.
    pub(super) fn top_keys(&self) -> Vec<String> {
        let (table, _) = DeTable::parse_recoverable(&self.text);
        let keys = table.get_ref().keys();
        keys.map(|key| key.get_ref().to_string()).collect()
    }

    /// Errors that make the text no TOML.
    pub(super) fn syntax_errors(&self) -> Vec<FileError> {
        let (_, errors) = DeTable::parse_recoverable(&self.text);
        errors.iter().map(|error| self.syntax(error)).collect()
    }

    /// Returns this file with another word for the last part of `key`; none where that makes it no TOML.
    pub(super) fn renamed(&self, key: &str, word: &str) -> Option<Self> {
        let (place, value) = self.spans(key)?;
        value?;
        let mut text = self.text.clone();
        text.replace_range(place, word);
        let renamed = Self {
            text,
            ..self.clone()
        };
        renamed.syntax_errors().is_empty().then_some(renamed)
    }

    /// The text without a key of an inline table, and the key's line; none where it stands elsewhere.
    pub(super) fn cut(&self, key: &str) -> Option<(usize, String)> {
        let (name, value) = self.spans(key)?;
        let (mut begin, mut end) = (name.start, value?.end);
        let rest = &self.text[end..];
        // The comma behind it goes too, else the one before it.
        if let Some(after) = rest.trim_start().strip_prefix(',') {
            end = self.text.len() - after.trim_start_matches(' ').len();
        } else if let Some(before) = self.text[..begin].trim_end().strip_suffix(',') {
            begin = before.len();
        }
        let mut text = self.text.clone();
        text.replace_range(begin..end, "");
        Some((self.line_at(name.start), text))
    }

    /// Text at `key`, as the file writes it; dotted keys with those below them.
    pub(super) fn value_at(&self, key: &str) -> Option<String> {
        if let Some(text) = self.text_at(key).filter(|t| t.contains(['=', '"'])) {
            return Some(text.to_owned());
        }
        let below = format!("{key}.law");
        self.text_at(&below).map(str::to_owned)
    }

    /// The value that stands at `key`, as the file writes it.
    fn text_at(&self, key: &str) -> Option<&str> {
        self.text.get(self.spans(key)?.1?)
    }

    /// Checks that `value`, or each of its numbers, lies in `range`.
    pub(super) fn range<T: Bounded<Number: Display>>(
        &self,
        key: &str,
        value: &T,
        range: RangeInclusive<T::Number>,
        unit: &str,
    ) -> Result<(), FileError> {
        let Some(key) = value.outside(key, &range) else {
            return Ok(());
        };
        let space = if unit.is_empty() { "" } else { " " };
        let (low, high) = range.into_inner();
        Err(self.bad(&key, format!("a number from {low} to {high}{space}{unit}")))
    }

    /// Checks the file's own name and description: lower case with hyphens, and not empty.
    pub(super) fn heading(&self, name: &str, description: &str) -> Result<(), FileError> {
        self.name("name", name)?;
        if description.trim().is_empty() {
            return Err(self.bad("description", "a sentence"));
        }
        Ok(())
    }

    /// Checks a name of a file or of something in it.
    pub(super) fn name(&self, key: &str, name: &str) -> Result<(), FileError> {
        let lower = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if name.is_empty() || !name.chars().all(lower) {
            return Err(self.bad(key, "lower-case letters, digits and hyphens"));
        }
        Ok(())
    }

    fn parse(&self) -> Result<Spanned<DeTable<'_>>, FileError> {
        DeTable::parse(&self.text).map_err(|error| self.syntax(&error))
    }

    fn syntax(&self, error: &toml::de::Error) -> FileError {
        let line = error.span().map(|span| self.line_at(span.start));
        FileError {
            path: self.label.clone(),
            line,
            key: None,
            expected: "valid TOML".into(),
            found: error.message().replace('\n', ", "),
        }
    }

    /// The line of `key`, or of the nearest table around it that is there.
    pub(super) fn line_of(&self, key: &str) -> usize {
        self.spans(key)
            .map_or(1, |(span, _)| self.line_at(span.start))
    }

    fn value_text(&self, key: &str) -> Option<String> {
        if let Some(change) = self.change(key) {
            return change.value.clone();
        }
        let (_, value) = self.spans(key)?;
        let text = self.text.get(value?)?;
        let line = text.lines().next().unwrap_or_default();
        let short: String = line.chars().take(60).collect();
        let cut = short.len() < text.trim_end().len();
        Some(if cut { format!("{short} ...") } else { short })
    }

    /// Finds the deepest part of `key` that exists, and the value's span if all of it exists.
    fn spans(&self, key: &str) -> Option<(Range<usize>, Option<Range<usize>>)> {
        let table = DeTable::parse(&self.text).ok()?;
        let mut place = None;
        let mut here: Option<Spanned<DeValue<'_>>> = None;
        for step in steps(key) {
            let next = match (&step, here.as_ref().map(Spanned::get_ref)) {
                (Step::Key(name), None) if place.is_none() => entry(table.get_ref(), name),
                (Step::Key(name), Some(DeValue::Table(inner))) => entry(inner, name),
                (Step::Index(index), Some(DeValue::Array(items))) => {
                    items.get(*index).map(|item| (item.span(), item.clone()))
                }
                _ => None,
            };
            let Some((span, value)) = next else {
                return place.map(|span| (span, None));
            };
            place = Some(span);
            here = Some(value);
        }
        place.map(|span| (span, here.map(|value| value.span())))
    }

    fn line_at(&self, byte: usize) -> usize {
        let end = byte.min(self.text.len());
        1 + newlines(&self.text.as_bytes()[..end])
    }
}

fn entry<'i>(table: &DeTable<'i>, name: &str) -> Option<(Range<usize>, Spanned<DeValue<'i>>)> {
    let (key, value) = table.get_key_value(name)?;
    Some((key.span(), value.clone()))
}

fn newlines(bytes: &[u8]) -> usize {
    bytes.iter().filter(|byte| **byte == b'\n').count()
}

fn list(table: &DeTable<'_>, out: &mut String) {
    out.push('{');
    for (key, value) in table {
        text(key.get_ref(), out);
        one(value.get_ref(), out);
    }
    out.push('}');
}

fn one(value: &DeValue<'_>, out: &mut String) {
    match value {
        DeValue::String(words) => text(words, out),
        DeValue::Table(table) => list(table, out),
        DeValue::Array(items) => {
            out.push('[');
            items.iter().for_each(|item| one(item.get_ref(), out));
            out.push(']');
        }
        DeValue::Integer(number) => *out += &format!("{number} "),
        DeValue::Float(number) => *out += &format!("{number} "),
        DeValue::Boolean(truth) => *out += &format!("{truth} "),
        // The mark in front tells a time from a length, which begin alike.
        DeValue::Datetime(date) => *out += &format!("@{date} "),
    }
}

fn text(words: &str, out: &mut String) {
    *out += &format!("{}:{words}", words.len());
}

#[cfg(test)]
#[path = "source_tests.rs"]
mod tests;
