//! Differences of what happened: lines that only one of two runs has. Limiter events are told by the bursts
//! themselves.

use std::collections::{BTreeMap, BTreeSet};

use super::{Difference, Grade};
use crate::story::Story;
use crate::words::{Happening, HappeningKind};

/// When each line of one kind and text came, in seconds.
type Lines<'a> = BTreeMap<(HappeningKind, &'a str), Vec<&'a Happening>>;

fn lines(story: &Story, partial: bool, until_us: u64) -> Lines<'_> {
    let in_every_file = [HappeningKind::AllOff, HappeningKind::PreScale];
    let wanted = |h: &&Happening| {
        h.kind != HappeningKind::Limiter
            && h.t_us < until_us
            && (!partial || in_every_file.contains(&h.kind))
    };
    let mut found = Lines::new();
    for happening in story.happenings.iter().filter(wanted) {
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

/// Tells the lines that only one of them has.
pub(super) fn moments(a: &Story, b: &Story, all: &mut Vec<Difference>) {
    let partial = a.partial || b.partial;
    let until = [a.told_until_us(), b.told_until_us()];
    let until = until.into_iter().flatten().min().unwrap_or(u64::MAX);
    let (first, second) = (lines(a, partial, until), lines(b, partial, until));
    let none = Vec::new();
    // By kind: what is new, what is gone.
    let mut new: BTreeMap<HappeningKind, Vec<&Happening>> = BTreeMap::new();
    let mut gone = new.clone();
    let keys: BTreeSet<_> = first.keys().chain(second.keys()).collect();
    for key in keys {
        let x = first.get(key).unwrap_or(&none);
        let y = second.get(key).unwrap_or(&none);
        let (kind, text) = *key;
        let word = kind.word();
        match (x.as_slice(), y.as_slice()) {
            (x, y) if x == y => {}
            ([], [one]) => new.entry(kind).or_default().push(one),
            ([one], []) => gone.entry(kind).or_default().push(one),
            ([was], [is]) => {
                let (was, is) = (was.when(), is.when());
                let text = format!("{word} at {was} -> {is} s: {text}");
                all.push(difference(kind, text));
            }
            (x, y) => {
                let text = format!("{word} {} -> {} times: {text}", x.len(), y.len());
                all.push(difference(kind, text));
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
}
