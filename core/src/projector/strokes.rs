//! Planned strokes in the loop: while one runs, its stimuli take the place of the live contacts.

use alloc::boxed::Box;
use alloc::vec::Vec;

use crate::illusion::{Dab, Planned};
use crate::units::Instant;

/// The strokes of a run and how far they are.
#[derive(Debug, Default)]
pub(super) struct Strokes {
    dabs: Box<[(Instant, Dab)]>,
    /// Start and end of each stroke.
    spans: Box<[(Instant, Instant)]>,
    /// Spans that belong to strokes of other displays on its boards.
    left: Box<[(Instant, Instant)]>,
    next: usize,
}

impl Strokes {
    pub(super) fn new(strokes: &[Planned]) -> Self {
        let of = |s: &Planned| -> Vec<(Instant, Dab)> {
            s.dabs.iter().map(|d| (s.start + d.at, *d)).collect()
        };
        let mut dabs: Vec<(Instant, Dab)> = strokes.iter().flat_map(of).collect();
        dabs.sort_by_key(|(at, _)| *at);
        Self {
            dabs: dabs.into(),
            spans: strokes.iter().map(|s| (s.start, s.end)).collect(),
            left: Box::default(),
            next: 0,
        }
    }

    /// Start of the next stimulus.
    pub(super) fn next(&self) -> Instant {
        self.dabs
            .get(self.next)
            .map_or(Instant::FAR_FUTURE, |(at, _)| *at)
    }

    /// The newest stimulus that is due; older ones that were missed are left out.
    pub(super) fn due(&mut self, now: Instant) -> Option<(Instant, Dab)> {
        let mut newest = None;
        while let Some(dab) = self.dabs.get(self.next).filter(|(at, _)| *at <= now) {
            newest = Some(*dab);
            self.next += 1;
        }
        newest
    }

    /// Start and end of each stroke.
    pub(super) fn spans(&self) -> &[(Instant, Instant)] {
        &self.spans
    }

    /// Leaves these spans to others.
    pub(super) fn leave(&mut self, spans: &[(Instant, Instant)]) {
        self.left = spans.into();
    }

    /// Tells whether a stroke has the display, or a board of it, at that time.
    pub(super) fn hold(&self, at: Instant) -> bool {
        let mut all = self.spans.iter().chain(&self.left);
        all.any(|(start, end)| *start <= at && at < *end)
    }
}

#[cfg(test)]
#[path = "strokes_tests.rs"]
mod tests;
