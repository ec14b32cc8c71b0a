//! Results as JSON that people read too: numbers without the digits that binary fractions leave behind.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::Serializer;
use serde_json::ser::{CompactFormatter, Formatter, PrettyFormatter};

/// Significant digits of a number: more than anything is measured with, fewer than rounding errors reach.
const DIGITS: usize = 12;

/// Writes a value on one line.
///
/// # Errors
/// Errors of the stream.
pub fn write_json(value: &(impl Serialize + ?Sized), out: impl Write) -> io::Result<()> {
    let mut serializer = Serializer::with_formatter(out, Rounded(CompactFormatter));
    Ok(value.serialize(&mut serializer)?)
}

/// Writes a value with a line for each of its parts.
///
/// # Errors
/// Errors of the stream.
pub fn write_json_lines(value: &(impl Serialize + ?Sized), out: impl Write) -> io::Result<()> {
    let mut serializer = Serializer::with_formatter(out, Rounded(PrettyFormatter::new()));
    Ok(value.serialize(&mut serializer)?)
}

/// A number without the noise of its last digits: as short as single precision has it where it came from there, else to
/// twelve significant digits.
fn rounded(value: f64) -> f64 {
    let single = value as f32;
    let exact = single.is_finite() && f64::from(single).total_cmp(&value).is_eq();
    let text = match exact {
        true => single.to_string(),
        false => format!("{value:.0$e}", DIGITS - 1),
    };
    text.parse().unwrap_or(value)
}

/// A formatter whose floating point numbers are [`rounded`].
struct Rounded<F>(F);

/// Methods that the formatter inside has.
macro_rules! inside {
    ($($name:ident($($flag:ident)?))*) => {$(
        fn $name<W: ?Sized + Write>(&mut self, out: &mut W $(, $flag: bool)?) -> io::Result<()> {
            self.0.$name(out $(, $flag)?)
        }
    )*};
}

impl<F: Formatter> Formatter for Rounded<F> {
    fn write_f64<W: ?Sized + Write>(&mut self, out: &mut W, value: f64) -> io::Result<()> {
        self.0.write_f64(out, rounded(value))
    }

    inside! {
        begin_array() end_array() begin_array_value(first) end_array_value()
        begin_object() end_object() begin_object_key(first) end_object_key()
        begin_object_value() end_object_value()
    }
}

#[cfg(test)]
#[path = "json_tests.rs"]
mod tests;
