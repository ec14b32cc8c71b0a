//! Clustering libraries from PyPI, on the very same frames and warm starts.

use serde::Deserialize;
use serde_json::json;

use super::clouds::{Cloud, Errors};
use crate::python::ask;
use palpate_run::Failure;

/// The script that measures them.
const SCRIPT: &str = include_str!("../../../../ci/peers/measure.py");

/// One peer's answer.
#[derive(Debug, Deserialize)]
struct Answer {
    method: String,
    median_us: f64,
    /// Centroids of every frame.
    centroids: Vec<Vec<(f64, f64)>>,
}

/// The peers' names, errors and median times on the frames of a case; none where no Python is named.
///
/// # Errors
/// A Python that cannot be started, fails, or answers something else.
pub(super) fn measure(
    round: &[Cloud],
    starts: &[Vec<(f64, f64)>],
    best: &[f64],
) -> Result<Vec<(String, Errors, f64)>, Failure> {
    let frames: Vec<_> = round
        .iter()
        .zip(starts)
        .map(|(c, start)| json!({"x": c.x, "y": c.y, "w": c.w, "start": start}))
        .collect();
    let answers: Vec<Answer> = ask(SCRIPT, &frames)?.unwrap_or_default();
    let measured = |answer: Answer| {
        let mut errors = Errors::default();
        for ((centroids, cloud), best) in answer.centroids.iter().zip(round).zip(best) {
            errors.add(cloud, centroids, *best);
        }
        (answer.method, errors, answer.median_us)
    };
    Ok(answers.into_iter().map(measured).collect())
}
