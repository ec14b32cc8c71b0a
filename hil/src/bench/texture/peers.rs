//! ONNX Runtime on the exported model, on the very same windows.

use serde::Deserialize;
use serde_json::json;

use super::Ground;
use crate::bench::Row;
use crate::bench::peers::ask;
use crate::failure::Failure;
use crate::output::write_file;
use crate::texture::onnx;

/// The script that measures it.
const SCRIPT: &str = include_str!("../../../../ci/peers/texture.py");
/// How far it may be from the reference: an export that is further off is wrong.
const AGREES: f64 = 1e-5;

#[derive(Debug, Deserialize)]
struct Answer {
    version: String,
    window_us: f64,
    batch_us: f64,
    latents: Vec<Vec<f32>>,
}

/// One window at a time and all in a batch, for each; none where no Python is named.
///
/// # Errors
/// A peer that fails, or does not agree.
pub(super) fn measure(ground: &Ground) -> Result<Option<[Row; 2]>, Failure> {
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
    let row = |method: String, median_us| Row {
        family: "",
        case: String::new(),
        method,
        error,
        error_unit: "",
        median_us,
        peer: true,
    };
    Ok(Some([
        row(format!("ONNX Runtime {}", answer.version), answer.window_us),
        row(
            format!("ONNX Runtime {}, batch", answer.version),
            answer.batch_us,
        ),
    ]))
}
