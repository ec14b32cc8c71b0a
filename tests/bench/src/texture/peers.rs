//! ONNX Runtime on the exported model, on the very same windows.

use serde::Deserialize;
use serde_json::json;

use palpate_live::output::write_file;
use palpate_run::Failure;
use palpate_texture::onnx;

use super::ground::Ground;
use crate::python::ask;

/// The script that measures it.
const SCRIPT: &str = include_str!("../../../../ci/peers/texture.py");
/// Largest error against the reference: an export that is further off is wrong.
const AGREES: f64 = 1e-5;

#[derive(Debug, Deserialize)]
struct Answer {
    version: String,
    window_us: f64,
    batch_us: f64,
    latents: Vec<Vec<f32>>,
}

/// Measurements of ONNX Runtime.
pub(super) struct Peer {
    /// Name of the peer with its version.
    pub name: String,
    /// One window at a time, microseconds.
    pub window_us: f64,
    /// Each window of a batch of all, microseconds.
    pub batch_us: f64,
    /// Largest error of its latents.
    pub error: f64,
}

/// ONNX Runtime on the windows of `ground`; none where no Python is named.
///
/// # Errors
/// A peer that fails, or does not agree.
pub(super) fn measure(ground: &Ground) -> Result<Option<Peer>, Failure> {
    let path = std::env::temp_dir().join(format!("palpate-{}.onnx", std::process::id()));
    write_file(&path, |out| out.write_all(&onnx::encoder(&ground.model)))?;
    let rows: Vec<Vec<&[f32]>> = ground
        .windows
        .iter()
        .map(|w| w.chunks_exact(ground.model.features()).collect())
        .collect();
    let answer = ask::<Answer>(SCRIPT, &json!({"model": path, "windows": rows}));
    // Best effort: it lies in a folder for such files.
    let _ = std::fs::remove_file(&path);
    let Some(answer) = answer? else {
        return Ok(None);
    };
    let error = ground.off(&answer.latents);
    if error > AGREES {
        return Err(Failure::Check(format!(
            "ONNX Runtime {} on the exported model is {error:e} off, expected at most {AGREES:e}",
            answer.version
        )));
    }
    Ok(Some(Peer {
        name: format!("ONNX Runtime {}", answer.version),
        window_us: answer.window_us,
        batch_us: answer.batch_us,
        error,
    }))
}
