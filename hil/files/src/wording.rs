//! Misfits of a settings file, in the words that people read.

use std::fmt::Display;

use serde::de::{Error, Expected, Unexpected};

use super::near::did_you_mean;

/// A value or a key that does not fit.
#[derive(Debug, thiserror::Error)]
#[error("expected {expected}")]
pub(super) struct Misfit {
    /// A key of the table that was being read, where that is unknown or missing.
    pub field: Option<String>,
    /// Expected value, in words.
    pub expected: String,
    /// Found value, in words; `None` where the value itself is shown.
    pub found: Option<String>,
}

impl Misfit {
    /// A misfit of a value where serde names the expectation.
    pub(super) fn of_value(expected: &dyn Expected) -> Self {
        Self {
            field: None,
            expected: plain(&expected.to_string()),
            found: None,
        }
    }
}

impl Error for Misfit {
    fn custom<T: Display>(what: T) -> Self {
        let what = what.to_string();
        Self {
            field: None,
            expected: "a valid value".into(),
            found: Some(what.lines().next().unwrap_or_default().into()),
        }
    }

    fn invalid_type(_: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::of_value(expected)
    }

    fn invalid_value(_: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::of_value(expected)
    }

    fn invalid_length(_: usize, expected: &dyn Expected) -> Self {
        Self::of_value(expected)
    }

    fn unknown_variant(variant: &str, known: &'static [&'static str]) -> Self {
        Self {
            field: None,
            expected: one_of("", known),
            found: Some(format!("`{variant}`{}", meant(variant, known))),
        }
    }

    fn unknown_field(field: &str, known: &'static [&'static str]) -> Self {
        let meant = meant(field, known);
        Self {
            field: Some(field.into()),
            expected: one_of("the keys ", known),
            found: Some(format!("the unknown key `{field}`{meant}")),
        }
    }

    fn missing_field(field: &'static str) -> Self {
        Self {
            field: Some(field.into()),
            expected: "a value".into(),
            found: Some("nothing".into()),
        }
    }
}

fn meant(word: &str, known: &[&str]) -> String {
    did_you_mean(word, known.iter().copied())
}

/// Words that may stand in a place, with a noun where there are more than two.
fn one_of(noun: &str, known: &[&str]) -> String {
    let words: Vec<String> = known.iter().map(|word| format!("`{word}`")).collect();
    match words.as_slice() {
        [_, _] => words.join(" or "),
        [_] => words.concat(),
        _ => format!("one of {noun}{}", words.join(", ")),
    }
}

/// A key inside the table at `path`.
pub(super) fn inside(path: &str, field: &str) -> String {
    match path {
        "" => field.into(),
        _ => format!("{path}.{field}"),
    }
}

/// Words of a user for Rust's type names.
fn plain(wanted: &str) -> String {
    let words = match wanted {
        "f64" => "a number",
        "u8" => "a whole number from 0 to 255",
        "u16" => "a whole number from 0 to 65535",
        "u32" | "u64" | "usize" => "a whole number, 0 or more",
        "a boolean" => "true or false",
        "a sequence" => "an array",
        "an array of length 2" => "an array of 2 numbers",
        "an array of length 3" => "an array of 3 numbers",
        "an array of length 4" => "an array of 4 numbers",
        other if other.starts_with("struct ") => "a table",
        other if other.starts_with("enum ") => "a string",
        other => other,
    };
    words.into()
}
