//! Distances of places from their true places.

use palpate_records::measure::Errors;
use serde::Serialize;

/// Root mean square and maximum of a distance, mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PathError {
    /// Root mean square.
    pub rmse: f64,
    /// Largest distance.
    pub max: f64,
}

impl From<Errors> for PathError {
    fn from(e: Errors) -> Self {
        let mm = |um: u64| um as f64 * 1e-3;
        Self {
            rmse: mm(e.rmse_um),
            max: mm(e.max_um),
        }
    }
}
