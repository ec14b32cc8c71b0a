//! Changes that a bench of hardware permits beside its file: a limit, towards the safe side, and the addresses of its
//! buses.
//!
//! Statements of the file about hardware are facts that the guard counts with: a current stated smaller than it is
//! would loosen every limit of heat.

use super::bench::Bench;
use super::error::FileError;
use super::loaded::Loaded;
use super::overrides::Overrides;
use super::setup::limits_of;
use super::source::Source;

/// The way on, after the changes that a key permits.
const FACT: &str = "nothing beside the file: on hardware it is a fact that the guard counts with; change the bench's own file";

/// Keys that address the hardware and describe none of it.
const ADDRESSES: [&str; 2] = ["unit.address", "unit.key"];

/// Choices that no limit depends on.
const CHOICES: [&str; 1] = ["drive.hot_pass"];

impl Loaded<Bench> {
    /// The bench read again with these changes. Of a bench of hardware they may only tighten a limit.
    ///
    /// # Errors
    /// Names the option and key of a value that is refused.
    pub fn with(self, overrides: &Overrides) -> Result<Self, FileError> {
        let source = self.source.with(overrides.bench.clone());
        if self.value.is_hardware() {
            refuse_facts(&source)?;
        }
        let changed = Self::read(source)?;
        check(&self, &changed)?;
        Ok(changed)
    }
}

/// Limits that the command line may tighten.
const LIMITS: [&str; 5] = [
    "limits",
    "drive.supply_limit_ma",
    "real.heartbeat_ms",
    "real.transfer_ms",
    "real.realtime",
];

/// Refuses every change to a bench of hardware but those of a limit or an address, whatever its value.
///
/// # Errors
/// Names the option and key.
fn refuse_facts(changed: &Source) -> Result<(), FileError> {
    let mut keys = changed.changes().iter().map(|change| change.key.as_str());
    let fact = keys
        .find(|key| !(LIMITS.contains(key) || ADDRESSES.contains(key) || CHOICES.contains(key)));
    fact.map_or(Ok(()), |key| Err(changed.bad(key, FACT)))
}

/// Refuses changes to a bench of hardware that tighten no limit, and changes that would make an emulated bench one of
/// hardware.
///
/// # Errors
/// Names the option and key.
fn check(before: &Loaded<Bench>, after: &Loaded<Bench>) -> Result<(), FileError> {
    if !(before.value.is_hardware() || after.value.is_hardware()) {
        return Ok(());
    }
    refuse_facts(&after.source)?;
    after.source.changes().iter().try_for_each(|change| {
        tightened(&change.key, before, after)?.map_or(Ok(()), |expected| {
            Err(after.source.bad(&change.key, expected))
        })
    })
}

/// Expectation for a change to this key, unless it is a limit that became no looser.
fn tightened(
    key: &str,
    before: &Loaded<Bench>,
    after: &Loaded<Bench>,
) -> Result<Option<String>, FileError> {
    let most = |old: f64, new: f64, unit: &str| {
        let expected = format!("at most {old} {unit}: on hardware a limit can only be tightened");
        (new > old).then_some(expected)
    };
    let (old, new) = (&before.value, &after.value);
    let real = old.real.as_ref().zip(new.real.as_ref());
    Ok(match (key, real) {
        ("limits", _) => {
            let (old, new) = (limits_of(before)?, limits_of(after)?);
            let is_tighter = new.value.limits.stricter(&old.value.limits) == new.value.limits;
            (!is_tighter).then(|| {
                format!(
                    "a table that is no looser than `{}` in any row: on hardware a limit can only be tightened",
                    old.value.name
                )
            })
        }
        ("drive.supply_limit_ma", _) => {
            most(old.drive.supply_limit_ma, new.drive.supply_limit_ma, "mA")
        }
        ("real.heartbeat_ms", Some((old, new))) => {
            most(old.heartbeat_ms.into(), new.heartbeat_ms.into(), "ms")
        }
        ("real.transfer_ms", Some((old, new))) => {
            most(old.transfer_ms.into(), new.transfer_ms.into(), "ms")
        }
        ("real.realtime", Some((_, new))) => {
            let insists = "true: on hardware real-time priority can only be insisted on";
            (new.realtime != Some(true)).then(|| insists.into())
        }
        // The key is an address or a choice, which may change.
        _ => None,
    })
}

#[cfg(test)]
#[path = "hardware_tests.rs"]
mod tests;
