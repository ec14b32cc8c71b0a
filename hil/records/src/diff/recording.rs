//! Two contact recordings (CSV) compared: which contacts are new or gone, how far the others lie apart, and in how many
//! rows their numbers are others.

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
    frame: u32,
    /// Thousandths of a raw count.
    intensity: i64,
    level: u16,
    members: u32,
}

/// Most contacts that are told apart, and most of one time.
const MOST: usize = 1 << 18;
/// Longest name of a display, bytes.
const LONGEST: usize = 256;

/// A recording of contacts that is read line by line, with the rows of one time in memory.
pub struct Contacts<'a, E> {
    lines: Box<dyn FnMut() -> Result<Option<String>, E> + 'a>,
    damaged: Box<dyn Fn(Damage) -> E + 'a>,
    number: usize,
    /// `true` for a recording of several displays: each row then ends with the name of one.
    several: bool,
    /// The display of each module that has a row; no name where there is one display.
    displays: BTreeMap<u16, String>,
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
            displays: BTreeMap::new(),
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
        let Some((row, display)) = row(&line, self.several) else {
            let expected = match self.several {
                true => "a contact: nine numbers and a display's name",
                false => "a contact: nine numbers",
            };
            return Err(self.damage(expected, &line));
        };
        if row.t_us < before_us {
            return Err(self.damage(&format!("a time from {before_us} us on"), &line));
        }
        let module = row.key.0;
        let own = self.displays.entry(module);
        let own = own.or_insert_with(|| display.to_owned());
        if own.as_str() != display {
            let expected = format!("display {own}, as in the rows of module {module} above");
            return Err(self.damage(&expected, &line));
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

/// Tells whether a line is the heading of a table of several displays.
fn is_of_several(line: &str) -> bool {
    let more = line.strip_prefix(HEADER).and_then(|m| m.strip_prefix(','));
    more == Some(DISPLAY)
}

/// A row, and the name of its display where there are several.
fn row(line: &str, several: bool) -> Option<(Row, &str)> {
    let most = if several { 10 } else { usize::MAX };
    let mut fields: Vec<&str> = line.trim_end().splitn(most, ',').collect();
    let display = match (several, fields.get(9).copied()) {
        (false, _) => "",
        (true, name) => name.filter(|name| name.len() <= LONGEST)?,
    };
    if several {
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
    let row = Row {
        t_us: time.parse().ok()?,
        key: (module.parse().ok()?, contact.parse().ok()?),
        place: (thousandths(x)?, thousandths(y)?),
        frame: frame.parse().ok()?,
        intensity: thousandths(intensity)?,
        level: level.parse().ok()?,
        members: members.parse().ok()?,
    };
    Some((row, display))
}

/// Distance of two places, micrometres.
fn distance(a: Row, b: Row) -> u64 {
    let squared = |x: i64, y: i64| u128::from(x.abs_diff(y)) * u128::from(x.abs_diff(y));
    let sum = squared(a.place.0, b.place.0).saturating_add(squared(a.place.1, b.place.1));
    u64::try_from(sum.isqrt()).unwrap_or(u64::MAX)
}

/// A number of a contact that is another in some rows.
#[derive(Clone, Copy, Debug, Default)]
struct Other {
    rows: usize,
    /// Largest difference.
    most: u64,
    /// `true` where it is beyond its band in some row.
    beyond: bool,
}

impl Other {
    fn add(&mut self, by: u64, within: u64) {
        self.rows += usize::from(by > 0);
        self.most = self.most.max(by);
        self.beyond |= by > within;
    }
}

/// Thousandths, such as micrometres as millimetres.
fn thousands(value: u64) -> String {
    short(i64::try_from(value).unwrap_or(i64::MAX))
}

/// Comparison of one contact in two recordings.
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
    frame: Other,
    intensity: Other,
    level: Other,
    members: Other,
}

impl Pair {
    fn add(&mut self, a: Option<&Row>, b: Option<&Row>, tolerance: Tolerance) {
        let (Some(row), Some(other)) = (a, b) else {
            let alone = &mut self.alone[usize::from(a.is_none())];
            alone.0 += 1;
            alone.1 = alone.1.or(a.or(b).map(|row| row.t_us));
            return;
        };
        self.both += 1;
        self.numbers(row, other, tolerance);
        let by = distance(*row, *other);
        if by > 0 {
            self.first = self.first.or(Some(row.t_us));
            self.apart += 1;
            self.most = self.most.max(by);
            self.squares = self.squares.saturating_add(u128::from(by) * u128::from(by));
        }
    }

    /// Holds the numbers of two rows against each other. Where places have a band, intensities have one too, levels and
    /// members may be one apart, and each recording counts its own frames.
    fn numbers(&mut self, row: &Row, other: &Row, tolerance: Tolerance) {
        let bands = tolerance.place_um > 0;
        let (step, any) = if bands { (1, u64::MAX) } else { (0, 0) };
        let larger = row
            .intensity
            .unsigned_abs()
            .max(other.intensity.unsigned_abs());
        let band = u128::from(larger) * u128::from(tolerance.permille) / 1000;
        let band = u64::try_from(band).unwrap_or(u64::MAX);
        let intensity = row.intensity.abs_diff(other.intensity);
        self.frame.add(row.frame.abs_diff(other.frame).into(), any);
        self.intensity.add(intensity, band);
        self.level.add(row.level.abs_diff(other.level).into(), step);
        self.members
            .add(row.members.abs_diff(other.members).into(), step);
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
            let rmse = thousands(u64::try_from(rmse).unwrap_or(u64::MAX));
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
                thousands(self.most)
            );
            push(grade, meaning, text);
        }
        let whole = |other: Other| (other, other.most.to_string());
        let intensity = (self.intensity, thousands(self.intensity.most));
        for (what, (other, most)) in [
            ("intensity", intensity),
            ("level", whole(self.level)),
            ("number of members", whole(self.members)),
            ("frame", whole(self.frame)),
        ] {
            if other.rows > 0 {
                let rows = count(other.rows, "row");
                let text = format!("{name}: another {what} in {rows}, {most} apart at most");
                push(Grade::Width, other.beyond, text);
            }
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
                .add(Some(row), theirs.get(key), tolerance);
        }
        for (key, row) in theirs.iter().filter(|(key, _)| !ours.contains_key(*key)) {
            pairs
                .entry(*key)
                .or_default()
                .add(None, Some(row), tolerance);
        }
        if pairs.len() > MOST {
            return Err(b.too_many());
        }
    }
    let mut all = Vec::new();
    for (module, was) in &a.displays {
        let said = |name: &str| match name {
            "" => "none".to_owned(),
            name => name.to_owned(),
        };
        if let Some(is) = b.displays.get(module).filter(|is| *is != was) {
            let text = format!("display of module {module}: {} -> {}", said(was), said(is));
            all.push(Difference::new(Grade::Setting, true, 0, text));
        }
    }
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
