//! Other people's clustering from PyPI, measured in the same run: `ci/peers/run` installs them and names their
//! Python in `PALPATE_PEERS`. It gets the very same frames and warm starts and answers with times and centroids.

use std::io::Write;
use std::process::{Command, Stdio};

use serde::Deserialize;
use serde_json::json;

use super::clouds::Cloud;
use super::kernels::{Errors, Measured};
use crate::failure::Failure;

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

/// The peers on the frames of a case; none where no Python is named.
///
/// # Errors
/// A Python that cannot be started, fails, or answers something else.
pub(super) fn measure(
    round: &[Cloud],
    starts: &[Vec<(f64, f64)>],
    best: &[f64],
) -> Result<Vec<Measured>, Failure> {
    let Some(python) = std::env::var_os("PALPATE_PEERS") else {
        return Ok(Vec::new());
    };
    let failed = |what: String| Failure::Input(format!("PALPATE_PEERS: {what}"));
    let frames: Vec<_> = round
        .iter()
        .zip(starts)
        .map(|(c, start)| json!({"x": c.x, "y": c.y, "w": c.w, "start": start}))
        .collect();
    let mut child = Command::new(&python)
        .args(["-c", SCRIPT])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|e| failed(format!("{}: {e}", python.display())))?;
    if let Some(mut stdin) = child.stdin.take() {
        serde_json::to_writer(&mut stdin, &frames)
            .map_err(|e| failed(e.to_string()))
            .and_then(|()| stdin.flush().map_err(|e| failed(e.to_string())))?;
    }
    let output = child
        .wait_with_output()
        .map_err(|e| failed(e.to_string()))?;
    if !output.status.success() {
        return Err(failed(format!(
            "the peers' script ended with {}",
            output.status
        )));
    }
    let answers: Vec<Answer> =
        serde_json::from_slice(&output.stdout).map_err(|e| failed(e.to_string()))?;
    let measured = |answer: Answer| {
        let mut errors = Errors::default();
        for ((centroids, cloud), best) in answer.centroids.iter().zip(round).zip(best) {
            errors.add(cloud, centroids, *best);
        }
        Measured {
            method: answer.method,
            errors,
            median_us: answer.median_us,
            peer: true,
        }
    };
    Ok(answers.into_iter().map(measured).collect())
}
