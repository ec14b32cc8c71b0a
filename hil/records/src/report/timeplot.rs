//! A plot against time: a drawing that stretches with the page, its numbers as text around it.
//!
//! Paths are in whole units of the data, so that the page's script reads values off the picture itself and zooms by
//! its view box: x in tenths of a millisecond, y downwards in ten-thousandths of the axis.

use super::scale::Scale;
use super::svg::{escape, line_key};
use std::fmt::Write;

/// Height of an axis, or of a row of the schedule, in units of its paths.
pub(super) const SPAN: i64 = 10_000;
/// Columns of a drawing that keep their extremes: an hour costs what a minute does.
const COLUMNS: i64 = 1920;

/// Microseconds in units of a path.
pub(super) fn tenth_ms(us: u64) -> i64 {
    i64::try_from(us / 100).unwrap_or(i64::MAX)
}

/// A path in whole numbers, each point told from the one before.
#[derive(Default)]
pub(super) struct Pen {
    out: String,
    at: (i64, i64),
    letter: char,
}

impl Pen {
    fn number(&mut self, value: i64) {
        let after_digit = self.out.ends_with(|c: char| c.is_ascii_digit());
        if after_digit && value >= 0 {
            self.out.push(' ');
        }
        let _ = write!(self.out, "{value}");
    }

    fn step(&mut self, letter: char, (x, y): (i64, i64)) {
        if letter == 'm' || letter != self.letter {
            self.out.push(letter);
            self.letter = letter;
        }
        self.number(x.saturating_sub(self.at.0));
        self.number(y.saturating_sub(self.at.1));
        self.at = (x, y);
    }

    /// Begins a new stroke here.
    pub fn lift_to(&mut self, at: (i64, i64)) {
        self.step('m', at);
    }

    /// Draws the stroke on to here.
    pub fn line_to(&mut self, at: (i64, i64)) {
        self.step('l', at);
    }

    /// Adds a dot, for a style with round ends.
    pub fn dot(&mut self, at: (i64, i64)) {
        self.lift_to(at);
        self.out.push_str("h0");
        self.letter = 'h';
    }

    /// Adds an upright bar on a base line.
    pub fn bar(&mut self, at: (i64, i64), width: i64, height: i64) {
        self.lift_to(at);
        let _ = write!(self.out, "v{}h{width}v{height}z", -height);
        self.letter = 'z';
    }

    /// The path; empty where nothing was drawn.
    pub fn finish(self) -> String {
        self.out
    }
}

/// A line whose columns keep their ends and extremes. `None` interrupts it.
fn envelope(points: impl Iterator<Item = Option<(i64, i64)>>, column: i64) -> String {
    let mut pen = Pen::default();
    let mut down = false;
    let mut here: Vec<(i64, i64)> = Vec::new();
    let mut flush = |here: &mut Vec<(i64, i64)>, lift: bool| {
        let lowest = here.iter().min_by_key(|p| p.1);
        let highest = here.iter().max_by_key(|p| p.1);
        let mut kept = vec![here.first(), lowest, highest, here.last()];
        kept.sort_by_key(|p| p.map_or(0, |p| p.0));
        kept.dedup();
        for at in kept.into_iter().flatten() {
            if down {
                pen.line_to(*at);
            } else {
                pen.lift_to(*at);
            }
            down = true;
        }
        down &= !lift;
        here.clear();
    };
    for point in points {
        let Some(at) = point else {
            flush(&mut here, true);
            continue;
        };
        // Runs of equal values cost two points.
        if let [.., a, b] = here.as_slice()
            && a.1 == at.1
            && b.1 == at.1
        {
            here.pop();
        }
        if here.first().is_some_and(|p| p.0 / column < at.0 / column) && here.len() > 1 {
            flush(&mut here, false);
        }
        here.push(at);
    }
    flush(&mut here, false);
    pen.finish()
}

/// A plot under construction.
pub(super) struct TimePlot {
    label: String,
    unit: &'static str,
    height: f64,
    from: i64,
    to: i64,
    y: Scale,
    rows: i64,
    body: String,
    around: String,
    named: bool,
    /// An entry for each curve.
    pub legend: String,
}

impl TimePlot {
    /// An empty plot of a stretch of the run, microseconds; the label is for those who hear it.
    pub fn new(label: &str, unit: &'static str, height: f64, span: (u64, u64), y: Scale) -> Self {
        let from = tenth_ms(span.0);
        Self {
            label: escape(label),
            unit,
            height,
            from,
            to: tenth_ms(span.1).max(from.saturating_add(1)),
            y,
            rows: 1,
            body: String::new(),
            around: String::new(),
            named: false,
            legend: String::new(),
        }
    }

    /// Rows of [`SPAN`] each in place of an axis; the first is on top.
    pub fn with_rows(mut self, rows: usize) -> Self {
        self.rows = i64::try_from(rows).unwrap_or(1).max(1);
        self
    }

    /// Least distance along x that a reader can tell, tenths of a millisecond.
    pub fn column(&self) -> i64 {
        ((self.to - self.from) / COLUMNS).max(1)
    }

    /// A point in units of the paths; `None` where it is no number.
    pub fn at(&self, t_us: u64, value: f64) -> Option<(i64, i64)> {
        let part = (1.0 - self.y.at(value)) * SPAN as f64;
        part.is_finite()
            .then(|| (tenth_ms(t_us), part.round() as i64))
    }

    fn percent(&self, value: f64) -> f64 {
        (1.0 - self.y.at(value)) * 100.0
    }

    /// Horizontal lines with their numbers, and what is measured.
    pub fn y_axis(&mut self, title: &str) {
        for (value, text) in self.y.ticks((self.height / 26.0).min(8.0)) {
            let _ = write!(
                self.around,
                "<span class=\"y\" style=\"top:{:.2}%\">{text}</span>",
                self.percent(value)
            );
            self.level(value, "grid");
        }
        self.title(title);
    }

    /// Title above the upper end: the measured quantity.
    pub fn title(&mut self, title: &str) {
        let _ = write!(self.around, "<figcaption>{}</figcaption>", escape(title));
    }

    /// Draws a line across at a value.
    fn level(&mut self, value: f64, class: &str) {
        let y = (1.0 - self.y.at(value)) * SPAN as f64;
        self.across(y.round() as i64, class);
    }

    /// Draws a line across, in units of the paths.
    pub fn across(&mut self, y: i64, class: &str) {
        let _ = write!(
            self.body,
            "<path class=\"{class}\" d=\"M{} {y}H{}\"/>",
            self.from, self.to
        );
    }

    /// Shows the time below, with its name or with numbers only.
    pub fn named(mut self) -> Self {
        self.named = true;
        self
    }

    /// Writes text at the left of a row.
    pub fn row_name(&mut self, row: usize, text: &str) {
        self.beside("y", row, text);
    }

    /// Writes text at the right of a row.
    pub fn row_note(&mut self, row: usize, text: &str) {
        self.beside("r", row, text);
    }

    fn beside(&mut self, class: &str, row: usize, text: &str) {
        let top = (row as f64 + 0.6) / self.rows as f64 * 100.0;
        let _ = write!(
            self.around,
            "<span class=\"{class}\" style=\"top:{top:.2}%\">{}</span>",
            escape(text)
        );
    }

    /// Draws a line across with its name at the right.
    pub fn bound(&mut self, value: f64, class: &str, text: &str) {
        self.level(value, class);
        let _ = write!(
            self.around,
            "<span class=\"r\" style=\"top:{:.2}%\">{}</span>",
            self.percent(value),
            escape(text)
        );
    }

    /// Draws a curve and its entry in the legend: values against microseconds. `NaN` interrupts it.
    pub fn line(&mut self, name: &str, class: &str, points: impl Iterator<Item = (u64, f64)>) {
        line_key(&mut self.legend, class, name);
        let d = envelope(points.map(|(t, v)| self.at(t, v)), self.column());
        self.path("line", name, class, &d);
    }

    /// Path that a script reads by its kind (`line`, `dots`, `bars`, `marks`) and name; nothing for an empty path.
    pub fn path(&mut self, kind: &str, name: &str, class: &str, d: &str) {
        if !d.is_empty() {
            let name = escape(name);
            let _ = writeln!(
                self.body,
                "<path class=\"{class}\" data-k=\"{kind}\" data-n=\"{name}\" d=\"{d}\"/>"
            );
        }
    }

    /// The plot; `digits` after the point are worth reading, and further attributes go with it.
    pub fn finish(mut self, digits: u8, more: &str) -> String {
        let seconds = |t: i64| t as f64 * 1e-4;
        let x = Scale::exact(seconds(self.from), seconds(self.to));
        let mut numbers = String::new();
        let mut grid = String::new();
        for (value, text) in x.ticks(10.0) {
            let left = x.at(value) * 100.0;
            let _ = write!(numbers, "<span style=\"left:{left:.2}%\">{text}</span>");
            let at = (value * 1e4).round() as i64;
            let _ = write!(grid, "M{at} 0V{}", self.rows * SPAN);
        }
        if self.named {
            self.around.push_str("<i>time [s]</i>");
        }
        let (low, high, log) = self.y.ends();
        format!(
            "<figure class=\"plot\" style=\"--h:{:.0}px\" role=\"group\" aria-label=\"{}\" data-y=\"{low} {high} {}\" \
             data-u=\"{}\" data-d=\"{digits}\"{more}>\
             <svg viewBox=\"{} 0 {} {}\" preserveAspectRatio=\"none\" aria-hidden=\"true\">\
             <path class=\"grid gx\" d=\"{grid}\"/>{}</svg>{}<div class=\"xs\">{numbers}</div></figure>\n",
            self.height,
            self.label,
            u8::from(log),
            self.unit,
            self.from,
            self.to - self.from,
            self.rows * SPAN,
            self.body,
            self.around,
        )
    }
}

#[cfg(test)]
#[path = "timeplot_tests.rs"]
mod tests;
