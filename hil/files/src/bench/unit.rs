//! A driver unit in place of the host's own I2C bus, and the network to it.

use serde::Deserialize;

use crate::error::FileError;
use crate::settings::{bounds, settings};
use crate::source::Source;

/// A network between host and unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema, serde::Serialize))]
#[serde(rename_all = "kebab-case")]
pub enum Network {
    /// A cable: half a millisecond at most, nothing lost.
    Wire,
    /// A Wi-Fi microcontroller near its access point, with the figures measured in docs/unit.md.
    Wifi,
    /// A Wi-Fi microcontroller with a worse radio.
    Rough,
}

settings! {
    /// A driver unit: an emulated one behind an emulated network, or with an `address` one that is there.
    #[derive(Eq)]
    pub struct BenchUnit {
        /// Address of a unit: ADDRESS or ADDRESS:PORT; left out: it is emulated.
        pub address: Option<String>,
        /// The file of the key that is shared with it. A unit with an address has one.
        pub key: Option<String>,
        /// The network to an emulated unit.
        pub network: Network = Network::Wifi,
        /// Time from an onset to its effect, milliseconds: more than the network's usual way.
        pub delay_ms: u32 = 20,
        /// Deviation of an emulated unit's crystal, parts per million; negative is slow.
        pub drift_ppm: i32 = 100,
        /// True if an emulated unit's processor bears the guard's thermal rows; the host has them in any case.
        pub heat: bool = false,
    }
}

impl BenchUnit {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        bounds!(source, "unit", self;
            // With a longer delay the 100 ms of the reading would end before the stimulus.
            delay_ms: 0..=40, "ms";
            drift_ppm: -1000..=1000, "ppm")?;
        match (&self.address, &self.key) {
            (Some(_), None) => Err(source.bad(
                "unit.key",
                "the file of the key that is shared with the unit; `hil unit --new-key FILE` makes one",
            )),
            (None, Some(_)) => Err(source.bad(
                "unit.key",
                "nothing: an emulated unit needs no key, and one that is there an address",
            )),
            _ => Ok(()),
        }
    }
}
