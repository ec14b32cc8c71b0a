//! One PWM channel: four registers, what they mean, and what is in force (data sheet 7.3.3).

use palpate_core::codec::pca9685::FULL;

use super::UpdateModel;
use super::clock::PERIOD;

/// ON_L, ON_H, OFF_L, OFF_H after reset: full off.
pub(super) const RESET: [u8; 4] = [0, 0, 0, FULL];

/// Pulse that four registers ask for: full off > full on > compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pulse {
    FullOff,
    /// A channel that is on for good, starting at count `on`.
    FullOn {
        on: u16,
    },
    Pwm {
        on: u16,
        off: u16,
    },
}

impl Pulse {
    pub(super) fn decode(r: [u8; 4]) -> Self {
        let on = u16::from_le_bytes([r[0], r[1] & 0x0F]);
        let off = u16::from_le_bytes([r[2], r[3] & 0x0F]);
        if r[3] & FULL != 0 {
            Self::FullOff
        } else if r[1] & FULL != 0 {
            Self::FullOn { on }
        } else {
            Self::Pwm { on, off }
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Channel {
    /// Registers as the bus wrote and reads them.
    pub(super) registers: [u8; 4],
    /// Registers written since the last commit, a bit each.
    pub(super) written: u8,
    /// The registers as of the last STOP or fourth ACK.
    committed: Pulse,
    /// Pulse that the comparator works with.
    force: Pulse,
    /// An update waits for the end of the low part of the cycle.
    pending: bool,
    /// True in the blank period that an update of a wrapping pulse costs.
    blank: bool,
    /// Full on has reached its ON count.
    started: bool,
}

impl Channel {
    pub(super) fn new() -> Self {
        Self {
            registers: RESET,
            written: 0,
            committed: Pulse::FullOff,
            force: Pulse::FullOff,
            pending: false,
            blank: false,
            started: false,
        }
    }

    /// Takes the registers over (STOP, or the fourth ACK).
    pub(super) fn commit(&mut self) {
        self.committed = Pulse::decode(self.registers);
        self.written = 0;
    }

    /// An update reaches a running counter at `count`.
    pub(super) fn update(&mut self, model: UpdateModel, count: u16) {
        match model {
            UpdateModel::EndOfLow => self.pending = true,
            UpdateModel::Immediate => {
                self.pending = false;
                self.load(count);
            }
        }
    }

    /// The counter starts from zero with what is committed.
    pub(super) fn start(&mut self) {
        self.pending = false;
        self.blank = false;
        self.started = false;
        self.load(0);
    }

    /// The end of a cycle: what was low takes its update. A wrapping pulse is high here, so it is
    /// switched off for one whole period first.
    pub(super) fn wrap(&mut self) {
        if self.blank {
            self.blank = false;
        } else if self.pending && matches!(self.force, Pulse::Pwm { on, off } if on > off) {
            self.blank = true;
            return;
        }
        if self.pending {
            self.pending = false;
            self.load(0);
        }
    }

    fn load(&mut self, count: u16) {
        let was = self.force;
        self.force = self.committed;
        self.started = match (was, self.force) {
            (Pulse::FullOn { .. }, Pulse::FullOn { on }) => self.started || on == count,
            (_, Pulse::FullOn { on }) => on == count,
            _ => false,
        };
    }

    /// The counter has come to `count`; returns the level from here on.
    pub(super) fn level(&self, count: u16) -> bool {
        if self.blank {
            return false;
        }
        match self.force {
            Pulse::FullOff => false,
            Pulse::FullOn { .. } => self.started,
            Pulse::Pwm { on, off } if on < off => on <= count && count < off,
            Pulse::Pwm { on, off } if on > off => count >= on || count < off,
            Pulse::Pwm { .. } => false,
        }
    }

    /// Full on starts when the counter comes to ON.
    pub(super) fn reach(&mut self, count: u16) {
        if matches!(self.force, Pulse::FullOn { on } if on == count) && !self.blank {
            self.started = true;
        }
    }

    /// The first tick after `tick` at which this channel needs a look.
    pub(super) fn next_tick(&self, tick: u64) -> Option<u64> {
        let wrap = || next(tick, 0);
        if self.blank {
            return Some(wrap());
        }
        let own = match self.force {
            Pulse::FullOff => None,
            Pulse::FullOn { on } => (!self.started).then(|| next(tick, on)),
            Pulse::Pwm { on, off } if on != off => Some(next(tick, on).min(next(tick, off))),
            Pulse::Pwm { .. } => None,
        };
        if self.pending {
            Some(own.map_or_else(wrap, |t| t.min(wrap())))
        } else {
            own
        }
    }

    /// Returns true if full off alone is in force and to come: the counter may be held (data sheet 7.3.3, remark).
    pub(super) fn is_off(&self) -> bool {
        self.force == Pulse::FullOff && !self.pending && !self.blank
    }

    /// The committed registers ask for something else than full off.
    pub(super) fn wants_on(&self) -> bool {
        self.committed != Pulse::FullOff
    }
}

/// The first tick after `tick` at which the 12-bit counter shows `count`.
fn next(tick: u64, count: u16) -> u64 {
    let ahead = (u64::from(count) + PERIOD - tick % PERIOD) % PERIOD;
    tick.saturating_add(if ahead == 0 { PERIOD } else { ahead })
}
