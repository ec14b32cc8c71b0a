//! Two runs compared and told in the words of the field: which wire rises later, which limit has less left.
//!
//! A [`Story`] is made from a trace, or read from a golden or a schedule file; [`compare`] lists what differs, the
//! gravest first; [`tell`] says it in ten lines and a count.

mod align;
mod edges;
mod moments;
mod recording;
mod tables;
mod words;

use serde::Serialize;

use crate::story::{GoldenKind, Story};
use crate::trace::Source;
pub use align::{Alignment, align};
use moments::moments;
pub use recording::{Contacts, compare_contacts};
use tables::{digests, figures, heads, rows};

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
    /// More is left of a limit.
    Gain,
    /// Nothing that anybody could feel or measure.
    Cosmetic,
}

/// One difference.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// The difference in words.
    pub text: String,
    /// Whether it means anything; else it is cosmetic.
    pub meaning: bool,
    /// The gravity of the difference.
    #[serde(skip)]
    pub grade: Grade,
    /// Its place within the grade: the larger is told first.
    #[serde(skip)]
    pub weight: i64,
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
    if a.kind == GoldenKind::Schedule && b.kind == GoldenKind::Schedule {
        edges::tell(a, b, tolerance, &mut all);
    }
    if all.iter().any(|d| d.grade == Grade::Limiter) {
        // Told with wires and times.
        all.retain(|d| !(d.grade == Grade::Figure && d.text.starts_with("limiter events ")));
    }
    if let Some(us) = edges::known_until(a, b)
        && !all.is_empty()
    {
        let text = format!(
            "bursts compared up to {}: a golden lists no more",
            words::at(us)
        );
        all.push(Difference::new(Grade::Setting, false, -1, text));
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
