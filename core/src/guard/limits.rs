//! The limit table: hard limits are constants here; a file can only tighten them.
//!
//! Engineering limits for a research device, not a certificate.

use crate::units::{Duration, Milliamps};

/// Every limit the guard enforces. Powers and energies are electrical, into the wire and its leads.
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
    /// Outputs go off when sensor input is older than this, or a tick or the link this late.
    pub stale: Duration,
    /// Current of all wires on at one instant; the bench's supply sets it, there is no hard value.
    pub supply: Milliamps,
}

/// Pause after which the next pulse on a wire starts a new burst.
pub const BURST_GAP: Duration = Duration::from_millis(20);

/// The hard limits. The supply's is the bench's to state, hence unlimited here.
pub const HARD: Limits = Limits {
    pulse_width_ns: 200_000,
    burst: Duration::from_millis(50),
    burst_energy_nj: 10_000_000,
    wire_1s_uw: 45_000,
    wire_10s_uw: 20_000,
    fingertip_1s_uw: 110_000,
    fingertip_60s_uw: 60_000,
    stale: Duration::from_millis(100),
    supply: Milliamps(u32::MAX),
};

impl Limits {
    /// Names of the limits, as limit files spell them, each with its value here and in [`HARD`].
    pub fn rows(&self) -> [(&'static str, u64, u64); 8] {
        let h = &HARD;
        [
            ("pulse_width_ns", self.pulse_width_ns, h.pulse_width_ns),
            ("burst_us", self.burst.as_micros(), h.burst.as_micros()),
            ("burst_energy_nj", self.burst_energy_nj, h.burst_energy_nj),
            ("wire_1s_uw", self.wire_1s_uw, h.wire_1s_uw),
            ("wire_10s_uw", self.wire_10s_uw, h.wire_10s_uw),
            ("fingertip_1s_uw", self.fingertip_1s_uw, h.fingertip_1s_uw),
            (
                "fingertip_60s_uw",
                self.fingertip_60s_uw,
                h.fingertip_60s_uw,
            ),
            ("stale_us", self.stale.as_micros(), h.stale.as_micros()),
        ]
    }

    /// The stricter of both in every row: however a table was made, it cannot loosen [`HARD`].
    pub fn tightened(self) -> Self {
        Self {
            pulse_width_ns: self.pulse_width_ns.min(HARD.pulse_width_ns),
            burst: self.burst.min(HARD.burst),
            burst_energy_nj: self.burst_energy_nj.min(HARD.burst_energy_nj),
            wire_1s_uw: self.wire_1s_uw.min(HARD.wire_1s_uw),
            wire_10s_uw: self.wire_10s_uw.min(HARD.wire_10s_uw),
            fingertip_1s_uw: self.fingertip_1s_uw.min(HARD.fingertip_1s_uw),
            fingertip_60s_uw: self.fingertip_60s_uw.min(HARD.fingertip_60s_uw),
            stale: self.stale.min(HARD.stale),
            supply: self.supply.min(HARD.supply),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_loosens() {
        let loose = Limits {
            pulse_width_ns: u64::MAX,
            burst: Duration::from_millis(51),
            burst_energy_nj: u64::MAX,
            wire_1s_uw: 45_001,
            wire_10s_uw: 20_001,
            fingertip_1s_uw: 110_001,
            fingertip_60s_uw: 60_001,
            stale: Duration::from_millis(101),
            supply: Milliamps(2500),
        };
        assert_eq!(
            loose.tightened(),
            Limits {
                supply: Milliamps(2500),
                ..HARD
            }
        );
        assert!(loose.rows().iter().all(|&(_, mine, hard)| mine > hard));
        let tight = Limits {
            wire_1s_uw: 1,
            ..HARD
        };
        assert_eq!(tight.tightened(), tight);
    }
}
