//! Aims of the latent vectors of windows, by the facts about their labels.

use std::collections::BTreeMap;

use burn::prelude::*;

use crate::network::last;
use crate::recordings::{LabelFacts, Material, Rating};
use crate::settings::Settings;
use crate::windows::{Place, Windows};

/// Latent coordinate of the ends of a property's range, plus and minus: inside the range of a GRU.
const REACH: f32 = 0.75;

/// The first coordinates of each label's latent vectors.
pub struct Aims {
    of_label: BTreeMap<String, Vec<f32>>,
    /// Weight of their mean squared miss in the loss.
    weight: f64,
}

impl Aims {
    /// Aims of the settings: with `--heads` roughness, friction and hardness by materials, with `--codes` a corner for
    /// each of the labels, with `--align` two by ratings; else `None`.
    pub fn new(known: &LabelFacts, labels: &[String], settings: &Settings) -> Option<Self> {
        let (weight, of_label) = if settings.heads > 0.0 {
            (settings.heads, by_materials(&known.materials))
        } else if settings.codes > 0.0 {
            (settings.codes, by_codes(labels, settings.latent))
        } else if settings.align > 0.0 {
            (settings.align, by_ratings(&known.ratings))
        } else {
            return None;
        };
        Some(Self { of_label, weight })
    }

    /// Half of the miss at the end of windows, half that of the states [steps, batch, latent] in their later half:
    /// properties that are to be known early have fewer steps to go through.
    pub fn miss_along<B: Backend>(
        &self,
        states: &Tensor<B, 3>,
        windows: &Windows,
        batch: &[Place],
    ) -> Option<Tensor<B, 1>> {
        let [steps, count, width] = states.dims();
        let later = steps - steps / 2;
        let rows = states.clone().narrow(0, steps / 2, later);
        let rows = rows.reshape([later * count, width]);
        let along = self.miss(&rows, windows, &batch.repeat(later))?;
        let end = self.miss(&last(states.clone()), windows, batch)?;
        Some((along + end) * 0.5)
    }

    /// The weighted mean squared miss of latent vectors; none where a window's label is not known.
    pub fn miss<B: Backend>(
        &self,
        z: &Tensor<B, 2>,
        windows: &Windows,
        batch: &[Place],
    ) -> Option<Tensor<B, 1>> {
        let aims: Option<Vec<&Vec<f32>>> = batch
            .iter()
            .map(|&place| self.of_label.get(&windows.recording(place).label))
            .collect();
        let aims = aims?;
        let width = aims.first()?.len();
        let values: Vec<f32> = aims.into_iter().flatten().copied().collect();
        let aims = TensorData::new(values, [batch.len(), width]);
        let aims = Tensor::<B, 2>::from_data(aims, &z.device());
        let said = z.clone().slice([0..batch.len(), 0..width]);
        Some((said - aims).powi_scalar(2).mean() * self.weight)
    }
}

/// z1, z2 and z3: relief, friction and stiffness, each by ratios over the range of the trained materials.
fn by_materials(materials: &[Material]) -> BTreeMap<String, Vec<f32>> {
    let ranges = Material::PROPERTIES.map(|of| Material::range(materials, of));
    let aim = |material: &Material| {
        let shares = Material::PROPERTIES.iter().zip(ranges);
        let aims = shares.map(|(of, [low, high])| {
            let share = (of(material) / low).ln() / (high / low).ln();
            if share.is_finite() {
                REACH * (2.0 * share as f32 - 1.0)
            } else {
                0.0
            }
        });
        (material.label.clone(), aims.collect())
    };
    materials.iter().map(aim).collect()
}

/// Most coordinates of which corners are taken; more tell no more labels apart.
const CODED: usize = 16;

/// Number of labels for which a latent vector of this width has a corner.
pub const fn corners(latent: usize) -> usize {
    1 << if latent < CODED { latent } else { CODED }
}

/// Corners of the cube of latent vectors, each as far as can be from those before (error-correcting output codes; Dietterich
/// and Bakiri 1995).
fn by_codes(labels: &[String], latent: usize) -> BTreeMap<String, Vec<f32>> {
    let bits = latent.min(CODED);
    let mut taken: Vec<u32> = Vec::with_capacity(labels.len());
    for _ in labels {
        let apart = |corner: &u32| taken.iter().map(|t| (t ^ corner).count_ones()).min();
        // The first of several, since the largest of a reversed order is its last.
        let corner = (0..corners(latent) as u32).rev().max_by_key(apart);
        taken.extend(corner);
    }
    let aim = |(label, corner): (&String, u32)| {
        let on = |bit: usize| {
            if corner >> bit & 1 == 1 {
                REACH
            } else {
                -REACH
            }
        };
        (label.clone(), (0..bits).map(on).collect())
    };
    labels.iter().zip(taken).map(aim).collect()
}

/// z1 and z2: rated roughness with friction, and hardness. 1 to 6 lies on -0.75 to 0.75.
fn by_ratings(ratings: &[Rating]) -> BTreeMap<String, Vec<f32>> {
    let on = |rating: f32| (rating - 3.5) * 0.3;
    let aim = |r: &Rating| {
        let aims = vec![on((r.roughness + r.friction) / 2.0), on(r.hardness)];
        (r.label.clone(), aims)
    };
    ratings.iter().map(aim).collect()
}

#[cfg(test)]
#[path = "aims_tests.rs"]
mod tests;
