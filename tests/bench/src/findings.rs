//! Findings of a family: rows of a table, figures, and sentences below them.

use serde::Serialize;

use crate::units;

/// Error of a method, with its unit and kind.
pub type Error = (f64, &'static str);

/// For what has a run time and no error.
pub const NO_ERROR: Error = (f64::NAN, "");

/// One measured method on one case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The family's name.
    pub family: &'static str,
    /// Case that was computed.
    pub case: String,
    /// Method that computed it; `default` is the program's.
    pub method: String,
    /// Error in `error_unit`; JSON writes null for what is no number (a method that diverged).
    pub error: f64,
    /// Unit and kind of the error.
    pub error_unit: &'static str,
    /// Median run time of the case, microseconds; null where only the error counts.
    pub median_us: f64,
    /// True for another project's method.
    pub peer: bool,
}

/// A drawing with its caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name of the figure's file, after the family's: lower case with hyphens.
    pub name: String,
    /// Heading of the figure.
    pub title: String,
    /// Description of the figure.
    pub words: String,
    /// The drawing, an SVG element that takes its colours from the page.
    pub svg: String,
    /// Meanings of the colours, as HTML.
    pub legend: String,
    /// The drawing as a file has it, with title and legend; left out: as the page has it.
    pub alone: Option<String>,
}

/// Findings of a family.
#[derive(Clone, Debug)]
pub struct Findings {
    /// The family's name.
    pub family: &'static str,
    /// The table.
    pub rows: Vec<Row>,
    /// Table for people in place of many rows; empty where they read the rows.
    pub table: String,
    /// The figures.
    pub figures: Vec<Figure>,
    /// Sentences below the table: conditions, targets met and missed.
    pub words: Vec<String>,
}

impl Findings {
    /// Nothing yet.
    pub const fn new(family: &'static str) -> Self {
        Self {
            family,
            rows: Vec::new(),
            table: String::new(),
            figures: Vec::new(),
            words: Vec::new(),
        }
    }

    /// A row of one of our own methods.
    pub fn row(&mut self, case: &str, method: &str, error: Error, median_us: f64) {
        self.rows.push(Row {
            family: self.family,
            case: case.into(),
            method: method.into(),
            error: error.0,
            error_unit: error.1,
            median_us,
            peer: false,
        });
    }

    /// A row of another project's method.
    pub fn peer(&mut self, case: &str, method: &str, error: Error, median_us: f64) {
        self.row(case, method, error, median_us);
        if let Some(row) = self.rows.last_mut() {
            row.peer = true;
        }
    }
    /// A sentence that says whether a run time is at most its target.
    pub fn target(&mut self, what: &str, us: f64, most_us: f64) {
        let met = if us <= most_us { "met" } else { "MISSED" };
        let (time, most) = (units::time(us), units::time(most_us));
        self.words
            .push(format!("{what}: {time}, target {most} {met}."));
    }
}
