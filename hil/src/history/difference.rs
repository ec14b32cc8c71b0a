//! A figure that differs, and the verdict over all of them.

use palpate_records::runs::{Measured, Values, has_zero, number, short};
use palpate_records::verdict::{Conclusion, Verdict};
use serde::Serialize;

/// Digits that every writer of a number keeps: what differs behind them is how it was written.
const WRITTEN: f64 = 1e-9;

/// Difference up to which numbers count as equal: a part of the larger one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tolerance(pub f64);

impl Tolerance {
    /// Tells whether two numbers count as equal.
    pub fn equal(self, a: f64, b: f64) -> bool {
        (a - b).abs() <= self.0.max(WRITTEN) * a.abs().max(b.abs())
    }
}

/// A figure that differs.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Difference {
    /// Name of the figure.
    pub figure: String,
    /// Value in the first file; `None` where it has none.
    pub a: Option<String>,
    /// Value in the second file; `None` where it has none.
    pub b: Option<String>,
    /// Growth of the number, as a part of the first one; none of zero, of a unit without one such as dB, and where it is no
    /// number.
    pub change: Option<f64>,
    /// The second number less the first; none where it is no number.
    pub difference: Option<f64>,
    /// The unit; empty for a count, and where it is not known.
    pub unit: String,
    /// Place among several runs; empty for one.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub detail: String,
}

impl Difference {
    /// Difference of two numbers in a unit.
    pub fn of_numbers(figure: String, (a, b): (f64, f64), unit: &str) -> Self {
        let change = (b - a) / a.abs();
        Self {
            figure,
            a: Some(number(a)),
            b: Some(number(b)),
            change: Some(change).filter(|part| part.is_finite() && has_zero(unit)),
            difference: Some(b - a).filter(|d| d.is_finite()),
            unit: unit.to_owned(),
            detail: String::new(),
        }
    }

    /// Growth in words: `+5.6 %`, `+0.09 dB`; empty where it is no number.
    pub fn grown(&self) -> String {
        match (self.change.map(|part| part * 100.0), self.difference) {
            (Some(percent), _) if percent.abs() > 1e6 => "> 1e6 %".to_owned(),
            (Some(percent), _) => format!("{percent:+.2} %"),
            (None, Some(difference)) => {
                let sign = if difference < 0.0 { "" } else { "+" };
                // Of percents the difference is in points.
                let unit = if self.unit == "%" {
                    "points"
                } else {
                    &self.unit
                };
                format!("{sign}{} {unit}", short(difference))
                    .trim_end()
                    .to_owned()
            }
            (None, None) => String::new(),
        }
    }

    /// Words for people: `felt_error_mm.rmse  1.62 -> 1.71 (+5.6 %)`.
    pub fn words(&self) -> String {
        let said = |text: &Option<String>| text.as_deref().unwrap_or("nothing").to_owned();
        let grown = match self.grown() {
            grown if grown.is_empty() => grown,
            grown => format!(" ({grown})"),
        };
        let detail = match &*self.detail {
            "" => String::new(),
            detail => format!("; {detail}"),
        };
        format!(
            "{:<34} {} -> {}{grown}{detail}",
            self.figure,
            said(&self.a),
            said(&self.b)
        )
    }
}

/// A figure that has a name, of both results.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Named {
    /// Key in tables.
    pub key: &'static str,
    /// Name for people.
    pub figure: &'static str,
    /// Unit; empty for a count.
    pub unit: &'static str,
    /// The first result's value; none where it has none.
    pub a: Option<f64>,
    /// The second result's value.
    pub b: Option<f64>,
    /// `true` where the values differ by more than they may.
    pub differs: bool,
}

impl Named {
    /// Difference of two results; none where neither has a value.
    pub fn compare(measured: &Measured, of: [&Values; 2], tolerance: Tolerance) -> Option<Self> {
        let [a, b] = of.map(|values| values.get(measured.key).copied());
        let differs = match (a, b) {
            (None, None) => return None,
            (Some(a), Some(b)) => !tolerance.equal(a, b),
            _ => true,
        };
        Some(Self {
            key: measured.key,
            figure: measured.words,
            unit: measured.unit,
            a,
            b,
            differs,
        })
    }

    /// A value as people read it; a dash for none.
    pub fn value(value: Option<f64>) -> String {
        value.map_or_else(|| "-".to_owned(), short)
    }

    /// Growth in words; empty where there is none.
    pub fn grown(&self) -> String {
        match (self.a, self.b) {
            (Some(a), Some(b)) if self.differs => {
                Difference::of_numbers(String::new(), (a, b), self.unit).grown()
            }
            _ => String::new(),
        }
    }
}

/// Result of a comparison.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Compared {
    /// The verdict and its reasons.
    #[serde(flatten)]
    pub conclusion: Conclusion,
    /// Number of figures that were compared.
    pub figures: usize,
    /// Figures that differ, in the order of the first file.
    pub differences: Vec<Difference>,
    /// The figures that have a name, the weightiest first; empty where the results are no summaries.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub named: Vec<Named>,
}

impl Compared {
    /// Returns the comparison with the verdict that the differences ask for.
    pub fn concluded(mut self) -> Self {
        let count = self.differences.len();
        let size = |d: &&Difference| d.change.map_or(f64::INFINITY, f64::abs);
        let most = self
            .differences
            .iter()
            .max_by(|a, b| size(a).total_cmp(&size(b)));
        let mut named = self.named.iter().filter(|named| named.differs);
        if let Some(first) = named.next() {
            let (a, b) = (Named::value(first.a), Named::value(first.b));
            let text = format!(
                "{} of {} figures differ, first of all {} {a} -> {b} {}",
                1 + named.count(),
                self.named.len(),
                first.figure,
                first.unit
            );
            self.conclusion.add(Verdict::Failed, text.trim_end());
        } else if let Some(most) = most {
            let words = most
                .words()
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" ");
            let text = match self.named.is_empty() {
                true => format!(
                    "{count} of {} figures differ, most of all {words}",
                    self.figures
                ),
                false => format!("no figure with a name differs, but {words}"),
            };
            self.conclusion.add(Verdict::Failed, text);
        } else if self.figures == 0 {
            self.conclusion
                .add(Verdict::Incomplete, "no figure stands in both");
        }
        self
    }
}
