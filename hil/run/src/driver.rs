//! What a session drives, and the line that cuts their outputs.

use embedded_hal::i2c::I2c;
use palpate_core::driver::{Actuators, Banks, DriverError, Traffic};
use palpate_core::units::{Board, Instant};
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::WornDisplay;

/// Boards that can be started, read back and driven.
pub trait Driver: Actuators<Error = DriverError> {
    /// Everything off, then set up; when the first update may come.
    ///
    /// # Errors
    /// The first board's that does not answer or does not read back, or the unit's.
    fn start(&mut self, now: Instant) -> Result<Instant, DriverError>;

    /// Whether all still is as [`Self::start`] left it.
    ///
    /// # Errors
    /// As [`Self::start`].
    fn verify(&mut self) -> Result<(), DriverError>;

    /// Transfers made again after a transient error.
    fn retries(&self) -> u64;

    /// What updates came to on the buses.
    fn traffic(&self) -> Traffic;

    /// The boards' numbers.
    fn boards(&self) -> Vec<Board>;
}

impl<I: I2c> Driver for Banks<I> {
    fn start(&mut self, now: Instant) -> Result<Instant, DriverError> {
        Self::start(self, now)
    }

    fn verify(&mut self) -> Result<(), DriverError> {
        Self::verify(self)
    }

    fn retries(&self) -> u64 {
        Self::retries(self)
    }

    fn traffic(&self) -> Traffic {
        Self::traffic(self)
    }

    fn boards(&self) -> Vec<Board> {
        Self::boards(self).collect()
    }
}

/// The line that cuts every output whatever the chips' registers say, and needs no bus.
pub trait OutputEnable {
    /// Releases it, or cuts.
    fn set_enabled(&self, now: Instant, enabled: bool);

    /// Whether outputs that it has cut are off: it is there, or they go off by themselves.
    fn cuts(&self) -> bool;

    /// How notes say that the outputs were cut, or that they could not be.
    fn words(&self) -> &'static str;
}

impl OutputEnable for WornDisplay {
    fn set_enabled(&self, now: Instant, enabled: bool) {
        self.set_outputs(Nanos::from(now), enabled);
    }

    fn cuts(&self) -> bool {
        true
    }

    fn words(&self) -> &'static str {
        "outputs off by the OE line"
    }
}
