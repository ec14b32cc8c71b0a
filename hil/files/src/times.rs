//! The times of a recording: clocks that jump, and numbers that are no microseconds.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::str::FromStr;

use palpate_core::statistics::quantile;
use serde::Deserialize;

use super::pace::SAME;

/// Longest recording, microseconds, as the longest scene: a slip in a time must not make a run of years.
pub const LONGEST_US: u64 = 86_400_000_000;
/// Distance of two rows beyond which the clock was set between them, microseconds.
const JUMP_US: u64 = 3_600_000_000;
/// Largest disorder of frames of several buses, microseconds.
pub const DISORDER_US: u64 = 1_000_000;
/// Steps that tell the unit of a column.
const TELLING: usize = 16;
/// Distance of rows a second apart and slower, by their numbers, microseconds: they may be nanoseconds.
const SLOW_US: u64 = 1_000_000;
/// Distance of rows at ten thousand a second and faster, by their numbers, microseconds: they may be milliseconds.
const FAST_US: u64 = 100;
/// Further step ahead that counts as a jump, where jumps are taken out: this and so many usual distances, a stray
/// frame.
const STRAY_US: u64 = 2_000_000;
const STRAY_STEPS: u64 = 100;

palpate_core::listed! {
    /// Unit of a column of times.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
    #[cfg_attr(test, derive(schemars::JsonSchema))]
    #[serde(rename_all = "kebab-case")]
    pub enum TimeUnit: word {
        /// Seconds.
        S = "s",
        /// Milliseconds.
        Ms = "ms",
        /// Microseconds.
        Us = "us",
        /// Nanoseconds.
        Ns = "ns",
        /// Dates with a time of day, `2026-03-01T12:00:00.25Z`; without a zone they are taken for UTC.
        Date = "date",
    }
}

/// A column of times, as `--time COLUMN[:UNIT]` names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TimeColumn {
    /// The column's heading.
    pub name: String,
    /// The column's unit.
    pub unit: TimeUnit,
}

impl FromStr for TimeColumn {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, unit) = text.rsplit_once(':').unwrap_or((text, "us"));
        let unit = TimeUnit::ALL.into_iter().find(|known| known.word() == unit);
        let unit =
            unit.ok_or("expected a column and s, ms, us, ns or date, such as timestamp:ms")?;
        match name {
            "" => Err("expected a column, such as timestamp:ms".into()),
            name => Ok(Self {
                name: name.to_owned(),
                unit,
            }),
        }
    }
}

impl TimeUnit {
    /// A field as microseconds, rounded.
    pub(super) fn micros(self, field: &str) -> Option<u64> {
        if self == Self::Date {
            return date_us(field);
        }
        let whole = field.parse::<u64>().ok();
        match (self, whole) {
            (Self::Us, Some(us)) => return Some(us),
            (Self::Ms, Some(ms)) => return ms.checked_mul(1000),
            (Self::S, Some(s)) => return s.checked_mul(1_000_000),
            (Self::Ns, Some(ns)) => return Some(ns / 1000),
            (Self::Date, _) | (_, None) => {}
        }
        let us_per_unit = match self {
            Self::S => 1e6,
            Self::Ms => 1e3,
            Self::Us | Self::Date => 1.0,
            Self::Ns => 1e-3,
        };
        let us = field.parse::<f64>().ok()? * us_per_unit;
        // Below 2^63 every rounded value has a place.
        (0.0..9.2e18).contains(&us).then(|| us.round() as u64)
    }

    /// Name of the unit in messages.
    pub(super) const fn noun(self) -> &'static str {
        match self {
            Self::S => "seconds",
            Self::Ms => "milliseconds",
            Self::Us => "microseconds",
            Self::Ns => "nanoseconds",
            Self::Date => "dates",
        }
    }
}

/// Microseconds since 1970 of a date with a time of day: `2026-03-01T12:00:00.25Z`, with a blank in place of the `T`,
/// with a zone such as `+02:00`, or without one, which is UTC. Of a date alone those of its midnight, and of a time of day those
/// since midnight. Days may stand in the middle, as `3/1/2026` has them, or first, as `1.3.2026` and `31/3/2026` do.
pub(super) fn date_us(text: &str) -> Option<u64> {
    let (date, time) = match text.split_once(['T', ' ']) {
        Some((clock, half)) if clock.contains(':') && is_half(half) => ("1970-01-01", text),
        Some(parts) => parts,
        None if text.contains(':') => ("1970-01-01", text),
        None => (text, "00:00:00"),
    };
    let number = |text: &str| -> Option<i64> {
        let digits =
            !text.is_empty() && text.len() < 10 && text.bytes().all(|b| b.is_ascii_digit());
        digits.then(|| text.parse().ok())?
    };
    let three = |text: &str, mark: char| -> Option<[i64; 3]> {
        let mut parts = text.splitn(3, mark).map(number);
        Some([parts.next()??, parts.next()??, parts.next()??])
    };
    let mark = date.chars().find(|c| "-/.".contains(*c))?;
    let [year, month, day] = match (three(date, mark)?, mark) {
        (own @ [(1000..), _, _], _) => own,
        ([day, month, year], '.') | ([day @ (13..), month, year], _) => [year, month, day],
        ([month, day, year], _) => [year, month, day],
    };
    let (time, half_day) = match time.trim_end().rsplit_once(' ') {
        Some((time, half)) if is_half(half) => (time, Some(half.starts_with(['p', 'P']))),
        _ => (time, None),
    };
    let zone_at = time.find(['Z', '+', '-']).unwrap_or(time.len());
    let (clock, zone) = time.split_at_checked(zone_at)?;
    let (clock, fraction) = clock.split_once(['.', ',']).unwrap_or((clock, ""));
    let [hour, minute, second] = three(clock, ':')?;
    let hour = match half_day {
        Some(is_late) => hour % 12 + if is_late { 12 } else { 0 },
        None => hour,
    };
    let micros: String = fraction.chars().chain("000000".chars()).take(6).collect();
    let zone_min = match zone {
        "" | "Z" => 0,
        zone => {
            let (hours, minutes) = zone
                .get(1..)?
                .split_once(':')
                .unwrap_or((zone.get(1..)?, "0"));
            let min = number(hours)? * 60 + number(minutes)?;
            if zone.starts_with('-') { -min } else { min }
        }
    };
    let fits = (1970..3000).contains(&year)
        && (1..=12).contains(&month)
        && (1..=31).contains(&day)
        && (hour < 24 && minute < 60 && second < 61);
    if !fits {
        return None;
    }
    // Days since 1970 in the Gregorian calendar, counted from March (Hinnant, "chrono-compatible date algorithms").
    let (y, m) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let of_era = y.rem_euclid(400);
    let of_year = (153 * m + 2) / 5 + day - 1;
    let days =
        y.div_euclid(400) * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468;
    let s = days * 86_400 + hour * 3600 + (minute - zone_min) * 60 + second;
    u64::try_from(s * 1_000_000 + number(&micros)?).ok()
}

/// Tells whether a word is the half of a day.
fn is_half(word: &str) -> bool {
    ["am", "pm"]
        .iter()
        .any(|half| word.eq_ignore_ascii_case(half))
}

/// The reason for which a time cannot follow those before it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutOfTime {
    /// The expectation.
    pub expected: String,
    /// The finding; none: the field as it stands.
    pub found: Option<String>,
}

/// Follows the times of a recording, in microseconds.
#[derive(Clone, Debug, Default)]
pub struct Times {
    /// True if jumps are taken out.
    split: bool,
    first: Option<u64>,
    last: Option<u64>,
    /// Shift of the times of the piece that is read, so that it follows the piece before.
    shift: i128,
    /// Rows in succession that share the newest time.
    same: u32,
    /// First distances, microseconds: their median is the usual one.
    steps: Vec<u64>,
    /// Microseconds to add to the times of each bus that has come.
    clocks: BTreeMap<usize, i128>,
    notes: Vec<String>,
}

/// Words for a length of time, in the unit that people would use.
fn length(us: u64) -> String {
    let s = us as f64 * 1e-6;
    match s {
        s if s >= 2.0 * 31_557_600.0 => format!("{:.1} years", s / 31_557_600.0),
        s if s >= 2.0 * 86_400.0 => format!("{:.1} days", s / 86_400.0),
        s if s >= 3600.0 => format!("{:.1} hours", s / 3600.0),
        s => format!("{s:.3} s"),
    }
}

impl Times {
    /// Follows times from the first on; `split` takes jumps of the clock out.
    #[must_use]
    pub fn new(split: bool) -> Self {
        Self {
            split,
            ..Self::default()
        }
    }

    /// The time of the next row of a file, in a line of it.
    ///
    /// # Errors
    /// The errors of [`Times::row`] or, for a clock that may repeat itself, [`Times::coarse_row`].
    pub(super) fn next_row(
        &mut self,
        (file, line): (&str, usize),
        us: u64,
        is_coarse: bool,
    ) -> Result<u64, OutOfTime> {
        match is_coarse {
            true => self.coarse_row(&format!("{file}:{line}"), us),
            false => self.row(&format!("{file}:{line}"), us),
        }
    }

    /// The time of the next row, later than the row before.
    ///
    /// # Errors
    /// A time that is not later, a jump of the clock, a recording of more than a day.
    pub fn row(&mut self, place: &str, us: u64) -> Result<u64, OutOfTime> {
        self.next(place, us, Some(1))
    }

    /// The time of the next row, no earlier than the row before: clocks of milliseconds repeat themselves.
    ///
    /// # Errors
    /// The errors of [`Times::row`].
    pub fn coarse_row(&mut self, place: &str, us: u64) -> Result<u64, OutOfTime> {
        self.next(place, us, Some(0))
    }

    /// The time of the next frame of a bus, by its number and its name. A later bus whose
    /// first frame is far from the newest one has a clock of its own.
    ///
    /// # Errors
    /// The errors of [`Times::frame`], and a clock of its own where jumps are not taken out.
    pub fn frame_of(
        &mut self,
        place: &str,
        (bus, name): (usize, impl Display),
        us: u64,
    ) -> Result<u64, OutOfTime> {
        if !self.clocks.contains_key(&bus) {
            let newest = self.last.map(i128::from);
            let by = newest.map_or(0, |newest| i128::from(us) + self.shift - newest);
            let is_apart = by > i128::from(JUMP_US) || by < -i128::from(DISORDER_US);
            let own = is_apart && !self.clocks.is_empty();
            let found = || format!("a clock of its own of `{name}`, {}", apart(by));
            if own && !self.split {
                return Err(OutOfTime {
                    expected: "one clock for all buses (--split-jumps puts the first frame of each bus at the newest one of the others)".into(),
                    found: Some(found()),
                });
            }
            if own {
                let note = "its first frame is put at the newest one of the others";
                self.notes.push(format!("{place}: {}: {note}", found()));
            }
            self.clocks.insert(bus, if own { -by } else { 0 });
        }
        let us = i128::from(us) + self.clocks.get(&bus).unwrap_or(&0);
        self.frame(place, u64::try_from(us).unwrap_or(0))
    }

    /// The time of the next frame, which may be a little earlier than the one before.
    ///
    /// # Errors
    /// A jump of the clock, a recording of more than a day.
    pub fn frame(&mut self, place: &str, us: u64) -> Result<u64, OutOfTime> {
        self.next(place, us, None)
    }

    /// Takes the next time: rows are at least `least` microseconds apart; frames may be out of order.
    fn next(&mut self, place: &str, us: u64, least: Option<i128>) -> Result<u64, OutOfTime> {
        let mut shifted = i128::from(us) + self.shift;
        if let Some(last) = self.last {
            let by = shifted - i128::from(last);
            self.same = if by == 0 { self.same + 1 } else { 0 };
            if least.is_some() && self.same >= SAME {
                return Err(OutOfTime {
                    expected: "times that tell rows apart".into(),
                    found: Some(format!("{} rows of one instant, {us} us", self.same + 1)),
                });
            }
            let mut most = JUMP_US;
            if self.split && by > i128::from(STRAY_US) {
                most = most.min(STRAY_US.max(self.usual().saturating_mul(STRAY_STEPS)));
            }
            let jumped = by > i128::from(most) || by < -i128::from(DISORDER_US);
            if jumped && self.split {
                let to = i128::from(last) + i128::from(self.usual().max(1));
                self.shift += to - shifted;
                shifted = to;
                let first = self.first.unwrap_or(0);
                // Frames count from a whole second.
                let zero = match least {
                    Some(_) => first,
                    None => first - first % 1_000_000,
                };
                self.notes.push(format!(
                    "{place}: {} taken out: a new piece, joined at {:.3} s of the run",
                    jump(by),
                    (shifted - i128::from(zero)) as f64 * 1e-6
                ));
            } else if jumped && (by > 0 || least.is_none()) {
                return Err(OutOfTime {
                    expected: format!(
                        "a time near the one before, {last} us (--split-jumps plays what follows right after it)"
                    ),
                    found: Some(jump(by)),
                });
            } else if least.is_some_and(|least| by < least) {
                let before = i128::from(last) - self.shift;
                let more = if least == Some(0) { "no less" } else { "more" };
                let expected = format!("{more} than the row before, {before}");
                return Err(OutOfTime {
                    expected,
                    found: None,
                });
            } else if by > 0 {
                let step = u64::try_from(by).unwrap_or(u64::MAX);
                if self.steps.len() < TELLING {
                    self.steps.push(step);
                }
            }
        }
        let first = *self.first.get_or_insert(us);
        if shifted - i128::from(first) > i128::from(LONGEST_US) {
            return Err(OutOfTime {
                expected: format!("at most a day after the first, {first} us"),
                found: None,
            });
        }
        // A frame may come a little before the first one.
        let time = u64::try_from(shifted).unwrap_or(0);
        self.last = Some(self.last.map_or(time, |last| last.max(time)));
        Ok(time)
    }

    /// The usual distance of two times, as far as it is known; 0 before there are two.
    fn usual(&self) -> u64 {
        let mut steps = self.steps.clone();
        steps.sort_unstable();
        quantile(&steps, 0.5).map_or(0, |middle| middle.above)
    }

    /// Returns true if enough rows have come to tell what their numbers are.
    pub(super) fn is_telling(&self) -> bool {
        self.steps.len() == TELLING
    }

    /// Other meaning of a column of whole microseconds whose rows come too fast or too slow for a skin.
    pub(super) fn looks_like(&self) -> Option<String> {
        if self.steps.len() < 2 {
            return None;
        }
        let median = self.usual();
        let every = |us: u64| length(us);
        match median {
            1 => Some("row numbers: give --rate HZ, and leave the column out".into()),
            2..FAST_US => Some(format!(
                "milliseconds: they would be rows every {median} us (--time COLUMN:ms)"
            )),
            SLOW_US.. => Some(format!(
                "nanoseconds: they would be rows every {}",
                every(median)
            )),
            _ => None,
        }
    }

    /// The jumps that were taken out, with their places.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }
}

fn jump(by: i128) -> String {
    format!("a jump of the clock, {}", apart(by))
}

/// Words for a distance between clocks.
fn apart(by: i128) -> String {
    let us = u64::try_from(by.unsigned_abs()).unwrap_or(u64::MAX);
    let way = if by < 0 { "back" } else { "ahead" };
    format!("{} {way}", length(us))
}

#[cfg(test)]
#[path = "times_tests.rs"]
mod tests;
