//! Starts this program again in a process of its own: as a guardian.

use std::ffi::OsString;
use std::io;
use std::process::Command as Process;
use std::sync::OnceLock;

/// The words that start this program again, where they are not the path of this executable.
static AGAIN: OnceLock<Vec<OsString>> = OnceLock::new();

/// Sets the words that start this program, the path of an interpreter first.
pub fn is_started_by(words: Vec<OsString>) {
    // Only the first counts: a process has one way to be started.
    let _ = AGAIN.set(words);
}

/// This program in another process, without a command yet.
///
/// # Errors
/// Error of the system where this executable has no path.
pub fn again() -> io::Result<Process> {
    if let Some((program, first)) = AGAIN.get().and_then(|words| words.split_first()) {
        let mut process = Process::new(program);
        process.args(first);
        return Ok(process);
    }
    Ok(Process::new(std::env::current_exe()?))
}
