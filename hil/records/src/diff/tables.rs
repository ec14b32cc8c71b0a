//! Differences of what a golden prints in lines and tables: header, figures, events, rows, digests.

use std::collections::{BTreeMap, BTreeSet};

use super::edges::known_until;
use super::golden::thousandths;
use super::story::{Figure, Item, Kind, Moment, Story};
use super::words::{at, change, changes, short, signed};
use super::{Difference, Grade, Tolerance};
use crate::trace::Source;

/// Pieces of a header that name a run and say nothing of what it did.
const NAMES: [&str; 4] = ["bench", "seed", "scene", "limits"];
/// Pieces that were asked for, not measured.
const SETTINGS: [&str; 9] = [
    "PWM", "period", "tick", "tau_d", "SOA", "illusion", "K_C", "wires", "length",
];

/// Header lines: settings, names, errors.
pub(super) fn heads(a: &Story, b: &Story, all: &mut Vec<Difference>) {
    if a.source != b.source {
        let word = |s: Source| match s {
            Source::Emulated => "emulated",
            Source::Real => "real",
        };
        let text = format!("{} -> {}", word(a.source), word(b.source));
        all.push(Difference::new(Grade::Cosmetic, false, 0, text));
    }
    let partial = a.partial || b.partial;
    let lookup = |s: &Story| -> BTreeMap<String, String> {
        let pairs = s.head.iter().map(|i| (i.key.clone(), i.text.clone()));
        pairs.collect()
    };
    let (first, second) = (lookup(a), lookup(b));
    // Pieces of one line of the header stay together.
    let mut lines: Vec<(Grade, String, Vec<String>)> = Vec::new();
    for key in in_order(&a.head, &b.head) {
        let grade = match key {
            k if NAMES.contains(&k) => Grade::Cosmetic,
            k if SETTINGS.contains(&k) => Grade::Setting,
            _ => Grade::Figure,
        };
        let text = match (first.get(key), second.get(key)) {
            (Some(x), Some(y)) if x == y => continue,
            (Some(x), Some(y)) => change(x, y),
            _ if partial => continue,
            (Some(x), None) => format!("no longer: {x}"),
            (None, Some(y)) => format!("now: {y}"),
            (None, None) => continue,
        };
        let line = key.split_once(": ").map_or("", |(line, _)| line);
        match lines.last_mut() {
            Some(last) if !line.is_empty() && last.1 == line => {
                let rest = text.strip_prefix(line).unwrap_or(&text);
                last.2.push(rest.trim_start_matches(": ").to_owned());
            }
            _ => lines.push((grade, line.to_owned(), vec![text])),
        }
    }
    for (grade, _, texts) in lines {
        let meaning = grade != Grade::Cosmetic;
        all.push(Difference::new(grade, meaning, 0, texts.join(", ")));
    }
}

/// Keys of both, in the order in which they stand there.
fn in_order<'a>(a: &'a [Item], b: &'a [Item]) -> Vec<&'a str> {
    let mut seen = BTreeSet::new();
    let keys = a.iter().chain(b).map(|i| i.key.as_str());
    keys.filter(|k| seen.insert(*k)).collect()
}

/// Measured values, and the limits they have less left of.
pub(super) fn figures(a: &Story, b: &Story, tolerance: Tolerance, all: &mut Vec<Difference>) {
    let by_name = |s: &Story| -> BTreeMap<String, Figure> {
        let named = s.figures.iter().map(|f| (f.name.clone(), f.clone()));
        named.collect()
    };
    let (first, second) = (by_name(a), by_name(b));
    let names: BTreeSet<&String> = first.keys().chain(second.keys()).collect();
    for name in names {
        let (Some(x), Some(y)) = (first.get(name), second.get(name)) else {
            if !(a.partial || b.partial) {
                let sign = if first.contains_key(name) {
                    "no longer"
                } else {
                    "now"
                };
                let text = format!("{sign} measured: {name}");
                all.push(Difference::new(Grade::Figure, true, 0, text));
            }
            continue;
        };
        let unit = if y.unit.is_empty() {
            String::new()
        } else {
            format!(" {}", y.unit)
        };
        if x.limit != y.limit && !(a.partial || b.partial) {
            let text = format!("limit of {name} {} -> {}{unit}", x.limit, y.limit);
            all.push(Difference::new(Grade::Setting, true, 0, text));
        }
        if x.value == y.value && x.unit == y.unit {
            continue;
        }
        let (old, new) = (thousandths(&x.value), thousandths(&y.value));
        let meaning = !same(old, new, tolerance);
        let (grade, weight, text) = match (thousandths(&x.used), thousandths(&y.used)) {
            (Some(was), Some(is)) => {
                let words = format!(
                    "{name} {} -> {}{unit} of {}, {} -> {} % used",
                    x.value,
                    y.value,
                    y.limit,
                    short(was),
                    short(is)
                );
                let by = is.saturating_sub(was);
                if by > 0 {
                    (Grade::Margin, by, format!("less left: {words}"))
                } else {
                    (Grade::Figure, -by, words)
                }
            }
            _ => {
                let by = old.zip(new).map(|(o, n)| n.saturating_sub(o));
                let text = match by {
                    Some(by) => format!("{name} {}{unit} ({} -> {})", signed(by), x.value, y.value),
                    None => format!("{name} {} -> {}{unit}", x.value, y.value),
                };
                (Grade::Figure, 0, text)
            }
        };
        let grade = if meaning { grade } else { Grade::Cosmetic };
        all.push(Difference::new(grade, meaning, weight, text));
    }
}

fn same(a: Option<i64>, b: Option<i64>, tolerance: Tolerance) -> bool {
    let (Some(a), Some(b)) = (a, b) else {
        return a == b;
    };
    let larger = u128::from(a.unsigned_abs().max(b.unsigned_abs()));
    u128::from(a.abs_diff(b)) * 1000 <= larger * u128::from(tolerance.permille)
}

/// What happened: lines that only one of them has. Limiter events are told by the bursts themselves.
pub(super) fn moments(a: &Story, b: &Story, all: &mut Vec<Difference>) {
    let partial = a.partial || b.partial;
    let until = [a.moments_until_ms, b.moments_until_ms];
    let until = until.into_iter().flatten().min().unwrap_or(i64::MAX);
    let begins = |m: &Moment| thousandths(m.when.split("..").next().unwrap_or("")).unwrap_or(0);
    let wanted = |m: &&Moment| {
        m.kind != "limiter"
            && begins(m) < until
            && (!partial || ["all-off", "pre-scale"].contains(&m.kind.as_str()))
    };
    let tally = |s: &Story| {
        let mut found: BTreeMap<(String, String), Vec<String>> = BTreeMap::new();
        for m in s.moments.iter().filter(wanted) {
            let key = (m.kind.clone(), m.text.clone());
            found.entry(key).or_default().push(m.when.clone());
        }
        found
    };
    let (first, second) = (tally(a), tally(b));
    let none = Vec::new();
    // By kind: what is new, what is gone.
    let mut new: BTreeMap<&str, Vec<(&str, &str)>> = BTreeMap::new();
    let mut gone = new.clone();
    let mut push = |kind: &str, text: String| {
        let grade = match kind {
            "all-off" | "pre-scale" => Grade::Stop,
            _ => Grade::Moment,
        };
        all.push(Difference::new(grade, true, 0, text));
    };
    let keys: BTreeSet<_> = first.keys().chain(second.keys()).collect();
    for key in keys {
        let x = first.get(key).unwrap_or(&none);
        let y = second.get(key).unwrap_or(&none);
        let (kind, text) = (key.0.as_str(), key.1.as_str());
        match (x.as_slice(), y.as_slice()) {
            (x, y) if x == y => {}
            ([], [when]) => new.entry(kind).or_default().push((when, text)),
            ([when], []) => gone.entry(kind).or_default().push((when, text)),
            ([was], [is]) => push(kind, format!("{kind} at {was} -> {is} s: {text}")),
            (x, y) => push(
                kind,
                format!("{kind} {} -> {} times: {text}", x.len(), y.len()),
            ),
        }
    }
    for (sign, side) in [("new", new), ("gone", gone)] {
        for (kind, found) in side {
            if let [(when, text)] = found.as_slice() {
                push(kind, format!("{sign}: {kind} at {when} s: {text}"));
                continue;
            }
            let first = found.iter().min_by_key(|(when, _)| {
                thousandths(when.split("..").next().unwrap_or("")).unwrap_or(0)
            });
            let (when, text) = first.copied().unwrap_or_default();
            let n = found.len();
            push(
                kind,
                format!("{sign}: {n} times {kind}, first at {when} s: {text}"),
            );
        }
    }
}

/// Rows of tables that have no figure of their own.
pub(super) fn rows(a: &Story, b: &Story, tolerance: Tolerance, all: &mut Vec<Difference>) {
    if a.partial || b.partial || !tolerance.is_none() {
        return;
    }
    let texts = |s: &Story| -> BTreeMap<String, String> {
        let pairs = s.rows.iter().map(|i| (i.key.clone(), i.text.clone()));
        pairs.collect()
    };
    let (first, second) = (texts(a), texts(b));
    let mut told = Vec::new();
    for key in in_order(&a.rows, &b.rows) {
        let text = match (first.get(key), second.get(key)) {
            (Some(x), Some(y)) if x == y => continue,
            (Some(x), Some(y)) => changes(key, x, y),
            (Some(x), None) => format!("gone: {x}"),
            (None, Some(y)) => format!("new: {y}"),
            (None, None) => continue,
        };
        told.push(text);
    }
    // Wires are many and warm together: one stands for them.
    if a.kind == Kind::Schedule && told.len() > 2 {
        let rest = told.len() - 1;
        told.truncate(1);
        told.iter_mut()
            .for_each(|t| t.push_str(&format!(", and {rest} wires more")));
    }
    let row = |text| Difference::new(Grade::Figure, true, -1, text);
    all.extend(told.into_iter().map(row));
}

/// What the words above do not explain.
pub(super) fn digests(a: &Story, b: &Story, tolerance: Tolerance, all: &mut Vec<Difference>) {
    if !tolerance.is_none() {
        return;
    }
    let differ = |key: &str| {
        let of = |s: &Story| {
            s.digests
                .iter()
                .find(|d| d.key == key)
                .map(|d| d.text.clone())
        };
        matches!((of(a), of(b)), (Some(x), Some(y)) if x != y)
    };
    let told = |grades: &[Grade]| all.iter().any(|d| grades.contains(&d.grade));
    let drive = [
        Grade::Stop,
        Grade::Limiter,
        Grade::Burst,
        Grade::Edge,
        Grade::Width,
    ];
    let text = if differ("schedule") && !told(&drive) {
        match known_until(a, b) {
            Some(us) => format!("bursts differ after {}, where a golden lists none", at(us)),
            None => "the same bursts, with pulses that begin elsewhere in their periods".to_owned(),
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
