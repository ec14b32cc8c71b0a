//! Outputs on adapters of this computer, whose driver knows the time at the end of a transfer.

use palpate_buses::i2c::SharedLine;
use palpate_buses::pacer::RunClock;
use palpate_core::driver::{Actuators, Banks, Driver, DriverError, Haptics, Traffic};
use palpate_core::guard::{Guarded, GuardedVibration};
use palpate_core::projector::Update;
use palpate_core::units::{Board, Instant};

/// A driver of one kind of actuators on buses of this computer.
pub trait OnLines: Driver<<Self as OnLines>::Update> {
    /// Kind of update that it takes.
    type Update: Update;

    /// The bus that carries a board.
    fn line(&self, board: Board) -> Option<&SharedLine>;
}

impl OnLines for Banks<SharedLine> {
    type Update = Guarded;

    fn line(&self, board: Board) -> Option<&SharedLine> {
        self.bus_of(board)
    }
}

impl OnLines for Haptics<SharedLine> {
    type Update = GuardedVibration;

    fn line(&self, _board: Board) -> Option<&SharedLine> {
        Some(self.bus())
    }
}

/// A driver with the clock of the run.
pub struct Clocked<D> {
    driver: D,
    clock: RunClock,
}

impl<D: OnLines> Clocked<D> {
    pub(super) const fn new(driver: D, clock: RunClock) -> Self {
        Self { driver, clock }
    }

    /// The bus that carries a board.
    pub(super) fn line(&self, board: Board) -> Option<&SharedLine> {
        self.driver.line(board)
    }
}

impl<D: OnLines> Actuators<D::Update> for Clocked<D> {
    type Error = DriverError;

    fn apply(&mut self, update: &D::Update) -> Result<(), DriverError> {
        self.driver.apply(update)
    }

    fn all_off(&mut self) -> Result<(), DriverError> {
        self.driver.all_off()
    }

    /// Time of the end of a transfer, which another finger's may have held up: later than it was asked for.
    fn confirmed(&self, asked: Instant) -> Instant {
        asked.max(self.clock.now())
    }
}

impl<D: OnLines> Driver<D::Update> for Clocked<D> {
    fn start(&mut self, now: Instant) -> Result<Instant, DriverError> {
        self.driver.start(now)
    }

    fn verify(&mut self) -> Result<(), DriverError> {
        self.driver.verify()
    }

    fn retries(&self) -> u64 {
        self.driver.retries()
    }

    fn traffic(&self) -> Traffic {
        self.driver.traffic()
    }

    fn boards(&self) -> Vec<Board> {
        self.driver.boards()
    }
}
