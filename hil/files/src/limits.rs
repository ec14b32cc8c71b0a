//! Limit tables: rows that may tighten what the guard enforces, and never loosen it.

use serde::Deserialize;

use super::{FileError, Source};

/// The hard limits. A file's row must be at or below its number here; a row left out keeps it.
pub const HARD_LIMITS: Limits = Limits {
    name: String::new(),
    description: String::new(),
    pulse: Pulse { width_us: 200.0 },
    burst: Burst {
        length_ms: 50.0,
        energy_mj: 10.0,
    },
    wire_power: WirePower {
        over_1s_mw: 45.0,
        over_10s_mw: 20.0,
    },
    fingertip_power: FingertipPower {
        over_1s_mw: 110.0,
        over_60s_mw: 60.0,
    },
    skin: Skin {
        mean_10s_c: 41.0,
        peak_c: 43.0,
        deep_c: 41.0,
    },
    dose: Dose {
        henriques_omega: 0.01,
        cem43_min: 2.0,
    },
    watchdog: Watchdog {
        off_within_ms: 100.0,
    },
};

macro_rules! section {
    ($(#[$doc:meta])* $name:ident, $field:ident: $($(#[$row:meta])* $key:ident),+) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
        #[cfg_attr(test, derive(schemars::JsonSchema))]
        #[serde(deny_unknown_fields, default)]
        pub struct $name { $($(#[$row])* pub $key: f64),+ }

        impl Default for $name {
            fn default() -> Self { HARD_LIMITS.$field }
        }
    };
}

section! { /** One pulse; full-on is refused whatever stands here. */ Pulse, pulse:
/** Longest pulse in microseconds. */ width_us }
section! { /** One burst on one wire. */ Burst, burst:
/** Longest burst in milliseconds. */ length_ms,
/** Most electrical energy in millijoules. */ energy_mj }
section! { /** Mean electrical power of one wire. */ WirePower, wire_power:
/** Milliwatts over one second. */ over_1s_mw,
/** Milliwatts over ten seconds. */ over_10s_mw }
section! { /** Mean electrical power of all wires of a fingertip. */ FingertipPower, fingertip_power:
/** Milliwatts over one second. */ over_1s_mw,
/** Milliwatts over sixty seconds. */ over_60s_mw }
section! { /** Modelled skin temperature. */ Skin, skin:
/** Ten-second mean at 0.1 mm in degrees Celsius. */ mean_10s_c,
/** At any time at 0.1 mm in degrees Celsius. */ peak_c,
/** At any time at 0.4 mm in degrees Celsius. */ deep_c }
section! { /** Dose over a session. */ Dose, dose:
/** Henriques' damage integral, kept below this. */ henriques_omega,
/** Cumulative equivalent minutes at 43 degrees Celsius, kept below this. */ cem43_min }
section! { /** Outputs off on stale input, a late tick or a lost link. */ Watchdog, watchdog:
/** Within this many milliseconds. */ off_within_ms }

/// A limit table, in the units its keys name.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Lower case with hyphens.
    pub name: String,
    /// What it is for, in a sentence.
    pub description: String,
    /// One pulse.
    #[serde(default)]
    pub pulse: Pulse,
    /// One burst on one wire.
    #[serde(default)]
    pub burst: Burst,
    /// Mean power of one wire.
    #[serde(default)]
    pub wire_power: WirePower,
    /// Mean power of a fingertip.
    #[serde(default)]
    pub fingertip_power: FingertipPower,
    /// Modelled skin temperature.
    #[serde(default)]
    pub skin: Skin,
    /// Dose over a session.
    #[serde(default)]
    pub dose: Dose,
    /// Time to outputs off.
    #[serde(default)]
    pub watchdog: Watchdog,
}

impl Limits {
    /// Every row: its key, its value, and the least value that makes sense.
    fn rows(&self) -> [(&'static str, f64, f64); 13] {
        // A skin limit at or below the 33 C of resting skin could never be met.
        const REST: f64 = 33.0;
        [
            ("pulse.width_us", self.pulse.width_us, 0.0),
            ("burst.length_ms", self.burst.length_ms, 0.0),
            ("burst.energy_mj", self.burst.energy_mj, 0.0),
            ("wire_power.over_1s_mw", self.wire_power.over_1s_mw, 0.0),
            ("wire_power.over_10s_mw", self.wire_power.over_10s_mw, 0.0),
            (
                "fingertip_power.over_1s_mw",
                self.fingertip_power.over_1s_mw,
                0.0,
            ),
            (
                "fingertip_power.over_60s_mw",
                self.fingertip_power.over_60s_mw,
                0.0,
            ),
            ("skin.mean_10s_c", self.skin.mean_10s_c, REST),
            ("skin.peak_c", self.skin.peak_c, REST),
            ("skin.deep_c", self.skin.deep_c, REST),
            ("dose.henriques_omega", self.dose.henriques_omega, 0.0),
            ("dose.cem43_min", self.dose.cem43_min, 0.0),
            ("watchdog.off_within_ms", self.watchdog.off_within_ms, 0.0),
        ]
    }

    /// Reads and checks a limit table.
    ///
    /// # Errors
    /// A row above its hard limit, or one that nothing could meet, with its line.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let limits: Self = source.read()?;
        source.heading(&limits.name, &limits.description)?;
        for ((key, value, floor), (_, hard, _)) in limits.rows().into_iter().zip(HARD_LIMITS.rows())
        {
            if value > hard {
                let expected = format!("at most the hard limit {hard} (a file may only tighten)");
                return Err(source.bad(key, expected));
            }
            if value <= floor {
                return Err(source.bad(key, format!("more than {floor}")));
            }
        }
        Ok(limits)
    }
}
