//! Static intensity levels over a whole input, with bounded memory.

use palpate_core::contact::{LevelTable, Levels};
use palpate_core::random::RandomStream;
use palpate_files::Setup;

/// Levels where the whole input cannot be seen beforehand.
pub(crate) fn live_levels(setup: &Setup) -> Levels {
    match setup.scene.value.compression.ki {
        0 | 1 => Levels::Off,
        k => Levels::Dynamic(u16::try_from(k).unwrap_or(u16::MAX)),
    }
}

/// So many intensities find the levels; of more, so many are drawn, each as likely as the others.
const TELLING: usize = 1 << 16;

/// The intensities of an input, raw counts.
#[derive(Debug)]
pub struct Intensities {
    drawn: Vec<f32>,
    count: u64,
    /// The lowest and the highest.
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
    /// Adds one.
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

    /// The table of `k` levels; none where nothing was touched.
    #[must_use]
    pub fn table(mut self, k: usize) -> Option<LevelTable> {
        if self.count > TELLING as u64 {
            let (least, most) = self.ends?;
            self.drawn.extend([least, most]);
        }
        LevelTable::from_intensities(&self.drawn, k).ok()
    }
}

#[cfg(test)]
#[path = "levels_tests.rs"]
mod tests;
