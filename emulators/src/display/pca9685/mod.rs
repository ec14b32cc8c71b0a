//! A PCA9685 at register level, in virtual time: NXP data sheet rev. 4; section numbers in brackets.
//!
//! A pure state machine with three faces. The bus face ([`Pca9685::start`], [`Pca9685::write`],
//! [`Pca9685::read`], [`Pca9685::stop`]) is what a driver sees. The physical face moves OE, the supply and
//! the clock and reads the pins. [`Pca9685::advance`] gives the outputs as [`Edge`]s in integer nanoseconds,
//! computed when asked for: a chip at rest costs nothing. Fault layers stand in front of the segment.
//!
//! Files: `registers` (addresses and the register file), `power` (reset, sleep, restart, clock), `channel`
//! (one comparator), `clock` (exact tick times), `pins` (what a level becomes on a pin).
//! `docs/pca9685.md` names the test of each behaviour.

mod channel;
mod clock;
mod pins;
mod power;
mod registers;

use std::collections::VecDeque;

use palpate_core::codec::pca9685::{CHANNELS, PRE_SCALE_RESET, SUBADR_RESET, mode1, mode2};
use palpate_core::units::{Channel as ChannelId, Prescale};

use crate::time::Nanos;
use channel::Channel;
pub use clock::Oscillator;
use clock::{Counter, PERIOD};
pub use pins::{Edge, Hazard, Pin, pin};

/// Time at which a register update reaches a running output. Silicon decides; a bench procedure tells for a lot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpdateModel {
    /// An update at the end of the low part of the cycle [7.3.3]: the counter's wrap. With ON > OFF in force the
    /// output is high there, and each update costs one whole blank period, as logic-analyser traces show.
    #[default]
    EndOfLow,
    /// An update at once, in mid-period, as one scope shot shows.
    Immediate,
}

/// Properties that distinguish one chip from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// Own 7-bit address, 0x40 ..= 0x7F by the six address pins [7.1.1].
    pub address: u8,
    /// The internal oscillator of this chip.
    pub oscillator: Oscillator,
    /// Time at which updates reach running outputs.
    pub updates: UpdateModel,
}

impl Config {
    /// A nominal chip; of `address` the lower six bits count, as on the pins.
    pub const fn new(address: u8) -> Self {
        Self {
            address: 0x40 | (address & 0x3F),
            oscillator: Oscillator::NOMINAL,
            updates: UpdateModel::EndOfLow,
        }
    }
}

/// Hazards kept a chip; later ones are only counted.
const HAZARDS_KEPT: usize = 256;

/// One emulated chip.
#[derive(Clone, Debug)]
pub struct Pca9685 {
    config: Config,
    powered: bool,
    oe_high: bool,
    /// MODE1 without RESTART.
    mode1: u8,
    /// RESTART: outputs are paused [7.3.1.1].
    restart: bool,
    mode2: u8,
    /// SUBADR1..3, ALLCALLADR.
    addresses: [u8; 4],
    pre: u8,
    channels: [Channel; CHANNELS as usize],
    bus: registers::Bus,
    /// The running counter; `None` asleep, paused, held or starting.
    counter: Option<Counter>,
    /// The counter starts here unless something comes between.
    start_at: Option<Nanos>,
    /// SLEEP waits for the end of the cycle.
    stopping: bool,
    /// The oscillator is stable from here on.
    stable_at: Nanos,
    /// EXTCLK pin, millihertz; zero: no clock there.
    external: u64,
    now: Nanos,
    pins: [Pin; CHANNELS as usize],
    /// Edges that bus and physical actions passed and `advance` has not yet handed on.
    outbox: VecDeque<Edge>,
    hazards: Vec<(Nanos, Hazard)>,
    hazard_count: u64,
    oe_hazard: bool,
}

impl Pca9685 {
    /// A chip as it is after power-on at the start of the run.
    pub fn new(config: Config) -> Self {
        Self {
            config,
            powered: true,
            oe_high: false,
            mode1: mode1::RESET,
            restart: false,
            mode2: mode2::RESET,
            addresses: SUBADR_RESET,
            pre: PRE_SCALE_RESET,
            channels: std::array::from_fn(|_| Channel::new()),
            bus: registers::Bus::default(),
            counter: None,
            start_at: None,
            stopping: false,
            stable_at: Nanos::ZERO,
            external: 0,
            now: Nanos::ZERO,
            pins: [Pin::Low; CHANNELS as usize],
            outbox: VecDeque::new(),
            hazards: Vec::new(),
            hazard_count: 0,
            oe_hazard: false,
        }
    }

    /// Properties that distinguish this chip.
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// Time that this chip has reached.
    pub const fn now(&self) -> Nanos {
        self.now
    }

    /// Lets time pass up to and including `to` and hands every edge since the last call to `sink`, in order
    /// of time. Actions on the bus and on the pins let time pass too; their edges wait here until then.
    pub fn advance(&mut self, to: Nanos, sink: &mut dyn FnMut(Edge)) {
        while let Some(edge) = self.outbox.pop_front() {
            sink(edge);
        }
        self.run(to, sink);
    }

    /// The earliest time at which an output may change without a transfer or a pin: call `advance` then.
    /// `None` while nothing moves. May name a cycle's end at which nothing changes after all.
    pub fn next_event(&self) -> Option<Nanos> {
        if let Some(edge) = self.outbox.front() {
            return Some(edge.at);
        }
        match &self.counter {
            Some(counter) => self.next_tick(counter).and_then(|t| counter.time_of(t)),
            None => self.start_at,
        }
    }

    /// The state of an output pin now; [`Pin::HighZ`] for a channel that does not exist.
    pub fn pin(&self, channel: ChannelId) -> Pin {
        let pin = self.pins.get(usize::from(channel.0)).copied();
        pin.unwrap_or(Pin::HighZ)
    }

    /// States of all pins now.
    pub const fn pins(&self) -> [Pin; CHANNELS as usize] {
        self.pins
    }

    /// Tells whether the tick counter runs: not asleep, not paused, not held.
    pub const fn is_running(&self) -> bool {
        self.counter.is_some()
    }

    /// The value in the PRE_SCALE register.
    pub const fn prescale(&self) -> Prescale {
        Prescale::new(self.pre)
    }

    /// Uses of this chip that the data sheet forbids: the first 256, with times.
    pub fn hazards(&self) -> &[(Nanos, Hazard)] {
        &self.hazards
    }

    /// Number of all hazards so far.
    pub const fn hazard_count(&self) -> u64 {
        self.hazard_count
    }

    fn hazard(&mut self, hazard: Hazard) {
        self.hazard_count += 1;
        if self.hazards.len() < HAZARDS_KEPT {
            self.hazards.push((self.now, hazard));
        }
    }

    /// Lets time pass for an action; edges go to the outbox.
    fn act(&mut self, at: Nanos) {
        self.buffered(|chip, sink| chip.run(at, sink));
    }

    /// Puts what the channels and the mode say on the pins, now.
    fn settle(&mut self) {
        self.buffered(|chip, sink| chip.refresh(sink));
    }

    fn buffered(&mut self, work: impl FnOnce(&mut Self, &mut dyn FnMut(Edge))) {
        let mut outbox = std::mem::take(&mut self.outbox);
        work(self, &mut |edge| outbox.push_back(edge));
        self.outbox = outbox;
    }

    /// Processes everything up to and including `to`.
    fn run(&mut self, to: Nanos, sink: &mut dyn FnMut(Edge)) {
        loop {
            if let Some(counter) = &self.counter {
                let Some(tick) = self.next_tick(counter) else {
                    break;
                };
                let Some(at) = counter.time_of(tick).filter(|&at| at <= to) else {
                    break;
                };
                self.now = self.now.max(at);
                self.reach(tick);
            } else if let Some(at) = self.start_at.filter(|&at| at <= to) {
                self.now = self.now.max(at);
                self.start_counter();
            } else {
                break;
            }
            self.refresh(sink);
        }
        self.now = self.now.max(to);
        if let Some(counter) = &mut self.counter {
            counter.tick = counter.tick.max(counter.tick_at(self.now)); // nothing was due in between
        }
    }

    /// The next tick at which there is something to do.
    fn next_tick(&self, counter: &Counter) -> Option<u64> {
        let first = (self.channels.iter())
            .filter_map(|c| c.next_tick(counter.tick))
            .min();
        if self.stopping || (self.config.oscillator.drifts() && !self.on_external_clock()) {
            let wrap = (counter.tick / PERIOD + 1).saturating_mul(PERIOD);
            return Some(first.map_or(wrap, |t| t.min(wrap)));
        }
        first
    }

    /// The counter has come to `tick`.
    fn reach(&mut self, tick: u64) {
        let millihertz = self.millihertz();
        if let Some(counter) = &mut self.counter {
            counter.tick = tick;
            if tick.is_multiple_of(PERIOD) {
                counter.retune(self.now, millihertz);
                self.end_of_cycle();
            }
        }
        let count = count(tick);
        for channel in &mut self.channels {
            channel.reach(count);
        }
    }

    fn end_of_cycle(&mut self) {
        for channel in &mut self.channels {
            channel.wrap();
        }
        if self.stopping {
            self.stop_clock();
        } else if self.channels.iter().all(Channel::is_off) {
            self.counter = None; // held [7.3.3]
        }
    }

    fn refresh(&mut self, sink: &mut dyn FnMut(Edge)) {
        let count = self.counter.as_ref().map(|c| count(c.tick));
        for (n, (channel, was)) in (0u8..).zip(self.channels.iter().zip(&mut self.pins)) {
            let on = count.is_some_and(|count| channel.level(count));
            let is = if self.powered {
                pin(on, self.mode2, self.oe_high)
            } else {
                Pin::HighZ
            };
            if is != *was {
                *was = is;
                sink(Edge {
                    at: self.now,
                    channel: ChannelId(n),
                    pin: is,
                });
            }
        }
    }
}

/// Value of the 12-bit counter at a tick.
const fn count(tick: u64) -> u16 {
    (tick % PERIOD) as u16
}
