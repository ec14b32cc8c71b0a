//! What a family finds: rows of a table, figures, and sentences below them.

use serde::Serialize;

use crate::units;

/// How far off a method is, with the unit and kind of the error.
pub type Error = (f64, &'static str);

/// For what has a run time and no error.
pub const NO_ERROR: Error = (f64::NAN, "");

/// One measured method on one case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The family's name.
    pub family: &'static str,
    /// What was computed.
    pub case: String,
    /// How; `default` is what the program uses.
    pub method: String,
    /// How far off, in `error_unit`; JSON writes null for what is no number (a method that diverged).
    pub error: f64,
    /// Unit and kind of the error.
    pub error_unit: &'static str,
    /// Median run time of the case, microseconds; null where only the error counts.
    pub median_us: f64,
    /// Whether it is another project's method.
    pub peer: bool,
}

/// A drawing with its caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its file's name, after the family's: lower case with hyphens.
    pub name: String,
    /// Its heading.
    pub title: String,
    /// What it shows.
    pub words: String,
    /// The drawing, an SVG element that takes its colours from the page.
    pub svg: String,
    /// What the colours mean, as HTML.
    pub legend: String,
    /// The drawing as a file has it, with title and legend; left out: as the page has it.
    pub alone: Option<String>,
}

/// What a family found.
#[derive(Clone, Debug)]
pub struct Findings {
    /// The family's name.
    pub family: &'static str,
    /// The table.
    pub rows: Vec<Row>,
    /// What a person reads in its place where rows are many; empty where they read the rows.
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
