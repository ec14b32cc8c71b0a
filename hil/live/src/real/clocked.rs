//! Boards on adapters of this computer, whose driver knows the time at the end of a transfer.

use embedded_hal::i2c::I2c;
use palpate_buses::pacer::RunClock;
use palpate_core::driver::{Actuators, Banks, Driver, DriverError, Traffic};
use palpate_core::guard::Guarded;
use palpate_core::units::{Board, Instant};

/// A driver of boards, with the clock of the run.
pub struct Clocked<I> {
    banks: Banks<I>,
    clock: RunClock,
}

impl<I: I2c> Clocked<I> {
    pub(super) const fn new(banks: Banks<I>, clock: RunClock) -> Self {
        Self { banks, clock }
    }

    /// The bus that carries a board.
    pub(super) fn bus_of(&self, board: Board) -> Option<&I> {
        self.banks.bus_of(board)
    }
}

impl<I: I2c> Actuators for Clocked<I> {
    type Error = DriverError;

    fn apply(&mut self, update: &Guarded) -> Result<(), DriverError> {
        self.banks.apply(update)
    }

    fn all_off(&mut self) -> Result<(), DriverError> {
        self.banks.all_off()
    }

    /// Time of the end of a transfer, which another finger's may have held up: later than it was asked for.
    fn confirmed(&self, asked: Instant) -> Instant {
        asked.max(self.clock.now())
    }
}

impl<I: I2c> Driver for Clocked<I> {
    fn start(&mut self, now: Instant) -> Result<Instant, DriverError> {
        self.banks.start(now)
    }

    fn verify(&mut self) -> Result<(), DriverError> {
        self.banks.verify()
    }

    fn retries(&self) -> u64 {
        self.banks.retries()
    }

    fn traffic(&self) -> Traffic {
        self.banks.traffic()
    }

    fn boards(&self) -> Vec<Board> {
        self.banks.boards()
    }
}
