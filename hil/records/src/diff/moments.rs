//! Differences of what happened: lines that only one of two runs has. Limiter events are told by the bursts
//! themselves, where these differ.

use std::collections::{BTreeMap, BTreeSet};

use super::{Difference, Grade, Tolerance, shared};
use crate::story::Story;
use crate::words::{Happening, HappeningKind};

/// Happenings by kind and text.
type Lines<'a> = BTreeMap<(HappeningKind, &'a str), Vec<&'a Happening>>;

fn lines<'a>(happenings: &[&'a Happening]) -> Lines<'a> {
    let mut found = Lines::new();
    for &happening in happenings {
        let key = (happening.kind, happening.text.as_str());
        found.entry(key).or_default().push(happening);
    }
    found
}

fn difference(kind: HappeningKind, text: String) -> Difference {
    let grade = match kind {
        HappeningKind::AllOff | HappeningKind::PreScale => Grade::Stop,
        _ => Grade::Moment,
    };
    Difference::new(grade, true, 0, text)
}

/// Tells the lines that only one of them has; those of the limiter where both have the same bursts.
pub(super) fn moments(
    a: &Story,
    b: &Story,
    tolerance: Tolerance,
    same_bursts: bool,
    all: &mut Vec<Difference>,
) {
    let partial = a.partial || b.partial;
    let wanted = |h: &&Happening| match h.kind {
        HappeningKind::AllOff | HappeningKind::PreScale => true,
        HappeningKind::Limiter => same_bursts && !partial,
        HappeningKind::Break | HappeningKind::Note => !partial,
    };
    let first: Vec<&Happening> = a.happenings.iter().filter(wanted).collect();
    let second: Vec<&Happening> = b.happenings.iter().filter(wanted).collect();
    let until = [a.told_until_us(), b.told_until_us()];
    let until = until.into_iter().flatten().min();
    let [first, second] = shared(&first, &second, until, |h| h.t_us);
    let found = tell(&lines(first), &lines(second), tolerance);
    let (was, is) = (a.happening_count(), b.happening_count());
    if found.is_empty() && same_bursts && !partial && was != is {
        let text = format!("{was} -> {is} events, and the same ones have a line");
        all.push(Difference::new(Grade::Moment, true, 0, text));
    }
    all.extend(found);
}

/// Differences of the lines of two runs; times within the tolerance are the same.
fn tell(first: &Lines<'_>, second: &Lines<'_>, tolerance: Tolerance) -> Vec<Difference> {
    let near = |was: &Happening, is: &Happening| {
        let apart = was.t_us.abs_diff(is.t_us);
        apart.max(was.last_us.abs_diff(is.last_us)) <= tolerance.edge_us
    };
    let mut all = Vec::new();
    let none = Vec::new();
    // New moments by kind, then those that are gone.
    let mut new: BTreeMap<HappeningKind, Vec<&Happening>> = BTreeMap::new();
    let mut gone = new.clone();
    let keys: BTreeSet<_> = first.keys().chain(second.keys()).collect();
    for key in keys {
        let x = first.get(key).unwrap_or(&none);
        let y = second.get(key).unwrap_or(&none);
        let (kind, text) = *key;
        let word = kind.word();
        match (x.as_slice(), y.as_slice()) {
            ([], [one]) => new.entry(kind).or_default().push(one),
            ([one], []) => gone.entry(kind).or_default().push(one),
            (x, y) if x.len() != y.len() => {
                let text = format!("{word} {} -> {} times: {text}", x.len(), y.len());
                all.push(difference(kind, text));
            }
            (x, y) => {
                let mut pairs = x.iter().zip(y);
                if let Some((was, is)) = pairs.find(|(was, is)| !near(was, is)) {
                    let (was, is) = (was.when(), is.when());
                    let text = format!("{word} at {was} -> {is} s: {text}");
                    all.push(difference(kind, text));
                }
            }
        }
    }
    for (sign, side) in [("new", new), ("gone", gone)] {
        for (kind, found) in side {
            let word = kind.word();
            let Some(first) = found.iter().min_by_key(|h| h.t_us) else {
                continue;
            };
            let (when, text) = (first.when(), &first.text);
            let text = match found.len() {
                1 => format!("{sign}: {word} at {when} s: {text}"),
                n => format!("{sign}: {n} times {word}, first at {when} s: {text}"),
            };
            all.push(difference(kind, text));
        }
    }
    all
}
