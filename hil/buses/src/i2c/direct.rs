//! An adapter for the core's driver on the caller's own thread: without limit, thread or memory of its own, for one that
//! has nothing else to do than to switch off.

use embedded_hal::i2c::{ErrorType, I2c, Operation};

use super::{Adapter, FaultKind};

/// Bytes of the longest write: an update of sixteen channels.
const LONGEST: usize = 65;

/// An adapter whose caller waits for as long as a transfer takes.
#[derive(Debug)]
pub struct Direct<A> {
    adapter: A,
    /// Address and kind of the last transfer that failed.
    last: Option<(u8, FaultKind)>,
}

impl<A: Adapter> Direct<A> {
    /// A bus over this adapter.
    pub const fn new(adapter: A) -> Self {
        Self {
            adapter,
            last: None,
        }
    }

    /// Rests as [`Adapter::rest`].
    pub fn rest(&mut self) {
        self.adapter.rest();
    }

    /// Address and kind of the last transfer that failed.
    pub const fn last_fault(&self) -> Option<(u8, FaultKind)> {
        self.last
    }

    fn pass(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), FaultKind> {
        let (mut bytes, mut length) = ([0; LONGEST], 0);
        let mut rest = operations;
        // Adjacent writes become one message, as in `Line`.
        while let [Operation::Write(part), after @ ..] = rest {
            let end = length + part.len();
            let place = bytes.get_mut(length..end).ok_or(FaultKind::Unsupported)?;
            place.copy_from_slice(part);
            (length, rest) = (end, after);
        }
        let write = bytes.get(..length).unwrap_or_default();
        match rest {
            [] => self.adapter.transfer(address, write, &mut []),
            [Operation::Read(into)] => self.adapter.transfer(address, write, into),
            _ => Err(FaultKind::Unsupported),
        }
    }
}

impl<A> ErrorType for Direct<A> {
    type Error = FaultKind;
}

impl<A: Adapter> I2c for Direct<A> {
    fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), FaultKind> {
        let done = self.pass(address, operations);
        if let Err(kind) = done {
            self.last = Some((address, kind));
        }
        done
    }
}
