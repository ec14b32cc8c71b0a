//! Static intensity levels over a whole input, with bounded memory; and levels that need none.

use palpate_core::contact::{Contact, LevelTable, Levels, VectorTable};
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

/// An intensity and its parts along x, y and z, raw counts.
type Intensity = (f32, [f32; 3]);

/// The intensities of an input.
#[derive(Debug)]
pub struct Intensities {
    drawn: Vec<Intensity>,
    count: u64,
    /// The lowest and the highest intensity.
    ends: Option<(Intensity, Intensity)>,
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
    /// Adds the intensity of a contact.
    pub fn add(&mut self, contact: &Contact) {
        let intensity = (contact.intensity, contact.vector);
        let (least, most) = self.ends.unwrap_or((intensity, intensity));
        self.ends = Some((
            if intensity.0 < least.0 {
                intensity
            } else {
                least
            },
            if intensity.0 > most.0 {
                intensity
            } else {
                most
            },
        ));
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

    /// Table of `k` levels, of vectors if so wanted; off where nothing was touched.
    #[must_use]
    pub fn levels(mut self, k: usize, vectors: bool) -> Levels {
        if let Some((least, most)) = self.ends.filter(|_| self.count > TELLING as u64) {
            self.drawn.extend([least, most]);
        }
        let table = match vectors {
            true => {
                let all: Vec<_> = self.drawn.iter().map(|(_, vector)| *vector).collect();
                VectorTable::from_intensities(&all, k).map(Levels::Vectors)
            }
            false => {
                let all: Vec<_> = self.drawn.iter().map(|(norm, _)| *norm).collect();
                LevelTable::from_intensities(&all, k).map(Levels::Table)
            }
        };
        table.unwrap_or(Levels::Off)
    }

    /// Levels by just noticeable differences, from the weakest intensity up; off where nothing was touched.
    #[must_use]
    pub fn noticeable(&self, weber: f32) -> Levels {
        let table = self
            .ends
            .and_then(|(least, most)| LevelTable::weber(least.0, most.0, weber).ok());
        table.map_or(Levels::Off, Levels::Table)
    }
}

#[cfg(test)]
#[path = "levels_tests.rs"]
mod tests;
