//! Differences of a golden's drawings: the strip chart and the map of the pad, where no burst or event explains them.

use std::collections::BTreeSet;

use super::words::{at, change, count, list, wire};
use super::{Difference, Grade, Tolerance};
use crate::bursts::DrivenOutput;
use crate::fixed::thousandths;
use crate::story::Story;

/// Columns of a row's label, with the space behind it.
const LABEL: usize = 13;
/// Most rows told by their names.
const EACH: usize = 3;

/// Tells the differences between the drawings of two stories. `driven` are the outputs whose bursts differ.
pub(super) fn drawings(
    a: &Story,
    b: &Story,
    tolerance: Tolerance,
    driven: &BTreeSet<DrivenOutput>,
    all: &mut Vec<Difference>,
) {
    // No band says how far a character may move; a schedule file has no drawing.
    if !tolerance.is_none() || a.chart.is_empty() || b.chart.is_empty() {
        return;
    }
    let grades = |grades: &[Grade]| all.iter().any(|d| d.meaning && grades.contains(&d.grade));
    let is_set = grades(&[Grade::Setting]);
    let events = [Grade::Stop, Grade::Limiter, Grade::Moment];
    let happened = a.partial || b.partial || !driven.is_empty() || grades(&events);
    // The scale follows from settings and from the widest pulse.
    let scale = scale(&a.chart, &b.chart).filter(|_| !is_set && driven.is_empty());
    let explained = |label: &str| match wire(label) {
        Some(wire) => driven.contains(&wire),
        None => label == "events" && happened,
    };
    let told = [
        scale,
        marks(&a.chart, &b.chart, explained),
        pad(&a.pad, &b.pad),
    ];
    let difference = |text| Difference::new(Grade::Figure, true, -2, text);
    all.extend(told.into_iter().flatten().map(difference));
}

/// A line of a chart: what stands before its characters, and these.
fn parted(line: &str) -> (&str, &str) {
    let (label, marks) = line.split_at_checked(LABEL).unwrap_or((line, ""));
    (label.trim(), marks)
}

/// Tells whether a line with this label has a character per quantum.
fn is_row(label: &str) -> bool {
    ["events", "contacts", "taxels", "x", "y"].contains(&label) || wire(label).is_some()
}

/// First difference of the headings, rulers and labels of two charts.
fn scale(a: &[String], b: &[String]) -> Option<String> {
    let is_row = |x: &str, y: &str| is_row(parted(x).0) && parted(x).0 == parted(y).0;
    let mut lines = a.iter().zip(b);
    let other = lines.find(|(x, y)| x != y && !is_row(x, y));
    let other = other.map(|(x, y)| change(x.trim_start(), y.trim_start()));
    let longer = || format!("{} -> {} lines", a.len(), b.len());
    let text = other.or_else(|| (a.len() != b.len()).then(longer))?;
    match text.starts_with("strip chart:") {
        true => Some(text),
        false => Some(format!("strip chart: {text}")),
    }
}

/// Differences of the rows of two charts of one scale, but for those that are explained.
fn marks(a: &[String], b: &[String], explained: impl Fn(&str) -> bool) -> Option<String> {
    let mut pairs = a.iter().zip(b);
    if a.len() != b.len() || pairs.any(|(x, y)| parted(x).0 != parted(y).0) {
        return None;
    }
    // `strip chart: one character is 20.000 ms, ..`
    let quantum = a.first().and_then(|line| line.split_whitespace().nth(5));
    let quantum_us = quantum.and_then(unsigned).unwrap_or(0);
    let mut found = Marks::default();
    let (mut seen, mut names) = (BTreeSet::new(), Vec::new());
    let mut from_us = 0;
    for (x, y) in a.iter().zip(b) {
        let ((label, was), (_, is)) = (parted(x), parted(y));
        if let Some(ms) = unsigned(label) {
            from_us = ms.saturating_mul(1000);
        }
        if was == is || !is_row(label) || explained(label) {
            continue;
        }
        for (column, was, is) in apart(was, is) {
            let by_us = quantum_us.saturating_mul(column as u64);
            found.add((was, is), || {
                format!("at {}", at(from_us.saturating_add(by_us)))
            });
        }
        if seen.insert(label) {
            names.push(label.to_owned());
        }
    }
    let rows = match names.len() {
        0..=EACH => list(&names),
        n => count(n, "row"),
    };
    found.words("strip chart", &format!(" of {rows}"))
}

/// Thousandths that have no sign.
fn unsigned(text: &str) -> Option<u64> {
    u64::try_from(thousandths(text)?).ok()
}

/// Differences of two maps of the pad.
fn pad(a: &[String], b: &[String]) -> Option<String> {
    let line = |pad: &[String], index: usize| pad.get(index).cloned().unwrap_or_default();
    let mut found = Marks::default();
    for index in 0..a.len().max(b.len()) {
        for (column, was, is) in apart(&line(a, index), &line(b, index)) {
            let place = || format!("in line {}, column {}", index + 1, column + 1);
            found.add((was, is), place);
        }
    }
    found.words("pad", "")
}

/// The characters that differ, with their columns; a line that is cut ends in spaces.
fn apart(a: &str, b: &str) -> Vec<(usize, char, char)> {
    let columns = a.chars().count().max(b.chars().count());
    let [a, b] = [a, b].map(|line| line.chars().chain(std::iter::repeat(' ')));
    let pairs = a.zip(b).take(columns).enumerate();
    let differ = pairs.filter(|(_, (was, is))| was != is);
    differ
        .map(|(column, (was, is))| (column, was, is))
        .collect()
}

/// Characters of a drawing that differ: how many, and the first.
#[derive(Default)]
struct Marks {
    count: usize,
    first: Option<String>,
}

impl Marks {
    fn add(&mut self, (was, is): (char, char), place: impl FnOnce() -> String) {
        self.count += 1;
        let first = || format!("first `{was}` -> `{is}` {}", place());
        self.first.get_or_insert_with(first);
    }

    fn words(self, drawing: &str, of: &str) -> Option<String> {
        let differ = if self.count == 1 { "differs" } else { "differ" };
        let characters = count(self.count, "character");
        let first = self.first?;
        Some(format!("{drawing}: {characters}{of} {differ}, {first}"))
    }
}
