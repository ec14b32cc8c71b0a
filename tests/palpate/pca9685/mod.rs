//! The PCA9685 as its bus and its pins show it: a test a line of the conformance table in
//! `docs/pca9685.md`, the known defects of published drivers, and a state machine against a second model.

#![cfg(test)] // helpers may unwrap too
#![expect(
    clippy::float_cmp,
    reason = "quotients of whole nanoseconds that are exact in binary"
)]

mod addresses;
mod benches;
mod bus_time;
mod clients;
mod conformance;
mod faults;
mod outputs;
mod pins;
mod prescale;
mod reference;
mod registers;
mod served;
mod sleep;
mod state_machine;
mod time;
mod updates;

pub use conformance::agree;

use embedded_hal::i2c::{I2c, Operation};
use palpate_core::codec::pca9685 as map;
use palpate_core::units::Channel;
use palpate_emulators::display::i2c::{Adjacent, BusClock, Error, I2cHandle, I2cSegment};
use palpate_emulators::display::pca9685::{Config, Edge, Oscillator, Pca9685, Pin, UpdateModel};
use palpate_emulators::time::Nanos;

/// One nominal tick and period at PRE = 30.
const TICK: u64 = 1_240;
const PERIOD: u64 = 5_079_040;
const ADDRESS: u8 = 0x40;

/// A segment with one or more chips and what came out of them.
struct Bench {
    bus: I2cHandle,
    /// Edges so far, all chips: (chip, edge).
    edges: Vec<(usize, Edge)>,
}

impl Bench {
    fn new(chips: &[Config]) -> Self {
        Self::over(I2cSegment::new(
            BusClock::Fast,
            chips.iter().map(|&c| Pca9685::new(c)).collect(),
        ))
    }

    fn over(mut segment: I2cSegment) -> Self {
        segment.keep_log(1000);
        Self {
            bus: I2cHandle::new(segment),
            edges: Vec::new(),
        }
    }

    fn one() -> Self {
        Self::new(&[Config::new(ADDRESS)])
    }

    fn with_updates(updates: UpdateModel) -> Self {
        let mut config = Config::new(ADDRESS);
        config.updates = updates;
        Self::new(&[config])
    }

    fn with_oscillator(oscillator: Oscillator) -> Self {
        let mut config = Config::new(ADDRESS);
        config.oscillator = oscillator;
        Self::new(&[config])
    }

    /// A bus as linux-embedded-hal puts its traffic on it.
    fn linux(config: Config) -> Self {
        let segment = I2cSegment::new(BusClock::Fast, vec![Pca9685::new(config)]);
        Self::over(segment.with_adjacent(Adjacent::RepeatedStart))
    }

    /// Awake with auto-increment, all-call on, oscillator stable.
    fn awake() -> Self {
        let mut bench = Self::one();
        bench.wake();
        bench
    }

    fn wake(&mut self) {
        self.write(&[map::MODE1, map::mode1::AI | map::mode1::ALLCALL]);
        self.wait_us(500);
    }

    fn try_write(&mut self, address: u8, bytes: &[u8]) -> Result<(), Error> {
        let result = self.bus.write(address, bytes);
        self.collect();
        result
    }

    fn write(&mut self, bytes: &[u8]) {
        self.try_write(ADDRESS, bytes).unwrap();
    }

    /// ON and OFF of one channel in one transaction, bit 12 as full.
    fn channel(&mut self, n: u8, on: u16, off: u16) {
        let ([a, b], [c, d]) = (on.to_le_bytes(), off.to_le_bytes());
        self.write(&[map::led(n), a, b, c, d]);
    }

    fn read(&mut self, register: u8) -> u8 {
        let mut byte = [0];
        self.bus
            .write_read(ADDRESS, &[register], &mut byte)
            .unwrap();
        self.collect();
        byte[0]
    }

    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Error> {
        let result = self.bus.transaction(address, operations);
        self.collect();
        result
    }

    fn now(&self) -> u64 {
        self.bus.with(|s| s.now().0).unwrap()
    }

    fn wait_ns(&mut self, ns: u64) {
        self.bus.with(|s| s.set_now(s.now() + Nanos(ns))).unwrap();
        self.collect();
    }

    fn wait_us(&mut self, us: u64) {
        self.wait_ns(us * 1000);
    }

    fn collect(&mut self) {
        let edges = &mut self.edges;
        self.bus
            .with(|s| s.advance(s.now(), &mut |n, edge| edges.push((n, edge))))
            .unwrap();
    }

    /// Touches chip 0, or looks at it, at the present time.
    fn chip<T>(&mut self, work: impl FnOnce(&mut Pca9685, Nanos) -> T) -> T {
        let result = self
            .bus
            .with(|s| {
                let now = s.now();
                work(&mut s.chips_mut()[0], now)
            })
            .unwrap();
        self.collect();
        result
    }

    fn pin(&mut self, channel: u8) -> Pin {
        self.chip(|chip, _| chip.pin(Channel(channel)))
    }

    /// The edges of one channel of chip 0 since the last call of this or of `forget`: (ns, high).
    fn take(&mut self, channel: u8) -> Vec<(u64, bool)> {
        let taken = (self.edges.iter())
            .filter(|(n, e)| *n == 0 && e.channel == Channel(channel))
            .map(|(_, e)| (e.at.0, e.pin == Pin::High))
            .collect();
        self.edges.clear();
        taken
    }

    fn forget(&mut self) {
        self.edges.clear();
    }

    /// Lets `ns` pass and says what fraction of it the channel was high.
    fn duty(&mut self, channel: u8, ns: u64) -> f64 {
        self.collect();
        self.forget();
        let (mut since, mut high) = (self.now(), self.pin(channel) == Pin::High);
        let end = since + ns;
        self.wait_ns(ns);
        let mut sum = 0;
        for (at, is) in self.take(channel) {
            sum += if high { at - since } else { 0 };
            (since, high) = (at, is);
        }
        sum += if high { end - since } else { 0 };
        sum as f64 / ns as f64
    }
}
