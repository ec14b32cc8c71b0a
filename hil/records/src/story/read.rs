//! A golden's text read back into its story, line by line; a line that no golden has there is named.

use super::table::Table;
use super::text::{self, LEDGER};
use super::{DIGEST, DRIVEN, GoldenKind, HeadLine, NAMED, Story, StoryTiming};
use crate::bursts::{Burst, DrivenOutput};
use crate::damage::Damage;
use crate::figures::Figure;
use crate::fixed::thousandths;
use crate::trace::Source;
use crate::words::{Happening, HappeningKind};
use palpate_core::schedule::Reason;
use std::collections::BTreeSet;

/// Heading of the ledger before it had units and parts in columns of their own.
const LEDGER_BEFORE: &str = "ledger                          value           limit";

/// The lines of a text, and which comes next.
struct Reader<'a> {
    lines: Vec<&'a str>,
    next: usize,
}

impl<'a> Reader<'a> {
    fn peek(&self) -> Option<&'a str> {
        self.lines.get(self.next).copied()
    }

    fn take(&mut self) -> Option<&'a str> {
        let line = self.peek()?;
        self.next += 1;
        Some(line)
    }

    /// The next line if it is a row of a list: not empty and indented.
    fn row(&mut self) -> Option<&'a str> {
        self.peek().filter(|l| l.starts_with(' '))?;
        self.take()
    }

    /// Damage at the next line, where something else is expected.
    fn wants(&self, expected: &str) -> Damage {
        self.damage(self.next, expected)
    }

    /// Damage at the line just taken, where something else is expected.
    fn wanted(&self, expected: &str) -> Damage {
        self.damage(self.next.saturating_sub(1), expected)
    }

    fn damage(&self, index: usize, expected: &str) -> Damage {
        match self.lines.get(index) {
            Some(line) => Damage::of_line(index + 1, expected, line),
            None => Damage {
                line: index + 1,
                expected: expected.to_owned(),
                found: "the end of the file".to_owned(),
            },
        }
    }

    fn blank(&mut self) -> Result<(), Damage> {
        match self.peek() {
            Some("") => {
                self.next += 1;
                Ok(())
            }
            _ => Err(self.wants("an empty line")),
        }
    }

    /// The rest of a line that begins with `start`.
    fn begins(&mut self, start: &str) -> Result<&'a str, Damage> {
        let rest = self.peek().and_then(|l| l.strip_prefix(start));
        let rest = rest.ok_or_else(|| self.wants(&format!("`{start}..`")))?;
        self.next += 1;
        Ok(rest)
    }

    /// A line that reads so from begin to end.
    fn exactly(&mut self, line: &str) -> Result<(), Damage> {
        if self.peek() != Some(line) {
            return Err(self.wants(&format!("`{line}`")));
        }
        self.next += 1;
        Ok(())
    }

    /// The line just taken, which has to say what was understood of it, but for spaces.
    fn understood(&self, as_line: &str) -> Result<(), Damage> {
        let taken = self.lines.get(self.next.saturating_sub(1));
        let words = taken.map(|line| line.split_whitespace());
        match words.is_some_and(|words| words.eq(as_line.split_whitespace())) {
            true => Ok(()),
            false => Err(self.wanted(&format!("`{}`", as_line.trim()))),
        }
    }

    /// The lines up to one that begins so.
    fn until(&mut self, start: &str) -> Result<Vec<String>, Damage> {
        let mut lines = Vec::new();
        while let Some(line) = self.peek().filter(|l| !l.starts_with(start)) {
            lines.push(line.to_owned());
            self.next += 1;
        }
        match self.peek() {
            Some(_) => Ok(lines),
            None => Err(self.wants(&format!("`{start}..` after the strip chart"))),
        }
    }

    /// The strip chart, up to a line that begins so.
    fn chart(&mut self, until: &str) -> Result<Vec<String>, Damage> {
        if !self.peek().is_some_and(|l| l.starts_with("strip chart:")) {
            return Err(self.wants("`strip chart:..`"));
        }
        self.until(until)
    }
}

/// Reads a golden of any kind, with insta's heading or without, behind a byte order mark or none.
pub(super) fn read(text: &str) -> Result<Story, Damage> {
    let text = text.trim_start_matches('\u{FEFF}');
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
    let mut story = title(&mut reader)?;
    while let Some(line) = reader.row() {
        story.head.push(head(line.trim()));
    }
    reader.blank()?;
    headed(&reader, &story)?;
    match story.kind {
        GoldenKind::Schedule => schedule(&mut reader, &mut story)?,
        GoldenKind::Contacts => {
            if !reader
                .peek()
                .is_some_and(|l| l.starts_with("pad:") || l.starts_with("no "))
            {
                return Err(reader.wants("`pad:..`"));
            }
            while let Some(line) = reader.peek().filter(|l| !l.is_empty()) {
                story.pad.push(line.to_owned());
                reader.next += 1;
            }
            reader.blank()?;
            let heading = story.table.heading();
            if reader.lines.contains(&heading.as_str()) {
                story.chart = reader.chart(&heading)?;
                rows(&mut reader, &mut story.table)?;
            } else {
                story.chart = reader.chart("contacts: ")?;
                story.partial = true;
            }
        }
        GoldenKind::Surface if reader.peek().is_some_and(|l| l.starts_with("force [N]")) => {
            story.partial = true;
        }
        GoldenKind::Surface => rows(&mut reader, &mut story.table)?,
    }
    if story.partial {
        // Tables of earlier versions have other columns, and their traces other events.
        reader.until("digest ")?;
    }
    for of in story.kind.digests() {
        // Digests of earlier goldens are of other bytes: they say nothing beside today's.
        let is_earlier = reader.peek().is_some_and(|l| l.starts_with("digest of "));
        let start = if is_earlier { "digest of" } else { DIGEST };
        let digest = reader.begins(&format!("{start} {of}"))?.trim();
        if digest.len() != 16 || !digest.bytes().all(|b| b.is_ascii_hexdigit()) {
            return Err(reader.wanted("16 hexadecimal digits"));
        }
        if !(is_earlier || story.partial && *of == "trace") {
            story.digests.insert(of, digest.to_owned());
        }
    }
    while reader.peek() == Some("") {
        reader.next += 1;
    }
    match reader.peek() {
        None => Ok(story),
        Some(_) => Err(reader.wants("the end of the file")),
    }
}

/// An empty story under the text's title.
fn title(reader: &mut Reader<'_>) -> Result<Story, Damage> {
    const TITLE: &str = "`palpate schedule of SCENE (emulated)` or the title of another golden";
    let rest = reader.peek().and_then(|l| l.strip_prefix("palpate "));
    let found = rest.and_then(|rest| {
        GoldenKind::ALL.into_iter().find_map(|kind| {
            let scene = rest.strip_prefix(kind.title())?.strip_prefix(" of ")?;
            Some((kind, scene))
        })
    });
    let (kind, scene) = found.ok_or_else(|| reader.wants(TITLE))?;
    reader.next += 1;
    // A title is cut where the scene's name is too long.
    let known = scene.rsplit_once(" (").and_then(|(scene, word)| {
        let source = Source::named(word.strip_suffix(')')?)?;
        Some((scene, source))
    });
    let (scene, source) = known.unwrap_or((scene, Source::Emulated));
    Ok(Story::empty(kind, scene.to_owned(), source))
}

/// A header's line in its pieces.
fn head(line: &str) -> HeadLine {
    let (label, rest) = line.split_once(": ").unwrap_or(("", line));
    HeadLine {
        label: label.to_owned(),
        pieces: rest.split(", ").map(str::to_owned).collect(),
    }
}

/// Refuses a header that lacks what every header of its kind says.
fn headed(reader: &Reader<'_>, story: &Story) -> Result<(), Damage> {
    let drive: &[&str] = match story.kind {
        GoldenKind::Schedule => &DRIVEN,
        GoldenKind::Contacts | GoldenKind::Surface => &[],
    };
    let plain = story.head.iter().filter(|line| line.label.is_empty());
    let pieces: Vec<&String> = plain.flat_map(|line| &line.pieces).collect();
    let lacks = |name: &&&str| !pieces.iter().any(|piece| piece.starts_with(**name));
    match NAMED.iter().chain(drive).find(lacks) {
        Some(name) => Err(reader.wants(&format!("`{name}..` in the header above"))),
        None => Ok(()),
    }
}

/// The times that a header names; a time that it lacks is zero.
fn timing(head: &[HeadLine]) -> StoryTiming {
    let thousandths_of = |name: &str| {
        let mut pieces = head.iter().flat_map(|line| &line.pieces);
        let number = pieces.find_map(|p| p.strip_prefix(name)?.split(' ').next());
        let value = number.and_then(thousandths);
        value.and_then(|v| u64::try_from(v).ok()).unwrap_or(0)
    };
    StoryTiming {
        tau_d_us: thousandths_of("tau_d "),
        soa_us: thousandths_of("SOA "),
        // The header has whole nanoseconds.
        tick_ns: thousandths_of("tick ") / 1000,
    }
}

fn schedule(reader: &mut Reader<'_>, story: &mut Story) -> Result<(), Damage> {
    story.timing = timing(&story.head);
    story.chart = reader.chart("events:")?;
    happenings(reader, story)?;
    reader.blank()?;
    if reader.peek() == Some(LEDGER_BEFORE) {
        story.partial = true;
        reader.until("bursts: ")?;
        return bursts(reader, story);
    }
    reader.exactly(LEDGER)?;
    let mut names = BTreeSet::new();
    while let Some(line) = reader.row() {
        let figure =
            figure(line).ok_or_else(|| reader.wanted("name, value, limit and part used"))?;
        reader.understood(&text::figure(&figure))?;
        if !names.insert(figure.name.clone()) {
            return Err(reader.wanted("each figure once"));
        }
        story.figures.push(figure);
    }
    reader.blank()?;
    rows(reader, &mut story.table)?;
    reader.blank()?;
    bursts(reader, story)
}

fn happenings(reader: &mut Reader<'_>, story: &mut Story) -> Result<(), Damage> {
    let count = reader.begins("events: ")?.parse::<u64>().ok();
    let count = count.ok_or_else(|| reader.wanted("a number of events"))?;
    while let Some(line) = reader.row() {
        match more(line) {
            Some(n) => story.happenings_untold = n,
            None => {
                let expected = "time, kind and text of an event";
                let happening = happening(line).ok_or_else(|| reader.wanted(expected))?;
                reader.understood(&text::event(&happening))?;
                story.happenings.push(happening);
            }
        }
    }
    let told = story.happenings.len() as u64;
    if told.checked_add(story.happenings_untold) != Some(count) {
        return Err(reader.wants(&format!("{count} events above, as their heading says")));
    }
    Ok(())
}

fn rows(reader: &mut Reader<'_>, table: &mut Table) -> Result<(), Damage> {
    reader.exactly(&table.heading())?;
    let mut keys = BTreeSet::new();
    while let Some(line) = reader.row() {
        match more(line) {
            Some(n) => table.untold = n,
            None => {
                let cells = table.read_row(line);
                let expected = format!("{} figures", table.columns.len());
                let cells = cells.ok_or_else(|| reader.wanted(&expected))?;
                if !keys.insert(table.key(&cells)) {
                    return Err(reader.wanted("each row once"));
                }
                table.rows.push(cells);
            }
        }
    }
    Ok(())
}

/// Number of lines that a list leaves out.
fn more(line: &str) -> Option<u64> {
    let rest = line.trim().strip_prefix(".. and ")?;
    rest.strip_suffix(" more")?.parse().ok()
}

/// An event's line.
fn happening(line: &str) -> Option<Happening> {
    let (when, rest) = line.trim_start().split_once(" s ")?;
    let (word, text) = rest
        .trim_start()
        .split_once(' ')
        .unwrap_or((rest.trim_start(), ""));
    let us = |seconds: &str| {
        let ms = u64::try_from(thousandths(seconds)?).ok()?;
        ms.checked_mul(1000)
    };
    let (first, last) = when.split_once("..").unwrap_or((when, when));
    Some(Happening {
        t_us: us(first)?,
        last_us: us(last)?,
        kind: HappeningKind::ALL.into_iter().find(|k| k.word() == word)?,
        text: text.trim_start().to_owned(),
    })
}

/// A row of the ledger: a name of 26 characters, value, unit, limit, part used.
fn figure(line: &str) -> Option<Figure> {
    let name = line.get(2..28)?.trim().to_owned();
    let mut words = line.get(28..)?.split_whitespace().peekable();
    let value = Figure::read(words.next()?)?;
    let unit = words.next_if(|w| Figure::read(w).is_none());
    let limit = Figure::read(words.next()?)?;
    let used = Figure::read(words.next()?)?;
    let over = words.last() == Some("OVER");
    (!name.is_empty()).then(|| Figure {
        name,
        value,
        unit: unit.unwrap_or_default().to_owned(),
        limit,
        used,
        over,
    })
}

/// The list of bursts.
fn bursts(reader: &mut Reader<'_>, story: &mut Story) -> Result<(), Damage> {
    const MEMBER: &str = "wire:ticks, or wire:ticks<asked(reason)";
    let heading = reader.begins("bursts: ")?;
    let count = heading
        .split(';')
        .next()
        .and_then(|n| n.parse::<u64>().ok());
    let count = count.ok_or_else(|| reader.wanted("a number of bursts"))?;
    let tau_d_us = story.timing.tau_d_us;
    reader.understood(&text::bursts_heading(count, tau_d_us))?;
    let mut at = None;
    while let Some(line) = reader.row() {
        if let Some(n) = more(line) {
            story.bursts_untold = n;
            continue;
        }
        for word in line.split_whitespace() {
            if word.contains(':') {
                let span = at.ok_or_else(|| reader.wanted("an onset before its wires"))?;
                let burst = member(word, span).filter(|burst| text::member(burst) == word);
                story
                    .bursts
                    .push(burst.ok_or_else(|| reader.wanted(MEMBER))?);
            } else {
                let expected = "an onset in microseconds";
                let span = onset(word, tau_d_us);
                let span = span.filter(|span| text::onset(*span, tau_d_us) == word);
                at = Some(span.ok_or_else(|| reader.wanted(expected))?);
            }
        }
    }
    let told = story.bursts.len() as u64;
    if told.checked_add(story.bursts_untold) != Some(count) {
        let expected = format!("{count} bursts above, as their heading says");
        return Err(reader.wants(&expected));
    }
    story.bursts.sort_by_key(|b| (b.from_us, b.output));
    Ok(())
}

/// First and last microsecond of `FROM` or `FROM+LENGTH`.
fn onset(word: &str, tau_d_us: u64) -> Option<(u64, u64)> {
    let (from, length) = match word.split_once('+') {
        Some((from, length)) => (from, length.parse().ok()?),
        None => (word, tau_d_us),
    };
    let from: u64 = from.parse().ok()?;
    Some((from, from.checked_add(length)?))
}

fn member(word: &str, (from_us, to_us): (u64, u64)) -> Option<Burst> {
    let (output, rest) = word.split_once(':')?;
    let output = match output.strip_prefix('@') {
        Some(pin) => {
            let (board, channel) = pin.split_once('.')?;
            DrivenOutput::Pin(board.parse().ok()?, channel.parse().ok()?)
        }
        None => DrivenOutput::Wire(output.parse().ok()?),
    };
    let (width, requested, reason) = match rest.split_once('<') {
        None => (rest, rest, None),
        Some((width, why)) => {
            let (asked, word) = why.strip_suffix(')')?.split_once('(')?;
            let reason = Reason::ALL.into_iter().find(|r| r.word() == word)?;
            (width, asked, Some(reason))
        }
    };
    Some(Burst {
        output,
        from_us,
        to_us,
        width: width.parse().ok()?,
        requested: requested.parse().ok()?,
        reason,
    })
}
