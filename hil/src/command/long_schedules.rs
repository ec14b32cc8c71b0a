//! Two schedules that are too long to be held: where they differ first, and what follows there, to be told in words.

use std::collections::VecDeque;
use std::fs::File;
use std::path::Path;

use palpate_files::{FileError, LONGEST_LINE, Lines};
use palpate_records::diff::{Difference, Grade, Tolerance, compare};
use palpate_records::schedule::check_line;
use palpate_records::story::Story;

use super::schedules::{MOST, wires};
use palpate_live::output::note;
use palpate_live::progress::Progress;
use palpate_run::damaged;

/// Lines before the first difference that are compared with what follows: bursts that are still on there.
const BEFORE: usize = 1 << 12;

/// One of the two files.
struct Side {
    lines: Lines<File>,
    /// Header and the records that are compared, and the end of each record in that text with its time, microseconds.
    text: String,
    records: Vec<(u64, usize)>,
    ended: bool,
}

impl Side {
    fn open(path: &Path) -> Result<Self, FileError> {
        let mut side = Self {
            lines: Lines::open(path, "a schedule (.jsonl)", LONGEST_LINE)?,
            text: String::new(),
            records: Vec::new(),
            ended: false,
        };
        side.take()?;
        side.records.clear();
        Ok(side)
    }

    /// Takes the next line.
    fn take(&mut self) -> Result<(), FileError> {
        let label = self.lines.label().to_owned();
        let Some((number, line)) = self.lines.advance()? else {
            self.ended = true;
            return Ok(());
        };
        let time = check_line(number, line).map_err(|damage| damaged(&label, damage))?;
        let line = line.to_owned();
        self.push(time, &line);
        Ok(())
    }

    fn push(&mut self, time: u64, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
        self.records.push((time, self.text.len()));
    }

    /// The time of the newest record.
    fn time(&self) -> u64 {
        self.records.last().map_or(0, |record| record.0)
    }

    /// Leaves out the records from this time on.
    fn cut(&mut self, until_us: u64) {
        let left = self.records.partition_point(|record| record.0 < until_us);
        if let Some((_, end)) = left.checked_sub(1).and_then(|n| self.records.get(n)) {
            self.text.truncate(*end);
        }
    }

    fn story(&self) -> Result<Story, FileError> {
        let story = Story::of_schedule_file(&self.text, wires);
        let mut story = story.map_err(|damage| damaged(self.lines.label(), damage))?;
        // The figures count only the part that was read.
        story.figures.clear();
        Ok(story)
    }
}

/// Subject of two schedules, and their differences. The last part is the time, seconds, until which differences were
/// told, where they were not told to the end.
pub(super) type Told = (String, Vec<Difference>, Option<f64>);

/// Compares two schedules of any length.
///
/// # Errors
/// A file that cannot be read, the first line that no schedule has there.
pub(super) fn long(paths: [&Path; 2], edge_us: Option<u64>) -> Result<Told, FileError> {
    let _shown = Progress::reading(paths[0]);
    let [mut a, mut b] = [Side::open(paths[0])?, Side::open(paths[1])?];
    to_difference(&mut a, &mut b)?;
    let differ = !(a.ended && b.ended);
    while differ && !(a.ended && b.ended) && (a.text.len() + b.text.len()) as u64 <= 2 * MOST {
        let behind = match (a.ended, b.ended) {
            (true, _) => &mut b,
            (_, true) => &mut a,
            _ if a.time() <= b.time() => &mut a,
            _ => &mut b,
        };
        behind.take()?;
    }
    for side in [&a, &b] {
        side.lines.note().iter().for_each(|text| note(text));
    }
    let open = [&a, &b].into_iter().filter(|side| !side.ended);
    let until = open.map(Side::time).min();
    if let Some(until) = until {
        a.cut(until);
        b.cut(until);
    }
    let (a, b) = (a.story()?, b.story()?);
    let mut tolerance = Tolerance::between(&a, &b);
    tolerance.edge_us = edge_us.unwrap_or(tolerance.edge_us);
    let mut found = compare(&a, &b, tolerance);
    if let Some(us) = until {
        found.push(Difference {
            grade: Grade::Setting,
            meaning: true,
            weight: 0,
            text: format!(
                "told up to {:.3} s: compare parts of the files for what follows",
                us as f64 * 1e-6
            ),
        });
    }
    Ok((b.scene, found, until.map(|us| us as f64 * 1e-6)))
}

/// Reads both up to the first records that differ, or to their ends, and keeps the last ones before.
fn to_difference(a: &mut Side, b: &mut Side) -> Result<(), FileError> {
    let mut before: VecDeque<(u64, String)> = VecDeque::new();
    let label = a.lines.label().to_owned();
    let (x, y) = loop {
        match (a.lines.advance()?, b.lines.advance()?) {
            (Some((number, x)), Some((_, y))) if x == y => {
                let time = check_line(number, x).map_err(|damage| damaged(&label, damage))?;
                if before.len() == BEFORE {
                    before.pop_front();
                }
                before.push_back((time, x.to_owned()));
            }
            (x, y) => {
                let own = |line: Option<(usize, &str)>| line.map(|(n, text)| (n, text.to_owned()));
                break (own(x), own(y));
            }
        }
    };
    for (side, next) in [(a, x), (b, y)] {
        before
            .iter()
            .for_each(|(time, line)| side.push(*time, line));
        let Some((number, line)) = next else {
            side.ended = true;
            continue;
        };
        let time = check_line(number, &line);
        let time = time.map_err(|damage| damaged(side.lines.label(), damage))?;
        side.push(time, &line);
    }
    Ok(())
}
