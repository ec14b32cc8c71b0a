//! A network in virtual time: delay, jitter, loss, doubling, cuts, and two clocks.

use std::collections::BTreeMap;

use palpate_core::units::Instant;
use palpate_link::judge::{Gate, Head, Patience};

/// A small generator, so that a failing case is one number.
#[derive(Clone, Debug)]
pub struct Dice(pub u64);

impl Dice {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    pub fn below(&mut self, n: u64) -> u64 {
        self.next() % n.max(1)
    }
    pub fn chance(&mut self, permille: u64) -> bool {
        self.below(1000) < permille
    }
}

/// What a network does.
#[derive(Clone, Copy, Debug)]
pub struct Weather {
    pub there_us: u64,
    pub back_us: u64,
    pub jitter_us: u64,
    pub loss: u64,
    pub double: u64,
    /// Whether what a cut holds comes all at once when it heals, as from a kernel's buffer.
    pub holds: bool,
    /// Robot's clock against ours: ahead by so much, and faster by so many millionths.
    pub ahead_us: u64,
    pub fast_ppm: i64,
}

/// What is on its way: of a frame its head, what it carries, and the true time of its reading.
#[derive(Clone, Debug)]
pub enum Message<T> {
    Frame(Head, T, u64),
    Beat(u64),
    Echo(u64, u64),
}

/// A network and the clocks at its ends; ours is the true one.
pub struct World<T> {
    pub weather: Weather,
    pub dice: Dice,
    /// What arrives, by time and a number that keeps the order.
    flying: BTreeMap<(u64, u64), Message<T>>,
    /// When links are cut.
    cuts: Vec<(u64, u64)>,
    count: u64,
}

impl<T: Clone> World<T> {
    pub fn new(weather: Weather, cuts: Vec<(u64, u64)>, seed: u64) -> Self {
        Self {
            weather,
            dice: Dice(seed),
            flying: BTreeMap::new(),
            cuts,
            count: 0,
        }
    }

    /// When the next message arrives.
    pub fn next(&self) -> u64 {
        self.flying.keys().next().map_or(u64::MAX, |k| k.0)
    }

    /// What has arrived by `now`, with its time.
    pub fn take(&mut self, now: u64) -> Option<(u64, Message<T>)> {
        if self.next() > now {
            return None;
        }
        self.flying
            .pop_first()
            .map(|((at, _), message)| (at, message))
    }

    /// A publisher's clock.
    pub fn robot(&self, t: u64) -> u64 {
        let drift = t as i64 * self.weather.fast_ppm / 1_000_000;
        (t + self.weather.ahead_us).saturating_add_signed(drift)
    }

    fn cut_at(&self, t: u64) -> Option<u64> {
        self.cuts
            .iter()
            .find(|(from, to)| (*from..*to).contains(&t))
            .map(|c| c.1)
    }

    /// Sends something that takes `delay` and jitter.
    pub fn send(&mut self, now: u64, delay: u64, message: &Message<T>) {
        let copies = 1 + u64::from(self.dice.chance(self.weather.double));
        for _ in 0..copies {
            if self.dice.chance(self.weather.loss) {
                continue;
            }
            let at = now + delay + self.dice.below(self.weather.jitter_us);
            let at = match self.cut_at(now) {
                None => at,
                Some(healed) if self.weather.holds => at.max(healed + 200 + self.dice.below(3000)),
                Some(_) => continue,
            };
            self.count += 1;
            self.flying.insert((at, self.count), message.clone());
        }
    }
}

/// What the gate let through: true time of the reading, time that the gate says, when.
pub struct Passed {
    pub taken: u64,
    pub at: u64,
    pub now: u64,
}

pub const LAYOUT: u64 = 7;

/// A publisher of a frame every 10 ms and a wearer behind a network; what the wearer's gate let through.
pub fn frames(weather: Weather, cuts: Vec<(u64, u64)>, length_us: u64, seed: u64) -> Vec<Passed> {
    let mut world = World::new(weather, cuts, seed);
    let mut gate = Gate::new(Patience::new(1, LAYOUT));
    let (mut passed, mut next_frame, mut next_beat, mut sequence) = (Vec::new(), 5000, 1000, 0);
    loop {
        let now = world.next().min(next_frame).min(next_beat);
        if now > length_us {
            return passed;
        }
        if now == next_frame {
            next_frame += 10_000;
            sequence += 1;
            let head = head(&world, sequence, now, now - 1000);
            world.send(now, weather.there_us, &Message::Frame(head, (), now - 1000));
        } else if now == next_beat {
            next_beat += beat(&gate, now);
            world.send(now, weather.back_us, &Message::Beat(now));
        } else if let Some((now, message)) = world.take(now)
            && let Some((head, (), taken)) = deliver(&mut world, &mut gate, now, message)
            && let Ok(at) = gate.judge(&head, Instant::from_micros(now))
        {
            passed.push(Passed {
                taken,
                at: at.as_micros(),
                now,
            });
        }
    }
}

/// The head of a frame that is sent at `now`, read at `taken`.
pub fn head<T: Clone>(world: &World<T>, sequence: u64, now: u64, taken: u64) -> Head {
    Head {
        version: 1,
        session: 3,
        sequence,
        sent_us: world.robot(now),
        taken_us: world.robot(taken),
        layout: LAYOUT,
    }
}

/// From one beat of a wearer to the next, as `palpate-link display` has it.
pub fn beat(gate: &Gate, now: u64) -> u64 {
    match gate.offset(Instant::from_micros(now)) {
        Some(_) => 100_000,
        None => 20_000,
    }
}

/// Beats are answered, answers heard; a frame is handed on.
pub fn deliver<T: Clone>(
    world: &mut World<T>,
    gate: &mut Gate,
    now: u64,
    message: Message<T>,
) -> Option<(Head, T, u64)> {
    match message {
        Message::Frame(head, what, taken) => return Some((head, what, taken)),
        Message::Beat(said) => {
            let heard = world.robot(now);
            let there = world.weather.there_us;
            world.send(now, there, &Message::Echo(said, heard));
        }
        Message::Echo(said, heard) => {
            gate.echoed(
                3,
                Instant::from_micros(said),
                heard,
                Instant::from_micros(now),
            );
        }
    }
    None
}
