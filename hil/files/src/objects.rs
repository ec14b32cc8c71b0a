//! JSON Lines, or a list of objects, read as the text of a table: the numbers of the first object are the columns.
//!
//! A column is named by its keys and places in lists, `1.data.0`. A text of hexadecimal numbers between commas is a
//! list, as `xela_server` sends them.

use std::io::{self, BufRead, BufReader, Read};

use serde_json::Value;

use super::error::FileError;
use super::made::Lines;

/// Least numbers of a row: greetings and settings come before the first one, and have fewer.
const LEAST: usize = 4;
/// Longest object, bytes.
const LONGEST: u64 = 8 << 20;

/// Reads objects one by one.
#[derive(Debug)]
pub(super) struct Objects<R> {
    label: String,
    input: BufReader<R>,
    line: usize,
    /// `true` in a list of objects, once its beginning was read.
    is_list: Option<bool>,
    /// Names of the columns, once they are known.
    names: Vec<String>,
}

impl<R: Read> Objects<R> {
    pub(super) fn new(input: R, label: &str) -> Self {
        Self {
            label: label.to_owned(),
            input: BufReader::new(input),
            line: 0,
            is_list: None,
            names: Vec::new(),
        }
    }
}

impl<R: Read> Objects<R> {
    /// Reads the text of the next object; an empty one at the end.
    fn next(&mut self, text: &mut Vec<u8>) -> io::Result<()> {
        let is_list = match self.is_list {
            Some(is_list) => is_list,
            None => {
                let start = self.input.fill_buf()?;
                let begin = start.iter().position(|b| !b.is_ascii_whitespace());
                let list = start
                    .get(begin.unwrap_or(0)..)
                    .and_then(|s| s.strip_prefix(b"["));
                // A line may be a list of numbers.
                let is_list = list.is_some_and(|list| list.trim_ascii_start().starts_with(b"{"));
                if is_list {
                    self.line = 1;
                    self.input.consume(begin.unwrap_or(0) + 1);
                }
                *self.is_list.insert(is_list)
            }
        };
        if is_list {
            return self.element(text);
        }
        self.line += 1;
        (&mut self.input).take(LONGEST).read_until(b'\n', text)?;
        Ok(())
    }

    /// Reads the text of the next element of a list.
    fn element(&mut self, text: &mut Vec<u8>) -> io::Result<()> {
        let (mut depth, mut in_text, mut is_escaped) = (0_usize, false, false);
        while let Some(byte) = self.input.fill_buf()?.first().copied() {
            self.input.consume(1);
            self.line += usize::from(byte == b'\n');
            if in_text {
                in_text = is_escaped || byte != b'"';
                is_escaped = !is_escaped && byte == b'\\';
            } else {
                match byte {
                    b'"' => in_text = true,
                    b'{' | b'[' => depth += 1,
                    b'}' | b']' if depth > 0 => depth -= 1,
                    b',' | b']' if !text.trim_ascii().is_empty() && depth == 0 => return Ok(()),
                    b',' | b']' if depth == 0 => continue,
                    _ => {}
                }
            }
            text.push(byte);
            if text.len() as u64 > LONGEST {
                return Err(io::Error::other(format!(
                    "an object of over {LONGEST} bytes"
                )));
            }
        }
        Ok(())
    }
}

impl<R: Read> Lines for Objects<R> {
    fn add(&mut self, text: &mut Vec<u8>) -> Result<bool, FileError> {
        let mut line = Vec::new();
        let read = self.next(&mut line);
        read.map_err(|e| FileError::of_io(&self.label, "a readable file", e))?;
        let wrong = |line, expected: &str, found: String| FileError {
            line: Some(line),
            ..FileError::whole(&self.label, expected, found)
        };
        if line.is_empty() {
            if self.names.is_empty() {
                let found = "none".to_owned();
                return Err(wrong(
                    self.line,
                    "an object with numbers in each line",
                    found,
                ));
            }
            return Ok(false);
        }
        if line.trim_ascii().is_empty() {
            return Ok(true);
        }
        let value: Value = serde_json::from_slice(&line)
            .map_err(|e| wrong(self.line, "a whole JSON object in each line", e.to_string()))?;
        let mut leaves = Vec::new();
        flatten("", &value, &mut leaves);
        if self.names.is_empty() {
            if leaves.len() < LEAST {
                return Ok(true);
            }
            self.names = leaves.iter().map(|(name, _)| name.clone()).collect();
            text.extend(self.names.join(",").bytes());
            text.push(b'\n');
        }
        let mut leaves = leaves.into_iter();
        for (place, name) in self.names.iter().enumerate() {
            let value = leaves.find(|(found, _)| found == name);
            let (_, value) = value.ok_or_else(|| {
                let found = format!("none under `{name}`");
                wrong(self.line, "the numbers of the first object", found)
            })?;
            if place > 0 {
                text.push(b',');
            }
            text.extend(value.bytes());
        }
        text.push(b'\n');
        Ok(true)
    }
}

/// The numbers in a value, each with its name.
pub(super) fn flatten(name: &str, value: &Value, leaves: &mut Vec<(String, String)>) {
    let below = |key: &str| {
        let key = key.replace([',', '"'], "_");
        if name.is_empty() {
            key
        } else {
            format!("{name}.{key}")
        }
    };
    match value {
        Value::Number(number) => leaves.push((name.to_owned(), number.to_string())),
        Value::Bool(truth) => leaves.push((name.to_owned(), u8::from(*truth).to_string())),
        Value::Array(items) => {
            for (place, item) in items.iter().enumerate() {
                flatten(&below(&place.to_string()), item, leaves);
            }
        }
        Value::Object(entries) => {
            for (key, item) in entries {
                flatten(&below(key), item, leaves);
            }
        }
        Value::String(text) => {
            if text.contains(',') {
                let numbers = text.split(',').map(|n| hexadecimal(n.trim()));
                let numbers: Option<Vec<u32>> = numbers.collect();
                for (place, number) in numbers.unwrap_or_default().into_iter().enumerate() {
                    leaves.push((below(&place.to_string()), number.to_string()));
                }
            } else if text.parse::<f64>().is_ok_and(f64::is_finite) {
                leaves.push((name.to_owned(), text.clone()));
            }
        }
        Value::Null => {}
    }
}

/// A number of four digits, as `xela_server` writes counts.
fn hexadecimal(text: &str) -> Option<u32> {
    let digits = text.strip_prefix("0x").unwrap_or(text);
    let is_hex = digits.len() == 4 && digits.bytes().all(|b| b.is_ascii_hexdigit());
    is_hex.then(|| u32::from_str_radix(digits, 16).ok())?
}

#[cfg(test)]
#[path = "objects_tests.rs"]
mod tests;
