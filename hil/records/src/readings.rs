//! Readings of every taxel, frame by frame: kept beside the trace, for a report's playback and for MCAP.

use crate::trace::PlaceUm;
use palpate_core::skin::{Layout, Module, RelativeFrame};

/// A module of the skin and where its taxels are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModulePlaces {
    /// Name of the module in the layout.
    pub name: String,
    /// Places of its taxels, in its own plane.
    pub taxels: Vec<PlaceUm>,
}

fn places(module: &Module) -> ModulePlaces {
    ModulePlaces {
        name: module.name().to_owned(),
        taxels: module.points().iter().copied().map(PlaceUm::from).collect(),
    }
}

/// One taxel of one frame, raw counts: x, y, z, and the distance from the reference as compression sees it.
pub type Reading = [u16; 4];

/// All readings of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaxelFrame {
    /// End of the driving module's scan, microseconds.
    pub t_us: u64,
    /// Every taxel that is kept, module by module.
    pub readings: Box<[Reading]>,
}

/// Most readings that a report needs: beyond, every other frame goes.
const REPORTED: usize = 1 << 18;

/// The readings of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Readings {
    modules: Vec<ModulePlaces>,
    /// Index of the driving module among them.
    drives: usize,
    /// Index of the first kept taxel in a frame of the skin.
    first: usize,
    most: usize,
    /// Number of frames of which one is kept.
    every: u64,
    seen: u64,
    frames: Vec<TaxelFrame>,
}

impl Readings {
    /// Readings for every frame of the whole skin, whose module `drives` drives the display.
    pub fn whole(layout: &Layout, drives: usize) -> Self {
        Self {
            modules: layout.modules().iter().map(places).collect(),
            drives,
            most: usize::MAX,
            every: 1,
            ..Self::default()
        }
    }

    /// Readings for a report: the driving module alone, at most 262,144 readings (2 MiB). Where there would be more,
    /// every other frame goes.
    pub fn sampled(layout: &Layout, drives: usize) -> Self {
        Self {
            modules: layout
                .modules()
                .get(drives)
                .map(places)
                .into_iter()
                .collect(),
            first: layout.range(drives).start,
            most: REPORTED,
            every: 1,
            ..Self::default()
        }
    }

    /// The skin's modules.
    pub fn modules(&self) -> &[ModulePlaces] {
        &self.modules
    }

    fn taxels(&self) -> usize {
        self.modules.iter().map(|m| m.taxels.len()).sum()
    }

    /// Takes a frame at its time, microseconds.
    pub fn push(&mut self, t_us: u64, frame: &RelativeFrame) {
        let due = self.seen.is_multiple_of(self.every);
        self.seen += 1;
        if !due {
            return;
        }
        let magnitudes = frame.magnitude().iter();
        // A cast saturates: three axes of 16 bits can come to more.
        let reading = |(&[x, y, z], m): (&[u16; 3], &f32)| [x, y, z, m.round() as u16];
        let counts = frame.counts().iter().zip(magnitudes);
        let own = counts.skip(self.first).take(self.taxels());
        let readings = own.map(reading).collect();
        self.frames.push(TaxelFrame { t_us, readings });
        while self.frames.len().saturating_mul(self.taxels()) > self.most && self.frames.len() > 1 {
            let mut odd = true;
            self.frames.retain(|_| {
                odd = !odd;
                !odd
            });
            self.every *= 2;
        }
    }

    /// The frames since the last time, for a record that grows: nothing of them stays.
    pub fn take_frames(&mut self) -> Vec<TaxelFrame> {
        std::mem::take(&mut self.frames)
    }

    /// Every frame that was kept.
    pub fn frames(&self) -> &[TaxelFrame] {
        &self.frames
    }

    /// The driving module alone: times, microseconds, and its taxels.
    pub fn driving(&self) -> impl ExactSizeIterator<Item = (u64, &[Reading])> {
        let before = self.modules.iter().take(self.drives);
        let from: usize = before.map(|m| m.taxels.len()).sum();
        let own = self.modules.get(self.drives).map_or(0, |m| m.taxels.len());
        self.frames.iter().map(move |f| {
            let own = f.readings.get(from..from + own);
            (f.t_us, own.unwrap_or_default())
        })
    }
}

#[cfg(test)]
#[path = "readings_tests.rs"]
mod tests;
