//! The limit table: hard limits are constants here; a file can only tighten them.
//!
//! Engineering limits for a research device, not a certificate.

use crate::units::{Duration, Milliamps};

/// Limits that the guard enforces. Powers and energies are electrical, into the wire and its leads; temperatures are
/// of modelled skin, at the worst of the guard's parameter range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Longest single pulse, nanoseconds, at the slowest oscillator a chip may have.
    pub pulse_width_ns: u64,
    /// Longest burst on one wire. A burst ends after [`BURST_GAP`] without a pulse on that wire.
    pub burst: Duration,
    /// Most energy of one burst, nanojoules.
    pub burst_energy_nj: u64,
    /// Mean power of one wire over 1 s, microwatts.
    pub wire_1s_uw: u64,
    /// Mean power of one wire over 10 s, microwatts.
    pub wire_10s_uw: u64,
    /// Mean power of a fingertip over 1 s, microwatts.
    pub fingertip_1s_uw: u64,
    /// Mean power of a fingertip over 60 s, microwatts.
    pub fingertip_60s_uw: u64,
    /// Mean power of all fingertips of one hand over 60 s, microwatts: [`Self::of_hand`] shares it out to them.
    pub hand_60s_uw: u64,
    /// Skin 0.1 mm deep as a mean over 10 s, millidegrees Celsius.
    pub skin_mean_mc: u64,
    /// Skin 0.1 mm deep at any time, millidegrees Celsius.
    pub skin_peak_mc: u64,
    /// Skin 0.4 mm deep at any time, millidegrees Celsius.
    pub skin_deep_mc: u64,
    /// Henriques' Omega over a session, millionths.
    pub dose_omega_ppm: u64,
    /// Cumulative equivalent time at 43 C over a session, milliseconds.
    pub dose_cem43_ms: u64,
    /// Age of sensor input, or lateness of a tick or the link, at which outputs go off.
    pub stale: Duration,
    /// Current of all wires on at one instant; the bench's supply sets it, there is no hard value.
    pub supply: Milliamps,
}

/// Pause after which the next pulse on a wire starts a new burst.
pub const BURST_GAP: Duration = Duration::from_millis(20);

/// The hard limits. A hand's is a tenth of the 6.6 W that a resting hand gives off by radiation and convection in air of
/// 27 degrees C (150 W/m2 of 0.044 m2: Taylor et al. 2014), rounded down. The supply's is the bench's to state, hence unlimited here.
pub const HARD: Limits = Limits {
    pulse_width_ns: 200_000,
    burst: Duration::from_millis(50),
    burst_energy_nj: 10_000_000,
    wire_1s_uw: 45_000,
    wire_10s_uw: 20_000,
    fingertip_1s_uw: 110_000,
    fingertip_60s_uw: 60_000,
    hand_60s_uw: 600_000,
    skin_mean_mc: 41_000,
    skin_peak_mc: 43_000,
    skin_deep_mc: 41_000,
    dose_omega_ppm: 10_000,
    dose_cem43_ms: 120_000,
    stale: Duration::from_millis(100),
    supply: Milliamps(u32::MAX),
};

impl Limits {
    /// The limits of one of `fingertips` fingertips of a hand: each has an equal share of the hand's power, whatever
    /// the others do with theirs.
    #[must_use]
    pub fn of_hand(self, fingertips: u64) -> Self {
        let share_uw = self.hand_60s_uw / fingertips.max(1);
        Self {
            fingertip_60s_uw: self.fingertip_60s_uw.min(share_uw),
            ..self
        }
    }

    /// The stricter of this table and [`HARD`] in every row: a table can be made in any way and loosens none of them.
    #[must_use]
    pub fn tightened(self) -> Self {
        self.stricter(&HARD)
    }

    /// The stricter of both in every row: the lower figure.
    #[must_use]
    pub fn stricter(self, other: &Self) -> Self {
        let mut rows = self.rows();
        for (row, other) in rows.iter_mut().zip(other.rows()) {
            *row = other.min(*row);
        }
        Self::from_rows(rows)
    }

    /// Every row in the order of the fields, as integers: times in microseconds, currents in milliamperes, the others
    /// unchanged. A driver unit tells its limits in this order.
    #[must_use]
    pub const fn rows(&self) -> [u64; 15] {
        [
            self.pulse_width_ns,
            self.burst.as_micros(),
            self.burst_energy_nj,
            self.wire_1s_uw,
            self.wire_10s_uw,
            self.fingertip_1s_uw,
            self.fingertip_60s_uw,
            self.hand_60s_uw,
            self.skin_mean_mc,
            self.skin_peak_mc,
            self.skin_deep_mc,
            self.dose_omega_ppm,
            self.dose_cem43_ms,
            self.stale.as_micros(),
            self.supply.0 as u64,
        ]
    }

    /// The table with these [`Self::rows`]; a current that is too large for its type becomes the largest.
    #[must_use]
    pub fn from_rows(rows: [u64; 15]) -> Self {
        Self {
            pulse_width_ns: rows[0],
            burst: Duration::from_micros(rows[1]),
            burst_energy_nj: rows[2],
            wire_1s_uw: rows[3],
            wire_10s_uw: rows[4],
            fingertip_1s_uw: rows[5],
            fingertip_60s_uw: rows[6],
            hand_60s_uw: rows[7],
            skin_mean_mc: rows[8],
            skin_peak_mc: rows[9],
            skin_deep_mc: rows[10],
            dose_omega_ppm: rows[11],
            dose_cem43_ms: rows[12],
            stale: Duration::from_micros(rows[13]),
            supply: Milliamps(u32::try_from(rows[14]).unwrap_or(u32::MAX)),
        }
    }
}

#[cfg(test)]
#[path = "limits_tests.rs"]
mod tests;
