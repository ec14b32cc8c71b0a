//! Static intensity levels over a whole input, with bounded memory; and levels that need none.

use palpate_core::contact::{LevelTable, Levels};
use palpate_core::random::RandomStream;
use palpate_files::{Compression, LevelsFrom};

/// Intensities from which the levels are found; of more, this many are drawn, each as likely as the others.
const TELLING: usize = 1 << 16;

/// Levels that are known without the input; `None` for those that are found in it.
pub fn known_levels(compression: &Compression) -> Option<Levels> {
    let needs_input = compression.ki > 1 && compression.levels == LevelsFrom::Static;
    (!needs_input).then(|| dynamic_levels(compression))
}

/// Levels found anew in every frame.
pub fn dynamic_levels(compression: &Compression) -> Levels {
    match compression.ki {
        // Every contact has the one level there is.
        0 | 1 => Levels::Off,
        k => Levels::Dynamic(u16::try_from(k).unwrap_or(u16::MAX)),
    }
}

/// The intensities of an input, raw counts.
#[derive(Debug)]
pub struct Intensities {
    drawn: Vec<f32>,
    count: u64,
    /// The lowest and the highest intensity.
    ends: Option<(f32, f32)>,
    draws: RandomStream,
}

impl Default for Intensities {
    fn default() -> Self {
        Self {
            drawn: Vec::new(),
            count: 0,
            ends: None,
            draws: RandomStream::new(0, "intensities that find levels"),
        }
    }
}

impl Intensities {
    /// Adds an intensity.
    pub fn add(&mut self, intensity: f32) {
        let (least, most) = self.ends.unwrap_or((intensity, intensity));
        self.ends = Some((least.min(intensity), most.max(intensity)));
        self.count += 1;
        if self.drawn.len() < TELLING {
            self.drawn.push(intensity);
            return;
        }
        // Contacts of one frame come in turn: every n-th would be of the same finger.
        let place = (self.draws.uniform() * self.count as f64) as usize;
        if let Some(one) = self.drawn.get_mut(place) {
            *one = intensity;
        }
    }

    /// Table of `k` levels; `None` where nothing was touched.
    #[must_use]
    pub fn table(mut self, k: usize) -> Option<LevelTable> {
        if self.count > TELLING as u64 {
            let (least, most) = self.ends?;
            self.drawn.extend([least, most]);
        }
        LevelTable::from_intensities(&self.drawn, k).ok()
    }

    /// Levels by just noticeable differences, from the weakest intensity up; `None` where nothing was touched.
    #[must_use]
    pub fn noticeable(&self, weber: f32) -> Option<LevelTable> {
        let (least, most) = self.ends?;
        LevelTable::weber(least, most, weber).ok()
    }
}

#[cfg(test)]
#[path = "levels_tests.rs"]
mod tests;
