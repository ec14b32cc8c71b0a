//! An I2C segment: several PCA9685, DAC7578 and haptic drivers on one pair of wires, one bus clock, virtual time.
//!
//! A transaction starts at [`I2cSegment::now`] and takes a bit time each for START, repeated START and STOP and
//! nine for a byte. Every byte reaches the chips at the instant of its ACK and the STOP at its end, so what
//! a torn or slow update does to a wire is seen where it happens. The bus-free time between a STOP and the
//! next START is not charged: it is what the controller makes of it.
//!
//! The owner of time moves the segment with [`I2cSegment::set_now`]; [`I2cHandle`] is the `embedded_hal` face.
//! [`fault::I2cFault`] stands in front of either.

mod error;
pub mod fault;
mod handle;
mod target;

use std::collections::VecDeque;

use embedded_hal::i2c::Operation;

use crate::display::dac7578::{Dac7578, Level};
use crate::display::pca9685::{Edge, Pca9685};
use crate::haptic::drv2605::Drv2605;
use crate::haptic::tca9548a::Tca9548a;
use crate::time::Nanos;
pub use error::Error;
pub use handle::{I2cHandle, immediate};
use target::Target;

/// The bus clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BusClock {
    /// Standard mode, 100 kbit/s.
    Standard,
    /// Fast mode, 400 kbit/s.
    #[default]
    Fast,
    /// Fast mode plus, 1 Mbit/s: the PCA9685's fastest.
    FastPlus,
}

impl BusClock {
    /// Length of a bit.
    pub const fn bit(self) -> Nanos {
        Nanos(match self {
            Self::Standard => 10_000,
            Self::Fast => 2_500,
            Self::FastPlus => 1_000,
        })
    }

    /// Length of a transaction with one message of `bytes` bytes after the address.
    pub const fn write_time(self, bytes: u64) -> Nanos {
        Nanos(self.bit().0.saturating_mul(2 + 9 * (1 + bytes)))
    }
}

/// Treatment of neighbouring operations in the same direction by the adapter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Adjacent {
    /// One message without a START between, as embedded-hal wants it (I2C_M_NOSTART).
    #[default]
    Merge,
    /// A message each with a repeated START between, which is what linux-embedded-hal's traffic looks like:
    /// the first byte of the second message is a control byte to the chip.
    RepeatedStart,
    /// EOPNOTSUPP: the adapter lacks I2C_M_NOSTART and its driver says so.
    Refuse,
}

/// One message of a recorded transaction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct I2cMessage {
    /// The 7-bit address.
    pub address: u8,
    /// Direction: from the chip.
    pub read: bool,
    /// Data bytes that crossed the bus, without the address; the last one may have been refused.
    pub bytes: Vec<u8>,
}

/// A recorded transaction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Transaction {
    /// START.
    pub start: Nanos,
    /// End of the STOP.
    pub end: Nanos,
    /// Messages that crossed the bus.
    pub messages: Vec<I2cMessage>,
    /// Outcome of the transaction.
    pub result: Result<(), Error>,
}

/// Longest clock stretch that the adapter bears per byte: 25 ms, as SMBus has it.
const STRETCH_LIMIT: Nanos = Nanos::from_micros(25_000);

/// Several chips on one bus.
#[derive(Debug)]
pub struct I2cSegment {
    clock: BusClock,
    adjacent: Adjacent,
    now: Nanos,
    chips: Vec<Pca9685>,
    converters: Vec<Dac7578>,
    muxes: Vec<Tca9548a>,
    haptics: Vec<Drv2605>,
    /// Devices that took part since the last STOP, in the order of [`Self::targets`].
    involved: Vec<bool>,
    /// SCL is held low for so long before the next byte.
    held: Nanos,
    log: VecDeque<Transaction>,
    log_capacity: usize,
    transactions: u64,
    busy: Nanos,
}

impl I2cSegment {
    /// A bus at `clock` with these chips; no log.
    pub fn new(clock: BusClock, chips: Vec<Pca9685>) -> Self {
        Self {
            clock,
            adjacent: Adjacent::default(),
            now: Nanos::ZERO,
            involved: vec![false; chips.len()],
            chips,
            converters: Vec::new(),
            muxes: Vec::new(),
            haptics: Vec::new(),
            held: Nanos::ZERO,
            log: VecDeque::new(),
            log_capacity: 0,
            transactions: 0,
            busy: Nanos::ZERO,
        }
    }

    /// Sets the treatment of neighbouring operations in the same direction.
    pub fn with_adjacent(mut self, adjacent: Adjacent) -> Self {
        self.adjacent = adjacent;
        self
    }

    /// Puts these converters beside the chips.
    pub fn with_converters(mut self, converters: Vec<Dac7578>) -> Self {
        self.converters = converters;
        self.with_all_at_rest()
    }

    /// Puts these multiplexers, with what is behind them, and these haptic drivers beside the chips.
    pub fn with_haptics(mut self, muxes: Vec<Tca9548a>, drivers: Vec<Drv2605>) -> Self {
        (self.muxes, self.haptics) = (muxes, drivers);
        self.with_all_at_rest()
    }

    fn with_all_at_rest(mut self) -> Self {
        let devices = [self.chips.len(), self.converters.len(), self.muxes.len()];
        let count = devices.iter().sum::<usize>() + self.haptics.len();
        self.involved = vec![false; count];
        self
    }

    /// Keeps the last `capacity` transactions from now on, for [`I2cSegment::take_log`].
    pub const fn keep_log(&mut self, capacity: usize) {
        self.log_capacity = capacity;
    }

    /// Start of the next transaction, never before the last one's end.
    pub const fn now(&self) -> Nanos {
        self.now
    }

    /// Moves time forward; a time in the past changes nothing.
    pub fn set_now(&mut self, now: Nanos) {
        self.now = self.now.max(now);
    }

    /// The bus clock.
    pub const fn clock(&self) -> BusClock {
        self.clock
    }

    /// The chips, for their physical face. Hand them times up to [`I2cSegment::now`].
    pub fn chips(&self) -> &[Pca9685] {
        &self.chips
    }

    /// Lets time pass until `to` and hands `sink` every edge of an output since the last call, with the number of its
    /// chip: chip by chip, each in order of time.
    pub fn advance(&mut self, to: Nanos, sink: &mut impl FnMut(usize, Edge)) {
        self.set_now(to);
        for (number, chip) in self.chips.iter_mut().enumerate() {
            // A transaction may have carried a chip beyond `to`.
            let until = to.max(chip.now());
            chip.advance(until, &mut |edge| sink(number, edge));
        }
        let until = self.now;
        self.muxes.iter_mut().for_each(|mux| mux.advance(until));
        self.haptics.iter_mut().for_each(|chip| chip.advance(until));
    }

    /// The chips, to touch them.
    pub fn chips_mut(&mut self) -> &mut [Pca9685] {
        &mut self.chips
    }

    /// The converters, to touch them.
    pub fn converters_mut(&mut self) -> &mut [Dac7578] {
        &mut self.converters
    }

    /// The multiplexers, with what is behind them, to touch them.
    pub fn muxes_mut(&mut self) -> &mut [Tca9548a] {
        &mut self.muxes
    }

    /// The haptic drivers that no multiplexer is before, to touch them.
    pub fn haptics_mut(&mut self) -> &mut [Drv2605] {
        &mut self.haptics
    }

    /// Hands `sink` every change of a converter's output until `to` that was not handed over yet, with the number of its
    /// converter: converter by converter, each in order of time.
    pub(crate) fn take_levels(&mut self, to: Nanos, sink: &mut impl FnMut(usize, Level)) {
        for (number, converter) in self.converters.iter_mut().enumerate() {
            converter.take_levels(to, &mut |level| sink(number, level));
        }
    }

    /// Chips and converters on the bus, and whether each took part since the last STOP.
    fn targets(&mut self) -> impl Iterator<Item = (&mut dyn Target, &mut bool)> {
        let chips = self.chips.iter_mut().map(|chip| chip as &mut dyn Target);
        let converters = self.converters.iter_mut().map(|c| c as &mut dyn Target);
        let muxes = self.muxes.iter_mut().map(|mux| mux as &mut dyn Target);
        let haptics = self.haptics.iter_mut().map(|h| h as &mut dyn Target);
        let all = chips.chain(converters).chain(muxes).chain(haptics);
        all.zip(&mut self.involved)
    }

    /// A device holds SCL low for `span` before the next byte is through.
    pub fn hold_clock(&mut self, span: Nanos) {
        self.held = self.held + span;
    }

    /// Transactions so far, failed ones too.
    pub const fn transactions(&self) -> u64 {
        self.transactions
    }

    /// Time during which the bus was taken.
    pub const fn busy(&self) -> Nanos {
        self.busy
    }

    /// The recorded transactions since the last call, oldest first.
    pub fn take_log(&mut self) -> Vec<Transaction> {
        self.log.drain(..).collect()
    }

    /// One transaction with one address, from START to STOP. On an error the adapter sends STOP at once:
    /// bytes already acknowledged have had their effect.
    pub fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), Error> {
        if self.adjacent == Adjacent::Refuse && has_neighbours(operations) {
            return Err(Error::Unsupported);
        }
        let merge = self.adjacent == Adjacent::Merge;
        let mut before = None;
        self.whole(operations.iter_mut().map(|operation| {
            let read = matches!(operation, Operation::Read(_));
            let start = !(merge && before == Some(read));
            before = Some(read);
            (start.then_some(address), operation)
        }))
    }

    /// Messages to any addresses with a repeated START between and one STOP at the end, as Linux's I2C_RDWR
    /// sends them: boards prepared so change together.
    pub fn transfer(&mut self, messages: &mut [(u8, Operation<'_>)]) -> Result<(), Error> {
        self.whole(messages.iter_mut().map(|(address, o)| (Some(*address), o)))
    }

    /// Operations, with the address where a START comes before one.
    fn whole<'a, 'b: 'a>(
        &mut self,
        mut operations: impl ExactSizeIterator<Item = (Option<u8>, &'a mut Operation<'b>)>,
    ) -> Result<(), Error> {
        if operations.len() == 0 {
            return Ok(()); // embedded-hal: nothing on the bus
        }
        let start = self.now;
        let mut messages = Vec::new();
        let result = operations.try_for_each(|(address, operation)| {
            if let Some(address) = address {
                let read = matches!(operation, Operation::Read(_));
                messages.push(I2cMessage {
                    address,
                    read,
                    bytes: Vec::new(),
                });
                self.start(address, read)?;
            }
            self.operation(operation, &mut messages)
        });
        self.stop();
        self.transactions += 1;
        self.busy = self.busy + self.now.since(start);
        if self.log_capacity > 0 {
            if self.log.len() >= self.log_capacity {
                self.log.pop_front();
            }
            self.log.push_back(Transaction {
                start,
                end: self.now,
                messages,
                result,
            });
        }
        result
    }

    fn operation(
        &mut self,
        operation: &mut Operation<'_>,
        log: &mut [I2cMessage],
    ) -> Result<(), Error> {
        match operation {
            Operation::Read(buffer) => {
                for slot in buffer.iter_mut() {
                    *slot = self.read_byte()?;
                    record(log, *slot);
                }
            }
            Operation::Write(bytes) => {
                for &byte in *bytes {
                    record(log, byte);
                    self.write_byte(byte)?;
                }
            }
        }
        Ok(())
    }

    /// A START bit and the address byte.
    fn start(&mut self, address: u8, read: bool) -> Result<(), Error> {
        self.tick(1);
        self.byte()?;
        let (now, mut acknowledged) = (self.now, false);
        for (target, involved) in self.targets() {
            // A chip that is not meant still sees the START, which calls off its software reset.
            if *involved || target.answers(address, read) {
                *involved = true;
                acknowledged |= target.start(now, address, read);
            }
        }
        if acknowledged {
            Ok(())
        } else {
            Err(Error::AddressNack)
        }
    }

    fn write_byte(&mut self, byte: u8) -> Result<(), Error> {
        self.byte()?;
        let (now, mut acknowledged) = (self.now, false);
        for (target, _) in self.targets().filter(|t| *t.1) {
            acknowledged |= target.write(now, byte);
        }
        if acknowledged {
            Ok(())
        } else {
            Err(Error::DataNack)
        }
    }

    /// Reads are a wired AND of all chips that were addressed.
    fn read_byte(&mut self) -> Result<u8, Error> {
        self.byte()?;
        let now = self.now;
        let addressed = self.targets().filter(|t| *t.1);
        Ok(addressed.fold(0xFF, |byte, (target, _)| byte & target.read(now)))
    }

    fn stop(&mut self) {
        self.tick(1);
        let now = self.now;
        for (target, involved) in self.targets() {
            if std::mem::take(involved) {
                target.stop(now);
            }
        }
    }

    /// The time of eight bits and an acknowledge, and of a device that holds the clock.
    fn byte(&mut self) -> Result<(), Error> {
        let held = std::mem::take(&mut self.held);
        if held > STRETCH_LIMIT {
            self.now = self.now + STRETCH_LIMIT;
            return Err(Error::Timeout);
        }
        self.now = self.now + held;
        self.tick(9);
        Ok(())
    }

    fn tick(&mut self, bits: u64) {
        self.now = self.now + Nanos(self.clock.bit().0 * bits);
    }
}

fn record(log: &mut [I2cMessage], byte: u8) {
    if let Some(message) = log.last_mut() {
        message.bytes.push(byte);
    }
}

fn has_neighbours(operations: &[Operation<'_>]) -> bool {
    let is_read = |o: &Operation<'_>| matches!(o, Operation::Read(_));
    operations
        .windows(2)
        .any(|w| is_read(&w[0]) == is_read(&w[1]))
}
