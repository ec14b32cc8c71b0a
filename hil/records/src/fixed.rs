//! Integers written as decimal fractions: goldens and tables never pass through a float.

use crate::trace::PlaceUm;

/// Thousandths as a decimal number with three places: `-7050` is `-7.050`.
pub(crate) fn milli(value: i64) -> String {
    let sign = if value < 0 { "-" } else { "" };
    let magnitude = value.unsigned_abs();
    format!("{sign}{}.{:03}", magnitude / 1000, magnitude % 1000)
}

/// Thousandths as a decimal number with three places, for values that do not fit a signed integer.
pub(crate) fn milli_u(value: u64) -> String {
    format!("{}.{:03}", value / 1000, value % 1000)
}

/// Microseconds as seconds, cut to the millisecond.
pub(crate) fn seconds(t_us: u64) -> String {
    milli_u(t_us / 1000)
}

/// A decimal with three places, or a whole number, in thousandths: [`milli`] read back.
pub(crate) fn thousandths(text: &str) -> Option<i64> {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1, digits),
        None => (1, text),
    };
    let plain = |t: &str| !t.is_empty() && t.bytes().all(|b| b.is_ascii_digit());
    let (whole, part) = match digits.split_once('.') {
        Some((whole, part)) if part.len() == 3 && plain(part) => (whole, part.parse::<i64>().ok()?),
        Some(_) => return None,
        None => (digits, 0),
    };
    let whole: i64 = plain(whole).then(|| whole.parse().ok())??;
    Some(sign * whole.checked_mul(1000)?.checked_add(part)?)
}

/// A place in millimetres, rounded to hundredths: a golden that shows micrometres is all noise.
pub(crate) fn place(p: PlaceUm) -> String {
    format!("({}, {}) mm", hundredths(p.x), hundredths(p.y))
}

/// Micrometres in millimetres, rounded to hundredths, with their sign.
pub(crate) fn hundredths(um: i32) -> String {
    let um = i64::from(um);
    let value = (um.abs() + 5) / 10;
    let sign = if um < 0 && value > 0 { '-' } else { '+' };
    format!("{sign}{}.{:02}", value / 100, value % 100)
}

/// Squared distance of two places, square micrometres.
pub(crate) fn distance2_um(a: PlaceUm, b: PlaceUm) -> u64 {
    let dx = i64::from(a.x).abs_diff(i64::from(b.x));
    let dy = i64::from(a.y).abs_diff(i64::from(b.y));
    dx.saturating_mul(dx).saturating_add(dy.saturating_mul(dy))
}

#[cfg(test)]
#[path = "fixed_tests.rs"]
mod tests;
