//! Numbers as people read them: three digits and a unit.

/// A run time with three digits, in the unit that fits; a dash for what was not timed.
pub fn time(us: f64) -> String {
    let (value, unit) = match us {
        us if !us.is_finite() => return "-".into(),
        us if us < 1.0 => (us * 1e3, "ns"),
        us if us < 1e3 => (us, "us"),
        us if us < 1e6 => (us * 1e-3, "ms"),
        us => (us * 1e-6, "s"),
    };
    let decimals = match value {
        v if v < 10.0 => 2,
        v if v < 100.0 => 1,
        _ => 0,
    };
    format!("{value:.decimals$} {unit}")
}

/// An error with three digits; a dash for what is no number.
pub fn error(value: f64, unit: &str) -> String {
    if !value.is_finite() {
        return "-".into();
    }
    if value == 0.0 {
        return format!("0 {unit}");
    }
    if (0.01..1e4).contains(&value.abs()) {
        return format!("{value:.3} {unit}");
    }
    format!("{value:.2e} {unit}")
}
