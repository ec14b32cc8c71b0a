//! A first guide: principal components between encoder and decoder, while these two cannot yet make sense of each
//! other. The encoder learns to put them out, the decoder to read them; later epochs are the network's own affair.

use burn::prelude::*;

use crate::measure::{Components, matrix};
use crate::windows::{Place, Windows};

/// Principal components of the training windows, squeezed into the range of a GRU.
pub struct Guide {
    components: Components,
    /// Twice the standard deviation of each coordinate, which becomes tanh(1).
    reach: Vec<f32>,
    /// Rough increase of the mean squared reconstruction error for a miss of one in each coordinate.
    weights: Vec<f32>,
}

impl Guide {
    /// Guide of the training recordings' windows, with as many components as the latent vector has.
    pub fn new(windows: &Windows, train: &[usize], latent: usize) -> Self {
        let rows = matrix(windows, &windows.places(train, 4));
        let components = Components::fit(&rows, latent);
        let deviations = components.scores(&rows).std_axis(ndarray::Axis(0), 0.0);
        let reach: Vec<f32> = deviations
            .iter()
            .map(|d| (2.0 * d).max(f32::MIN_POSITIVE))
            .collect();
        let numbers = rows.ncols() as f32;
        let weights = reach.iter().map(|r| r * r / numbers).collect();
        Self {
            components,
            reach,
            weights,
        }
    }

    /// Latent vectors that these windows should have, [places, latent].
    pub fn latents<B: Backend>(
        &self,
        windows: &Windows,
        places: &[Place],
        device: &B::Device,
    ) -> Tensor<B, 2> {
        let scores = self.components.scores(&matrix(windows, places));
        let reach = self.reach.iter().cycle();
        let values: Vec<f32> = scores
            .iter()
            .zip(reach)
            .map(|(s, r)| (s / r).tanh())
            .collect();
        let shape = [places.len(), self.reach.len()];
        Tensor::from_data(TensorData::new(values, shape), device)
    }

    /// Rough increase of the reconstruction error for the misses of some latent vectors.
    pub fn miss<B: Backend>(&self, found: Tensor<B, 2>, wanted: Tensor<B, 2>) -> Tensor<B, 1> {
        let [places, latent] = found.dims();
        let weights = TensorData::new(self.weights.clone(), [1, latent]);
        let weights = Tensor::<B, 2>::from_data(weights, &found.device());
        let misses = (found - wanted).powi_scalar(2) * weights;
        misses.sum() / places as f32
    }
}
