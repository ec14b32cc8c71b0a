//! Computing time of frames, as a summary and a report say it.

use palpate_core::statistics::quantile;
use serde::Serialize;

/// Computing time of a frame, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrameTime {
    /// Median.
    pub median: f64,
    /// 99th percentile.
    pub p99: f64,
}

impl FrameTime {
    /// Sums up measured times, and leaves out what is no number. `None` where none was measured.
    pub fn summarise(costs_us: impl Iterator<Item = f32>) -> Option<Self> {
        let mut sorted: Vec<f32> = costs_us.filter(|us| us.is_finite()).collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let at = |part| quantile(&sorted, part).map(|at| f64::from(at.below));
        Some(Self {
            median: at(0.5)?,
            p99: at(0.99)?,
        })
    }
}
