//! Times of a table's rows: the column that holds them, and its unit.

use super::dialect::Row;
use super::gain::Gain;
use super::taken::{TIMES, Wrong, numbered, shown};
use super::times::{TimeColumn, TimeUnit, date_us};

/// Options for the times of a table's rows, for the unit of their values, and for the messages that are rows.
#[derive(Clone, Debug, Default)]
pub struct Timing {
    /// The column that holds times; none: a first column `time_us`, else one whose name is that of times.
    pub column: Option<TimeColumn>,
    /// Rows per second where no column holds times.
    pub rate_hz: Option<f64>,
    /// True if jumps of the clock are taken out.
    pub split_jumps: bool,
    /// Rows at rest that are put before the readings of an array that is compensated, and never at rest.
    pub rest_rows: usize,
    /// Gain that turns values in another unit into counts.
    pub gain: Option<Gain>,
    /// The topic whose messages are rows; none: the one with the most numbers.
    pub topic: Option<String>,
}

/// Sources of times.
#[derive(Clone, Debug)]
pub(super) enum Clock {
    Column(usize, TimeColumn),
    /// Whole seconds, and the column of the nanoseconds in them.
    Seconds(usize, usize),
    /// Dates, and the column of the times of day.
    Dated(usize, usize),
    Rate(f64),
    /// A clock whose times are of no interest.
    None,
}

/// Rows of a table's beginning, which tell the unit of a clock that states none.
pub(super) struct Beginning<'a> {
    /// The names of the columns; none where there is no heading.
    pub(super) names: Option<&'a [&'a str]>,
    pub(super) rows: &'a [Vec<String>],
    /// Columns that stand before the values, where there is no heading.
    pub(super) before: usize,
}

impl Clock {
    /// The column of times, which holds no values.
    pub(super) fn places(&self) -> Vec<usize> {
        match self {
            Self::Column(place, _) => vec![*place],
            Self::Seconds(first, second) | Self::Dated(first, second) => vec![*first, *second],
            Self::Rate(_) | Self::None => Vec::new(),
        }
    }

    /// The column of times, where there is one, and its unit.
    pub(super) fn counted(&self) -> Option<(usize, TimeUnit)> {
        match self {
            Self::Column(place, column) => Some((*place, column.unit)),
            Self::Seconds(place, _) => Some((*place, TimeUnit::Ns)),
            Self::Dated(_, place) => Some((*place, TimeUnit::Date)),
            Self::Rate(_) | Self::None => None,
        }
    }

    /// The column of times as a recipe names it, and what it counts; none where there is none.
    pub(super) fn named(&self, names: Option<&[&str]>) -> Option<(String, TimeUnit)> {
        let (place, unit) = match self {
            Self::Column(place, column) => (*place, column.unit),
            Self::Seconds(place, _) => (*place, TimeUnit::S),
            Self::Dated(place, _) => (*place, TimeUnit::Date),
            Self::Rate(_) | Self::None => return None,
        };
        let name = names.and_then(|names| names.get(place));
        Some((
            name.map_or_else(|| (place + 1).to_string(), |name| (*name).to_owned()),
            unit,
        ))
    }

    /// The column of times as errors name it.
    pub(super) fn key(&self) -> String {
        match self {
            Self::Column(place, column) if column.name.is_empty() => {
                format!("column {}", place + 1)
            }
            Self::Column(place, column) => format!("column {} ({})", place + 1, column.name),
            Self::Seconds(first, second) | Self::Dated(first, second) => {
                format!("columns {} and {}", first + 1, second + 1)
            }
            Self::Rate(_) | Self::None => String::new(),
        }
    }

    /// The time of a row as its column states it, microseconds; 0 without one. Numbers whose unit was not stated are
    /// whole.
    pub(super) fn micros(&self, row: Row<'_>, stated: bool) -> Result<u64, Wrong> {
        let wrong = |field: &str, expected: String| (Some(self.key()), expected, shown(field));
        match self {
            Self::Rate(_) | Self::None => Ok(0),
            Self::Column(place, column) => {
                let field = row.get(*place);
                let us = match stated || column.unit != TimeUnit::Us {
                    true => column.unit.micros(field),
                    false => field.parse().ok(),
                };
                let whole = if stated { "" } else { "whole " };
                us.ok_or_else(|| wrong(field, format!("a {whole}number of {}", column.unit.noun())))
            }
            Self::Dated(date, clock) => {
                let field = |place: &usize| row.get(*place);
                let us = |place| date_us(field(place));
                let us = us(date).zip(us(clock)).map(|(date, clock)| date + clock);
                us.ok_or_else(|| wrong(field(clock), "a date and a time of day".to_owned()))
            }
            Self::Seconds(seconds, nanos) => {
                let whole = |place: usize, most: u64| {
                    let field = row.get(place);
                    let number = field.parse::<u64>().ok().filter(|n| *n < most);
                    number.ok_or_else(|| wrong(field, format!("a whole number below {most}")))
                };
                let us = whole(*seconds, u64::MAX / 2_000_000)? * 1_000_000;
                Ok(us + whole(*nanos, 1_000_000_000)? / 1000)
            }
        }
    }
}

impl Timing {
    /// Finds the clock of a table, with a remark on how it was found.
    pub(super) fn clock(&self, table: &Beginning<'_>) -> Result<(Clock, Option<String>), Wrong> {
        let names = table.names.unwrap_or_default();
        if let Some(column) = &self.column {
            let place = match table.names {
                Some(names) => names.iter().position(|name| *name == column.name),
                None => numbered(&column.name),
            };
            let place = place.ok_or_else(|| {
                let found = match table.names {
                    Some(names) => shown(&names.join(", ")),
                    None => "no heading (a column is called by its number, from 1)".into(),
                };
                (None, format!("a column {} (--time)", column.name), found)
            })?;
            if let Some(found) = paired(names, place, table.rows) {
                return Ok(found);
            }
            return Ok((Clock::Column(place, column.clone()), None));
        }
        if names.first() == Some(&TIMES[0]) {
            let column = TimeColumn {
                name: TIMES[0].into(),
                unit: TimeUnit::Us,
            };
            return Ok((Clock::Column(0, column), None));
        }
        match self.rate_hz {
            Some(rate) if rate.is_finite() && rate > 0.0 => return Ok((Clock::Rate(rate), None)),
            Some(rate) => return Err((None, "a rate above 0 Hz".into(), rate.to_string())),
            None => {}
        }
        let found = match table.names {
            Some(names) => named(names, table.rows)?,
            None => unnamed(table)?,
        };
        Ok(found.unwrap_or((Clock::None, None)))
    }
}

type Found = Option<(Clock, Option<String>)>;

/// The first column whose name is that of times.
fn named(names: &[&str], rows: &[Vec<String>]) -> Result<Found, Wrong> {
    for (place, name) in names.iter().enumerate() {
        let Some(unit) = is_time(name) else { continue };
        if let Some(found) = paired(names, place, rows) {
            return Ok(Some(found));
        }
        return of_column(place, name, unit, rows).map(Some);
    }
    // Times of day are times whatever their column is called.
    let told = |place: &usize| all(rows, *place, is_clock);
    match (0..names.len()).find(told) {
        Some(place) => of_column(place, names[place], Some(TimeUnit::Date), rows).map(Some),
        None => Ok(None),
    }
}

/// The clock of two columns that belong to each other: seconds with nanoseconds, or dates with times of day.
fn paired(names: &[&str], place: usize, rows: &[Vec<String>]) -> Option<(Clock, Option<String>)> {
    let is_date = |field: &str| date_us(field).is_some() && !is_clock(field);
    let clock = match nanos_beside(names, place) {
        Some(nanos) => Clock::Seconds(place, nanos),
        None if all(rows, place, is_date) => {
            Clock::Dated(place, (0..names.len()).find(|of| all(rows, *of, is_clock))?)
        }
        None => return None,
    };
    let both: Vec<String> = clock
        .places()
        .iter()
        .map(|of| format!("`{}`", names[*of]))
        .collect();
    let note = format!("times are {}", both.join(" and "));
    Some((clock, Some(note)))
}

/// Tells whether a field has a time of day.
fn is_clock(field: &str) -> bool {
    field.contains(':') && date_us(field).is_some()
}

/// Tells whether all fields of a column, of which there are some, are such ones.
fn all(rows: &[Vec<String>], place: usize, holds: impl Fn(&str) -> bool) -> bool {
    let fields = || {
        rows.iter()
            .map(|row| row.get(place).map_or("", String::as_str))
    };
    !rows.is_empty() && fields().all(holds)
}

/// Finds a counter, a time, or both before the values.
fn unnamed(table: &Beginning<'_>) -> Result<Found, Wrong> {
    let counts = |place: usize| {
        let rows = table.rows.iter();
        let numbers: Option<Vec<u64>> = rows.map(|row| row.get(place)?.parse().ok()).collect();
        numbers.is_some_and(|n| n.len() > 1 && n.windows(2).all(|p| p[1] == p[0] + 1))
    };
    match table.before {
        0 => Ok(None),
        1 if counts(0) => Ok(None),
        1 => of_column(0, "", None, table.rows).map(Some),
        2 if counts(0) => of_column(1, "", None, table.rows).map(Some),
        before => {
            let found = format!("{before} columns before the values");
            Err((
                None,
                "a time, or a number and a time, before them".into(),
                found,
            ))
        }
    }
}

fn of_column(
    place: usize,
    name: &str,
    unit: Option<TimeUnit>,
    rows: &[Vec<String>],
) -> Result<(Clock, Option<String>), Wrong> {
    let shown_name = match name {
        "" => format!("column {}", place + 1),
        name => format!("column `{name}`"),
    };
    let (unit, note) = match unit {
        Some(unit) => (unit, format!("times are {shown_name}, {}", unit.noun())),
        None => {
            let fields: Vec<&str> = rows
                .iter()
                .filter_map(|r| Some(r.get(place)?.as_str()))
                .collect();
            let guessed = guess(&fields).ok_or_else(|| {
                let expected = "what it counts (--time COLUMN:UNIT with s, ms, us, ns or date), or a rate (--rate HZ)";
                let found = fields.iter().take(3).copied().collect::<Vec<_>>().join(", ");
                (Some(shown_name.clone()), expected.to_owned(), shown(&found))
            })?;
            let note = format!(
                "times are {shown_name}, taken for {} by its numbers (--time COLUMN:UNIT says otherwise)",
                guessed.noun()
            );
            (guessed, note)
        }
    };
    let column = TimeColumn {
        name: name.to_owned(),
        unit,
    };
    Ok((Clock::Column(place, column), Some(note)))
}

/// Words for a unit at the end of a name; those from `secs` on may be the whole name.
const UNITS: [(TimeUnit, &[&str]); 4] = [
    (TimeUnit::S, &["s", "sec", "secs", "second", "seconds"]),
    (
        TimeUnit::Ms,
        &["ms", "msec", "msecs", "millis", "milliseconds"],
    ),
    (
        TimeUnit::Us,
        &["us", "µs", "μs", "usec", "usecs", "micros", "microseconds"],
    ),
    (
        TimeUnit::Ns,
        &[
            "ns",
            "nsec",
            "nsecs",
            "nanosec",
            "nanosecs",
            "nanos",
            "nanoseconds",
        ],
    ),
];

/// Tells whether a word is a unit of times.
pub(super) fn is_unit_of_time(word: &str) -> bool {
    UNITS.iter().any(|(_, names)| names.contains(&word))
}

/// Tells whether a name is one of times, with the unit if the name states it.
fn is_time(name: &str) -> Option<Option<TimeUnit>> {
    if name == "%time" {
        return Some(Some(TimeUnit::Ns)); // as rostopic writes them
    }
    let lower = name.to_lowercase();
    let mut words: Vec<&str> = lower.split(|c: char| !c.is_alphanumeric()).collect();
    words.retain(|word| !word.is_empty());
    let unit_of = |word: &str| {
        UNITS
            .iter()
            .find(|(_, names)| names.contains(&word))
            .map(|(u, _)| *u)
    };
    let is_base = |words: &[&str]| {
        matches!(
            words,
            ["t" | "date" | "timestamps"]
                | [.., "time" | "timestamp" | "stamp" | "datetime" | "elapsed"]
        )
    };
    if is_base(&words) {
        return Some(None);
    }
    let (last, base) = words.split_last()?;
    let unit = unit_of(last)?;
    (is_base(base) || (base.is_empty() && last.len() > 2)).then_some(Some(unit))
}

/// The column of nanoseconds that belongs to one of whole seconds: `secs` and `nsecs`, `stamp.sec` and `stamp.nanosec`.
fn nanos_beside(names: &[&str], seconds: usize) -> Option<usize> {
    let name = names.get(seconds)?;
    let partner = |name: &str, (sec, nano): (&str, &str)| {
        let base = name.strip_suffix(sec)?;
        let wanted = format!("{base}{nano}");
        names.iter().position(|other| *other == wanted)
    };
    let pairs = [("secs", "nsecs"), ("sec", "nanosec"), ("sec", "nsec")];
    pairs.into_iter().find_map(|pair| partner(name, pair))
}

/// Guesses the unit of a column by its numbers: those since 1970 show it, others by the rows that a skin would give.
fn guess(fields: &[&str]) -> Option<TimeUnit> {
    if fields.first().is_some_and(|f| date_us(f).is_some()) {
        return Some(TimeUnit::Date);
    }
    let numbers: Option<Vec<f64>> = fields.iter().map(|f| f.parse().ok()).collect();
    let numbers = numbers.filter(|n| n.iter().all(|v| v.is_finite()))?;
    let first = *numbers.first()?;
    let units = [
        (TimeUnit::S, 1.0),
        (TimeUnit::Ms, 1e3),
        (TimeUnit::Us, 1e6),
        (TimeUnit::Ns, 1e9),
    ];
    // From 2001 to 2096.
    let since_1970 = |(_, scale): &&(TimeUnit, f64)| (1e9..4e9).contains(&(first / scale));
    if let Some((unit, _)) = units.iter().find(since_1970) {
        return Some(*unit);
    }
    let mut steps: Vec<f64> = numbers
        .windows(2)
        .map(|p| p[1] - p[0])
        .filter(|s| *s > 0.0)
        .collect();
    steps.sort_by(f64::total_cmp);
    let step = *steps.get(steps.len() / 2)?;
    // A unit counts only where rows as fast as a skin's exclude all others.
    Some(match step {
        1e-4..0.9 => TimeUnit::S,
        s if s > 1.0 && s <= 500.0 => TimeUnit::Ms,
        1e3..=5e5 => TimeUnit::Us,
        1e6..=5e8 => TimeUnit::Ns,
        _ => return None,
    })
}

#[cfg(test)]
#[path = "clock_tests.rs"]
mod tests;
