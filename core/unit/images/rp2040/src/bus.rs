//! The controller of the boards' bus: a transfer that returns is over, and its answer is known.
//!
//! rp2040-hal 0.12 takes the first STOP that is marked for a write's. A read does not wait for its own, so the write behind it
//! returns early and the next transfer cuts it short. It also looks for a refusal only while its queue is full, so a short
//! write that no chip acknowledged counts as done.

use embedded_hal::i2c::{self, ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};
use palpate_image::Register;

/// Registers of I2C0 (RP2040 data sheet, 4.3.17): raw interrupts, the source of an abort, and two that clear when read.
const RAW: Register = Register(0x4004_4034);
const GIVEN_UP: Register = Register(0x4004_4080);
const CLEAR_GIVEN_UP: Register = Register(0x4004_4054);
const CLEAR_STOP: Register = Register(0x4004_4060);
const STOP: u32 = 1 << 9;
/// Looks for a STOP, more than a byte's time of them.
const LOOKS: usize = 10_000;

/// A transfer that did not come to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed;

impl i2c::Error for Failed {
    fn kind(&self) -> ErrorKind {
        ErrorKind::NoAcknowledge(NoAcknowledgeSource::Unknown)
    }
}

/// A controller of I2C0.
#[derive(Debug)]
pub struct Settled<I>(pub I);

impl<I> ErrorType for Settled<I> {
    type Error = Failed;
}

impl<I: I2c> I2c for Settled<I> {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Failed> {
        let reads = matches!(operations.last(), Some(Operation::Read(_)));
        let done = self.0.transaction(address, operations);
        if reads && done.is_ok() {
            let _ = (0..LOOKS).find(|_| RAW.read() & STOP != 0);
        }
        let given_up = GIVEN_UP.read();
        CLEAR_GIVEN_UP.read();
        CLEAR_STOP.read();
        match done {
            Ok(()) if given_up == 0 => Ok(()),
            _ => Err(Failed),
        }
    }
}
