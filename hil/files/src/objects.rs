//! JSON Lines read as the text of a table: the numbers of the first object are the columns.
//!
//! A column is named by its keys and places in lists, `1.data.0`. A text of hexadecimal numbers between commas is a
//! list, as `xela_server` sends them.

use std::io::{BufRead, BufReader, Read};

use serde_json::Value;

use super::error::FileError;
use super::made::Lines;

/// Least numbers of a row: greetings and settings come before the first one, and have fewer.
const LEAST: usize = 4;
/// Longest line, bytes.
const LONGEST: u64 = 8 << 20;

/// Reads objects line by line.
#[derive(Debug)]
pub(super) struct Objects<R> {
    label: String,
    input: BufReader<R>,
    line: usize,
    /// Names of the columns, once they are known.
    names: Vec<String>,
}

impl<R: Read> Objects<R> {
    pub(super) fn new(input: R, label: &str) -> Self {
        Self {
            label: label.to_owned(),
            input: BufReader::new(input),
            line: 0,
            names: Vec::new(),
        }
    }
}

impl<R: Read> Lines for Objects<R> {
    fn add(&mut self, text: &mut Vec<u8>) -> Result<bool, FileError> {
        let wrong = |line, expected: &str, found: String| FileError {
            line: Some(line),
            ..FileError::whole(&self.label, expected, found)
        };
        let mut line = Vec::new();
        let read = (&mut self.input).take(LONGEST).read_until(b'\n', &mut line);
        let read = read.map_err(|e| FileError::of_io(&self.label, "a readable file", e))?;
        self.line += 1;
        if read == 0 {
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
