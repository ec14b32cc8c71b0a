//! The image's end of the rig: a bus, an OE line and a network, as the unit wants them.

use core::cell::RefCell;
use core::convert::Infallible;

use embedded_hal::digital::{ErrorType as PinErrorType, OutputPin};
use embedded_hal::i2c::{Error, ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};
use palpate_core::codec::link::{Buffer, MOST};
use palpate_core::units::Instant;
use palpate_unit::Datagrams;

use super::{HEAD, Head, Kind, Outcome};
use crate::serve::Link;

/// Most bytes of a question.
const QUESTION: usize = HEAD + MOST;
/// Most bytes of the operations of a transfer: the longest write of the driver, 65, and a read.
const OPERATIONS: usize = 80;

/// The pipes to the rig; `None` once the other end is gone.
pub trait Wires {
    /// Sends all bytes.
    fn send(&mut self, bytes: &[u8]) -> Option<()>;

    /// Fills `bytes`.
    fn receive(&mut self, bytes: &mut [u8]) -> Option<()>;
}

/// The rig, with a clock in nanoseconds that goes on over a reset.
#[derive(Debug)]
pub struct Rig<W, C> {
    wires: RefCell<(W, [u8; QUESTION])>,
    clock_ns: C,
}

impl<W: Wires, C: Fn() -> u64> Rig<W, C> {
    /// A rig over its pipes.
    pub const fn new(wires: W, clock_ns: C) -> Self {
        Self {
            wires: RefCell::new((wires, [0; QUESTION])),
            clock_ns,
        }
    }

    /// Asks one question; returns the answer's time, its outcome and
    /// how many of its bytes are in `reply`. `None` if the rig is gone.
    pub(super) fn ask(
        &self,
        (kind, argument): (Kind, u8),
        parts: &[&[u8]],
        reply: &mut [u8],
    ) -> Option<(u64, Outcome, usize)> {
        let (wires, question) = &mut *self.wires.borrow_mut();
        let length: usize = parts.iter().map(|part| part.len()).sum();
        let head = Head {
            ns: (self.clock_ns)(),
            what: kind as u8,
            argument,
            length: length as u16, // a datagram at most
        };
        let question = question.get_mut(..HEAD + length)?;
        let (first, mut room) = question.split_at_mut(HEAD);
        first.copy_from_slice(&head.bytes());
        for part in parts {
            let (own, rest) = room.split_at_mut(part.len());
            own.copy_from_slice(part);
            room = rest;
        }
        // At once: a reset in the middle of a question would leave the rig waiting for its end.
        wires.send(question)?;
        let mut head = [0; HEAD];
        wires.receive(&mut head)?;
        let head = Head::read(&head);
        let length = usize::from(head.length);
        wires.receive(reply.get_mut(..length)?)?;
        Some((head.ns, head.outcome()?, length))
    }

    /// A number that no start had before.
    pub fn boot(&self) -> u64 {
        let mut number = [0; 8];
        // A rig that is gone has no boards either.
        let _ = self.ask((Kind::Boot, 0), &[], &mut number);
        u64::from_le_bytes(number)
    }

    /// Reads the next question to a guard; returns its length.
    pub fn question(&self, question: &mut [u8]) -> Option<usize> {
        let (_, outcome, length) = self.ask((Kind::Ask, 0), &[], question)?;
        (outcome == Outcome::Done).then_some(length)
    }

    /// Tells the rig the guard's answer, and how far the clock counted meanwhile.
    pub fn tell(&self, took: u32, answer: &[u8]) {
        let _ = self.ask((Kind::Tell, 0), &[&took.to_le_bytes(), answer], &mut []);
    }

    /// Waits until the clock shows this.
    fn wait(&self, until_ns: u64) {
        while (self.clock_ns)() < until_ns {}
    }
}

/// The reason for which a transfer failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusError(Option<Outcome>);

impl Error for BusError {
    fn kind(&self) -> ErrorKind {
        match self.0 {
            Some(Outcome::NoAddress) => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address),
            Some(Outcome::NoData) => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Data),
            Some(Outcome::Arbitration) => ErrorKind::ArbitrationLoss,
            Some(Outcome::Failed) => ErrorKind::Bus,
            // A rig that is gone is not worth another try.
            _ => ErrorKind::Other,
        }
    }
}

/// The rig's I2C bus.
#[derive(Debug)]
pub struct Bus<'r, W, C>(pub &'r Rig<W, C>);

impl<W, C> ErrorType for Bus<'_, W, C> {
    type Error = BusError;
}

impl<W: Wires, C: Fn() -> u64> I2c for Bus<'_, W, C> {
    fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), BusError> {
        let mut sent = [0; OPERATIONS];
        let mut length = 0;
        let mut put = |bytes: &[u8]| {
            let room = sent.get_mut(length..length + bytes.len());
            length += bytes.len();
            room.map(|room| room.copy_from_slice(bytes))
        };
        for operation in operations.iter() {
            let (head, data): (_, &[u8]) = match operation {
                Operation::Read(bytes) => ([0, bytes.len() as u8], &[]),
                Operation::Write(bytes) => ([1, bytes.len() as u8], bytes),
            };
            put(&head).and_then(|()| put(data)).ok_or(BusError(None))?;
        }
        let mut read = [0; OPERATIONS];
        let asked = self
            .0
            .ask((Kind::Transfer, address), &[&sent[..length]], &mut read);
        let (ends, outcome, _) = asked.ok_or(BusError(None))?;
        if outcome == Outcome::Stuck {
            // What a controller without a time-out does: the hardware watchdog alone ends it.
            self.0.wait(u64::MAX);
        }
        self.0.wait(ends);
        if outcome != Outcome::Done {
            return Err(BusError(Some(outcome)));
        }
        let mut rest = &read[..];
        for operation in operations {
            if let Operation::Read(bytes) = operation
                && let Some((own, more)) = rest.split_at_checked(bytes.len())
            {
                bytes.copy_from_slice(own);
                rest = more;
            }
        }
        Ok(())
    }
}

/// The rig's line to the OE pins of all chips.
#[derive(Debug)]
pub struct Oe<'r, W, C>(pub &'r Rig<W, C>);

impl<W: Wires, C: Fn() -> u64> Oe<'_, W, C> {
    fn set(&self, level: u8) {
        // Without a rig there are no chips.
        let _ = self.0.ask((Kind::Oe, level), &[], &mut []);
    }
}

impl<W, C> PinErrorType for Oe<'_, W, C> {
    type Error = Infallible;
}

impl<W: Wires, C: Fn() -> u64> OutputPin for Oe<'_, W, C> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.set(0);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.set(1);
        Ok(())
    }
}

/// A network that is the rig's as well: datagrams come at times that the rig's owner sets.
#[derive(Debug)]
pub struct Network<'r, W, C> {
    rig: &'r Rig<W, C>,
    next: Option<Instant>,
}

impl<'r, W: Wires, C: Fn() -> u64> Network<'r, W, C> {
    /// The network of a rig.
    pub const fn new(rig: &'r Rig<W, C>) -> Self {
        Self { rig, next: None }
    }
}

impl<W: Wires, C: Fn() -> u64> Datagrams for Network<'_, W, C> {
    type Peer = ();

    fn receive(&mut self, buffer: &mut Buffer) -> Option<(usize, ())> {
        let asked = self.rig.ask((Kind::Receive, 0), &[], &mut buffer[..]);
        let (next_ns, outcome, length) = asked?;
        // As long as there are some, more may wait.
        self.next = Some(Instant::from_micros(next_ns.div_ceil(1000)));
        (outcome == Outcome::Done).then_some((length.min(MOST), ()))
    }

    fn send(&mut self, datagram: &[u8], (): ()) {
        let _ = self.rig.ask((Kind::Send, 0), &[datagram], &mut []);
    }
}

impl<W: Wires, C: Fn() -> u64> Link for Network<'_, W, C> {
    fn next(&mut self) -> Option<Instant> {
        self.next
    }
}
