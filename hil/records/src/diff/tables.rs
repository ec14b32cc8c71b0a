//! Differences of a golden's lines and tables: header, figures, rows, digests.

use std::collections::{BTreeMap, BTreeSet};

use super::edges::known_until;
use super::words::{at, change, item_key, short, signed, wire};
use super::{Difference, Grade, Tolerance};
use crate::bursts::DrivenOutput;
use crate::figures::Figure;
use crate::story::{Column, GoldenKind, Role, Story, Table};

/// Pieces of a header that name a run and tell nothing of its actions.
const NAMES: [&str; 5] = ["bench", "seed", "scene", "limits", "version"];
/// The length of a run: a setting where it is emulated, measured where it is real.
const LENGTH: &str = "length";
/// Pieces that were asked for, not measured.
const SETTINGS: [&str; 11] = [
    "clock",
    "PWM",
    "PRE_SCALE",
    "period",
    "tick",
    "tau_d",
    "SOA",
    "illusion",
    "K_C",
    "wires",
    LENGTH,
];

/// Words for schedules whose digests differ while bursts show no difference.
const SENT: &str = "the same bursts, sent otherwise: phases, currents, ends asked for, or times within a millisecond";

/// Most margins that are told before the bursts.
const EACH: usize = 3;

/// Key of a header's piece: the label of its line, and its first word without a digit.
type Key<'a> = (&'a str, &'a str);

/// The pieces of a header in their order, such as `tau_d 35.000 ms` under `tau_d`.
fn pieces(story: &Story) -> impl Iterator<Item = (Key<'_>, &str)> {
    story.head.iter().flat_map(|line| {
        line.pieces
            .iter()
            .map(|piece| ((line.label.as_str(), item_key(piece)), piece.as_str()))
    })
}

/// The pieces of a header by what names them; those of one name are one text.
fn named_pieces(story: &Story) -> BTreeMap<Key<'_>, String> {
    let mut all = BTreeMap::<Key<'_>, String>::new();
    for (key, piece) in pieces(story) {
        let text = all.entry(key).or_default();
        if !text.is_empty() {
            text.push_str(", ");
        }
        text.push_str(piece);
    }
    all
}

/// Keys of both, in the order in which they stand there.
fn in_order<K: Ord + Copy>(a: impl Iterator<Item = K>, b: impl Iterator<Item = K>) -> Vec<K> {
    let mut seen = BTreeSet::new();
    a.chain(b).filter(|k| seen.insert(*k)).collect()
}

/// Header lines: settings, names, errors.
pub(super) fn heads(a: &Story, b: &Story, tolerance: Tolerance, all: &mut Vec<Difference>) {
    if a.source != b.source {
        let text = format!("{} -> {}", a.source.word(), b.source.word());
        all.push(Difference::new(Grade::Cosmetic, false, 0, text));
    }
    let partial = a.partial || b.partial;
    let (first, second) = (named_pieces(a), named_pieces(b));
    // Pieces of one line of the header stay together.
    let mut lines: Vec<(Grade, &str, Vec<String>)> = Vec::new();
    for key in in_order(pieces(a).map(|p| p.0), pieces(b).map(|p| p.0)) {
        let (label, name) = key;
        let grade = match name {
            _ if !label.is_empty() => Grade::Figure,
            k if NAMES.contains(&k) => Grade::Cosmetic,
            k if SETTINGS.contains(&k) => Grade::Setting,
            _ => Grade::Figure,
        };
        let is_measured = grade == Grade::Figure || name == LENGTH;
        let same = |x: &str, y: &str| x == y || is_measured && tolerance.alike(x, y);
        let text = match (first.get(&key), second.get(&key)) {
            (Some(x), Some(y)) if same(x, y) => continue,
            (Some(x), Some(y)) => change(x, y),
            _ if partial => continue,
            (Some(x), None) => format!("no longer {x}"),
            (None, Some(y)) => format!("now {y}"),
            (None, None) => continue,
        };
        match lines.last_mut() {
            Some(last) if !label.is_empty() && last.1 == label => last.2.push(text),
            _ => lines.push((grade, label, vec![text])),
        }
    }
    for (grade, label, texts) in lines {
        let colon = if label.is_empty() { "" } else { ": " };
        let text = format!("{label}{colon}{}", texts.join(", "));
        all.push(Difference::new(grade, grade != Grade::Cosmetic, 0, text));
    }
}

fn by_name(story: &Story) -> BTreeMap<&str, &Figure> {
    let figures = story.figures.iter();
    figures.map(|f| (f.name.as_str(), f)).collect()
}

/// Measured values, and the limits they have less left of.
pub(super) fn figures(a: &Story, b: &Story, tolerance: Tolerance, all: &mut Vec<Difference>) {
    let partial = a.partial || b.partial;
    let (first, second) = (by_name(a), by_name(b));
    let mut found = Vec::new();
    for name in in_order(first.keys().copied(), second.keys().copied()) {
        let (Some(x), Some(y)) = (first.get(name), second.get(name)) else {
            if !partial {
                let is_gone = first.contains_key(name);
                let sign = if is_gone { "no longer" } else { "now" };
                let text = format!("{sign} measured: {name}");
                all.push(Difference::new(Grade::Figure, true, 0, text));
            }
            continue;
        };
        if x.limit != y.limit && !partial {
            let (was, is) = (x.text(x.limit), y.text(y.limit));
            let text = format!("limit of {name} {was} -> {is} {}", y.unit);
            let text = text.trim_end().to_owned();
            all.push(Difference::new(Grade::Setting, true, 0, text));
        }
        if x.value == y.value && x.unit == y.unit {
            // Where values have a band, the part used has it too.
            let part = tolerance.permille == 0 && x.limit == y.limit && x.used != y.used;
            if part || x.over != y.over {
                let text = format!("{name} {}", change(&used(x), &used(y)));
                all.push(Difference::new(Grade::Figure, true, 0, text));
            }
            continue;
        }
        let mut difference = figure(x, y);
        difference.meaning = x.unit != y.unit || !same(x.value, y.value, tolerance);
        if !difference.meaning {
            difference.grade = Grade::Cosmetic;
        }
        found.push(difference);
    }
    // What warms more warms everywhere: the rest must not hide which bursts did it.
    found.sort_by_key(|d| (d.grade, std::cmp::Reverse(d.weight)));
    let lost = found.iter_mut().filter(|d| d.grade == Grade::Margin);
    lost.skip(EACH).for_each(|d| d.grade = Grade::Figure);
    all.extend(found);
}

/// The part of a limit that was used.
fn used(figure: &Figure) -> String {
    let part = figure
        .used
        .map_or_else(|| "-".to_owned(), |used| short(used.max(0)));
    let over = if figure.over { ", over" } else { "" };
    format!("{part} % used{over}")
}

/// One value that changed.
fn figure(x: &Figure, y: &Figure) -> Difference {
    let (name, unit) = (&y.name, &y.unit);
    let (was, is) = (x.text(x.value), y.text(y.value));
    if x.unit != *unit {
        let text = change(&format!("{was} {}", x.unit), &format!("{is} {unit}"));
        return Difference::new(Grade::Figure, true, 0, format!("{name} {text}"));
    }
    // Skin cooler than the rest that its rows count from uses nothing of them.
    let parts = x
        .used
        .zip(y.used)
        .map(|(before, after)| (before.max(0), after.max(0)));
    if let Some((before, after)) = parts.filter(|(before, after)| before != after) {
        let limit = y.text(y.limit);
        let (from, to) = (short(before), short(after));
        let words = format!("{name} {was} -> {is} {unit} of {limit}, {from} -> {to} % used");
        let by = after.saturating_sub(before);
        return if by > 0 {
            Difference::new(Grade::Margin, true, by, format!("less left: {words}"))
        } else {
            Difference::new(Grade::Gain, true, by.saturating_neg(), words)
        };
    }
    let text = match x.value.zip(y.value) {
        Some((old, new)) => {
            let by = format!("{} {unit}", signed(new.saturating_sub(old)));
            format!("{name} {} ({was} -> {is})", by.trim_end())
        }
        None => format!("{name} {was} -> {is} {unit}").trim_end().to_owned(),
    };
    Difference::new(Grade::Figure, true, 0, text)
}

fn same(a: Option<i64>, b: Option<i64>, tolerance: Tolerance) -> bool {
    let (Some(a), Some(b)) = (a, b) else {
        return a == b;
    };
    let larger = u128::from(a.unsigned_abs().max(b.unsigned_abs()));
    u128::from(a.abs_diff(b)) * 1000 <= larger * u128::from(tolerance.permille)
}

/// The cells of some roles in words: `contact 0/1`, or `from 0.831 s`.
fn cells(table: &Table, row: &[String], roles: &[Role]) -> Vec<String> {
    let cells = table.columns.iter().zip(row);
    let named = cells.filter(|(column, _)| roles.contains(&column.role));
    let word = |(c, cell): (&Column, &String)| {
        format!("{} {cell} {}", c.name, c.unit)
            .trim_end()
            .to_owned()
    };
    named.map(word).collect()
}

/// Rows of tables. What follows from bursts is told of wires that are not among `driven`, the outputs whose bursts
/// differ.
pub(super) fn rows(
    a: &Story,
    b: &Story,
    tolerance: Tolerance,
    driven: &BTreeSet<DrivenOutput>,
    all: &mut Vec<Difference>,
) {
    if a.partial || b.partial {
        return;
    }
    let named = |s: &'_ Story| -> Vec<String> {
        let rows = s.table.rows.iter();
        rows.map(|row| cells(&s.table, row, &[Role::Key]).join(", "))
            .collect()
    };
    let (names_a, names_b) = (named(a), named(b));
    let mut told = Vec::new();
    for name in in_order(names_a.iter(), names_b.iter()) {
        let row = |s: &'_ Story, names: &[String], roles: &[Role]| -> Option<Vec<String>> {
            let index = names.iter().position(|n| n == name)?;
            Some(cells(&s.table, s.table.rows.get(index)?, roles))
        };
        let roles: &[Role] = match wire(name) {
            Some(wire) if driven.contains(&wire) => &[Role::Told],
            _ => &[Role::Told, Role::Derived],
        };
        match (row(a, &names_a, roles), row(b, &names_b, roles)) {
            (Some(x), Some(y)) => {
                let differ = x.iter().zip(&y).filter(|(x, y)| !tolerance.alike(x, y));
                let changes: Vec<String> = differ.map(|(x, y)| change(x, y)).collect();
                if !changes.is_empty() {
                    told.push(format!("{name}: {}", changes.join(", ")));
                }
            }
            (Some(x), None) => told.push(format!("gone: {name}: {}", x.join(", "))),
            (None, Some(y)) => told.push(format!("new: {name}: {}", y.join(", "))),
            (None, None) => {}
        }
    }
    // Wires are many and warm together: one stands for them.
    if a.kind == GoldenKind::Schedule && told.len() > 2 {
        let rest = told.len() - 1;
        told.truncate(1);
        told.iter_mut()
            .for_each(|t| t.push_str(&format!(", and {rest} wires more")));
    }
    let (was, is) = (a.table.untold, b.table.untold);
    if was != is {
        told.push(format!("rows beyond those listed: {was} -> {is}"));
    }
    let row = |text| Difference::new(Grade::Figure, true, -1, text);
    all.extend(told.into_iter().map(row));
}

/// Tells of digests that differ without an explanation by the differences found so far.
pub(super) fn digests(a: &Story, b: &Story, tolerance: Tolerance, all: &mut Vec<Difference>) {
    if !tolerance.is_none() {
        return;
    }
    let differ = |of: &str| {
        let pair = a.digests.get(of).zip(b.digests.get(of));
        pair.is_some_and(|(x, y)| x != y)
    };
    let told = |grades: &[Grade]| all.iter().any(|d| grades.contains(&d.grade));
    let drive = [
        Grade::Stop,
        Grade::Limiter,
        Grade::Burst,
        Grade::Edge,
        Grade::Width,
    ];
    // Of bursts that none of them lists there is the number.
    let more = !a.partial && !b.partial && a.burst_count() != b.burst_count();
    let text = if (differ("schedule") || more) && !told(&drive) {
        match known_until(a, b) {
            Some(us) => format!("bursts differ after {}, where a golden lists none", at(us)),
            None => SENT.to_owned(),
        }
    } else if differ("contacts") && all.iter().all(|d| !d.meaning) {
        "contacts differ by less than a golden shows".to_owned()
    } else if differ("trace") && all.is_empty() {
        "traces differ in something that a golden does not show".to_owned()
    } else {
        return;
    };
    all.push(Difference::new(Grade::Moment, true, 0, text));
}
