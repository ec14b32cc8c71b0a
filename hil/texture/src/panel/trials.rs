//! Trials of a panel before they are shown: strokes and pieces of recordings as rows, rows as control parameters.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use palpate_core::texture::{Control, ControlMap, Encoder, Ends, Stream};
use palpate_core::units::Duration;
use palpate_emulators::sensor::surface::Recording;
use palpate_files::{Rows, Take, TextureModel};
use palpate_run::Failure;

use super::stage::SHOWN;
use crate::explore::{STROKED_HZ, features};
use crate::rows::files;

/// Time from one latent vector to the next, as in the loop.
const SOA: Duration = Duration::from_micros(58_500);

/// Rows of one stroke, feature by feature.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Values, row by row.
    values: Vec<f32>,
    rate_hz: f64,
    /// Name of the stroke, for errors.
    what: String,
}

/// A stroke as control parameters.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Trial {
    /// Control parameters, each with the time from which it holds.
    pub(super) controls: Vec<(Duration, Control)>,
    /// Mean roughness, 0 to 1.
    pub(super) driven: f64,
    /// Hardness of the surface by the last window, 0 to 1: that of the tap where the surface is left.
    pub(super) hardness: Option<f64>,
}

impl Trial {
    /// Control parameters that the loop would make of a stroke: from the windows that are newest at each onset, from
    /// the first one on. The last window gives the hardness.
    pub(super) fn new(
        encoder: &Arc<Encoder>,
        map: &ControlMap,
        source: &Source,
    ) -> Result<Self, Failure> {
        let bad = |e: String| Failure::Input(format!("{}: {e}", source.what));
        let sample = Duration::from_micros((1e6 / source.rate_hz).round() as u64);
        let window = encoder.window();
        let ends = Ends::Onsets { sample, every: SOA };
        let mut stream = Stream::new(encoder.clone(), 1);
        let mut trial = Self {
            controls: Vec::new(),
            driven: 0.0,
            hardness: None,
        };
        let mut first = None;
        for (row, values) in source.values.chunks_exact(encoder.features()).enumerate() {
            // The first window counts whether or not an onset falls on its end.
            let begin = row == 0 || ends.begins(row as u64, window);
            let latent = stream.push(values, begin).map_err(|e| bad(e.to_string()))?;
            let Some(latent) = latent else { continue };
            let at = Duration::from_micros(row as u64 * sample.as_micros());
            let begun = *first.get_or_insert(at);
            let since = Duration::from_micros(at.as_micros() - begun.as_micros());
            trial.driven += map.roughness(latent);
            trial.hardness = map.hardness(latent);
            trial.controls.push((since, map.control(latent)));
        }
        if trial.controls.is_empty() {
            return Err(bad(format!("expected at least {window} rows, one window")));
        }
        trial.driven /= trial.controls.len() as f64;
        Ok(trial)
    }
}

impl Source {
    /// A stroke as the model's features.
    pub(super) fn of_stroke(
        model: &TextureModel,
        name: &str,
        stroke: &Recording,
    ) -> Result<Self, Failure> {
        Ok(Self {
            values: features(model, stroke)?,
            rate_hz: STROKED_HZ,
            what: name.to_owned(),
        })
    }
}

/// Recordings of one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Name of the material.
    pub name: String,
    files: Vec<PathBuf>,
}

impl Label {
    /// The materials of a folder of `NAME_ANYTHING.csv`, in the order of their names.
    ///
    /// # Errors
    /// A folder that cannot be read, or holds none.
    pub fn all(folder: &Path) -> Result<Vec<Self>, Failure> {
        let bad = |e: &dyn std::fmt::Display| Failure::Input(format!("{}: {e}", folder.display()));
        let mut labels: Vec<Self> = Vec::new();
        let found = files(folder, "csv");
        for (stem, file) in
            found.map_err(|e| bad(&format!("expected a readable folder, found {e}")))?
        {
            let Some((name, _)) = stem.split_once('_') else {
                continue;
            };
            match labels.iter_mut().find(|label| label.name == name) {
                Some(label) => label.files.push(file),
                None => labels.push(Self {
                    name: name.to_owned(),
                    files: vec![file],
                }),
            }
        }
        if labels.is_empty() {
            return Err(bad(
                &"expected recordings called NAME_NUMBER.csv, found none",
            ));
        }
        Ok(labels)
    }

    /// Pieces as long as a window and the shown time after it, from the middle of one recording after another.
    pub(super) fn pieces(
        &self,
        model: &TextureModel,
        rate_hz: f64,
        count: u32,
    ) -> Result<Vec<Source>, Failure> {
        let shown = SHOWN.as_micros() as f64 * 1e-6 * rate_hz;
        let wanted = model.window() + shown.ceil() as usize;
        let take = Take::Features {
            names: model.feature_names(),
            count: model.features(),
        };
        let piece = |file: &PathBuf| {
            let mut rows = Rows::open(file, take, None)?;
            let values: Vec<f32> = rows.rest()?;
            let length = wanted.min(rows.count());
            let first = (rows.count() - length) / 2;
            let kept = values.chunks_exact(model.features()).skip(first);
            Ok(Source {
                values: kept.take(length).flatten().copied().collect(),
                rate_hz,
                what: file.display().to_string(),
            })
        };
        // With fewer recordings than trials some are shown twice, to different people.
        let files = self.files.iter().cycle().take(count as usize);
        files.map(piece).collect()
    }
}
