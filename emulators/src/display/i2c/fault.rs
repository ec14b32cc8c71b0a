//! A fault layer in front of any I2C bus: seeded or scripted, each fault counted and kept for the record.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};
use palpate_core::random::RandomStream;

/// Fault that the layer puts into a transaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum I2cFaultKind {
    /// The address is not acknowledged; nothing reaches the chip.
    AddressNack,
    /// A data byte is lost: what came before it has reached the chip (a torn update), nothing after it.
    DataNack,
    /// Another controller wins the bus in the address; nothing reaches the chip.
    ArbitrationLoss,
    /// A line is stuck low: this transaction and the following ones fail, see [`I2cFaults::stuck_for`].
    StuckBus,
    /// The adapter fails after the transfer: everything has reached the chip, and the host cannot know.
    Eio,
    /// SCL is held low for [`I2cFaults::stretch_ns`] first; the bus decides whether that fails.
    LongStretch,
}

impl I2cFaultKind {
    /// All kinds.
    pub const ALL: [Self; 6] = [
        Self::AddressNack,
        Self::DataNack,
        Self::ArbitrationLoss,
        Self::StuckBus,
        Self::Eio,
        Self::LongStretch,
    ];
}

/// Rates of the faults.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct I2cFaults {
    /// Probability of each kind, a transaction, in the order of [`I2cFaultKind::ALL`]; at most one strikes.
    pub probability: [f64; 6],
    /// Transactions that a stuck bus lasts, the first one included.
    pub stuck_for: u32,
    /// Length of a long stretch, nanoseconds.
    pub stretch_ns: u64,
}

/// A bus whose clock can be held low from outside. Buses that cannot keep the default: nothing happens.
pub trait HoldClock {
    /// Holds SCL low for `ns` before the next byte.
    fn hold_clock_ns(&mut self, _ns: u64) {}
}

impl HoldClock for super::I2cHandle {
    fn hold_clock_ns(&mut self, ns: u64) {
        // Refused only from inside a look at the segment, where no transaction can follow.
        let _ = self.with(|segment| segment.hold_clock(crate::time::Nanos(ns)));
    }
}

/// The error of a bus behind the fault layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", embedded_hal::i2c::Error::kind(self))]
pub enum FaultError<E: embedded_hal::i2c::Error> {
    /// The bus itself failed.
    Bus(E),
    /// The layer struck.
    Injected(I2cFaultKind),
}

impl<E: embedded_hal::i2c::Error> embedded_hal::i2c::Error for FaultError<E> {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Bus(e) => e.kind(),
            Self::Injected(kind) => match kind {
                I2cFaultKind::AddressNack => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address),
                I2cFaultKind::DataNack => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Data),
                I2cFaultKind::ArbitrationLoss => ErrorKind::ArbitrationLoss,
                I2cFaultKind::StuckBus | I2cFaultKind::Eio => ErrorKind::Bus,
                I2cFaultKind::LongStretch => ErrorKind::Other,
            },
        }
    }
}

/// The layer.
#[derive(Clone, Debug)]
pub struct I2cFault<I> {
    bus: I,
    faults: I2cFaults,
    stream: RandomStream,
    /// Fault that the next transaction suffers, whatever the dice say.
    scripted: Option<I2cFaultKind>,
    stuck: u32,
    counts: [u64; 6],
    transactions: u64,
}

impl<I> I2cFault<I> {
    /// Stands in front of `bus`. `identity` names the bus, so that its dice are its own.
    pub fn new(bus: I, faults: I2cFaults, seed: u64, identity: &str) -> Self {
        Self {
            bus,
            faults,
            stream: RandomStream::new(seed, identity),
            scripted: None,
            stuck: 0,
            counts: [0; 6],
            transactions: 0,
        }
    }

    /// Sets the dice from now on.
    pub const fn set_faults(&mut self, faults: I2cFaults) {
        self.faults = faults;
    }

    /// Lets `kind` strike the next transaction (a scene's script).
    pub const fn strike(&mut self, kind: I2cFaultKind) {
        self.scripted = Some(kind);
    }

    /// Frees a stuck bus.
    pub const fn free(&mut self) {
        self.stuck = 0;
    }

    /// Number of faults of each kind so far, in the order of [`I2cFaultKind::ALL`].
    pub const fn counts(&self) -> [u64; 6] {
        self.counts
    }

    /// Transactions asked for.
    pub const fn transactions(&self) -> u64 {
        self.transactions
    }

    /// The bus behind the layer.
    pub const fn bus(&mut self) -> &mut I {
        &mut self.bus
    }

    /// One throw a transaction, so that a longer script leaves later throws alone.
    fn throw(&mut self) -> Option<I2cFaultKind> {
        let mut rest = self.stream.uniform();
        if self.stuck > 0 {
            self.stuck -= 1;
            return Some(I2cFaultKind::StuckBus);
        }
        let diced =
            (I2cFaultKind::ALL.into_iter().zip(self.faults.probability)).find_map(|(kind, p)| {
                rest -= p;
                (rest < 0.0).then_some(kind)
            });
        let kind = self.scripted.take().or(diced);
        if kind == Some(I2cFaultKind::StuckBus) {
            self.stuck = self.faults.stuck_for.saturating_sub(1);
        }
        kind
    }
}

impl<I: I2c> I2cFault<I> {
    /// Hands on what comes before a byte that gets lost, and ends there.
    fn torn(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), I::Error> {
        let bytes: usize = operations.iter().map(length).sum();
        let mut left = (self.stream.uniform() * bytes as f64) as usize;
        let mut whole = 0;
        for operation in operations.iter() {
            if length(operation) > left {
                break;
            }
            left -= length(operation);
            whole += 1;
        }
        let (before, rest) = operations.split_at_mut(whole);
        match rest.first_mut() {
            Some(Operation::Write(bytes)) if left > 0 => {
                let cut = bytes.get(..left).unwrap_or(bytes);
                let mut shorter: Vec<Operation<'_>> = Vec::with_capacity(whole + 1);
                for operation in before {
                    shorter.push(match operation {
                        Operation::Write(bytes) => Operation::Write(bytes),
                        Operation::Read(buffer) => Operation::Read(buffer),
                    });
                }
                shorter.push(Operation::Write(cut));
                self.bus.transaction(address, &mut shorter)
            }
            _ if before.is_empty() => Ok(()),
            _ => self.bus.transaction(address, before),
        }
    }
}

fn length(operation: &Operation<'_>) -> usize {
    match operation {
        Operation::Write(bytes) => bytes.len(),
        Operation::Read(buffer) => buffer.len(),
    }
}

impl<I: I2c> ErrorType for I2cFault<I> {
    type Error = FaultError<I::Error>;
}

impl<I: I2c + HoldClock> I2c for I2cFault<I> {
    fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), Self::Error> {
        self.transactions += 1;
        let Some(kind) = self.throw() else {
            return (self.bus.transaction(address, operations)).map_err(FaultError::Bus);
        };
        self.counts[kind as usize] += 1;
        match kind {
            I2cFaultKind::AddressNack | I2cFaultKind::ArbitrationLoss | I2cFaultKind::StuckBus => {}
            I2cFaultKind::DataNack => {
                self.torn(address, operations).map_err(FaultError::Bus)?;
            }
            I2cFaultKind::Eio => {
                (self.bus.transaction(address, operations)).map_err(FaultError::Bus)?;
            }
            I2cFaultKind::LongStretch => {
                self.bus.hold_clock_ns(self.faults.stretch_ns);
                return (self.bus.transaction(address, operations)).map_err(FaultError::Bus);
            }
        }
        Err(FaultError::Injected(kind))
    }
}

/// A layer that a driver and the script of its faults share.
#[derive(Debug)]
pub struct Shared<I>(Arc<Mutex<I2cFault<I>>>);

impl<I> Clone for Shared<I> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<I> Shared<I> {
    /// Takes the layer in.
    pub fn new(layer: I2cFault<I>) -> Self {
        Self(Arc::new(Mutex::new(layer)))
    }

    /// Looks at the layer or changes its faults. `work` must not use this layer: it would wait for itself.
    pub fn with<T>(&self, work: impl FnOnce(&mut I2cFault<I>) -> T) -> T {
        work(&mut self.lock())
    }

    fn lock(&self) -> MutexGuard<'_, I2cFault<I>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<I: I2c> ErrorType for Shared<I> {
    type Error = FaultError<I::Error>;
}

impl<I: I2c + HoldClock> I2c for Shared<I> {
    fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), Self::Error> {
        self.lock().transaction(address, operations)
    }
}
