//! A place on the grid of onsets, where several displays share boards and buses.

use crate::units::Instant;

use super::{Output, Projector};

impl Output {
    /// Sets the grid of onsets to begin at `first`, not at t = 0: the offset of one finger among several.
    pub const fn begin_at(&mut self, first: Instant) {
        self.next_onset = first;
    }

    /// Start and end of each planned stroke: spans in which strokes have the display.
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
    /// Sets the grid of onsets to begin at `first`, as [`Output::begin_at`] does.
    pub const fn begin_at(&mut self, first: Instant) {
        self.output.begin_at(first);
    }

    /// Start and end of each planned stroke, as [`Output::strokes`] has them.
    pub fn strokes(&self) -> &[(Instant, Instant)] {
        self.output.strokes()
    }

    /// Leaves these spans to strokes of other displays, as [`Output::leave`] does.
    pub fn leave(&mut self, spans: &[(Instant, Instant)]) {
        self.output.leave(spans);
    }
}
