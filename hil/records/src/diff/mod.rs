//! Two runs compared and told in the words of the field: which wire rises later, which limit has less left.
//!
//! A [`Story`] is made from a trace, or read from a golden or a schedule file; [`compare`] lists what differs, the
//! gravest first; [`tell`] says it in ten lines and a count.

mod align;
mod drawn;
mod edges;
mod moments;
mod recording;
mod tables;
mod words;

use serde::Serialize;

use crate::story::{GoldenKind, Story};
use crate::trace::Source;
pub use align::{Alignment, align};
use drawn::drawings;
use moments::moments;
pub use recording::{Contacts, compare_contacts};
use tables::{digests, figures, heads, rows};

/// Lines told one by one.
pub const LINES: usize = 10;

/// Gravity and subject of a difference; the first is told first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grade {
    /// Settings of the run: times, illusion, limits.
    Setting,
    /// Everything off, or a period that changed.
    Stop,
    /// The guard stepped in, or no longer does.
    Limiter,
    /// A limit of which less is left.
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
    /// Differences that nobody could feel or measure.
    Cosmetic,
}

/// One difference.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// The difference in words.
    pub text: String,
    /// `true` where the difference has a meaning, `false` where it is cosmetic.
    pub meaning: bool,
    /// The gravity of the difference.
    #[serde(skip)]
    pub grade: Grade,
    /// Weight within the grade: the largest is told first.
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

/// Tolerance of a comparison: nothing but equality for emulated runs, bands for recordings of hardware.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tolerance {
    /// Edges this far apart are in the same place, microseconds.
    pub edge_us: u64,
    /// Contacts this far apart are in the same place, micrometres.
    pub place_um: u64,
    /// Measured values this far apart, in thousandths of the larger, are the same. Where it is not 0, so are counts that
    /// are one apart.
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

    /// Tells whether two texts say the same: their words are equal, or numbers within the band of the unit behind them.
    fn alike(self, a: &str, b: &str) -> bool {
        if a == b || self.is_none() {
            return a == b;
        }
        let (a, b): (Vec<&str>, Vec<&str>) = (
            a.split_whitespace().collect(),
            b.split_whitespace().collect(),
        );
        let unit = |index: usize| a.get(index + 1).copied().unwrap_or_default();
        let mut pairs = a.iter().zip(&b).enumerate();
        a.len() == b.len() && pairs.all(|(index, (x, y))| x == y || self.near(x, y, unit(index)))
    }

    /// Tells whether two numbers, or the ends of two ranges, lie within the band of their unit.
    fn near(self, x: &str, y: &str, unit: &str) -> bool {
        let ends = |text: &str| -> Option<Vec<f64>> {
            let number = |end: &str| end.parse().ok().filter(|v: &f64| v.is_finite());
            text.split("..").map(number).collect()
        };
        let Some((from, to)) = ends(x).zip(ends(y)) else {
            return false;
        };
        let mut parts = x.split("..").chain(y.split(".."));
        let are_counts = self.permille > 0 && parts.all(|part| !part.contains('.'));
        let least = if are_counts { 1.0 } else { 0.0 };
        let band = |larger: f64| match unit {
            "s" => self.edge_us as f64 * 1e-6,
            "ms" => self.edge_us as f64 * 1e-3,
            "us" => self.edge_us as f64,
            "mm" => self.place_um as f64 * 1e-3,
            _ => (larger * f64::from(self.permille) * 1e-3).max(least),
        };
        // What is printed has three places.
        let near = |(x, y): (&f64, &f64)| (x - y).abs() <= band(x.abs().max(y.abs())) + 1e-6;
        from.len() == to.len() && from.iter().zip(&to).all(near)
    }
}

/// The parts of two lists that can be held against each other where one is cut after `until_us`: what comes before that,
/// and where this is the same, as many as both have. Both are sorted by time.
fn shared<'l, T: PartialEq>(
    a: &'l [T],
    b: &'l [T],
    until_us: Option<u64>,
    time: fn(&T) -> u64,
) -> [&'l [T]; 2] {
    let Some(until_us) = until_us else {
        return [a, b];
    };
    let before = |list: &'l [T]| &list[..list.partition_point(|one| time(one) < until_us)];
    let parts = [before(a), before(b)];
    if parts[0] != parts[1] {
        return parts;
    }
    let most = a.len().min(b.len());
    [&a[..most], &b[..most]]
}

/// Everything that differs, gravest first.
pub fn compare(a: &Story, b: &Story, tolerance: Tolerance) -> Vec<Difference> {
    let mut all = Vec::new();
    if a.scene != b.scene {
        let text = format!("scene {} -> {}", a.scene, b.scene);
        all.push(Difference::new(Grade::Cosmetic, false, 0, text));
    }
    heads(a, b, tolerance, &mut all);
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
    let driven = edges::differing(a, b);
    moments(a, b, tolerance, driven.is_empty(), &mut all);
    rows(a, b, tolerance, &driven, &mut all);
    drawings(a, b, tolerance, &driven, &mut all);
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

#[cfg(test)]
#[path = "told_tests.rs"]
mod tests;
