//! The boards of several I2C buses as one: numbered through, each bus with a bank of its own.

use alloc::boxed::Box;
use alloc::vec::Vec;

use embedded_hal::i2c::I2c;

use super::{Actuators, Driver, DriverError, Pca9685Bank, Traffic};
use crate::guard::Guarded;
use crate::units::{Board, Instant, Milliamps, Prescale};

/// Every board of a bench. The first bus's boards come first.
#[derive(Debug)]
pub struct Banks<I> {
    banks: Box<[Pca9685Bank<I>]>,
}

impl<I: I2c> Banks<I> {
    /// A bank for each bus with its boards' 7-bit addresses; nothing is sent yet.
    pub fn new<'a>(buses: impl IntoIterator<Item = (I, &'a [u8])>, prescale: Prescale) -> Self {
        let mut first = 0;
        let bank = |(i2c, addresses): (I, &[u8])| {
            let bank = Pca9685Bank::new(i2c, addresses, prescale).numbered_from(first);
            first += addresses.len() as u8; // a bench has at most 16 boards
            bank
        };
        Self {
            banks: buses.into_iter().map(bank).collect(),
        }
    }

    /// Returns the banks for buses that other drivers use too, each
    /// [`Pca9685Bank::sharing`]. `channels` has those of all boards.
    #[must_use]
    pub fn sharing(self, channels: &[u16]) -> Self {
        self.divided(channels, Pca9685Bank::sharing)
    }

    /// Returns the banks with a converter for each board, as in [`Pca9685Bank::with_converters`].
    #[must_use]
    pub fn with_converters(self, addresses: &[u8], full_scale: Milliamps) -> Self {
        self.divided(addresses, |bank, own| bank.with_converters(own, full_scale))
    }

    fn divided<T>(
        self,
        mut rest: &[T],
        give: impl Fn(Pca9685Bank<I>, &[T]) -> Pca9685Bank<I>,
    ) -> Self {
        let share = |bank: Pca9685Bank<I>| {
            let (own, others) = rest.split_at(bank.numbers().count().min(rest.len()));
            rest = others;
            give(bank, own)
        };
        Self {
            banks: self.banks.into_iter().map(share).collect(),
        }
    }

    /// The bus that carries a board.
    pub fn bus_of(&self, board: Board) -> Option<&I> {
        let carries = |bank: &&Pca9685Bank<I>| bank.numbers().any(|b| b == board);
        self.banks.iter().find(carries).map(Pca9685Bank::bus)
    }
}

impl<I: I2c> Actuators for Banks<I> {
    type Error = DriverError;

    fn apply(&mut self, update: &Guarded) -> Result<(), DriverError> {
        let board = update.board();
        let carries = |bank: &&mut Pca9685Bank<I>| bank.numbers().any(|b| b == board);
        match self.banks.iter_mut().find(carries) {
            Some(bank) => bank.apply(update),
            None => Err(DriverError::NoSuchBoard(board)),
        }
    }

    /// Every bus is tried whatever the others answer; the first error is returned.
    fn all_off(&mut self) -> Result<(), DriverError> {
        let off = |result: Result<(), _>, bank: &mut Pca9685Bank<I>| {
            let one = bank.all_off();
            result.and(one)
        };
        self.banks.iter_mut().fold(Ok(()), off)
    }
}

impl<I: I2c> Driver for Banks<I> {
    /// A bank switches its own boards off first; the last bus does not wait for the first one's set-up.
    fn start(&mut self, now: Instant) -> Result<Instant, DriverError> {
        if self.banks.len() > 1 {
            self.all_off()?;
        }
        let mut ready = now;
        for bank in &mut self.banks {
            ready = ready.max(bank.start(now)?);
        }
        Ok(ready)
    }

    fn verify(&mut self) -> Result<(), DriverError> {
        self.banks.iter_mut().try_for_each(Pca9685Bank::verify)
    }

    fn retries(&self) -> u64 {
        self.banks.iter().map(Pca9685Bank::retries).sum()
    }

    fn traffic(&self) -> Traffic {
        let each = self.banks.iter().map(Pca9685Bank::traffic);
        each.fold(Traffic::default(), |sum, one| Traffic {
            writes: sum.writes + one.writes,
            unchanged_updates: sum.unchanged_updates + one.unchanged_updates,
            channels: sum.channels + one.channels,
            unchanged_channels: sum.unchanged_channels + one.unchanged_channels,
        })
    }

    fn boards(&self) -> Vec<Board> {
        self.banks.iter().flat_map(Pca9685Bank::numbers).collect()
    }
}
