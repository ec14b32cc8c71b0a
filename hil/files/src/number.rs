//! Numbers that tables of recordings hold.

/// A number that a table may hold.
pub trait Number: Sized {
    /// Name of the kind of number in messages.
    const EXPECTED: &'static str;

    /// The number in a field.
    fn read(field: &str) -> Option<Self>;

    /// The number that a value comes to.
    fn of_value(value: f64) -> Option<Self>;

    /// The number that a count is.
    fn of_count(count: u16) -> Self;

    /// The number on an axis that counts the other way.
    fn opposite(self) -> Self;
}

impl Number for u16 {
    const EXPECTED: &'static str = "a whole count from 0 to 65535";

    /// Also written as `49202.0`.
    fn read(field: &str) -> Option<Self> {
        let digits = field.as_bytes();
        let digits = digits.strip_suffix(b".0").unwrap_or(digits);
        if let Some(count) = plain(digits) {
            return Some(count);
        }
        let whole = match field.split_once('.') {
            Some((whole, rest)) if rest.bytes().all(|digit| digit == b'0') => whole,
            _ => field,
        };
        if let Ok(count) = whole.parse() {
            return Some(count);
        }
        let value: f64 = field.parse().ok()?;
        let whole = (0.0..=65_535.0).contains(&value) && (value - libm::floor(value)).abs() <= 0.0;
        // In range and whole: the cast changes nothing.
        whole.then_some(value as Self)
    }

    fn of_value(value: f64) -> Option<Self> {
        let count = libm::round(value);
        (0.0..=65_535.0).contains(&count).then_some(count as Self)
    }

    fn of_count(count: u16) -> Self {
        count
    }

    fn opposite(self) -> Self {
        Self::MAX - self
    }
}

impl Number for f32 {
    const EXPECTED: &'static str = "a finite number";

    fn read(field: &str) -> Option<Self> {
        field.parse().ok().filter(|v: &Self| v.is_finite())
    }

    fn of_value(value: f64) -> Option<Self> {
        Some(value as Self).filter(|v| v.is_finite())
    }

    fn of_count(count: u16) -> Self {
        Self::from(count)
    }

    fn opposite(self) -> Self {
        -self
    }
}

/// A count of one to five digits and nothing else, as most fields are.
fn plain(digits: &[u8]) -> Option<u16> {
    if !(1..=5).contains(&digits.len()) {
        return None;
    }
    let mut count = 0_u32;
    for digit in digits {
        let value = digit.wrapping_sub(b'0');
        if value > 9 {
            return None;
        }
        count = count * 10 + u32::from(value);
    }
    u16::try_from(count).ok()
}
