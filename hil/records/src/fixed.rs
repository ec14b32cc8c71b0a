//! Integers written as decimal fractions: goldens and tables never pass through a float.

use crate::trace::PlaceUm;

/// Thousandths as a decimal number with three places: `-7050` is `-7.050`.
pub(crate) fn milli(value: i64) -> String {
    let sign = if value < 0 { "-" } else { "" };
    let magnitude = value.unsigned_abs();
    format!("{sign}{}.{:03}", magnitude / 1000, magnitude % 1000)
}

/// As [`milli`], for values that do not fit a signed integer.
pub(crate) fn milli_u(value: u64) -> String {
    format!("{}.{:03}", value / 1000, value % 1000)
}

/// Microseconds as seconds, cut to the millisecond.
pub(crate) fn seconds(t_us: u64) -> String {
    milli_u(t_us / 1000)
}

/// A place in millimetres, rounded to hundredths: a golden that shows micrometres is all noise.
pub(crate) fn place(p: PlaceUm) -> String {
    format!("({}, {}) mm", hundredths(p.x), hundredths(p.y))
}

fn hundredths(um: i32) -> String {
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
mod tests {
    use super::*;

    #[test]
    fn fractions_keep_their_sign_below_one() {
        assert_eq!(milli(-50), "-0.050");
        assert_eq!(milli(i64::MIN), "-9223372036854775.808");
        assert_eq!(milli_u(12_345), "12.345");
        assert_eq!(place(PlaceUm { x: -7_050, y: 4 }), "(-7.05, +0.00) mm");
    }

    #[test]
    fn distance_survives_the_extremes() {
        let a = PlaceUm {
            x: i32::MIN,
            y: i32::MIN,
        };
        let b = PlaceUm {
            x: i32::MAX,
            y: i32::MAX,
        };
        assert_eq!(distance2_um(a, b), u64::MAX);
    }
}
