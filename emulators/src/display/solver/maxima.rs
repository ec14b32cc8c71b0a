//! Running maxima of the tissue at one depth, settled when a caller asks.
//!
//! The heat of a pulse arrives after the pulse, so a stretch between two edges may be warmest inside. In a burst the
//! ends of later stretches soon pass all of that, and between bursts those of later bursts do. A stretch therefore
//! only waits, with a ceiling, and is forgotten once an end passes that ceiling. It is searched when a caller asks
//! for maxima, or when too many wait.

use super::highest::{ENOUGH_K, ceiling_between, highest};
use super::sum::{Sum, SumPoint};
use crate::display::finger::NODES;
use palpate_core::vector::{Simd, Vectors};

/// Largest number of stretches that wait.
const MOST: usize = 24;

/// The maximum since the start and the one since a window was opened, degrees C.
#[derive(Clone, Debug)]
pub struct Maxima {
    whole: f64,
    window: f64,
    /// Stretches that wait, the oldest first.
    waiting: Vec<Stretch>,
    /// The lowest of the ceilings.
    lowest: f64,
    vectors: Vectors,
}

/// A stretch that may be warmer inside than anything known.
#[derive(Clone, Debug)]
struct Stretch {
    /// Bound that the stretch cannot have passed, degrees C.
    ceiling: f64,
    lambda: [f64; NODES],
    ends: [SumPoint; 2],
}

impl Maxima {
    /// Maxima that start at a temperature, degrees C.
    pub fn new(now: f64) -> Self {
        Self {
            whole: now,
            window: now,
            waiting: Vec::new(),
            lowest: f64::INFINITY,
            vectors: Vectors::widest(),
        }
    }

    /// Takes a stretch between two instants of a sum with these decay rates.
    #[inline(always)]
    pub fn pass<S: Simd>(&mut self, simd: S, lambda: &[f64; NODES], ends: &[SumPoint; 2]) {
        let [from, to] = ends;
        self.raise(from.value.max(to.value));
        let known = self.window + ENOUGH_K;
        if self.lowest <= known {
            self.waiting.retain(|stretch| stretch.ceiling > known);
            let ceilings = self.waiting.iter().map(|stretch| stretch.ceiling);
            self.lowest = ceilings.fold(f64::INFINITY, f64::min);
        }
        let ceiling = ceiling_between(simd, lambda, from, to, known);
        if ceiling <= known {
            return;
        }
        self.lowest = self.lowest.min(ceiling);
        if self.waiting.len() == MOST {
            let oldest = self.waiting.remove(0);
            self.raise(oldest.highest(self.window, self.vectors));
        }
        self.waiting.push(Stretch {
            ceiling,
            lambda: *lambda,
            ends: *ends,
        });
    }

    /// The known part of the maximum since the window was opened, degrees C.
    pub const fn known(&self) -> f64 {
        self.window
    }

    /// The known part of the maximum since the start, degrees C.
    pub const fn known_whole(&self) -> f64 {
        self.whole
    }

    /// Searches the stretches that wait, and returns both maxima: since the start, and since the window was opened. A
    /// stretch that cannot pass `floor` is forgotten without a search. Maxima under `floor` are lower bounds only.
    pub fn settle(&mut self, floor: f64) -> (f64, f64) {
        // The last stretches are the likeliest to settle the others.
        while let Some(stretch) = self.waiting.pop() {
            let known = self.window.max(floor);
            if stretch.ceiling > known + ENOUGH_K {
                let highest = stretch.highest(known, self.vectors);
                if highest > known {
                    self.raise(highest);
                }
            }
        }
        self.lowest = f64::INFINITY;
        (self.whole, self.window)
    }

    /// Opens a new window at a temperature, degrees C. No stretch may wait.
    pub const fn open(&mut self, now: f64) {
        self.window = now;
    }

    #[inline(always)]
    fn raise(&mut self, to: f64) {
        self.whole = self.whole.max(to);
        self.window = self.window.max(to);
    }
}

impl Stretch {
    /// The stretch's maximum, or `known` if that is higher.
    fn highest(&self, known: f64, vectors: Vectors) -> f64 {
        let [from, to] = &self.ends;
        let sum = Sum::new(&self.lambda, from.terms, from.value, vectors);
        highest(&sum, from, to, known)
    }
}
