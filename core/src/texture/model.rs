//! The parts of a model, and what is refused: shapes that do not fit, numbers that could overflow.

use core::fmt;

/// Largest magnitude of a weight, a bias or a scaled sample. Below it no sum of a layer can overflow, so no state
/// can become a NaN. Trained weights are below ten.
pub(super) const LARGEST: f32 = 1e6;
/// Most features, units of a layer, layers and samples of a window.
const MOST: [usize; 4] = [4096, 1024, 8, 1000];

/// One GRU layer with two bias vectors (`reset_after`, `linear_before_reset = 1`), in PyTorch's gate order r, z, n.
#[derive(Clone, Copy, Debug)]
pub struct Gru<'a> {
    /// Inputs I.
    pub inputs: usize,
    /// Units H.
    pub units: usize,
    /// `[3H, I]`, row by row.
    pub weight_ih: &'a [f32],
    /// `[3H, H]`, row by row.
    pub weight_hh: &'a [f32],
    /// `[3H]`.
    pub bias_ih: &'a [f32],
    /// `[3H]`.
    pub bias_hh: &'a [f32],
}

/// An encoder's numbers.
#[derive(Clone, Copy, Debug)]
pub struct Model<'a> {
    /// The smallest raw value of each feature in the training data.
    pub scale_min: &'a [f32],
    /// The largest. A feature that was constant carries nothing: its scaled value is 0.
    pub scale_max: &'a [f32],
    /// The layers, first to last; the last layer's state is z.
    pub layers: &'a [Gru<'a>],
    /// Samples of a window.
    pub window: usize,
}

/// A tensor of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TensorPlace {
    /// The layer; none for the scaling.
    pub layer: Option<usize>,
    /// The tensor's name.
    pub tensor: &'static str,
}

impl fmt::Display for TensorPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.layer {
            Some(layer) => write!(f, "encoder.{layer}.{}", self.tensor),
            None => f.write_str(self.tensor),
        }
    }
}

/// A model that is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A tensor has another length than the shapes ask for.
    #[error("{place}: expected {expected} numbers, found {found}")]
    Length {
        /// The tensor.
        place: TensorPlace,
        /// Numbers expected.
        expected: usize,
        /// Numbers found.
        found: usize,
    },
    /// A count is zero or too large.
    #[error("{what}: expected 1 to {most}, found {found}")]
    Count {
        /// Name of the count.
        what: &'static str,
        /// The largest.
        most: usize,
        /// Found.
        found: usize,
    },
    /// A layer does not take what the one before gives.
    #[error("encoder.{layer}: expected {expected} inputs, as many as come in, found {found}")]
    Inputs {
        /// The layer.
        layer: usize,
        /// Outputs of the layer before.
        expected: usize,
        /// Inputs of this layer.
        found: usize,
    },
    /// A number that is not finite or larger than a million.
    #[error(
        "{place}[{index}]: expected a finite number of at most {LARGEST:e} in magnitude, found {found}"
    )]
    Value {
        /// The tensor.
        place: TensorPlace,
        /// Index of the number in the tensor.
        index: usize,
        /// The number.
        found: f32,
    },
    /// A feature's largest value is below its smallest.
    #[error("scale.max[{feature}]: expected at least scale.min")]
    Range {
        /// The feature.
        feature: usize,
    },
}

/// A sample that is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SampleError {
    /// The number of values is not that of modules times features.
    #[error("expected {expected} values, found {found}")]
    Length {
        /// Values expected.
        expected: usize,
        /// Values found.
        found: usize,
    },
    /// A value that is not finite, or a million times its training range away.
    #[error(
        "value {index} (feature {feature}): expected a finite number near the training range, found {found}"
    )]
    Value {
        /// Index of the value among the samples given: sample times features plus feature.
        index: usize,
        /// Index of its feature.
        feature: usize,
        /// The raw value.
        found: f32,
    },
}

impl Model<'_> {
    /// Factor of each feature's distance from its smallest value: one over its range, 0 without a range.
    pub fn factors(&self) -> impl Iterator<Item = f32> {
        let ranges = self.scale_min.iter().zip(self.scale_max);
        ranges.map(|(&low, &high)| {
            let factor = (1.0 / (f64::from(high) - f64::from(low))) as f32;
            if factor.is_finite() { factor } else { 0.0 }
        })
    }

    /// Checks that everything fits and nothing can overflow.
    ///
    /// # Errors
    /// The first thing that does not fit.
    pub(super) fn check(&self) -> Result<(), ModelError> {
        let features = self.scale_min.len();
        count("features", MOST[0], features)?;
        count("layers", MOST[2], self.layers.len())?;
        count("samples of a window", MOST[3], self.window)?;
        let scale = |tensor| TensorPlace {
            layer: None,
            tensor,
        };
        length(scale("scale.max"), features, self.scale_max.len())?;
        for (tensor, values) in [("scale.min", self.scale_min), ("scale.max", self.scale_max)] {
            // Raw counts: anything finite.
            if let Some(index) = values.iter().position(|v| !v.is_finite()) {
                return Err(ModelError::Value {
                    place: scale(tensor),
                    index,
                    found: values[index],
                });
            }
        }
        let mut ranges = self.scale_min.iter().zip(self.scale_max);
        if let Some(feature) = ranges.position(|(low, high)| high < low) {
            return Err(ModelError::Range { feature });
        }
        let mut comes_in = features;
        for (l, layer) in self.layers.iter().enumerate() {
            let Gru { inputs, units, .. } = *layer;
            count("units of a layer", MOST[1], units)?;
            if inputs != comes_in {
                return Err(ModelError::Inputs {
                    layer: l,
                    expected: comes_in,
                    found: inputs,
                });
            }
            let rows = 3 * units;
            for (tensor, values, expected) in [
                ("weight_ih", layer.weight_ih, rows * inputs),
                ("weight_hh", layer.weight_hh, rows * units),
                ("bias_ih", layer.bias_ih, rows),
                ("bias_hh", layer.bias_hh, rows),
            ] {
                let place = TensorPlace {
                    layer: Some(l),
                    tensor,
                };
                length(place, expected, values.len())?;
                let fits = |v: &f32| v.abs() <= LARGEST; // no NaN does
                if let Some(index) = values.iter().position(|v| !fits(v)) {
                    return Err(ModelError::Value {
                        place,
                        index,
                        found: values[index],
                    });
                }
            }
            comes_in = units;
        }
        Ok(())
    }
}

fn count(what: &'static str, most: usize, found: usize) -> Result<(), ModelError> {
    if (1..=most).contains(&found) {
        return Ok(());
    }
    Err(ModelError::Count { what, most, found })
}

fn length(place: TensorPlace, expected: usize, found: usize) -> Result<(), ModelError> {
    if expected == found {
        return Ok(());
    }
    Err(ModelError::Length {
        place,
        expected,
        found,
    })
}
