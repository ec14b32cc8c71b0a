//! The rows as a table for a terminal: one block a case.

use std::io::{self, Write};

use super::Findings;

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

/// Writes a family's rows and sentences.
///
/// # Errors
/// What the stream says.
pub fn write(out: &mut dyn Write, family: &str, findings: &Findings) -> io::Result<()> {
    writeln!(out, "{family}")?;
    let width = findings.rows.iter().map(|r| r.method.len()).max();
    let width = width.unwrap_or(0).max(7);
    let mut case = None;
    for row in &findings.rows {
        if case != Some(&row.case) {
            writeln!(out, "\n  {}", row.case)?;
            case = Some(&row.case);
        }
        writeln!(
            out,
            "    {:width$}  {:>10}  {}{}",
            row.method,
            time(row.median_us),
            error(row.error, row.error_unit),
            if row.peer { "  (peer)" } else { "" }
        )?;
    }
    if !findings.words.is_empty() {
        writeln!(out)?;
    }
    for sentence in &findings.words {
        writeln!(out, "  {sentence}")?;
    }
    writeln!(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_in_the_unit_that_fits() {
        assert_eq!(time(0.0312), "31.2 ns");
        assert_eq!(time(2.5), "2.50 us");
        assert_eq!(time(123_456.0), "123 ms");
        assert_eq!(time(f64::NAN), "-");
        assert_eq!(error(0.234_56, "K"), "0.235 K");
        assert_eq!(error(3.21e-9, "K"), "3.21e-9 K");
        assert_eq!(error(f64::INFINITY, "K"), "-");
    }
}
