//! A TOML text with its place: parsing it, finding a key's line again, and saying what is wrong there.

use std::fmt::Display;
use std::ops::{Range, RangeInclusive};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::FileError;
use super::wording::expectation;

/// A file's text and where it came from. Kept beside what was read, so that later checks can name a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    label: String,
    text: String,
    folder: Option<PathBuf>,
}

impl Source {
    /// A text of a built-in file (or of a test): `label` names it in errors.
    #[must_use]
    pub fn new(label: impl Into<String>, text: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            text: text.into(),
            folder: None,
        }
    }

    /// Reads a file from disk.
    ///
    /// # Errors
    /// When it cannot be read, is empty, or is not UTF-8 (with the line of the first wrong byte).
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let label = path.display().to_string();
        let bytes = std::fs::read(path)
            .map_err(|error| FileError::whole(&label, "a readable file", error.to_string()))?;
        let text = String::from_utf8(bytes).map_err(|error| {
            let good = error.utf8_error().valid_up_to();
            FileError {
                path: label.clone(),
                line: Some(1 + newlines(&error.as_bytes()[..good])),
                key: None,
                expected: "UTF-8 text".into(),
                found: format!("byte 0x{:02X}", error.as_bytes()[good]),
            }
        })?;
        if text.trim().is_empty() {
            return Err(FileError::whole(label, "a TOML file", "an empty file"));
        }
        Ok(Self {
            label,
            text,
            folder: path.parent().map(Path::to_path_buf),
        })
    }

    /// How errors name this file.
    #[must_use]
    pub fn label(&self) -> &str {
        &self.label
    }

    /// The text itself, for digests.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The folder that relative names in this file start from; none for a built-in file.
    #[must_use]
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// An error at `key`; what was found is read back from the text.
    #[must_use]
    pub fn bad(&self, key: &str, expected: impl Into<String>) -> FileError {
        let found = self.value_text(key).unwrap_or_else(|| "nothing".into());
        self.bad_found(key, expected, found)
    }

    /// An error at `key` with what was found in words.
    #[must_use]
    pub fn bad_found(
        &self,
        key: &str,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> FileError {
        FileError {
            path: self.label.clone(),
            line: Some(self.line_of(key)),
            key: Some(key.into()),
            expected: expected.into(),
            found: found.into(),
        }
    }

    /// Deserialises the whole text; numbers that no machine holds are refused first, since the plain value has no place for them.
    pub(super) fn read<T: DeserializeOwned>(&self) -> Result<T, FileError> {
        let table = self.parse()?;
        self.refuse_numbers(&mut String::new(), table.get_ref())?;
        let deserializer = toml::Deserializer::from(table);
        // Through the plain value: the parser's own deserialisers would each be compiled once more for every type.
        let value = toml::Value::deserialize(deserializer).map_err(|error| self.syntax(&error))?;
        serde_path_to_error::deserialize(value).map_err(|error| {
            let path = error.path().to_string();
            let path = if path == "." { "" } else { &path };
            let wrong = expectation(path, error.inner().message());
            let found = wrong.found.unwrap_or_else(|| {
                self.value_text(&wrong.key)
                    .unwrap_or_else(|| "nothing".into())
            });
            self.bad_found(&wrong.key, wrong.expected, found)
        })
    }

    /// The text of one top-level string, before anything else is known about the file.
    pub(super) fn peek(&self, key: &str) -> Result<Option<String>, FileError> {
        let table = self.parse()?;
        Ok(table
            .get_ref()
            .get(key)
            .and_then(|value| value.get_ref().as_str().map(str::to_owned)))
    }

    /// `value` must lie in `range`.
    pub(super) fn range<T: PartialOrd + Display>(
        &self,
        key: &str,
        value: T,
        range: RangeInclusive<T>,
        unit: &str,
    ) -> Result<(), FileError> {
        if range.contains(&value) {
            return Ok(());
        }
        let space = if unit.is_empty() { "" } else { " " };
        let (low, high) = range.into_inner();
        Err(self.bad(key, format!("a number from {low} to {high}{space}{unit}")))
    }

    /// The file's own name and description: lower case with hyphens, and not empty.
    pub(super) fn heading(&self, name: &str, description: &str) -> Result<(), FileError> {
        let lower = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if name.is_empty() || !name.chars().all(lower) {
            return Err(self.bad("name", "lower-case letters, digits and hyphens"));
        }
        if description.trim().is_empty() {
            return Err(self.bad("description", "a sentence"));
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

    fn refuse_numbers(&self, path: &mut String, table: &DeTable<'_>) -> Result<(), FileError> {
        for (key, value) in table {
            let length = path.len();
            if length > 0 {
                path.push('.');
            }
            path.push_str(key.get_ref());
            self.refuse_value(path, value.get_ref())?;
            path.truncate(length);
        }
        Ok(())
    }

    fn refuse_value(&self, path: &mut String, value: &DeValue<'_>) -> Result<(), FileError> {
        match value {
            DeValue::Table(table) => self.refuse_numbers(path, table),
            DeValue::Array(items) => {
                for (index, item) in items.iter().enumerate() {
                    let length = path.len();
                    path.push_str(&format!("[{index}]"));
                    self.refuse_value(path, item.get_ref())?;
                    path.truncate(length);
                }
                Ok(())
            }
            DeValue::Float(float)
                if !float
                    .as_str()
                    .parse::<f64>()
                    .is_ok_and(|number| number.is_finite()) =>
            {
                Err(self.bad(path, "a finite number"))
            }
            DeValue::Integer(integer)
                if i64::from_str_radix(integer.as_str(), integer.radix()).is_err() =>
            {
                Err(self.bad(path, "a whole number of at most 64 bits"))
            }
            _ => Ok(()),
        }
    }

    /// The line of `key`, or of the nearest table around it that is there.
    fn line_of(&self, key: &str) -> usize {
        self.spans(key)
            .map_or(1, |(span, _)| self.line_at(span.start))
    }

    fn value_text(&self, key: &str) -> Option<String> {
        let (_, value) = self.spans(key)?;
        let text = self.text.get(value?)?;
        let line = text.lines().next().unwrap_or_default();
        let short: String = line.chars().take(60).collect();
        let cut = short.len() < text.trim_end().len();
        Some(if cut { format!("{short} ...") } else { short })
    }

    /// Where the deepest part of `key` that exists is written, and the value's span if all of it exists.
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

enum Step<'k> {
    Key(&'k str),
    Index(usize),
}

/// `touches[0].force_n` as steps; an index may follow a key directly or stand after a dot.
fn steps(key: &str) -> impl Iterator<Item = Step<'_>> {
    key.split(['.', '[', ']'])
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().map_or(Step::Key(part), Step::Index))
}
