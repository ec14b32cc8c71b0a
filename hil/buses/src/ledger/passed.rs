//! State of wires that outlives a run: those that a hot pass has turned to austenite since the machine's last start.
//!
//! Nothing measures the state, and nobody knows how long a wire lay cold while the machine was off. So an account of another
//! start, and one that cannot be read, says that no wire is passed: a pass too many does no harm that the guard does not count.

use std::path::Path;

use super::LedgerError;
use super::account::Account;
use super::layout::{Output, bytes, words};
use super::uptime::Uptime;

pub(super) fn name_of(hardware: &str) -> String {
    format!("{hardware}.passed")
}

/// Outputs of hardware, by its name, whose wires are passed.
#[must_use]
pub fn passed(folder: &Path, hardware: &str) -> Vec<Output> {
    let account = Account::open(folder, &name_of(hardware));
    account.map_or_else(
        |_| Vec::new(),
        |account| read_outputs(&account, Uptime::now()),
    )
}

/// Keeps whether the wires on these outputs of hardware are passed; it is on the disk when this returns.
///
/// # Errors
/// [`LedgerError::Folder`] and [`LedgerError::Held`], and [`LedgerError::Reserve`] where the disk takes nothing.
pub fn keep_passed(
    folder: &Path,
    hardware: &str,
    outputs: &[Output],
    are_passed: bool,
) -> Result<(), LedgerError> {
    let name = name_of(hardware);
    let account = match Account::open(folder, &name) {
        Ok(account) => account,
        Err(LedgerError::Unreadable { .. }) => {
            Account::forget(folder, &name)?;
            Account::open(folder, &name)?
        }
        Err(error) => return Err(error),
    };
    let now = Uptime::now();
    let mut kept = read_outputs(&account, now);
    kept.retain(|output| !outputs.contains(output));
    if are_passed {
        kept.extend_from_slice(outputs);
    }
    let words = [now.boot].into_iter();
    let payload = bytes(words.chain(kept.iter().map(Output::word)));
    let written = account.hold()?.write(&payload);
    written.map_err(|error| LedgerError::Reserve(error.to_string()))
}

/// Outputs of an account; none of another start of the machine, or where that is not known.
fn read_outputs(account: &Account, now: Uptime) -> Vec<Output> {
    let payload = account.payload().ok().flatten();
    let Some((boot, outputs)) = payload.and_then(words).and_then(|words| {
        let (boot, outputs) = words.split_first()?;
        Some((*boot, outputs.to_vec()))
    }) else {
        return Vec::new();
    };
    match boot == now.boot && boot != 0 {
        true => outputs.into_iter().filter_map(Output::of_word).collect(),
        false => Vec::new(),
    }
}

#[cfg(test)]
#[path = "passed_tests.rs"]
mod tests;
