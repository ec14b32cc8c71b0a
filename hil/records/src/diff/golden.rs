//! A golden read back, line by line; what no golden has there is named with its line.

use std::collections::BTreeMap;

use super::sections::{bursts, contacts, digests, margins, surface};
use super::story::{Damage, Figure, Item, Kind, Moment, Story};
use super::words::item_key;
use crate::trace::Source;

/// The lines of a text with their numbers.
pub(super) struct Reader<'a> {
    lines: Vec<&'a str>,
    next: usize,
}

impl<'a> Reader<'a> {
    pub(super) fn peek(&self) -> Option<&'a str> {
        self.lines.get(self.next).copied()
    }

    fn take(&mut self) -> Option<&'a str> {
        let line = self.peek()?;
        self.next += 1;
        Some(line)
    }

    /// The next line if it is a row of a list: not empty and indented.
    pub(super) fn row(&mut self) -> Option<&'a str> {
        self.peek().filter(|l| l.starts_with(' '))?;
        self.take()
    }

    /// Where the reader stands, wanting something else.
    pub(super) fn wants(&self, expected: &str) -> Damage {
        damage(self.next + 1, expected, self.peek())
    }

    /// The line just taken, wanting something else.
    pub(super) fn wanted(&self, expected: &str) -> Damage {
        let index = self.next.saturating_sub(1);
        damage(index + 1, expected, self.lines.get(index).copied())
    }

    pub(super) fn blank(&mut self) -> Result<(), Damage> {
        match self.take() {
            Some("") => Ok(()),
            _ => Err(self.wanted("an empty line")),
        }
    }

    /// The rest of a line that begins with `start`.
    pub(super) fn begins(&mut self, start: &str) -> Result<&'a str, Damage> {
        let rest = self.peek().and_then(|l| l.strip_prefix(start));
        let rest = rest.ok_or_else(|| self.wants(&format!("`{start}..`")))?;
        self.next += 1;
        Ok(rest)
    }
}

fn damage(line: usize, expected: &str, found: Option<&str>) -> Damage {
    let found = match found {
        None => "the end of the file".to_owned(),
        Some("") => "an empty line".to_owned(),
        Some(text) => {
            let cut: String = text.chars().take(60).collect();
            format!("`{}`", cut.trim_end().escape_default())
        }
    };
    Damage {
        line,
        expected: expected.to_owned(),
        found,
    }
}

/// Reads a golden of any kind, with insta's heading or without.
pub(super) fn read_golden(text: &str) -> Result<Story, Damage> {
    let mut reader = Reader {
        lines: text.lines().map(str::trim_end).collect(),
        next: 0,
    };
    if reader.peek() == Some("---") {
        reader.next = 1;
        while reader.peek().is_some_and(|l| l != "---") {
            reader.next += 1;
        }
        reader.begins("---")?;
    }
    let (kind, scene, source) = title(&mut reader)?;
    let mut story = Story {
        kind,
        scene,
        source,
        head: Vec::new(),
        chart: Vec::new(),
        moments: Vec::new(),
        moments_until_ms: None,
        figures: Vec::new(),
        rows: Vec::new(),
        bursts: BTreeMap::new(),
        untold: 0,
        digests: Vec::new(),
        partial: false,
    };
    while let Some(line) = reader.row() {
        head(&mut story.head, line.trim());
    }
    reader.blank()?;
    match kind {
        Kind::Schedule => schedule(&mut reader, &mut story)?,
        Kind::Contacts => contacts(&mut reader, &mut story)?,
        Kind::Margins => margins(&mut reader, &mut story)?,
        Kind::Surface => surface(&mut reader, &mut story)?,
    }
    while reader.peek() == Some("") {
        reader.next += 1;
    }
    match reader.peek() {
        None => Ok(story),
        Some(_) => Err(reader.wants("the end of the file")),
    }
}

fn title(reader: &mut Reader<'_>) -> Result<(Kind, String, Source), Damage> {
    const TITLE: &str = "`palpate schedule of SCENE (emulated)` or the title of another golden";
    let rest = reader.peek().and_then(|l| l.strip_prefix("palpate "));
    let found = rest.and_then(|rest| {
        let kind = Kind::ALL.into_iter().find(|k| {
            let after = rest.strip_prefix(k.title());
            after.is_some_and(|after| after.starts_with(" of "))
        })?;
        let scene = rest.strip_prefix(kind.title())?.strip_prefix(" of ")?;
        // A title is cut where the scene's name is too long.
        let (scene, source) = match scene.rsplit_once(" (") {
            Some((scene, "real)")) => (scene, Source::Real),
            Some((scene, "emulated)")) => (scene, Source::Emulated),
            _ => (scene, Source::Emulated),
        };
        Some((kind, scene.to_owned(), source))
    });
    let found = found.ok_or_else(|| reader.wants(TITLE))?;
    reader.next += 1;
    Ok(found)
}

/// A header's line in its pieces.
fn head(items: &mut Vec<Item>, line: &str) {
    let (prefix, rest) = match line.split_once(": ") {
        Some((prefix, rest)) => (format!("{prefix}: "), rest),
        None => (String::new(), line),
    };
    for piece in rest.split("; ").flat_map(|part| part.split(", ")) {
        items.push(Item {
            key: format!("{prefix}{}", item_key(piece)),
            text: format!("{prefix}{piece}"),
        });
    }
}

/// The strip chart, up to a line that begins so.
pub(super) fn chart(reader: &mut Reader<'_>, story: &mut Story, until: &str) -> Result<(), Damage> {
    let heading = reader.begins("strip chart:")?;
    story.chart.push(format!("strip chart:{heading}"));
    while !reader.peek().is_none_or(|l| l.starts_with(until)) {
        story.chart.extend(reader.take().map(str::to_owned));
    }
    if reader.peek().is_none() {
        return Err(reader.wants(&format!("`{until}..` after the strip chart")));
    }
    Ok(())
}

fn schedule(reader: &mut Reader<'_>, story: &mut Story) -> Result<(), Damage> {
    chart(reader, story, "events:")?;
    let count = reader.begins("events: ")?;
    let count: u64 = count
        .parse()
        .map_err(|_| reader.wanted("a number of events"))?;
    while let Some(line) = reader.row() {
        if let Some(n) = more(line) {
            story.untold = n;
            continue;
        }
        let moment =
            moment(line).ok_or_else(|| reader.wanted("time, kind and text of an event"))?;
        story.moments.push(moment);
    }
    let untold = std::mem::take(&mut story.untold);
    if untold > 0 {
        let last = story.moments.last().and_then(|m| m.when.split("..").next());
        story.moments_until_ms = last.and_then(thousandths);
    }
    let told = (story.moments.len() as u64).saturating_add(untold);
    if told != count {
        return Err(reader.wants(&format!("{count} events above, as their heading says")));
    }
    reader.blank()?;
    reader.begins("ledger ")?;
    while let Some(line) = reader.row() {
        let figure = figure(line).ok_or_else(|| reader.wanted("name, value and limit"))?;
        story.figures.push(figure);
    }
    reader.blank()?;
    reader.begins("wire  output ")?;
    while let Some(line) = reader.row() {
        if more(line).is_none() {
            let row = wire_row(line).ok_or_else(|| reader.wanted("a wire's row"))?;
            story.rows.push(row);
        }
    }
    reader.blank()?;
    bursts(reader, story)?;
    digests(reader, story, &["schedule", "trace"])
}

/// How many a list leaves out.
pub(super) fn more(line: &str) -> Option<u64> {
    let rest = line.trim().strip_prefix(".. and ")?;
    rest.strip_suffix(" more")?.parse().ok()
}

/// An event's line.
pub(super) fn moment(line: &str) -> Option<Moment> {
    let (when, rest) = line.trim_start().split_once(" s ")?;
    let numbers = |t: &str| t.split("..").all(|n| thousandths(n).is_some());
    if !numbers(when) {
        return None;
    }
    let (kind, text) = rest.trim_start().split_once(' ').unwrap_or((rest, ""));
    Some(Moment {
        when: when.to_owned(),
        kind: kind.to_owned(),
        text: text.trim().to_owned(),
    })
}

/// A decimal with three places, or a count, in thousandths.
pub(super) fn thousandths(text: &str) -> Option<i64> {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1, digits),
        None => (1, text),
    };
    let plain = |t: &str| !t.is_empty() && t.bytes().all(|b| b.is_ascii_digit());
    let (whole, part) = match digits.split_once('.') {
        Some((whole, part)) if part.len() == 3 && plain(part) => (whole, part.parse::<i64>().ok()?),
        Some(_) => return None,
        None => (digits, 0),
    };
    let whole: i64 = plain(whole).then(|| whole.parse().ok())??;
    Some(sign * whole.checked_mul(1000)?.checked_add(part)?)
}

/// A number as goldens print them, or the `-` of what was not measured.
pub(super) fn number(text: &str) -> Option<&str> {
    (text == "-" || thousandths(text).is_some()).then_some(text)
}

/// A row of the ledger: a name of 22 characters, value, unit, limit, part used.
fn figure(line: &str) -> Option<Figure> {
    let name = line.get(2..24)?.trim().to_owned();
    let mut words = line.get(24..)?.split_whitespace();
    let value = number(words.next()?)?.to_owned();
    let mut next = words.next()?;
    let mut unit = "";
    if number(next).is_none() {
        unit = next;
        next = words.next()?;
    }
    let limit = number(next)?.to_owned();
    let used = match words.next() {
        Some(percent) => number(percent)?.to_owned(),
        None => "-".to_owned(),
    };
    (!name.is_empty()).then(|| Figure {
        name,
        value,
        unit: unit.to_owned(),
        limit,
        used,
    })
}

/// Of a wire's row only what its bursts do not say: how hot it became.
fn wire_row(line: &str) -> Option<Item> {
    let wire: u16 = line.split_whitespace().next()?.parse().ok()?;
    let mut back = line.trim_end().strip_suffix(" C")?.split_whitespace().rev();
    let hottest = number(back.next()?)?;
    Some(Item {
        key: format!("wire {wire} hottest"),
        text: format!("wire {wire} hottest {hottest} degC"),
    })
}
