//! A place on the grid of onsets, where several displays share boards and buses.

use crate::units::Instant;

use super::{Output, Projector};

impl Output {
    /// With a grid of onsets that begins at `first`, not at t = 0: the offset of one finger among several.
    pub const fn begin_at(&mut self, first: Instant) {
        self.next_onset = first;
    }

    /// When strokes that are known beforehand have the display: start and end of each.
    pub fn strokes(&self) -> &[(Instant, Instant)] {
        self.strokes.spans()
    }

    /// Leaves these spans, start and end, to strokes of other displays on its boards: no onset of the grid falls into them.
    /// Allocates, so it belongs before the loop.
    pub fn leave(&mut self, spans: &[(Instant, Instant)]) {
        self.strokes.leave(spans);
    }
}

impl Projector {
    /// As [`Output::begin_at`].
    pub const fn begin_at(&mut self, first: Instant) {
        self.output.begin_at(first);
    }

    /// As [`Output::strokes`].
    pub fn strokes(&self) -> &[(Instant, Instant)] {
        self.output.strokes()
    }

    /// As [`Output::leave`].
    pub fn leave(&mut self, spans: &[(Instant, Instant)]) {
        self.output.leave(spans);
    }
}
