//! The texture encoder: windows of readings to latent vectors.

use std::sync::Arc;

use palpate_core::texture::{Ends, Stream};
use palpate_core::units::Duration;
use palpate_files::TextureModel;
use palpate_run::Failure;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::free;

/// A texture model.
#[pyclass(frozen, module = "palpate._palpate")]
#[derive(Debug)]
pub struct Texture(TextureModel);

#[pymethods]
impl Texture {
    /// A built-in model, or a file.
    #[new]
    fn new(py: Python<'_>, model: &str) -> PyResult<Self> {
        free(py, || Ok(Self(TextureModel::open(model)?)))
    }

    /// Samples per window, features per sample, numbers per latent vector.
    fn shape(&self) -> (usize, usize, usize) {
        (self.0.window(), self.0.features(), self.0.latents())
    }

    /// The features by their names, as columns of a recording.
    fn features(&self) -> Vec<String> {
        self.0.feature_names().to_vec()
    }

    /// Rows of features (f32) to the rows that windows ended with, and their latent vectors (f32). With a grid, sample
    /// and onset distance in microseconds, only windows that end with the newest sample at an onset.
    fn encode<'py>(
        &self,
        py: Python<'py>,
        rows: &[u8],
        grid: Option<(u64, u64)>,
    ) -> PyResult<(Vec<u64>, Bound<'py, PyBytes>)> {
        let values: Vec<f32> = bytemuck::pod_collect_to_vec(rows);
        let model = &self.0;
        let ends = grid.map_or(Ends::Every, |(sample, every)| Ends::Onsets {
            sample: Duration::from_micros(sample),
            every: Duration::from_micros(every),
        });
        let (frames, latents) = free(py, || {
            let mut stream = Stream::new(Arc::new(model.encoder()?), 1);
            let (mut frames, mut latents) = (Vec::new(), Vec::new());
            for (row, sample) in (0u64..).zip(values.chunks_exact(model.features().max(1))) {
                let begin = ends.begins(row, model.window());
                let pushed = stream.push(sample, begin);
                let latent = pushed.map_err(|e| Failure::Input(format!("rows[{row}]: {e}")))?;
                if let Some(latent) = latent {
                    frames.push(row);
                    latents.extend_from_slice(latent);
                }
            }
            Ok((frames, latents))
        })?;
        Ok((frames, PyBytes::new(py, bytemuck::cast_slice(&latents))))
    }
}
