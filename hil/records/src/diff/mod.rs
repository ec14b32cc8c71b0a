//! Two runs compared and told in the words of the field: which wire rises later, which limit has less left.
//!
//! A [`Story`] is read from a golden, a schedule file or a trace; [`compare`] lists what differs, the gravest
//! first; [`tell`] says it in ten lines and a count.

mod align;
mod edges;
mod golden;
mod recording;
mod schedule;
mod sections;
mod story;
mod tables;
mod words;

use crate::trace::Source;
pub use align::{Alignment, align};
use golden::thousandths;
pub use recording::{Recording, compare_recordings};
pub use story::{Damage, Figure, Item, Kind, Moment, Output, Stay, Story};
use tables::{digests, figures, heads, moments, rows};

/// Lines told one by one.
pub const LINES: usize = 10;

/// How grave a difference is, and what it is about; the first is told first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grade {
    /// What was asked for: times, illusion, limits.
    Setting,
    /// Everything off, or a period that changed.
    Stop,
    /// The guard stepped in, or no longer does.
    Limiter,
    /// Less is left of a limit.
    Margin,
    /// Bursts that are new or gone.
    Burst,
    /// Edges that moved.
    Edge,
    /// Pulses that are wider or narrower.
    Width,
    /// A measured value.
    Figure,
    /// A line of the story: a break, a note.
    Moment,
    /// Nothing that anybody could feel or measure.
    Cosmetic,
}

/// One difference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// How grave.
    pub grade: Grade,
    /// Whether it means anything; else it is cosmetic.
    pub meaning: bool,
    /// Among its grade: the larger is told first.
    pub weight: i64,
    /// In words.
    pub text: String,
}

impl Difference {
    fn new(grade: Grade, meaning: bool, weight: i64, text: String) -> Self {
        Self {
            grade,
            meaning,
            weight,
            text,
        }
    }
}

/// What counts as the same: nothing but equality for emulated runs, bands for recordings of hardware.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tolerance {
    /// Edges this far apart are in the same place, microseconds.
    pub edge_us: u64,
    /// Contacts this far apart are in the same place, micrometres.
    pub place_um: u64,
    /// Measured values this far apart, in thousandths of the larger, are the same.
    pub permille: u16,
}

impl Tolerance {
    /// The bands for hardware: two turns of the loop, half a millimetre, 5 %.
    pub const HARDWARE: Self = Self {
        edge_us: 2_000,
        place_um: 500,
        permille: 50,
    };

    /// The bands for two sources: [`Self::HARDWARE`] where one of them is real.
    pub fn between(a: &Story, b: &Story) -> Self {
        if [a.source, b.source].contains(&Source::Real) {
            Self::HARDWARE
        } else {
            Self::default()
        }
    }

    fn is_none(self) -> bool {
        self == Self::default()
    }
}

/// Everything that differs, gravest first.
pub fn compare(a: &Story, b: &Story, tolerance: Tolerance) -> Vec<Difference> {
    let mut all = Vec::new();
    if a.scene != b.scene {
        let text = format!("scene {} -> {}", a.scene, b.scene);
        all.push(Difference::new(Grade::Cosmetic, false, 0, text));
    }
    heads(a, b, &mut all);
    figures(a, b, tolerance, &mut all);
    let number = |key: &str, unit: &str| {
        let item = a.head.iter().find(|i| i.key == key)?;
        let rest = item.text.strip_prefix(key)?.trim_start();
        let text = rest.split(' ').next().filter(|_| rest.contains(unit))?;
        u64::try_from(thousandths(text)?).ok()
    };
    let soa_us = number("SOA", "ms").unwrap_or(58_500).max(1);
    // The header has whole nanoseconds.
    let tick_ns = number("tick", "ns").map_or(1_240, |t| t / 1000);
    if a.kind == Kind::Schedule && b.kind == Kind::Schedule {
        edges::tell(a, b, soa_us, tick_ns, tolerance, &mut all);
    }
    if all.iter().any(|d| d.grade == Grade::Limiter) {
        // Told with wires and times.
        all.retain(|d| !(d.grade == Grade::Figure && d.text.starts_with("limiter events ")));
    }
    moments(a, b, &mut all);
    rows(a, b, tolerance, &mut all);
    digests(a, b, tolerance, &mut all);
    all.sort_by(|x, y| x.grade.cmp(&y.grade).then(y.weight.cmp(&x.weight)));
    all
}

/// The differences as lines, ten and a count of the rest.
pub fn tell(differences: &[Difference]) -> Vec<String> {
    let mut lines: Vec<String> = differences
        .iter()
        .take(LINES)
        .map(|d| d.text.clone())
        .collect();
    if differences.len() > LINES {
        lines.push(format!(".. and {} more", differences.len() - LINES));
    }
    lines
}
