//! A driver unit in place of the host's own I2C bus, and the network to it.

use serde::Deserialize;

use crate::error::FileError;
use crate::source::Source;

/// A network between host and unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema, serde::Serialize))]
#[serde(rename_all = "kebab-case")]
pub enum Network {
    /// A cable: half a millisecond at most, nothing lost.
    Wire,
    /// A Wi-Fi microcontroller near its access point, as measured: docs/unit.md.
    Wifi,
    /// The same with a worse radio.
    Rough,
}

/// An emulated driver unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct BenchUnit {
    /// The network to it.
    pub network: Network,
    /// From an onset to its effect, milliseconds: more than the network's usual way.
    pub delay_ms: u32,
    /// How fast its crystal is, parts per million; negative is slow.
    pub drift_ppm: i32,
    /// Whether its processor bears the guard's thermal rows; the host has them in any case.
    pub heat: bool,
}

impl Default for BenchUnit {
    fn default() -> Self {
        Self {
            network: Network::Wifi,
            delay_ms: 20,
            drift_ppm: 100,
            heat: false,
        }
    }
}

impl BenchUnit {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        // Later than this, the 100 ms of the reading would be over before the stimulus is.
        source.range("unit.delay_ms", self.delay_ms, 0..=40, "ms")?;
        source.range("unit.drift_ppm", self.drift_ppm, -1000..=1000, "ppm")
    }
}
