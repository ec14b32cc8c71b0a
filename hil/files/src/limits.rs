//! Limit tables: rows that may tighten the guard's limits, and never loosen them.

use palpate_core::guard::{HARD, Limits};
use palpate_core::units::Duration;
use serde::Deserialize;

use super::error::FileError;
use super::settings::settings;
use super::source::Source;

settings! { /** One pulse; full-on is refused whatever the file states. */ struct Pulse {
/** Longest pulse in microseconds. */ width_us: f64 = HARD.pulse_width_ns as f64 / 1e3 } }
settings! { /** One burst on one wire. */ struct Burst {
/** Longest burst in milliseconds. */ length_ms: f64 = HARD.burst.as_micros() as f64 / 1e3,
/** Most electrical energy in millijoules. */ energy_mj: f64 = HARD.burst_energy_nj as f64 / 1e6 } }
settings! { /** Mean electrical power of one wire. */ struct WirePower {
/** Milliwatts over one second. */ over_1s_mw: f64 = HARD.wire_1s_uw as f64 / 1e3,
/** Milliwatts over ten seconds. */ over_10s_mw: f64 = HARD.wire_10s_uw as f64 / 1e3 } }
settings! { /** Mean electrical power of all wires of a fingertip. */ struct FingertipPower {
/** Milliwatts over one second. */ over_1s_mw: f64 = HARD.fingertip_1s_uw as f64 / 1e3,
/** Milliwatts over sixty seconds. */ over_60s_mw: f64 = HARD.fingertip_60s_uw as f64 / 1e3 } }
settings! { /** Mean electrical power of all fingertips of one hand, which share it evenly. */ struct HandPower {
/** Milliwatts over sixty seconds. */ over_60s_mw: f64 = HARD.hand_60s_uw as f64 / 1e3 } }
settings! { /** Modelled skin temperature. */ struct Skin {
/** Ten-second mean at 0.1 mm in degrees Celsius. */ mean_10s_c: f64 = HARD.skin_mean_mc as f64 / 1e3,
/** Peak at any time at 0.1 mm in degrees Celsius. */ peak_c: f64 = HARD.skin_peak_mc as f64 / 1e3,
/** Peak at any time at 0.4 mm in degrees Celsius. */ deep_c: f64 = HARD.skin_deep_mc as f64 / 1e3 } }
settings! { /** Dose over a session. */ struct Dose {
/** Henriques' damage integral, kept below this. */ henriques_omega: f64 = HARD.dose_omega_ppm as f64 / 1e6,
/** Cumulative equivalent minutes at 43 degrees Celsius, kept below this. */
cem43_min: f64 = HARD.dose_cem43_ms as f64 / 60e3 } }
settings! { /** Outputs off on stale input, a late tick or a lost link. */ struct Watchdog {
/** Longest time until the outputs are off, milliseconds. */ off_within_ms: f64 = HARD.stale.as_micros() as f64 / 1e3 } }

/// A limit table, in the units its keys name.
#[derive(Default, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(test, schemars(extend("required" = ["name", "description"])))]
#[serde(default, deny_unknown_fields)]
pub(super) struct Limiting {
    /// Name, in lower case with hyphens.
    name: String,
    /// The purpose of the table, in a sentence.
    description: String,
    /// One pulse.
    pulse: Pulse,
    /// One burst on one wire.
    burst: Burst,
    /// Mean power of one wire.
    wire_power: WirePower,
    /// Mean power of a fingertip.
    fingertip_power: FingertipPower,
    /// Mean power of a hand.
    hand_power: HandPower,
    /// Modelled skin temperature.
    skin: Skin,
    /// Dose over a session.
    dose: Dose,
    /// Time to outputs off.
    watchdog: Watchdog,
}

impl Limiting {
    /// Every row: its key, its value, and the bound that the value must exceed.
    fn rows(&self) -> [(&'static str, f64, f64); 14] {
        // A skin limit at or below the 33 C of resting skin could never be met.
        const REST: f64 = 33.0;
        let (wire, finger) = (&self.wire_power, &self.fingertip_power);
        [
            ("pulse.width_us", self.pulse.width_us, 0.0),
            ("burst.length_ms", self.burst.length_ms, 0.0),
            ("burst.energy_mj", self.burst.energy_mj, 0.0),
            ("wire_power.over_1s_mw", wire.over_1s_mw, 0.0),
            ("wire_power.over_10s_mw", wire.over_10s_mw, 0.0),
            ("fingertip_power.over_1s_mw", finger.over_1s_mw, 0.0),
            ("fingertip_power.over_60s_mw", finger.over_60s_mw, 0.0),
            ("hand_power.over_60s_mw", self.hand_power.over_60s_mw, 0.0),
            ("skin.mean_10s_c", self.skin.mean_10s_c, REST),
            ("skin.peak_c", self.skin.peak_c, REST),
            ("skin.deep_c", self.skin.deep_c, REST),
            ("dose.henriques_omega", self.dose.henriques_omega, 0.0),
            ("dose.cem43_min", self.dose.cem43_min, 0.0),
            ("watchdog.off_within_ms", self.watchdog.off_within_ms, 0.0),
        ]
    }

    /// Returns the limits in the guard's integers. The supply's limit is a bench's to state.
    fn limits(&self) -> Limits {
        let scaled = |value: f64, scale: f64| (value * scale).round() as u64;
        Limits {
            pulse_width_ns: scaled(self.pulse.width_us, 1e3),
            burst: Duration::from_micros(scaled(self.burst.length_ms, 1e3)),
            burst_energy_nj: scaled(self.burst.energy_mj, 1e6),
            wire_1s_uw: scaled(self.wire_power.over_1s_mw, 1e3),
            wire_10s_uw: scaled(self.wire_power.over_10s_mw, 1e3),
            fingertip_1s_uw: scaled(self.fingertip_power.over_1s_mw, 1e3),
            fingertip_60s_uw: scaled(self.fingertip_power.over_60s_mw, 1e3),
            hand_60s_uw: scaled(self.hand_power.over_60s_mw, 1e3),
            skin_mean_mc: scaled(self.skin.mean_10s_c, 1e3),
            skin_peak_mc: scaled(self.skin.peak_c, 1e3),
            skin_deep_mc: scaled(self.skin.deep_c, 1e3),
            dose_omega_ppm: scaled(self.dose.henriques_omega, 1e6),
            dose_cem43_ms: scaled(self.dose.cem43_min, 60e3),
            stale: Duration::from_micros(scaled(self.watchdog.off_within_ms, 1e3)),
            supply: HARD.supply,
        }
        .tightened()
    }
}

/// A limit table that was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LimitTable {
    /// Name, in lower case with hyphens.
    pub name: String,
    /// The purpose of the table, in a sentence.
    pub description: String,
    /// Rows of the table; a bench states the supply's.
    pub limits: Limits,
}

impl LimitTable {
    /// Reads and checks a limit table.
    ///
    /// # Errors
    /// A row above its hard limit, or one that nothing could meet, with its line.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let file: Limiting = source.read()?;
        source.heading(&file.name, &file.description)?;
        let hard = Limiting::default().rows();
        for ((key, value, floor), (_, hard, _)) in file.rows().into_iter().zip(hard) {
            if value > hard {
                let expected = format!("at most the hard limit {hard} (a file may only tighten)");
                return Err(source.bad(key, expected));
            }
            if value <= floor {
                return Err(source.bad(key, format!("more than {floor}")));
            }
        }
        Ok(Self {
            limits: file.limits(),
            name: file.name,
            description: file.description,
        })
    }
}
