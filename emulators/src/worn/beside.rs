//! Other wires in the place of a display's own, through which the same currents flow.
//!
//! Nothing of the display depends on them, so they may follow elsewhere, as on another thread. What is felt of them is known at
//! the end, and the same either way.

use std::mem;
#[cfg(not(target_family = "wasm"))]
use std::sync::mpsc::{Receiver, Sender, channel};

use super::wearing::Wearing;
use crate::person::channels::Felt;
use crate::time::Nanos;

/// Steps that are handed over at once.
const BATCH: usize = 512;

/// Runs work beside the caller's, as on a thread of its own; returns `false` where it cannot.
pub type Aside = fn(Box<dyn FnOnce() + Send>) -> bool;

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
    #[cfg(not(target_family = "wasm"))]
    Aside(Sender<Vec<Step>>, Receiver<Stimuli>),
}

impl Beside {
    pub fn new(wearing: Wearing, aside: Option<Aside>) -> Self {
        Self {
            amps: vec![0.0; wearing.wires.len()],
            steps: Vec::new(),
            worker: Worker::new(wearing, aside),
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
            #[cfg(not(target_family = "wasm"))]
            // Where the work ended early there are no stimuli.
            Worker::Aside(sender, _) => drop(sender.send(steps)),
        }
    }

    /// Ends the wires; returns the stimulus of every onset, the oldest first.
    pub fn finish(mut self) -> Stimuli {
        self.hand_over();
        match self.worker {
            Worker::Here(_, met) => met,
            #[cfg(not(target_family = "wasm"))]
            Worker::Aside(sender, stimuli) => {
                drop(sender);
                stimuli.recv().unwrap_or_default()
            }
        }
    }
}

impl Worker {
    #[cfg(target_family = "wasm")]
    fn new(wearing: Wearing, _aside: Option<Aside>) -> Self {
        Self::Here(Box::new(wearing), Vec::new())
    }

    #[cfg(not(target_family = "wasm"))]
    fn new(wearing: Wearing, aside: Option<Aside>) -> Self {
        let here = |wearing| Self::Here(Box::new(wearing), Vec::new());
        let Some(aside) = aside else {
            return here(wearing);
        };
        let (sender, steps) = channel::<Vec<Step>>();
        let (lend, lent) = channel::<Wearing>();
        let (tell, stimuli) = channel();
        let work = move || {
            let mut met = Vec::new();
            if let Ok(mut wearing) = lent.recv() {
                for batch in steps {
                    play(&mut wearing, &batch, &mut met);
                }
            }
            // A display that was dropped asks for no stimuli.
            drop(tell.send(met));
        };
        if !aside(Box::new(work)) {
            return here(wearing);
        }
        match lend.send(wearing) {
            Ok(()) => Self::Aside(sender, stimuli),
            Err(back) => here(back.0),
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
