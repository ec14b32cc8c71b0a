//! Input of the network, from recordings: split by recording, scaled by feature, cut into windows less their first
//! sample.

use burn::prelude::*;
use palpate_core::random::RandomStream;
use serde::{Deserialize, Serialize};

use crate::recordings::{Recording, Recordings};

/// Recordings by purpose, as indices. No recording is in two parts.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Split {
    pub train: Vec<usize>,
    pub test: Vec<usize>,
    pub validation: Vec<usize>,
    /// Recordings of labels that are kept from training altogether.
    pub unseen: Vec<usize>,
}

impl Split {
    /// Draws recordings label by label, so that every part has its share (in per cent) of every label. Labels for
    /// which `seen` is false are left out of all three.
    pub fn new(
        recordings: &Recordings,
        seen: impl Fn(&str) -> bool,
        shares: [u32; 3],
        seed: u64,
    ) -> Self {
        let mut split = Self::default();
        for label in recordings.labels() {
            let mut of_label: Vec<usize> = (0..recordings.all.len())
                .filter(|&r| recordings.all[r].label == label)
                .collect();
            if !seen(&label) {
                split.unseen.append(&mut of_label);
                continue;
            }
            shuffle(
                &mut of_label,
                &mut RandomStream::new(seed, &format!("split of {label}")),
            );
            let whole = shares.iter().sum::<u32>().max(1) as usize;
            let count = |share: u32| (of_label.len() * share as usize + whole / 2) / whole;
            let (test, validation) = (
                count(shares[1]),
                count(shares[2]).max(usize::from(shares[2] > 0)),
            );
            let rest = of_label.split_off((test + validation).min(of_label.len()));
            split
                .validation
                .extend(of_label.split_off(test.min(of_label.len())));
            split.test.append(&mut of_label);
            split.train.extend(rest);
        }
        for part in [&mut split.train, &mut split.test, &mut split.validation] {
            part.sort_unstable();
        }
        split
    }

    /// Draws whole labels, each with the chance of its share: a model of materials is tested on others.
    pub fn by_label(
        recordings: &Recordings,
        seen: impl Fn(&str) -> bool,
        shares: [u32; 3],
        seed: u64,
    ) -> Self {
        let mut split = Self::default();
        let whole = f64::from(shares.iter().sum::<u32>().max(1));
        let [_, test, validation] = shares.map(|share| f64::from(share) / whole);
        for (r, recording) in recordings.all.iter().enumerate() {
            let label = &recording.label;
            let draw = RandomStream::new(seed, &format!("part of {label}")).uniform();
            let part = match draw {
                _ if !seen(label) => &mut split.unseen,
                d if d < test => &mut split.test,
                d if d < test + validation => &mut split.validation,
                _ => &mut split.train,
            };
            part.push(r);
        }
        split
    }
}

/// Shuffles items from a seeded stream (Fisher and Yates).
pub fn shuffle<T>(items: &mut [T], stream: &mut RandomStream) {
    for last in (1..items.len()).rev() {
        let other = (stream.uniform() * (last + 1) as f64) as usize;
        items.swap(last, other.min(last));
    }
}

/// Smallest and largest reading of every feature over some recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    pub min: Vec<f32>,
    pub max: Vec<f32>,
}

impl Scale {
    /// Scale of these recordings. A feature that never changes gets a span of one count: it is zero wherever it stays
    /// so.
    pub fn new(recordings: &Recordings, part: &[usize]) -> Self {
        let features = recordings.columns.len();
        let (mut min, mut max) = (
            vec![f32::INFINITY; features],
            vec![f32::NEG_INFINITY; features],
        );
        for row in part
            .iter()
            .flat_map(|&r| recordings.all[r].values.chunks_exact(features))
        {
            for (feature, &value) in row.iter().enumerate() {
                min[feature] = min[feature].min(value);
                max[feature] = max[feature].max(value);
            }
        }
        for (min, max) in min.iter().zip(&mut max) {
            if *max <= *min {
                *max = *min + 1.0;
            }
        }
        Self { min, max }
    }
}

/// A window: its recording and its first row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    pub recording: usize,
    pub row: usize,
}

/// Recordings, their scale, and the length of a window.
pub struct Windows {
    pub recordings: Recordings,
    pub scale: Scale,
    pub length: usize,
}

impl Windows {
    /// The windows of these recordings, `hop` rows apart; a recording shorter than a window has none.
    pub fn places(&self, part: &[usize], hop: usize) -> Vec<Place> {
        let of = |&recording: &usize| {
            let rows = self.recordings.rows(&self.recordings.all[recording]);
            let count = (rows + 1).saturating_sub(self.length);
            (0..count)
                .step_by(hop.max(1))
                .map(move |row| Place { recording, row })
        };
        part.iter().flat_map(of).collect()
    }

    /// A window's rows as they were recorded.
    pub fn raw(&self, place: Place) -> &[f32] {
        let features = self.recordings.columns.len();
        &self.recordings.all[place.recording].values[place.row * features..]
            [..self.length * features]
    }

    /// Row of a window as the network sees it: each reading less the first row's, in shares of its feature's range.
    pub fn scaled(&self, place: Place, step: usize) -> impl Iterator<Item = f32> {
        let (raw, scale) = (self.raw(place), &self.scale);
        let features = scale.min.len();
        let now = &raw[step * features..][..features];
        let spans = scale.max.iter().zip(&scale.min).map(|(max, min)| max - min);
        let changes = now.iter().zip(raw).map(|(now, first)| now - first);
        changes.zip(spans).map(|(change, span)| change / span)
    }

    /// Windows as the network sees them, time-major: `[length, places, features]`.
    pub fn batch<B: Backend>(&self, places: &[Place], device: &B::Device) -> Tensor<B, 3> {
        let features = self.recordings.columns.len();
        let mut values = Vec::with_capacity(self.length * places.len() * features);
        for step in 0..self.length {
            for &place in places {
                values.extend(self.scaled(place, step));
            }
        }
        let shape = [self.length, places.len(), features];
        Tensor::from_data(TensorData::new(values, shape), device)
    }

    /// The recording a window was cut from.
    pub fn recording(&self, place: Place) -> &Recording {
        &self.recordings.all[place.recording]
    }
}

#[cfg(test)]
#[path = "windows_tests.rs"]
mod tests;
