//! An I2C bus that does nothing.

use std::cell::Cell;
use std::convert::Infallible;
use std::hint::black_box;

use embedded_hal::i2c::{ErrorType, I2c, Operation};

/// An I2C bus without time and without chips, which counts what is sent, so that the loop's calls can be told apart.
pub struct NullBus<'a>(pub &'a Cell<usize>);

impl ErrorType for NullBus<'_> {
    type Error = Infallible;
}

impl I2c for NullBus<'_> {
    fn transaction(
        &mut self,
        _address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), Infallible> {
        self.0.set(self.0.get() + 1);
        black_box(operations);
        Ok(())
    }
}
