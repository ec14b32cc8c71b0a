//! An adapter's page. A transaction makes a new state beside the old one, and one atomic store makes it the chips' state:
//! nobody holds a lock, so a process may be killed or stopped at any instant.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use super::Switch;
use super::chip::{ROWS, State, WIDTH_WORDS, WORDS, Widths, packed, unpacked};

/// States beside each other: one is the chips', others are being made.
const SLOTS: usize = 64;
/// Changes of what is driven that a page keeps, many times what a test makes.
const RING: usize = 16_384;

/// What an adapter does with a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Carries it out.
    Works,
    /// Does not answer until its mode changes, then carries it out.
    Hangs,
    /// Carries it out, and every byte that it reads is wrong.
    Lies,
    /// Refuses it with an error number, and carries out nothing.
    Fails(u16),
}

impl Mode {
    /// As a page holds it.
    pub const fn number(self) -> u32 {
        match self {
            Self::Works => 0,
            Self::Hangs => 1,
            Self::Lies => 2,
            Self::Fails(errno) => 256 + errno as u32,
        }
    }

    /// Of what a page holds.
    pub const fn new(number: u32) -> Self {
        match number {
            1 => Self::Hangs,
            2 => Self::Lies,
            256.. => Self::Fails((number - 256) as u16),
            _ => Self::Works,
        }
    }
}

/// A change of what an adapter's chips drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// CLOCK_MONOTONIC_RAW, nanoseconds.
    pub at_ns: u64,
    /// Widths of pulses from then on, chip by chip, ticks, and last the levels of motors; zero for a channel that is off.
    pub widths: [Widths; ROWS],
}

/// An adapter: what it does, its chips, and the record of what was on.
#[repr(C)]
#[derive(Debug)]
pub struct AdapterPage {
    mode: AtomicU32,
    /// How long an answer takes, microseconds.
    pub late_us: AtomicU32,
    /// Transfers until the mode becomes `then`; zero for never.
    fail_after: AtomicU32,
    then: AtomicU32,
    /// Chips that answer nothing, a bit each.
    pub absent: AtomicU32,
    /// Transfers that were asked for.
    pub transfers: AtomicU32,
    /// The number of the chips' state.
    current: AtomicU64,
    /// Numbers given to states so far.
    given: AtomicU64,
    slots: [[AtomicU64; WORDS]; SLOTS],
    ring: [[AtomicU64; 1 + WIDTH_WORDS]; RING],
}

impl AdapterPage {
    /// Puts chips on a page that nobody uses yet.
    pub fn put(&self, addresses: &[u8]) {
        self.store(0, &State::new(addresses));
        self.current.store(0, Ordering::Release);
    }

    /// Puts a switch with drivers of motors on a page that nobody uses yet, in place of chips.
    pub fn put_motors(&self, switch: Switch) {
        let mut state = State::new(&[]);
        state.switch = switch;
        self.store(0, &state);
        self.current.store(0, Ordering::Release);
    }

    /// What it does now.
    pub fn mode(&self) -> Mode {
        Mode::new(self.mode.load(Ordering::Acquire))
    }

    /// Says what it does from now on.
    pub fn set_mode(&self, mode: Mode) {
        self.mode.store(mode.number(), Ordering::Release);
    }

    /// Says what it does after so many more transfers, one at least.
    pub fn set_mode_after(&self, transfers: u32, mode: Mode) {
        self.then.store(mode.number(), Ordering::Release);
        self.fail_after.store(transfers.max(1), Ordering::Release);
    }

    /// Counts a transfer.
    pub fn count(&self) {
        self.transfers.fetch_add(1, Ordering::AcqRel);
        let counted = self
            .fail_after
            .fetch_update(Ordering::AcqRel, Ordering::Acquire, |n| n.checked_sub(1));
        if counted == Ok(1) {
            self.mode
                .store(self.then.load(Ordering::Acquire), Ordering::Release);
        }
    }

    /// The chips as they are.
    pub fn state(&self) -> State {
        self.numbered().1
    }

    /// Carries a transaction out. `act` may be called again, from the state that another process has made meanwhile.
    pub fn change<T>(&self, now_ns: impl Fn() -> u64, mut act: impl FnMut(&mut State) -> T) -> T {
        loop {
            let (number, before) = self.numbered();
            let mut after = before;
            let result = act(&mut after);
            if after.widths() != before.widths() {
                // Whoever makes the next change keeps this one: its own maker may be dead.
                self.keep(&before);
                after.changes = before.changes + 1;
                after.at_ns = now_ns();
            }
            let own = self.given.fetch_add(1, Ordering::AcqRel) + 1;
            self.store(own, &after);
            let order = (Ordering::AcqRel, Ordering::Acquire);
            let swapped = self.current.compare_exchange(number, own, order.0, order.1);
            if swapped.is_ok() {
                return result;
            }
        }
    }

    /// Every change so far, the oldest first; the first is the beginning, at zero.
    ///
    /// # Errors
    /// More of them than a page keeps.
    pub fn record(&self) -> Result<Vec<Change>, String> {
        let last = self.state();
        let count = last.changes as usize;
        if count >= RING {
            return Err(format!("{count} changes of outputs, a page keeps {RING}"));
        }
        let kept = |[at_ns, words @ ..]: &[AtomicU64; 1 + WIDTH_WORDS]| Change {
            at_ns: at_ns.load(Ordering::Acquire),
            widths: unpacked(&std::array::from_fn(|n| words[n].load(Ordering::Acquire))),
        };
        let mut changes: Vec<Change> = self.ring[..count].iter().map(kept).collect();
        changes.push(Change {
            at_ns: last.at_ns,
            widths: last.widths(),
        });
        Ok(changes)
    }

    fn numbered(&self) -> (u64, State) {
        loop {
            let number = self.current.load(Ordering::Acquire);
            let slot = &self.slots[number as usize % SLOTS];
            let state = State::of_words(&std::array::from_fn(|n| slot[n].load(Ordering::Acquire)));
            if self.current.load(Ordering::Acquire) == number {
                return (number, state);
            }
        }
    }

    fn store(&self, number: u64, state: &State) {
        let slot = &self.slots[number as usize % SLOTS];
        for (place, word) in slot.iter().zip(state.words()) {
            place.store(word, Ordering::Release);
        }
    }

    fn keep(&self, state: &State) {
        let [at_ns, words @ ..] = &self.ring[state.changes as usize % RING];
        at_ns.store(state.at_ns, Ordering::Release);
        for (place, word) in words.iter().zip(packed(&state.widths())) {
            place.store(word, Ordering::Release);
        }
    }
}
