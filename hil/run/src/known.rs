//! Temperatures of a summary as JSON: null beyond what the model knows.

use palpate_records::model;
use serde::{Serialize, Serializer};

/// A wire's temperature, degrees C.
#[allow(clippy::ref_option)] // serde's signature
pub(crate) fn known_wire<S: Serializer>(celsius: &Option<f64>, to: S) -> Result<S::Ok, S::Error> {
    celsius
        .and_then(|c| model::known(c, model::WIRE_C))
        .serialize(to)
}

/// A tissue's temperature, degrees C.
#[allow(clippy::ref_option)] // serde's signature
pub(crate) fn known_tissue<S: Serializer>(celsius: &Option<f64>, to: S) -> Result<S::Ok, S::Error> {
    celsius
        .and_then(|c| model::known(c, model::TISSUE_C))
        .serialize(to)
}
