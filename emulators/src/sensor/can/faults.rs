//! Faults between a sensor bus and its reader, as a layer over any [`CanBus`]; layers stack.
//!
//! Random faults hit frame by frame, each kind with its own stream, so that switching one on leaves the
//! others' draws alone. Rules hit identifiers: a dead SDA line, a frozen or a zero taxel. All are counted.

use std::collections::{BTreeMap, VecDeque};

use palpate_core::bus::{CanBus, Received};
use palpate_core::codec::can::CanFrame;
use palpate_core::random::RandomStream;
use palpate_core::units::Duration;

/// Probabilities per frame, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates {
    /// Lost.
    pub lost: f64,
    /// Received twice.
    pub duplicated: f64,
    /// Received late by [`Self::late_by`], after newer frames.
    pub late: f64,
    /// Delay of late frames.
    pub late_by: Duration,
    /// One bit of the data turned over (a fault behind the controller: the CRC cannot see it).
    pub corrupted: f64,
    /// Cut short by one to eight bytes.
    pub short: f64,
}

/// Effect on the frames of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Effect {
    /// The frames never arrive: a dead taxel, SDA line (mask 0x700) or board (mask 0x00F).
    Silent,
    /// The data of the first one, for ever.
    Frozen,
    /// Zero triplets: bytes 1 to 6.
    Zero,
}

/// An effect on some identifiers, as SocketCAN filters say it: `id & mask == rule.id & mask`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Rule {
    /// The bus; `None`: every bus.
    pub bus: Option<u8>,
    /// Identifier.
    pub id: u16,
    /// Bits of the identifier that count.
    pub mask: u16,
    /// Effect on the frames.
    pub effect: Effect,
}

impl Rule {
    /// Tells whether a frame is one of the rule's.
    pub fn hits(&self, bus: u8, id: u16) -> bool {
        self.bus.is_none_or(|mine| mine == bus) && id & self.mask == self.id & self.mask
    }
}

/// Number of frames that each fault hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Lost at random.
    pub lost: u64,
    /// Received twice.
    pub duplicated: u64,
    /// Received late.
    pub late: u64,
    /// One bit turned over.
    pub corrupted: u64,
    /// Cut short.
    pub short: u64,
    /// Kept back by a rule.
    pub silent: u64,
    /// Given old data by a rule.
    pub frozen: u64,
    /// Given zeros by a rule.
    pub zero: u64,
}

/// A bus behind which frames suffer.
pub struct Faulty<B> {
    inner: B,
    rates: Rates,
    rules: Vec<Rule>,
    streams: [RandomStream; 5],
    frozen: BTreeMap<(u8, u16), CanFrame>,
    /// Frames on their way, oldest first, and those held back.
    ready: VecDeque<Received>,
    held: VecDeque<Received>,
    counts: Counts,
}

impl<B: CanBus> Faulty<B> {
    /// A layer over `inner` with no fault yet. `name` tells stacked layers' streams apart.
    pub fn new(inner: B, seed: u64, name: &str) -> Self {
        let kinds = ["lost", "duplicated", "late", "corrupted", "short"];
        Self {
            inner,
            rates: Rates::default(),
            rules: Vec::new(),
            streams: kinds.map(|kind| RandomStream::new(seed, &format!("{name} {kind}"))),
            frozen: BTreeMap::new(),
            ready: VecDeque::new(),
            held: VecDeque::new(),
            counts: Counts::default(),
        }
    }

    /// Sets the random faults from now on.
    pub const fn set_rates(&mut self, rates: Rates) {
        self.rates = rates;
    }

    /// Sets the rules from now on; a frame that no rule freezes any more thaws.
    pub fn set_rules(&mut self, rules: Vec<Rule>) {
        self.frozen.retain(|&(bus, id), _| {
            let freezes = |r: &Rule| r.effect == Effect::Frozen && r.hits(bus, id);
            rules.iter().any(freezes)
        });
        self.rules = rules;
    }

    /// Number of frames that each fault hit so far.
    pub const fn counts(&self) -> Counts {
        self.counts
    }

    /// The bus behind the layer.
    pub const fn inner(&self) -> &B {
        &self.inner
    }

    /// The bus behind the layer, to disturb it.
    pub const fn inner_mut(&mut self) -> &mut B {
        &mut self.inner
    }

    fn strikes(&mut self, kind: usize, rate: f64) -> bool {
        rate > 0.0 && self.streams[kind].uniform() < rate
    }

    /// Applies rules and random faults to a frame that arrived.
    fn pass(&mut self, mut received: Received) {
        for n in 0..self.rules.len() {
            let rule = self.rules[n];
            let hit = rule.hits(received.bus, received.frame.id());
            match rule.effect {
                _ if !hit => {}
                Effect::Silent => {
                    self.counts.silent += 1;
                    return;
                }
                Effect::Frozen => {
                    let key = (received.bus, received.frame.id());
                    received.frame = *self.frozen.entry(key).or_insert(received.frame);
                    self.counts.frozen += 1;
                }
                Effect::Zero => {
                    received.frame = edit(&received.frame, |data| {
                        data.iter_mut().skip(1).take(6).for_each(|byte| *byte = 0);
                    });
                    self.counts.zero += 1;
                }
            }
        }
        if self.strikes(0, self.rates.lost) {
            self.counts.lost += 1;
            return;
        }
        if self.strikes(3, self.rates.corrupted) {
            let bit = self.streams[3].next_u64() as usize;
            received.frame = edit(&received.frame, |data| {
                let bits = (8 * data.len()).max(1);
                if let Some(byte) = data.get_mut(bit % bits / 8) {
                    *byte ^= 1 << (bit % 8);
                }
            });
            self.counts.corrupted += 1;
        }
        if self.strikes(4, self.rates.short) {
            let cut = 1 + (self.streams[4].next_u64() % 8) as usize;
            let (id, data) = (received.frame.id(), received.frame.data());
            let kept = data
                .get(..data.len().saturating_sub(cut))
                .unwrap_or_default();
            received.frame = CanFrame::new(id, kept).unwrap_or(received.frame);
            self.counts.short += 1;
        }
        if self.strikes(2, self.rates.late) {
            received.at += self.rates.late_by;
            self.held.push_back(received);
            self.counts.late += 1;
            return;
        }
        self.ready.push_back(received);
        if self.strikes(1, self.rates.duplicated) {
            self.ready.push_back(received);
            self.counts.duplicated += 1;
        }
    }
}

fn edit(frame: &CanFrame, change: impl FnOnce(&mut [u8])) -> CanFrame {
    let mut bytes = [0; 8];
    let length = frame.data().len();
    bytes[..length].copy_from_slice(frame.data());
    change(&mut bytes[..length]);
    CanFrame::new(frame.id(), &bytes[..length]).unwrap_or(*frame)
}

impl<B: CanBus> CanBus for Faulty<B> {
    type Error = B::Error;

    fn receive(&mut self) -> Result<Option<Received>, B::Error> {
        loop {
            if let Some(received) = self.ready.pop_front() {
                return Ok(Some(received));
            }
            let Some(received) = self.inner.receive()? else {
                return Ok(None);
            };
            // Late frames come in before the first newer one.
            while self.held.front().is_some_and(|held| held.at <= received.at) {
                self.ready.extend(self.held.pop_front());
            }
            self.pass(received);
        }
    }

    fn transmit(&mut self, bus: u8, frame: &CanFrame) -> Result<(), B::Error> {
        self.inner.transmit(bus, frame)
    }
}

#[cfg(test)]
#[path = "faults_tests.rs"]
mod tests;
