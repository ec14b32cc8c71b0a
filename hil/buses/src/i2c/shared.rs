//! A bus that several loops use: one transfer at a time.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use embedded_hal::i2c::{ErrorType, I2c, Operation};

use super::{Fault, Line};
use crate::pulse::{Pulse, Round};

/// One loop's end of a bus.
#[derive(Debug)]
pub struct SharedLine {
    line: Arc<Mutex<Line>>,
    /// The loops that wait for the bus or for its answer.
    waiting: Arc<AtomicU32>,
    /// Bit of this loop.
    own: u32,
    /// This loop's last fault.
    last: Option<Fault>,
}

impl SharedLine {
    /// A bus for the loops of these numbers, an end each. While a transfer goes on the loops that wait for it count as
    /// alive: its limit bounds the wait of all of them.
    pub fn share(mut line: Line, pulse: Pulse, round: &Arc<Round>, loops: &[usize]) -> Vec<Self> {
        let waiting = Arc::new(AtomicU32::new(0));
        line.set_pulse(pulse.among(Arc::clone(round), Arc::clone(&waiting)));
        let line = Arc::new(Mutex::new(line));
        let end = |number: &usize| Self {
            line: Arc::clone(&line),
            waiting: Arc::clone(&waiting),
            own: Round::bit(*number),
            last: None,
        };
        loops.iter().map(end).collect()
    }

    /// This loop's last transaction that failed, in full.
    pub const fn last_fault(&self) -> Option<&Fault> {
        self.last.as_ref()
    }

    /// Returns when no other loop's transfer is on the bus, so that a turn's writes come at about its time.
    pub fn wait(&self) {
        self.with(|_| ());
    }

    fn with<T>(&self, act: impl FnOnce(&mut Line) -> T) -> T {
        self.waiting.fetch_or(self.own, Ordering::Relaxed);
        // A loop that panicked in a transfer has spoilt no other's: the line knows of an answer that is out.
        let done = act(&mut self.line.lock().unwrap_or_else(PoisonError::into_inner));
        self.waiting.fetch_and(!self.own, Ordering::Relaxed);
        done
    }
}

impl ErrorType for SharedLine {
    type Error = Fault;
}

impl I2c for SharedLine {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Fault> {
        let done = self.with(|line| line.transaction(address, operations));
        if let Err(fault) = &done {
            self.last = Some(fault.clone());
        }
        done
    }
}

#[cfg(test)]
#[path = "shared_tests.rs"]
mod tests;
