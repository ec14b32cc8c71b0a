//! Quarantine files: trials that are known to fail, each with its reason.

use serde::Deserialize;

use super::error::FileError;
use super::near::did_you_mean;
use super::source::Source;

/// A list of trials that may fail.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Quarantine {
    /// The trials.
    #[serde(default)]
    pub quarantine: Vec<Quarantined>,
}

/// Trial that may fail.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Quarantined {
    /// The scene's name.
    pub trial: String,
    /// The bench's name; left out: every bench.
    pub bench: Option<String>,
    /// The reason for which it fails, and the person who knows more.
    pub reason: String,
}

impl Quarantine {
    /// Reads and checks a file; `trials` are all trials that exist.
    ///
    /// # Errors
    /// Names the line of a trial that does not exist, or that has no reason.
    pub fn read(source: &Source, trials: &[String]) -> Result<Self, FileError> {
        let list = Self::alone(source)?;
        for (index, entry) in list.quarantine.iter().enumerate() {
            if !trials.contains(&entry.trial) {
                let expected = format!("a trial: {}", trials.join(", "));
                let meant = did_you_mean(&entry.trial, trials.iter().map(String::as_str));
                let found = format!("\"{}\"{meant}", entry.trial);
                let key = format!("quarantine[{index}].trial");
                return Err(source.bad_found(&key, expected, found));
            }
        }
        Ok(list)
    }

    /// Reads a file where the existing trials are unknown.
    pub(super) fn alone(source: &Source) -> Result<Self, FileError> {
        let list: Self = source.read()?;
        for (index, entry) in list.quarantine.iter().enumerate() {
            if entry.reason.trim().is_empty() {
                return Err(source.bad(&format!("quarantine[{index}].reason"), "a reason"));
            }
        }
        Ok(list)
    }

    /// The reason for which a trial may fail on a bench; `None` where it may not.
    pub fn reason(&self, trial: &str, bench: &str) -> Option<&str> {
        let here = |q: &&Quarantined| q.bench.as_deref().is_none_or(|b| b == bench);
        let entry = self
            .quarantine
            .iter()
            .filter(here)
            .find(|q| q.trial == trial);
        entry.map(|q| q.reason.as_str())
    }
}
