//! Nearness of contacts to the level that they shall have.

use super::RISE;

/// Summary of the onsets with a contact on the display, in parts of full level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// Number of these onsets.
    pub onsets: u64,
    /// Onsets at which heat made a contact weaker than it shall be by more than is just noticeable.
    pub weaker: u64,
    /// The least part of full amplitude that a contact had.
    pub least: f32,
}

impl Default for Reached {
    fn default() -> Self {
        Self {
            onsets: 0,
            weaker: 0,
            least: 1.0,
        }
    }
}

impl Reached {
    /// Adds an onset of which the weakest contact had this part; infinite where no contact was on the display.
    pub(super) const fn add(&mut self, part: f32) {
        if part.is_finite() {
            self.onsets += 1;
            self.weaker += (part * RISE < 1.0) as u64;
            self.least = self.least.min(part);
        }
    }
}
