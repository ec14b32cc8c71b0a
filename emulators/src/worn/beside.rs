//! Other wires in the place of a display's own, through which the same currents flow.
//!
//! Nothing of the display depends on them, so they follow on a thread of their own, where the system gives one. What is felt
//! of them is known at the end, and the same either way.

use std::mem;
use std::sync::mpsc::{Sender, channel};
use std::thread::{Builder, JoinHandle};

use super::wearing::Wearing;
use crate::person::channels::Felt;
use crate::time::Nanos;

/// Steps that are handed over at once.
const BATCH: usize = 512;

/// One step of the display.
#[derive(Clone, Copy, Debug)]
enum Step {
    /// The current of a wire changes, A.
    Current { wire: usize, at: Nanos, amps: f64 },
    /// The person sums up what was felt.
    Settle(Nanos),
    /// A stimulus ends, and the next one begins.
    Onset(Nanos),
}

/// Wires beside, and who computes them.
#[derive(Debug)]
pub(super) struct Beside {
    /// Present current of each wire, A.
    amps: Vec<f64>,
    steps: Vec<Step>,
    worker: Worker,
}

/// Stimuli of an onset each, the oldest first.
type Stimuli = Vec<Option<Felt>>;

#[derive(Debug)]
enum Worker {
    Here(Box<Wearing>, Stimuli),
    There(Sender<Vec<Step>>, JoinHandle<Stimuli>),
}

impl Beside {
    pub fn new(wearing: Wearing) -> Self {
        Self {
            amps: vec![0.0; wearing.wires.len()],
            steps: Vec::new(),
            worker: Worker::new(wearing),
        }
    }

    pub fn set_current(&mut self, wire: usize, at: Nanos, amps: f64) {
        if self.amps[wire].to_bits() != amps.to_bits() {
            self.amps[wire] = amps;
            self.take(Step::Current { wire, at, amps });
        }
    }

    pub fn settle(&mut self, now: Nanos) {
        self.take(Step::Settle(now));
    }

    pub fn onset(&mut self, now: Nanos) {
        self.take(Step::Onset(now));
    }

    fn take(&mut self, step: Step) {
        self.steps.push(step);
        if self.steps.len() >= BATCH {
            self.hand_over();
        }
    }

    fn hand_over(&mut self) {
        let steps = mem::take(&mut self.steps);
        match &mut self.worker {
            Worker::Here(wearing, met) => play(wearing, &steps, met),
            // A thread that ended has no stimuli to give.
            Worker::There(sender, _) => drop(sender.send(steps)),
        }
    }

    /// Ends the wires; returns the stimulus of every onset, the oldest first.
    pub fn finish(mut self) -> Stimuli {
        self.hand_over();
        match self.worker {
            Worker::Here(_, met) => met,
            Worker::There(sender, thread) => {
                drop(sender);
                thread.join().unwrap_or_default()
            }
        }
    }
}

impl Worker {
    fn new(wearing: Wearing) -> Self {
        // A browser's page has one thread.
        if cfg!(target_family = "wasm") {
            return Self::Here(Box::new(wearing), Vec::new());
        }
        let (sender, steps) = channel::<Vec<Step>>();
        let (lend, lent) = channel::<Wearing>();
        let work = move || {
            let mut met = Vec::new();
            if let Ok(mut wearing) = lent.recv() {
                for batch in steps {
                    play(&mut wearing, &batch, &mut met);
                }
            }
            met
        };
        let thread = Builder::new().name("wires beside".to_owned()).spawn(work);
        match thread {
            Ok(thread) => match lend.send(wearing) {
                Ok(()) => Self::There(sender, thread),
                Err(back) => Self::Here(Box::new(back.0), Vec::new()),
            },
            // No thread is left in the system.
            Err(_) => Self::Here(Box::new(wearing), Vec::new()),
        }
    }
}

fn play(wearing: &mut Wearing, steps: &[Step], met: &mut Stimuli) {
    for step in steps {
        match *step {
            Step::Current { wire, at, amps } => wearing.wires[wire].set_current(at, amps),
            Step::Settle(now) => wearing.settle(now),
            Step::Onset(now) => met.push(wearing.onset(now)),
        }
    }
}

#[cfg(test)]
#[path = "beside_tests.rs"]
mod tests;
