//! An H-bridge of 20 kHz and more behind an LC filter: the module sees a current, not its ripple.

use palpate_core::units::{Duration, Instant};

use super::instant;
use crate::time::Nanos;

/// Heating current of a bridge with a shorted transistor, mA: all that its supply gives.
const SHORTED_MA: i32 = -1500;

/// A bridge; off without an update.
#[derive(Clone, Debug, Default)]
pub(super) struct Bridge {
    milliamps: i32,
    /// Time at which the bridge lets go by itself.
    until: Instant,
    pub(super) shorted: bool,
}

impl Bridge {
    /// Takes a current at an instant of its own clock, by which it lets go after so long.
    pub(super) fn set(&mut self, at: Nanos, milliamps: i32, length: Duration) {
        self.milliamps = milliamps;
        self.until = instant(at) + length;
    }

    pub(super) const fn off(&mut self) {
        self.milliamps = 0;
    }

    /// Current at an instant, mA.
    pub(super) fn milliamps(&self, at: Nanos) -> i32 {
        match self.shorted {
            true => SHORTED_MA,
            false if instant(at) < self.until => self.milliamps,
            false => 0,
        }
    }
}

#[cfg(test)]
impl Bridge {
    /// A current that no guard has passed.
    pub(super) const fn flowing(milliamps: i32) -> Self {
        Self {
            milliamps,
            until: Instant::FAR_FUTURE,
            shorted: false,
        }
    }

    /// Makes the bridge let go at that time of its own clock, ms.
    pub(super) const fn until_ms(&mut self, ms: u64) {
        self.until = Instant::from_micros(1000 * ms);
    }
}
