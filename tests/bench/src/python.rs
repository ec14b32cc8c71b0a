//! Peers from PyPI, measured in the same run: `ci/peers/run` installs them and names their Python in `PALPATE_PEERS`. A
//! script gets the very same input as JSON and answers with times and results.

use std::io::Write;
use std::process::{Command, Stdio};

use serde::Serialize;
use serde::de::DeserializeOwned;

use palpate_run::Failure;

/// Answer of `script` to `question`; none where no Python is named.
///
/// # Errors
/// A Python that cannot be started, fails, or answers something else.
pub fn ask<T: DeserializeOwned>(
    script: &str,
    question: &impl Serialize,
) -> Result<Option<T>, Failure> {
    let Some(python) = std::env::var_os("PALPATE_PEERS") else {
        return Ok(None);
    };
    let failed = |what: String| Failure::Input(format!("PALPATE_PEERS: {what}"));
    let mut child = Command::new(&python)
        .args(["-c", script])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|e| failed(format!("{}: {e}", python.display())))?;
    if let Some(mut stdin) = child.stdin.take() {
        serde_json::to_writer(&mut stdin, question)
            .map_err(|e| failed(e.to_string()))
            .and_then(|()| stdin.flush().map_err(|e| failed(e.to_string())))?;
    }
    let output = child
        .wait_with_output()
        .map_err(|e| failed(e.to_string()))?;
    if !output.status.success() {
        let what = format!("the peers' script ended with {}", output.status);
        return Err(failed(what));
    }
    serde_json::from_slice(&output.stdout)
        .map(Some)
        .map_err(|e| failed(e.to_string()))
}
