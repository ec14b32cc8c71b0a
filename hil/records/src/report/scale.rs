//! Scales: from values to places along an axis, and the round numbers written beside it.

/// Conversion of values to places along an axis.
#[derive(Clone, Copy)]
pub struct Scale {
    low: f64,
    high: f64,
    log: bool,
    /// `true` where ticks are at least one apart.
    whole: bool,
}

impl Scale {
    /// Exactly `low` to `high`; opened to one unit where that is empty or no number.
    pub fn exact(low: f64, high: f64) -> Self {
        let sound = low.is_finite() && high.is_finite();
        let (low, high) = if sound { (low, high) } else { (0.0, 1.0) };
        let high = if high - low > 1e-9 { high } else { low + 1.0 };
        Self {
            low,
            high,
            log: false,
            whole: false,
        }
    }

    /// Returns the scale for counts: nothing is written between two whole numbers.
    #[must_use]
    pub const fn of_counts(self, whole: bool) -> Self {
        Self { whole, ..self }
    }

    /// `low` to `high` widened to round ticks.
    pub fn round(low: f64, high: f64) -> Self {
        let raw = Self::exact(low, high);
        let step = step(raw.high - raw.low, 5.0);
        Self::exact(
            (raw.low / step).floor() * step,
            (raw.high / step).ceil() * step,
        )
    }

    /// Logarithmic, widened to whole decades; both ends must be above zero.
    pub fn decades(low: f64, high: f64) -> Self {
        let low = 10f64.powf(low.max(1e-15).log10().floor());
        let high = 10f64.powf(high.max(low * 1.1).min(1e12).log10().ceil());
        Self {
            low,
            high,
            log: true,
            whole: false,
        }
    }

    /// Logarithmic, from exactly `low` to `high`, with ticks at 1, 2 and 5 of every decade; both must be above zero.
    #[allow(clippy::manual_clamp)] // clamp keeps what is no number, max and min take the bound
    pub fn logarithmic(low: f64, high: f64) -> Self {
        let low = low.max(1e-15).min(1e12);
        Self {
            low,
            high: high.max(low * 1.1).min(1e13),
            log: true,
            whole: false,
        }
    }

    /// 0 at the low end, 1 at the high end.
    pub fn at(&self, value: f64) -> f64 {
        if self.log {
            let value = value.max(self.low * 1e-3);
            (value / self.low).log10() / (self.high / self.low).log10()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// Low end, high end, and whether the axis is logarithmic.
    pub const fn ends(&self) -> (f64, f64, bool) {
        (self.low, self.high, self.log)
    }

    /// About `wanted` values along the axis, with what is written beside them.
    pub fn ticks(&self, wanted: f64) -> Vec<(f64, String)> {
        if self.log {
            let span = (self.high / self.low).log10();
            let decades = span.round() as i32;
            if (span - f64::from(decades)).abs() > 1e-6 {
                return self.parts_of_decades();
            }
            let by = (f64::from(decades) / wanted).ceil().max(1.0) as usize;
            return (0..=decades)
                .step_by(by)
                .map(|d| self.low * 10f64.powi(d))
                .map(|v| (v, decade(v)))
                .collect();
        }
        let step = step(self.high - self.low, wanted);
        let step = if self.whole { step.max(1.0) } else { step };
        let decimals = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
        let first = (self.low / step - 1e-6).ceil();
        (0..40)
            .map(|i| (first + f64::from(i)) * step)
            .take_while(|v| *v <= self.high + step * 1e-6)
            .map(|v| {
                let v = if v.abs() < step * 1e-6 { 0.0 } else { v };
                let text = if decimals == 0 {
                    thousands(v)
                } else {
                    format!("{v:.decimals$}")
                };
                (v, text)
            })
            .collect()
    }
}

impl Scale {
    /// 1, 2 and 5 of every decade along the axis.
    fn parts_of_decades(&self) -> Vec<(f64, String)> {
        let (first, last) = (
            self.low.log10().floor() as i32,
            self.high.log10().ceil() as i32,
        );
        let all = (first..=last).flat_map(|d| [1.0, 2.0, 5.0].map(|part| part * 10f64.powi(d)));
        all.filter(|v| (self.low * (1.0 - 1e-9)..=self.high * (1.0 + 1e-9)).contains(v))
            .map(|v| {
                let text = match v < 1.0 {
                    true => format!("{v:.*}", -v.log10().floor() as usize),
                    false => thousands(v),
                };
                (v, text)
            })
            .collect()
    }
}

/// A round number of which about `wanted` fit into `span`.
fn step(span: f64, wanted: f64) -> f64 {
    let raw = span / wanted.max(1.0);
    let decade = 10f64.powf(raw.log10().floor());
    let part = raw / decade;
    let nice = if part <= 1.0 {
        1.0
    } else if part <= 2.0 {
        2.0
    } else if part <= 5.0 {
        5.0
    } else {
        10.0
    };
    nice * decade
}

/// A power of ten: as a number near 1, else with its exponent.
fn decade(value: f64) -> String {
    if (0.005..0.5).contains(&value) {
        return format!("{value:.2}");
    }
    if (0.5..5e6).contains(&value) {
        return thousands(value);
    }
    let digit = |c: char| match c {
        '-' => '\u{207b}',
        '1' => '\u{b9}',
        '2' => '\u{b2}',
        '3' => '\u{b3}',
        c => char::from_u32(0x2070 + c.to_digit(10).unwrap_or(0)).unwrap_or(c),
    };
    let exponent = format!("{:.0}", value.log10());
    format!("10{}", exponent.chars().map(digit).collect::<String>())
}

/// Whole number with a thin gap between thousands.
fn thousands(value: f64) -> String {
    let digits = format!("{:.0}", value.abs());
    let mut out = String::new();
    if value < 0.0 && digits != "0" {
        out.push('\u{2212}');
    }
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) && digits.len() > 4 {
            out.push('\u{202f}');
        }
        out.push(c);
    }
    out
}

#[cfg(test)]
#[path = "scale_tests.rs"]
mod tests;
