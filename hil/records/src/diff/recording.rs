//! Two contact recordings (CSV) compared: which contacts are new or gone, and how far the others lie apart.

use std::collections::BTreeMap;
use std::fmt;

use super::words::{at, count, short};
use super::{Difference, Grade, Tolerance};
use crate::contacts_csv::{DISPLAY, HEADER};
use crate::damage::Damage;
use crate::fixed::thousandths;

/// One row of one contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Row {
    t_us: u64,
    /// Module and identity.
    key: (u16, u32),
    /// Place, micrometres.
    place: (i64, i64),
    level: u16,
}

/// Most contacts that are told apart, and most of one time.
const MOST: usize = 1 << 18;

/// A recording of contacts that is read line by line, with the rows of one time in memory.
pub struct Contacts<'a, E> {
    lines: Box<dyn FnMut() -> Result<Option<String>, E> + 'a>,
    damaged: Box<dyn Fn(Damage) -> E + 'a>,
    number: usize,
    /// Whether it is of several displays: each row then ends with the name of one.
    several: bool,
    /// The first row of the time after the one that was read last.
    next: Option<Row>,
}

impl<E> fmt::Debug for Contacts<'_, E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Contacts")
            .field("number", &self.number)
            .finish_non_exhaustive()
    }
}

impl<'a, E> Contacts<'a, E> {
    /// A recording whose lines are pulled; `damaged` makes an error of a line that has no place there.
    ///
    /// # Errors
    /// A first line that is another, and what the lines say.
    pub fn new(
        lines: impl FnMut() -> Result<Option<String>, E> + 'a,
        damaged: impl Fn(Damage) -> E + 'a,
    ) -> Result<Self, E> {
        let mut all = Self {
            lines: Box::new(lines),
            damaged: Box::new(damaged),
            number: 1,
            several: false,
            next: None,
        };
        match (all.lines)()? {
            Some(line) if line.trim_end() == HEADER => {}
            Some(line) if is_of_several(line.trim_end()) => all.several = true,
            found => return Err(all.damage(HEADER, &found.unwrap_or_default())),
        }
        all.next = all.row(0)?;
        Ok(all)
    }

    fn damage(&self, expected: &str, found: &str) -> E {
        (self.damaged)(Damage::of_line(self.number, expected, found))
    }

    /// The next row, which is not earlier than the one before.
    fn row(&mut self, before_us: u64) -> Result<Option<Row>, E> {
        let Some(line) = (self.lines)()? else {
            return Ok(None);
        };
        self.number += 1;
        let Some(row) = row(&line, self.several) else {
            let expected = match self.several {
                true => "a contact: nine numbers and a display's name",
                false => "a contact: nine numbers",
            };
            return Err(self.damage(expected, &line));
        };
        if row.t_us < before_us {
            return Err(self.damage(&format!("a time from {before_us} us on"), &line));
        }
        Ok(Some(row))
    }

    fn too_many(&self) -> E {
        let expected = format!("at most {MOST} contacts");
        self.damage(&expected, "more (compare parts of the recordings)")
    }

    /// The time of the rows that come next.
    fn time(&self) -> Option<u64> {
        self.next.map(|row| row.t_us)
    }

    /// All rows of the time that comes next.
    fn moment(&mut self, into: &mut BTreeMap<(u16, u32), Row>) -> Result<(), E> {
        into.clear();
        while let Some(row) = self.next {
            if into.insert(row.key, row).is_some() {
                let (module, contact) = row.key;
                let found = format!("contact {module}/{contact} at {} us twice", row.t_us);
                return Err(self.damage("one row a contact and time", &found));
            }
            if into.len() > MOST {
                return Err(self.too_many());
            }
            self.next = self.row(row.t_us)?;
            if self.time() != Some(row.t_us) {
                break;
            }
        }
        Ok(())
    }
}

/// Whether the table of several displays begins so.
fn is_of_several(line: &str) -> bool {
    let more = line.strip_prefix(HEADER).and_then(|m| m.strip_prefix(','));
    more == Some(DISPLAY)
}

/// A row; the name that it has with several displays says what its module says already.
fn row(line: &str, several: bool) -> Option<Row> {
    let most = if several { 10 } else { usize::MAX };
    let mut fields: Vec<&str> = line.trim_end().splitn(most, ',').collect();
    if several {
        fields.get(9)?;
        fields.truncate(9);
    }
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
    Some(Row {
        t_us: time.parse().ok()?,
        key: (module.parse().ok()?, contact.parse().ok()?),
        place: (thousandths(x)?, thousandths(y)?),
        level: level.parse().ok()?,
    })
}

/// Distance of two places, micrometres.
fn distance(a: Row, b: Row) -> u64 {
    let squared = |x: i64, y: i64| u128::from(x.abs_diff(y)) * u128::from(x.abs_diff(y));
    let sum = squared(a.place.0, b.place.0).saturating_add(squared(a.place.1, b.place.1));
    u64::try_from(sum.isqrt()).unwrap_or(u64::MAX)
}

/// What two recordings make of one contact.
#[derive(Clone, Copy, Debug, Default)]
struct Pair {
    /// Rows in one recording alone, and when the first of them came.
    alone: [(usize, Option<u64>); 2],
    both: usize,
    /// Rows elsewhere: how many, their squared distances, the largest, the first.
    apart: u64,
    squares: u128,
    most: u64,
    first: Option<u64>,
    levels: usize,
}

impl Pair {
    fn add(&mut self, a: Option<&Row>, b: Option<&Row>) {
        let (Some(row), Some(other)) = (a, b) else {
            let alone = &mut self.alone[usize::from(a.is_none())];
            alone.0 += 1;
            alone.1 = alone.1.or(a.or(b).map(|row| row.t_us));
            return;
        };
        self.both += 1;
        self.levels += usize::from(row.level != other.level);
        let by = distance(*row, *other);
        if by > 0 {
            self.first = self.first.or(Some(row.t_us));
            self.apart += 1;
            self.most = self.most.max(by);
            self.squares = self.squares.saturating_add(u128::from(by) * u128::from(by));
        }
    }

    fn tell(
        &self,
        key: (u16, u32),
        tolerance: Tolerance,
        mut push: impl FnMut(Grade, bool, String),
    ) {
        let name = format!("contact {}/{}", key.0, key.1);
        let [gone, new] = self.alone;
        for (sign, (n, first), others) in [("gone", gone, new.0), ("new", new, gone.0)] {
            match n {
                0 => {}
                _ if self.both + others == 0 => {
                    let rows = count(n, "row");
                    let first = at(first.unwrap_or(0));
                    push(
                        Grade::Moment,
                        true,
                        format!("{sign}: {name}, {rows} from {first}"),
                    );
                }
                n => push(
                    Grade::Moment,
                    true,
                    format!("{name}: {} {sign}", count(n, "row")),
                ),
            }
        }
        if let Some(first) = self.first {
            let rmse = (self.squares / u128::from(self.apart)).isqrt();
            let mm = |um: u64| short(i64::try_from(um).unwrap_or(i64::MAX));
            let rmse = mm(u64::try_from(rmse).unwrap_or(u64::MAX));
            let meaning = self.most > tolerance.place_um;
            let grade = if meaning {
                Grade::Edge
            } else {
                Grade::Cosmetic
            };
            let text = format!(
                "{name} elsewhere in {} of {} rows from {} on: {rmse} mm RMSE, {} mm at most",
                self.apart,
                self.both,
                at(first),
                mm(self.most)
            );
            push(grade, meaning, text);
        }
        if self.levels > 0 {
            let text = format!("{name}: another level in {}", count(self.levels, "row"));
            push(Grade::Width, tolerance.place_um == 0, text);
        }
    }
}

/// Everything that differs between two recordings, read side by side: memory holds a few numbers per contact.
///
/// # Errors
/// The first line that no such file has there, and what the lines say.
pub fn compare_contacts<E>(
    a: &mut Contacts<'_, E>,
    b: &mut Contacts<'_, E>,
    tolerance: Tolerance,
) -> Result<Vec<Difference>, E> {
    let mut pairs: BTreeMap<(u16, u32), Pair> = BTreeMap::new();
    let (mut ours, mut theirs) = (BTreeMap::new(), BTreeMap::new());
    while let Some(time) = [a.time(), b.time()].into_iter().flatten().min() {
        ours.clear();
        theirs.clear();
        if a.time() == Some(time) {
            a.moment(&mut ours)?;
        }
        if b.time() == Some(time) {
            b.moment(&mut theirs)?;
        }
        for (key, row) in &ours {
            pairs
                .entry(*key)
                .or_default()
                .add(Some(row), theirs.get(key));
        }
        for (key, row) in theirs.iter().filter(|(key, _)| !ours.contains_key(*key)) {
            pairs.entry(*key).or_default().add(None, Some(row));
        }
        if pairs.len() > MOST {
            return Err(b.too_many());
        }
    }
    let mut all = Vec::new();
    for (key, pair) in pairs {
        pair.tell(key, tolerance, |grade, meaning, text| {
            all.push(Difference::new(grade, meaning, 0, text));
        });
    }
    all.sort_by_key(|d| d.grade);
    Ok(all)
}

#[cfg(test)]
#[path = "recording_tests.rs"]
mod tests;
