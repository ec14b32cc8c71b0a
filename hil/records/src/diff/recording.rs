//! Two contact recordings (CSV) compared: which contacts are new or gone, and how far the others lie apart.

use std::collections::BTreeMap;

use super::words::{at, count, short};
use super::{Difference, Grade, Tolerance};
use crate::contacts_csv::HEADER;
use crate::damage::Damage;
use crate::fixed::thousandths;

/// One row of one contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Row {
    /// Place, micrometres.
    place: (i64, i64),
    level: u16,
}

/// Contacts by module and identity, each by time in microseconds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Recording(BTreeMap<(u16, u32), BTreeMap<u64, Row>>);

impl Recording {
    /// Whether a text begins as such a file does.
    pub fn is_one(text: &str) -> bool {
        text.starts_with("frame,time_us,")
    }

    /// Reads a file.
    ///
    /// # Errors
    /// The first line that no such file has there.
    pub fn read(text: &str) -> Result<Self, Damage> {
        let mut lines = text.lines().enumerate();
        let damage =
            |index: usize, expected: &str, line: &str| Damage::of_line(index + 1, expected, line);
        match lines.next() {
            Some((_, line)) if line.trim_end() == HEADER => {}
            found => return Err(damage(0, HEADER, found.map_or("", |f| f.1))),
        }
        let mut all = Self::default();
        for (index, line) in lines {
            let row = row(line).ok_or_else(|| damage(index, "a contact: nine numbers", line))?;
            let (key, t_us, row) = row;
            if all.0.entry(key).or_default().insert(t_us, row).is_some() {
                return Err(damage(index, "one row a contact and time", line));
            }
        }
        Ok(all)
    }
}

fn row(line: &str) -> Option<((u16, u32), u64, Row)> {
    let fields: Vec<&str> = line.trim_end().split(',').collect();
    let &[
        frame,
        time,
        module,
        contact,
        x,
        y,
        intensity,
        level,
        members,
    ] = fields.as_slice()
    else {
        return None;
    };
    frame.parse::<u32>().ok()?;
    members.parse::<u32>().ok()?;
    thousandths(intensity)?;
    let row = Row {
        place: (thousandths(x)?, thousandths(y)?),
        level: level.parse().ok()?,
    };
    let key = (module.parse().ok()?, contact.parse().ok()?);
    Some((key, time.parse().ok()?, row))
}

/// Distance of two places, micrometres.
fn distance(a: Row, b: Row) -> u64 {
    let squared = |x: i64, y: i64| u128::from(x.abs_diff(y)) * u128::from(x.abs_diff(y));
    let sum = squared(a.place.0, b.place.0).saturating_add(squared(a.place.1, b.place.1));
    u64::try_from(sum.isqrt()).unwrap_or(u64::MAX)
}

/// Everything that differs between two recordings.
pub fn compare_recordings(a: &Recording, b: &Recording, tolerance: Tolerance) -> Vec<Difference> {
    let mut all = Vec::new();
    let mut push = |grade, meaning, text| all.push(Difference::new(grade, meaning, 0, text));
    let whole = |sign: &str, key: &(u16, u32), rows: &BTreeMap<u64, Row>| {
        let first = rows.keys().next().copied().unwrap_or(0);
        let rows = count(rows.len(), "row");
        format!(
            "{sign}: contact {}/{}, {rows} from {}",
            key.0,
            key.1,
            at(first)
        )
    };
    for (key, rows) in &a.0 {
        let name = format!("contact {}/{}", key.0, key.1);
        let Some(others) = b.0.get(key) else {
            push(Grade::Moment, true, whole("gone", key, rows));
            continue;
        };
        let (mut apart, mut squares, mut most, mut first) = (0u64, 0u128, 0u64, None);
        let (mut levels, mut both) = (0, 0);
        for (t_us, row) in rows {
            let Some(other) = others.get(t_us) else {
                continue;
            };
            both += 1;
            levels += usize::from(row.level != other.level);
            let by = distance(*row, *other);
            if by > 0 {
                first = first.or(Some(*t_us));
                apart += 1;
                most = most.max(by);
                squares = squares.saturating_add(u128::from(by) * u128::from(by));
            }
        }
        for (sign, n) in [("gone", rows.len() - both), ("new", others.len() - both)] {
            if n > 0 {
                push(
                    Grade::Moment,
                    true,
                    format!("{name}: {} {sign}", count(n, "row")),
                );
            }
        }
        if let Some(first) = first {
            let rmse = (squares / u128::from(apart)).isqrt();
            let mm = |um: u64| short(i64::try_from(um).unwrap_or(i64::MAX));
            let rmse = mm(u64::try_from(rmse).unwrap_or(u64::MAX));
            let meaning = most > tolerance.place_um;
            let grade = if meaning {
                Grade::Edge
            } else {
                Grade::Cosmetic
            };
            let text = format!(
                "{name} elsewhere in {apart} of {both} rows from {} on: {rmse} mm RMSE, {} mm at most",
                at(first),
                mm(most)
            );
            push(grade, meaning, text);
        }
        if levels > 0 {
            let text = format!("{name}: another level in {}", count(levels, "row"));
            push(Grade::Width, tolerance.place_um == 0, text);
        }
    }
    for (key, rows) in b.0.iter().filter(|(key, _)| !a.0.contains_key(key)) {
        push(Grade::Moment, true, whole("new", key, rows));
    }
    all.sort_by_key(|d| d.grade);
    all
}

#[cfg(test)]
#[path = "recording_tests.rs"]
mod tests;
