//! The hot pass: every wire heated once through its transformation, one after the other, while nothing else is felt.

use alloc::boxed::Box;
use alloc::vec;

use crate::schedule::Entry;
use crate::units::{Duration, Instant, Ticks};

/// Pulses that bring a wire from martensite to austenite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HotPass {
    /// Width of each pulse, in ticks of the board's PWM period.
    pub width: Ticks,
    /// Length of a burst, from the start of its first pulse to the end of its last one.
    pub burst: Duration,
    /// Bursts of each wire, one at least.
    pub bursts: u8,
    /// Time from one burst of a wire to its next one.
    pub again: Duration,
    /// Time from the first burst of a wire to that of the next wire.
    pub apart: Duration,
}

/// A hot pass on its way. A burst begins at an onset without a contact, so that a contact never waits for more than one.
#[derive(Clone, Debug)]
pub struct Passing {
    pass: HotPass,
    /// Wire whose burst is next, and the number of its bursts so far.
    wire: u16,
    bursts: u8,
    /// Earliest start of the next burst, and of the next wire.
    next: Instant,
    next_wire: Instant,
    /// Wires that the guard let have every burst as it was planned.
    whole: Box<[bool]>,
    /// The burst under way waits for the guard's answer.
    asked: bool,
    /// Refusals and changes by the guard, the first one.
    refused: Option<(u16, Entry)>,
}

impl Passing {
    pub(super) fn new(pass: HotPass, wires: usize, from: Instant) -> Self {
        Self {
            pass,
            wire: 0,
            bursts: 0,
            next: from,
            next_wire: from,
            whole: vec![true; wires].into(),
            asked: false,
            refused: None,
        }
    }

    /// Pulses of the pass.
    pub const fn pass(&self) -> &HotPass {
        &self.pass
    }

    /// Wires that are over, passed or not.
    pub const fn wires(&self) -> u16 {
        self.wire
    }

    /// True once every wire has had its bursts.
    pub const fn is_over(&self) -> bool {
        self.wire as usize >= self.whole.len()
    }

    /// True once every wire has had its bursts as planned.
    pub const fn has_passed(&self) -> bool {
        self.is_over() && self.refused.is_none()
    }

    /// The first wire whose burst the guard refused or changed, with the guard's answer.
    pub const fn refused(&self) -> Option<&(u16, Entry)> {
        self.refused.as_ref()
    }

    /// Wires that are over and had every burst as planned.
    pub fn passed(&self) -> usize {
        let over = self.whole.iter().take(usize::from(self.wire));
        over.filter(|whole| **whole).count()
    }

    /// The wire whose burst is due.
    pub(super) fn due(&self, now: Instant) -> Option<u16> {
        (!self.is_over() && now >= self.next).then_some(self.wire)
    }

    /// Begins the burst that is due at this onset.
    pub(super) fn begin(&mut self, onset: Instant) {
        if self.bursts == 0 {
            self.next_wire = onset + self.pass.apart;
        }
        self.bursts += 1;
        self.next = onset + self.pass.again;
        self.asked = true;
    }

    /// Takes the guard's answer to the burst that has begun.
    pub(super) fn answer(&mut self, entry: &Entry) {
        if !core::mem::take(&mut self.asked) {
            return;
        }
        let is_whole = entry.width() == entry.requested && entry.until == entry.requested_until;
        if !is_whole {
            self.whole[usize::from(self.wire)] = false;
            self.refused.get_or_insert((self.wire, *entry));
        }
        // A wire that is not heated as planned has no use for the bursts that are left.
        if self.bursts >= self.pass.bursts || !is_whole {
            self.bursts = 0;
            self.wire += 1;
            self.next = self.next.max(self.next_wire);
        }
    }
}

#[cfg(test)]
#[path = "pass_tests.rs"]
mod tests;
