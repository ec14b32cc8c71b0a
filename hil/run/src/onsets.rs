//! Tallies of onsets: those at which something touched, on the part of the skin that the display shows or beyond it,
//! and those at which the person felt it.

use palpate_core::projector::Projector;
use palpate_core::units::Point;
use palpate_emulators::person::channels::Felt;
use serde::Serialize;

/// Tallies of a run's onsets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Onsets {
    /// Onsets at which something touched the skin that drives the display: by the truth, or where that is not known by the
    /// contacts that were found.
    pub touched: u64,
    /// Onsets at which every touch lay beyond the part of the skin that the display shows.
    pub off_pad: u64,
    /// Onsets that the person should feel: with a contact on the display, a touch on the part of the skin that it shows, or
    /// pulses of a texture that has the display to itself.
    pub meant: u64,
    /// Onsets that the person should feel and at which a touch made no contact.
    pub unfound: u64,
    /// Onsets that were to be felt and were; null where no person is emulated.
    pub felt: Option<u64>,
}

impl Onsets {
    /// Adds an onset that was projected for so many targets, with the touched places, where they are known.
    pub(crate) fn add(&mut self, projector: &Projector, targets: usize, truth: Option<&[Point]>) {
        let (touching, shown) = match truth {
            Some(places) => {
                let shown = places.iter().filter(|place| projector.map().shows(**place));
                (places.len(), shown.count())
            }
            None => projector.found(),
        };
        self.touched += u64::from(touching > 0);
        self.off_pad += u64::from(touching > 0 && shown == 0);
        let missed = targets == 0 && shown > 0 && projector.renders_contacts();
        self.meant += u64::from(targets > 0 || missed);
        self.unfound += u64::from(missed && projector.found().0 == 0);
    }

    /// Adds an onset of a texture that has the display to itself.
    pub(crate) const fn add_texture(&mut self) {
        self.meant += 1;
    }

    /// Adds a person's sensation of an onset that was meant to be felt.
    pub(crate) fn meet(&mut self, met: Option<&Felt>) {
        let is_felt = met.is_some_and(|met| met.levels.felt());
        self.felt = Some(self.felt.unwrap_or(0) + u64::from(is_felt));
    }

    /// Adds the onsets of another display.
    pub(crate) fn join(&mut self, other: &Self) {
        self.touched += other.touched;
        self.off_pad += other.off_pad;
        self.meant += other.meant;
        self.unfound += other.unfound;
        let both = self.felt.zip(other.felt).map(|(own, more)| own + more);
        self.felt = both.or(self.felt).or(other.felt);
    }

    /// Tells whether most contacts at onsets lay beyond the display.
    pub const fn mostly_off(&self) -> bool {
        2 * self.off_pad > self.touched
    }

    /// Tells whether fewer than half of the onsets meant to be felt were felt. `false` without an emulated person.
    pub fn mostly_unfelt(&self) -> bool {
        self.felt.is_some_and(|felt| 2 * felt < self.meant)
    }

    /// Share of onsets that were felt, percent: 100 only where all were. `None` where no onset was meant to be felt, or
    /// no person is emulated.
    pub fn felt_percent(&self) -> Option<u64> {
        (self.felt? * 100).checked_div(self.meant)
    }

    /// The share of touched onsets beyond the pad, percent: 0 only where none was. `None` where nothing touched.
    pub fn off_percent(&self) -> Option<u64> {
        (self.touched > 0).then(|| (100 * self.off_pad).div_ceil(self.touched))
    }
}

#[cfg(test)]
#[path = "onsets_tests.rs"]
mod tests;
