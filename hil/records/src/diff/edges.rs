//! Differences of bursts, in words: bursts that are new, gone, earlier, later, longer, wider, limited.

use std::collections::{BTreeMap, BTreeSet};

use super::align::align;
use super::words::{at, count, list, ms, signed};
use super::{Difference, Grade, Tolerance, shared};
use crate::bursts::{Burst, DrivenOutput};
use crate::story::Story;
use palpate_core::schedule::Reason;

/// Most wires told one by one for one thing.
const EACH: usize = 3;

/// Edges of a burst that moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Move {
    Rise,
    Fall,
    Whole,
}

impl Move {
    const fn verb(self, many: bool) -> &'static str {
        match (self, many) {
            (Self::Rise, false) => "rises",
            (Self::Rise, true) => "rise",
            (Self::Fall, false) => "falls",
            (Self::Fall, true) => "fall",
            (Self::Whole, false) => "comes",
            (Self::Whole, true) => "come",
        }
    }

    fn words(self, many: bool, by: i64) -> String {
        format!("{} {}", self.verb(many), lateness(by))
    }
}

/// `5 ms later`.
fn lateness(by: i64) -> String {
    let later = if by < 0 { "earlier" } else { "later" };
    format!("{} {later}", ms(by.unsigned_abs()))
}

/// Findings of one kind: their number on each output, and the time of the first.
#[derive(Default)]
struct Tally(BTreeMap<DrivenOutput, (usize, u64)>);

impl Tally {
    fn add(&mut self, output: DrivenOutput, t_us: u64) {
        let entry = self.0.entry(output).or_insert((0, t_us));
        entry.0 += 1;
        entry.1 = entry.1.min(t_us);
    }

    fn total(&self) -> usize {
        self.0.values().map(|v| v.0).sum()
    }

    fn first_us(&self) -> u64 {
        self.0.values().map(|v| v.1).min().unwrap_or(0)
    }

    /// `wire 3`, `wire 1 and wire 2`, `8 wires`.
    fn who(&self) -> String {
        if self.0.len() > EACH {
            return format!("{} wires", self.0.len());
        }
        let names: Vec<String> = self.0.keys().map(ToString::to_string).collect();
        list(&names)
    }

    /// `at 1.2 s`, or `12 times from 1.2 s on`.
    fn when(&self) -> String {
        match self.total() {
            1 => format!("at {}", at(self.first_us())),
            n => format!("{n} times from {} on", at(self.first_us())),
        }
    }
}

/// Widths that are others: where, and by how many ticks at least and at most.
#[derive(Default)]
struct Change {
    tally: Tally,
    by: Option<(i64, i64)>,
}

impl Change {
    fn add(&mut self, burst: &Burst, (was, is): (u16, u16)) {
        if was == is {
            return;
        }
        let by = i64::from(is) - i64::from(was);
        let (low, high) = self.by.unwrap_or((by, by));
        self.by = Some((low.min(by), high.max(by)));
        self.tally.add(burst.output, burst.from_us);
    }
}

/// Everything found between two sets of bursts.
#[derive(Default)]
struct Found {
    paired: usize,
    new: Tally,
    gone: Tally,
    moves: BTreeMap<(Move, i64), Tally>,
    within: usize,
    wider: Change,
    asked: Change,
    limited: BTreeMap<Reason, Tally>,
    freed: BTreeMap<Reason, Tally>,
}

fn difference(later: u64, earlier: u64) -> i64 {
    let size = i64::try_from(later.abs_diff(earlier)).unwrap_or(i64::MAX);
    if later >= earlier { size } else { -size }
}

/// The bursts of each output.
type Trains = BTreeMap<DrivenOutput, Vec<Burst>>;

/// The bursts that both list, by output.
fn trains(a: &Story, b: &Story) -> [Trains; 2] {
    let lists = shared(&a.bursts, &b.bursts, known_until(a, b), |b| b.from_us);
    lists.map(|list| {
        let mut found = Trains::new();
        for burst in list {
            found.entry(burst.output).or_default().push(*burst);
        }
        found
    })
}

/// The outputs whose bursts differ, as far as both list them.
pub(super) fn differing(a: &Story, b: &Story) -> BTreeSet<DrivenOutput> {
    let [first, second] = trains(a, b);
    let outputs = first.keys().chain(second.keys());
    let differ = outputs.filter(|output| first.get(*output) != second.get(*output));
    differ.copied().collect()
}

/// Time until which both list their bursts; `None` where both list all.
pub(super) fn known_until(a: &Story, b: &Story) -> Option<u64> {
    let ends = [a.listed_until_us(), b.listed_until_us()];
    ends.into_iter().flatten().min()
}

/// The delay of the whole of `b` behind `a`: that of their first bursts, if with it more bursts agree than
/// without, and more than half of them.
fn delay(a: &Trains, b: &Trains) -> i64 {
    let first = |s: &Trains| s.values().flatten().map(|s| s.from_us).min();
    let (Some(from), Some(to)) = (first(a), first(b)) else {
        return 0;
    };
    let by = difference(to, from);
    let starts: BTreeSet<(DrivenOutput, u64)> = b
        .iter()
        .flat_map(|(output, stays)| stays.iter().map(|s| (*output, s.from_us)))
        .collect();
    let agree = |by: i64| {
        let all = a
            .iter()
            .flat_map(|(o, stays)| stays.iter().map(|s| (*o, s.from_us)));
        all.filter(|(o, t)| {
            t.checked_add_signed(by)
                .is_some_and(|t| starts.contains(&(*o, t)))
        })
        .count()
    };
    let total: usize = a.values().map(Vec::len).sum();
    let with = agree(by);
    if by != 0 && with > agree(0) && with * 2 > total {
        by
    } else {
        0
    }
}

/// Tells the differences between the bursts of two stories.
pub(super) fn tell(a: &Story, b: &Story, tolerance: Tolerance, out: &mut Vec<Difference>) {
    let soa_us = a.timing.soa_us.max(1);
    let [mut first, second] = trains(a, b);
    let by = delay(&first, &second);
    if by != 0 {
        for stay in first.values_mut().flatten() {
            stay.from_us = stay.from_us.saturating_add_signed(by);
            stay.to_us = stay.to_us.saturating_add_signed(by);
        }
        let words = Move::Whole.words(false, by);
        let all = by.unsigned_abs() > tolerance.edge_us;
        out.push(Difference::new(
            Grade::Edge,
            all,
            i64::MAX,
            format!("everything {words}"),
        ));
    }
    let outputs: BTreeSet<DrivenOutput> = first.keys().chain(second.keys()).copied().collect();
    let mut found = Found::default();
    for output in outputs {
        let none = Vec::new();
        let x = first.get(&output).unwrap_or(&none);
        let y = second.get(&output).unwrap_or(&none);
        compare(output, x, y, soa_us, tolerance, &mut found);
    }
    words(&found, a.timing.tick_ns, tolerance, out);
}

fn compare(
    output: DrivenOutput,
    a: &[Burst],
    b: &[Burst],
    soa_us: u64,
    tolerance: Tolerance,
    found: &mut Found,
) {
    // A burst that moved to the next onset is another one.
    let alignment = align(a, b, soa_us - soa_us / 4);
    let mut limit = |burst: &Burst, new: bool| {
        if let Some(reason) = burst.reason {
            let side = if new {
                &mut found.limited
            } else {
                &mut found.freed
            };
            side.entry(reason).or_default().add(output, burst.from_us);
        }
    };
    for (i, j) in &alignment.pairs {
        let (x, y) = (&a[*i], &b[*j]);
        if x.reason != y.reason {
            limit(x, false);
            limit(y, true);
        }
    }
    for i in &alignment.gone {
        limit(&a[*i], false);
        found.gone.add(output, a[*i].from_us);
    }
    for j in &alignment.new {
        limit(&b[*j], true);
        found.new.add(output, b[*j].from_us);
    }
    for (i, j) in alignment.pairs {
        let (x, y) = (&a[i], &b[j]);
        found.paired += 1;
        let rise = difference(y.from_us, x.from_us);
        let fall = difference(y.to_us, x.to_us);
        let edges = match (rise, fall) {
            (r, f) if r == f => [Some((Move::Whole, r)), None],
            (r, f) => [Some((Move::Rise, r)), Some((Move::Fall, f))],
        };
        for (kind, by) in edges.into_iter().flatten().filter(|(_, by)| *by != 0) {
            if by.unsigned_abs() <= tolerance.edge_us {
                found.within += 1;
            } else {
                found
                    .moves
                    .entry((kind, by))
                    .or_default()
                    .add(output, x.from_us);
            }
        }
        // What the limiter changed is told by the limiter's event.
        if x.reason == y.reason {
            found.wider.add(x, (x.width, y.width));
            // Of a burst that is as wide as was asked for, the width says both.
            if (x.requested, y.requested) != (x.width, y.width) {
                found.asked.add(x, (x.requested, y.requested));
            }
        }
    }
}

fn words(found: &Found, tick_ns: u64, tolerance: Tolerance, out: &mut Vec<Difference>) {
    if found.within > 0 {
        let edges = count(found.within, "edge");
        let by = ms(tolerance.edge_us);
        let text = format!("{edges} elsewhere by no more than {by}");
        out.push(Difference::new(Grade::Cosmetic, false, 0, text));
    }
    for (is_new, side) in [(true, &found.limited), (false, &found.freed)] {
        for (reason, tally) in side {
            let what = new_or_gone(is_new, tally.total(), "limiter event");
            let what = format!("{what} ({})", reason.word());
            out.push(told(Grade::Limiter, tally, &what));
        }
    }
    for (is_new, tally) in [(true, &found.new), (false, &found.gone)] {
        if tally.total() > 0 {
            let what = new_or_gone(is_new, tally.total(), "burst");
            out.push(told(Grade::Burst, tally, &what));
        }
    }
    for kind in [Move::Rise, Move::Fall, Move::Whole] {
        moved(found, kind, out);
    }
    for (what, change) in [("pulses of", &found.wider), ("requests for", &found.asked)] {
        out.extend(ticks(what, change, tick_ns));
    }
}

/// `1 new burst`, `2 bursts gone`.
fn new_or_gone(is_new: bool, n: usize, what: &str) -> String {
    if is_new {
        count(n, &format!("new {what}"))
    } else {
        format!("{} gone", count(n, what))
    }
}

fn weighed(grade: Grade, tally: &Tally, text: String) -> Difference {
    let weight = i64::try_from(tally.total()).unwrap_or(i64::MAX);
    Difference::new(grade, true, weight, text)
}

/// Words for a finding: its kind, its outputs, and its first time.
fn told(grade: Grade, tally: &Tally, what: &str) -> Difference {
    let from = if tally.total() == 1 { "at" } else { "from" };
    let (who, first) = (tally.who(), at(tally.first_us()));
    weighed(grade, tally, format!("{what}: {who}, {from} {first}"))
}

/// Edges that moved in one way; many different distances are told as a range.
fn moved(found: &Found, kind: Move, out: &mut Vec<Difference>) {
    let of_kind: Vec<(i64, &Tally)> = found
        .moves
        .iter()
        .filter(|((k, _), _)| *k == kind)
        .map(|((_, by), tally)| (*by, tally))
        .collect();
    if of_kind.len() <= EACH {
        for (by, tally) in of_kind {
            let n = tally.total();
            let text = if n == found.paired && n > 1 {
                let words = kind.words(false, by);
                format!("every burst {words}: {n} on {}", tally.who())
            } else {
                let words = kind.words(tally.0.len() > 1, by);
                format!("{} {words}, {}", tally.who(), tally.when())
            };
            out.push(weighed(Grade::Edge, tally, text));
        }
        return;
    }
    let mut all = Tally::default();
    for (_, tally) in &of_kind {
        for (output, (n, t_us)) in &tally.0 {
            let entry = all.0.entry(*output).or_insert((0, *t_us));
            *entry = (entry.0 + n, entry.1.min(*t_us));
        }
    }
    let by = |f: fn(i64, i64) -> i64| of_kind.iter().map(|(by, _)| *by).reduce(f);
    let (low, high) = (by(i64::min).unwrap_or(0), by(i64::max).unwrap_or(0));
    let verb = kind.verb(all.0.len() > 1);
    let range = format!("{} to {}", lateness(low), lateness(high));
    let text = format!("{} {verb} {range}, {}", all.who(), all.when());
    out.push(weighed(Grade::Edge, &all, text));
}

/// Widths that are others, if any are; a tick takes `tick_ns`.
fn ticks(what: &str, change: &Change, tick_ns: u64) -> Option<Difference> {
    let (low, high) = change.by?;
    let tick_ns = i64::try_from(tick_ns).unwrap_or(0);
    let us = |ticks: i64| signed(ticks.saturating_mul(tick_ns));
    let by = if low == high {
        format!("by {low:+} ticks ({} us)", us(low))
    } else {
        let (from, to) = (us(low), us(high));
        format!("by {low:+} to {high:+} ticks ({from} to {to} us)")
    };
    let (who, when) = (change.tally.who(), change.tally.when());
    let text = format!("{what} {who} change {by}, {when}");
    Some(weighed(Grade::Width, &change.tally, text))
}
