//! Tensors and layers of a model file.

use palpate_core::texture::Gru;
use safetensors::{Dtype, SafeTensors};

use crate::error::FileError;

/// A tensor: its shape and its numbers, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Tensor {
    /// Rows and columns, or the length alone.
    pub shape: Vec<usize>,
    /// The numbers.
    pub values: Vec<f32>,
}

/// One GRU layer of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Input weights `[3H, I]`, gates r, z, n.
    pub weight_ih: Tensor,
    /// Recurrent weights `[3H, H]`.
    pub weight_hh: Tensor,
    /// Input biases `[3H]`.
    pub bias_ih: Tensor,
    /// Recurrent biases `[3H]`.
    pub bias_hh: Tensor,
}

impl Layer {
    /// Reads a layer by the name of its stack and its number there.
    ///
    /// # Errors
    /// The errors of [`tensor`].
    pub(crate) fn read(
        tensors: &SafeTensors<'_>,
        label: &str,
        (stack, number): (&str, usize),
    ) -> Result<Self, FileError> {
        let name = |tensor: &str| format!("{stack}.{number}.{tensor}");
        Ok(Self {
            weight_ih: tensor(tensors, label, &name("weight_ih"), 2)?,
            weight_hh: tensor(tensors, label, &name("weight_hh"), 2)?,
            bias_ih: tensor(tensors, label, &name("bias_ih"), 1)?,
            bias_hh: tensor(tensors, label, &name("bias_hh"), 1)?,
        })
    }

    /// Units H.
    pub fn units(&self) -> usize {
        self.weight_hh.shape[1]
    }

    /// Inputs I.
    pub fn inputs(&self) -> usize {
        self.weight_ih.shape[1]
    }

    /// Trained numbers of the layer.
    pub fn parameters(&self) -> usize {
        let all = [
            &self.weight_ih,
            &self.weight_hh,
            &self.bias_ih,
            &self.bias_hh,
        ];
        all.map(|tensor| tensor.values.len()).iter().sum()
    }

    /// The layer in the core's type.
    pub(crate) fn gru(&self) -> Gru<'_> {
        Gru {
            inputs: self.inputs(),
            units: self.units(),
            weight_ih: &self.weight_ih.values,
            weight_hh: &self.weight_hh.values,
            bias_ih: &self.bias_ih.values,
            bias_hh: &self.bias_hh.values,
        }
    }
}

/// Reads a tensor by its name.
///
/// # Errors
/// A tensor that is not there, or is of another kind.
pub(crate) fn tensor(
    tensors: &SafeTensors<'_>,
    label: &str,
    key: &str,
    dimensions: usize,
) -> Result<Tensor, FileError> {
    let wrong = |expected: String, found: String| FileError {
        key: Some(key.to_owned()),
        ..FileError::whole(label, expected, found)
    };
    let view = tensors
        .tensor(key)
        .map_err(|_| wrong("a tensor".into(), "none".into()))?;
    let values: Option<Vec<f32>> = match view.dtype() {
        Dtype::F32 => {
            let (numbers, _) = view.data().as_chunks::<4>();
            Some(numbers.iter().map(|b| f32::from_le_bytes(*b)).collect())
        }
        // A page's module reads `default` alone, which is whole.
        #[cfg(not(target_family = "wasm"))]
        Dtype::F16 => {
            let (numbers, _) = view.data().as_chunks::<2>();
            let widen = |b: &[u8; 2]| crate::half::widen(u16::from_le_bytes(*b));
            Some(numbers.iter().map(widen).collect())
        }
        _ => None,
    };
    let values = values.filter(|_| view.shape().len() == dimensions);
    let values = values.ok_or_else(|| {
        let expected = format!("F32 with {dimensions} dimensions");
        wrong(
            expected,
            format!("{:?} of shape {:?}", view.dtype(), view.shape()),
        )
    })?;
    Ok(Tensor {
        shape: view.shape().to_vec(),
        values,
    })
}
