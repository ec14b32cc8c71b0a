//! A person's perception of vibrating contactors, by the channels of [`channels`](super::channels): a sine whose
//! amplitude changes slowly beside its period goes through each filter with the gain of its frequency.
//!
//! The Pacinian channel adds up energy with its leak, q' = (P^2 - q) / 0.2 s with P the filtered amplitude of all contactors
//! together. Of NP I and NP II the strongest contactor counts.

use palpate_core::physics::ParameterError;

use super::channels::{Felt, LEAK_S, Levels, Person, SILENCE_DB, gains};

/// Account of one contactor since the onset.
#[derive(Clone, Copy, Debug, Default)]
struct Met {
    /// Integral of the squared Pacinian output, um2 s.
    energy: f64,
    /// Largest filtered amplitude of the Pacinian channel and of NP I, um.
    peak: [f64; 2],
    /// Largest amplitude of the contactor, um.
    um: f64,
}

/// Motion of one contactor over a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shake {
    /// Amplitude, um.
    pub um: f64,
    /// Frequency, Hz.
    pub hz: f64,
    /// `true` while the driver drives it.
    pub driven: bool,
}

/// A person with contactors on a finger.
#[derive(Clone, Debug)]
pub struct Feeler {
    person: Person,
    places: Vec<(f64, f64)>,
    met: Vec<Met>,
    /// Leaky energy, um2, and the largest since the onset.
    energy: f64,
    most: f64,
    /// Time since the onset; first and last time at which a contactor was driven, s.
    since_s: f64,
    driven: Option<(f64, f64)>,
}

impl Feeler {
    /// A person with contactors at these places, mm, all at rest. `person.vibration_um` holds for one contactor.
    ///
    /// # Errors
    /// A threshold that is not above 0, by name.
    pub fn new(person: Person, places: &[(f64, f64)]) -> Result<Self, ParameterError> {
        person.check_thresholds()?;
        Ok(Self {
            person,
            places: places.to_vec(),
            met: vec![Met::default(); places.len()],
            energy: 0.0,
            most: 0.0,
            since_s: 0.0,
            driven: None,
        })
    }

    /// Lets a step pass in which the contactors move so, in the order of their places.
    pub fn pass(&mut self, shakes: &[Shake], seconds: f64) {
        let kept = libm::exp(-seconds / LEAK_S);
        let mut inflow = 0.0;
        for (met, shake) in self.met.iter_mut().zip(shakes) {
            if shake.um <= 0.0 {
                continue;
            }
            let outputs = gains(shake.hz).map(|gain| gain * shake.um);
            let square = outputs[0] * outputs[0];
            inflow += square;
            met.energy += square / 2.0 * seconds;
            met.um = met.um.max(shake.um);
            for (peak, output) in met.peak.iter_mut().zip(outputs) {
                *peak = peak.max(output);
            }
        }
        self.energy = self.energy * kept + inflow * (1.0 - kept);
        self.most = self.most.max(self.energy);
        let (from, to) = (self.since_s, self.since_s + seconds);
        if shakes.iter().any(|shake| shake.driven) {
            let first = self.driven.map_or(from, |(first, _)| first);
            self.driven = Some((first, to));
        }
        self.since_s = to;
    }

    /// Takes the stimulus since the last onset, felt or not, and begins the next one; the leaky energy goes on. `None` where
    /// nothing moved.
    pub fn onset(&mut self) -> Option<Felt> {
        let centre = |weight: fn(&Met) -> f64| {
            let each = self.met.iter().zip(&self.places);
            let sums = each.fold((0.0, 0.0, 0.0), |(sum, x, y), (met, place)| {
                let w = weight(met);
                (sum + w, x + w * place.0, y + w * place.1)
            });
            (sums.0 > 0.0).then(|| (sums.1 / sums.0, sums.2 / sums.0))
        };
        let most = |of: fn(&Met) -> f64| self.met.iter().map(of).fold(0.0, f64::max);
        let decibels = |amplitude: f64| (20.0 * libm::log10(amplitude)).max(SILENCE_DB);
        let places = centre(|met| met.energy).zip(centre(|met| met.peak[0]));
        let person = &self.person;
        let np2 = |um: f64| decibels(most(|met| met.peak[0]) / um);
        let felt = places.map(|(energy_mm, amplitude_mm)| Felt {
            levels: Levels {
                vibration_db: decibels(libm::sqrt(self.most) / person.vibration_um),
                flutter_db: decibels(most(|met| met.peak[1]) / person.flutter_um),
                np2_db: person.np2_um.map_or(SILENCE_DB, np2),
            },
            energy_mm,
            amplitude_mm,
            energy: self.met.iter().map(|met| met.energy).sum(),
            skin_um: 2.0 * most(|met| met.um),
            seconds: self.driven.map_or(0.0, |(first, last)| last - first),
        });
        self.met.fill(Met::default());
        self.most = self.energy;
        (self.since_s, self.driven) = (0.0, None);
        felt
    }
}

#[cfg(test)]
#[path = "vibration_tests.rs"]
mod tests;
