//! Known strokes by the Tactile Brush planner (Israr and Poupyrev 2011): from start to end in a given time.
//!
//! The stroke is felt at points on it: its ends, and wherever it passes from one cell of wires into the
//! next, which on a regular grid are its crossings with the grid's lines. At the point `i` the stimulus is
//! strongest when the stroke is there: onset + d/2 = distance / speed. Onsets follow the law
//! `SOA_i = 0.32 d_i + 47.3 ms`, so that the durations follow one from the other:
//! `d_(i+1) = 2 (passage to the next point) - 94.6 ms + 0.36 d_i`.

use alloc::boxed::Box;
use alloc::vec::Vec;

use crate::units::{Duration, Instant, Point};

use super::cells::Cells;
use super::timing::{LONGEST, duration_tactile_brush};

/// A straight stroke over the display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Start, display mm.
    pub from: Point,
    /// End, display mm.
    pub to: Point,
    /// Time from start to end.
    pub length: Duration,
}

/// One stimulus of a stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dab {
    /// Onset after the stroke's first one.
    pub at: Duration,
    /// Duration of the stimulus.
    pub duration: Duration,
    /// Place, display mm.
    pub place: Point,
    /// Intensity, in [0, 1].
    pub weight: f32,
}

/// A planned stroke: its stimuli from `start` on, the last of them over at `end`.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// First onset.
    pub start: Instant,
    /// End of the last stimulus.
    pub end: Instant,
    /// The stimuli, in order.
    pub dabs: Box<[Dab]>,
}

impl Planned {
    /// Stimuli of `duration` at one place, an onset every `soa`, the last one begun before `length` is over.
    pub fn staying(
        start: Instant,
        place: Point,
        length: Duration,
        (duration, soa): (Duration, Duration),
    ) -> Self {
        let count = length.as_micros().div_ceil(soa.as_micros().max(1));
        let dab = |number: u64| Dab {
            at: Duration::from_micros(number * soa.as_micros()),
            duration,
            place,
            weight: 1.0,
        };
        Self::new(start, (0..count).map(dab).collect())
    }

    /// Returns the stroke with this weight, in [0, 1], for every stimulus.
    #[must_use]
    pub fn weighted(mut self, weight: f32) -> Self {
        self.dabs.iter_mut().for_each(|dab| dab.weight = weight);
        self
    }

    /// Stimuli in order, beginning at `start`.
    pub fn new(start: Instant, dabs: Vec<Dab>) -> Self {
        let end = dabs.iter().map(|d| start + d.at + d.duration).max();
        Self {
            start,
            end: end.unwrap_or(start),
            dabs: dabs.into(),
        }
    }
}

/// Reasons for which there is no plan of a stroke.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StrokeError {
    /// A stroke whose start and end are one place, or no numbers: a contact, not a stroke.
    #[error("a stroke between two different places")]
    NoLength,
    /// A stroke faster than two stimuli can follow one another, with the shortest time that it can take.
    #[error("a stroke of at least {} ms", .0.as_micros().div_ceil(1000))]
    TooFast(Duration),
}

/// Shortest stimulus worth giving: two periods of 200 Hz.
const SHORTEST_US: f32 = 10_000.0;
/// The law's constant term.
const BASE_US: f32 = 47_300.0;
/// The law's factor.
const LAW: f32 = 0.32;
/// A phantom must travel this part of the gap to be felt as moving.
const FELT_STEP: f32 = 0.2;

impl Stroke {
    /// Stimuli of the stroke in order, none longer than `longest` or [`LONGEST`]. `gap`
    /// is the display's smallest distance of two wires. Points nearer to one another
    /// than a felt step, or passed faster than stimuli can follow, are left out.
    ///
    /// # Errors
    /// [`StrokeError`] for a stroke of no length, or one too fast.
    pub fn plan(
        &self,
        cells: &Cells,
        gap: f32,
        longest: Duration,
    ) -> Result<Vec<Dab>, StrokeError> {
        let length = self.from.distance(self.to);
        if !(length.is_finite() && length > 0.0) {
            return Err(StrokeError::NoLength);
        }
        let total = self.length.as_micros() as f32;
        let least = BASE_US + LAW * SHORTEST_US;
        if total < least {
            return Err(StrokeError::TooFast(Duration::from_micros(least as u64)));
        }
        let step = (FELT_STEP * gap / length).max(least / total);
        let mut parts = cells.crossings(self.from, self.to);
        let mut last = 0.0;
        parts.retain(|&p| {
            let apart = p - last >= step && 1.0 - p >= step;
            if apart {
                last = p;
            }
            apart
        });
        parts.insert(0, 0.0);
        parts.push(1.0);
        let passage = |i: usize| (parts[i + 1] - parts[i]) * total;
        let longest = longest.min(LONGEST).as_micros() as f32;
        let limit = |us: f32| us.min(longest).max(SHORTEST_US);
        let first = Duration::from_micros(passage(0) as u64);
        let mut duration = limit(duration_tactile_brush(first).as_micros() as f32);
        let lead = duration / 2.0;
        let mut dabs = Vec::with_capacity(parts.len());
        for (i, &part) in parts.iter().enumerate() {
            if i > 0 {
                duration = limit(2.0 * passage(i - 1) - 2.0 * BASE_US + 0.36 * duration);
            }
            let middle = part * total;
            dabs.push(Dab {
                at: Duration::from_micros((middle + lead - duration / 2.0).max(0.0) as u64),
                duration: Duration::from_micros(duration as u64),
                place: Point::new(
                    self.from.x + part * (self.to.x - self.from.x),
                    self.from.y + part * (self.to.y - self.from.y),
                ),
                weight: 1.0,
            });
        }
        Ok(dabs)
    }
}

#[cfg(test)]
#[path = "stroke_tests.rs"]
mod tests;
