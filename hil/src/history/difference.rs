//! A figure that differs, and what all of them come to.

use palpate_records::runs::number;
use palpate_records::verdict::{Conclusion, Verdict};
use serde::Serialize;

/// By how much numbers may differ and count as equal: a part of the larger one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tolerance(pub f64);

impl Tolerance {
    /// Whether two numbers count as equal.
    pub fn equal(self, a: f64, b: f64) -> bool {
        (a - b).abs() <= self.0 * a.abs().max(b.abs())
    }
}

/// A figure that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Which.
    pub figure: String,
    /// What the first file says; none where it has nothing.
    pub a: Option<String>,
    /// What the second file says.
    pub b: Option<String>,
    /// How much the number grew, as a part of the first one; none of zero, and where it is no number.
    pub change: Option<f64>,
    /// Where among several runs; empty for one.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub detail: String,
}

impl Difference {
    /// Of two numbers.
    pub fn of_numbers(figure: String, a: f64, b: f64) -> Self {
        let change = (b - a) / a.abs();
        Self {
            figure,
            a: Some(number(a)),
            b: Some(number(b)),
            change: change.is_finite().then_some(change),
            detail: String::new(),
        }
    }

    /// As people read it: `felt_error_mm.rmse  1.62 -> 1.71 (+5.6 %)`.
    pub fn words(&self) -> String {
        let said = |text: &Option<String>| text.as_deref().unwrap_or("nothing").to_owned();
        let grown = match self.change.map(|part| part * 100.0) {
            Some(percent) if percent.abs() > 1e6 => " (> 1e6 %)".to_owned(),
            Some(percent) => format!(" ({percent:+.2} %)"),
            None => String::new(),
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

/// What a comparison found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Compared {
    /// The verdict and its reasons.
    #[serde(flatten)]
    pub conclusion: Conclusion,
    /// How many figures were held against each other.
    pub figures: usize,
    /// Those that differ, in the order of the first file.
    pub differences: Vec<Difference>,
}

impl Compared {
    /// With the verdict that the differences ask for.
    pub fn concluded(mut self) -> Self {
        let count = self.differences.len();
        let size = |d: &&Difference| d.change.map_or(f64::INFINITY, f64::abs);
        let most = self
            .differences
            .iter()
            .max_by(|a, b| size(a).total_cmp(&size(b)));
        if let Some(most) = most {
            let words = most
                .words()
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" ");
            let text = format!(
                "{count} of {} figures differ, most of all {words}",
                self.figures
            );
            self.conclusion.add(Verdict::Failed, text);
        } else if self.figures == 0 {
            self.conclusion
                .add(Verdict::Incomplete, "no figure stands in both");
        }
        self
    }
}
