//! One piece of a wire's motion: short enough that a rule of a few nodes is exact to rounding.

// Indices name modes, nodes and states, several arrays of them at once.
#![allow(clippy::needless_range_loop)]

use std::collections::BTreeMap;

use super::filter::{self, Free, OUT_N, OUT_P, STATES, State};
use super::gauss::{self, Gauss};
use crate::display::finger::NODES as MODES;
use crate::display::solver::decay::decays;
use crate::display::solver::modal::ModeKey;
use palpate_core::vector::Vectors;

/// Nodes of both outputs, side by side.
const BOTH: usize = 2 * gauss::NODES;
/// States in whole vectors.
const WIDE: usize = 8;
/// Tables kept. Pulses have at most some hundred widths.
const MOST: usize = 1024;

/// Time constant of the Pacinian channel's energy, s (Zwislocki).
pub const LEAK_S: f64 = 0.2;

/// What a piece of some length does, for the modes of one regime: everything but the amplitudes.
#[derive(Clone, Debug)]
pub struct Table {
    rates: [f64; MODES],
    /// exp(-rate t) at the end.
    pub decay: [f64; MODES],
    /// Forced states at the start and at the end, by mode.
    start: [[f64; WIDE]; MODES],
    end: [[f64; WIDE]; MODES],
    /// Forced outputs at the nodes, by mode.
    nodes: [[f64; BOTH]; MODES],
    /// Free outputs at the nodes, by state.
    rings: [[f64; BOTH]; STATES],
    free: Free,
    /// exp(t / tau) at the nodes.
    swell: [f64; gauss::NODES],
}

impl Table {
    fn new(rule: &Gauss, rates: &[f64; MODES], seconds: f64) -> Self {
        let mut table = Self {
            rates: *rates,
            decay: decays(rates, seconds).0,
            start: [[0.0; WIDE]; MODES],
            end: [[0.0; WIDE]; MODES],
            nodes: [[0.0; BOTH]; MODES],
            rings: [[0.0; BOTH]; STATES],
            free: Free::over(seconds),
            swell: rule.nodes.map(|part| libm::exp(part * seconds / LEAK_S)),
        };
        let forced = rates.map(filter::forced);
        for k in 0..MODES {
            for state in 0..STATES {
                table.start[k][state] = forced[k][state];
                table.end[k][state] = forced[k][state] * table.decay[k];
            }
        }
        for (i, part) in rule.nodes.into_iter().enumerate() {
            let t = part * seconds;
            let (decay, _) = decays(rates, t);
            for k in 0..MODES {
                table.nodes[k][i] = forced[k][OUT_P] * decay[k];
                table.nodes[k][gauss::NODES + i] = forced[k][OUT_N] * decay[k];
            }
            let free = Free::over(t);
            for state in 0..STATES {
                let mut one = [0.0; STATES];
                one[state] = 1.0;
                let after = free.step(&one);
                table.rings[state][i] = after[OUT_P];
                table.rings[state][gauss::NODES + i] = after[OUT_N];
            }
        }
        table
    }

    /// Lets a piece pass: the terms of the displacement's rate (um/s) at its start and the states, which go to its end.
    pub fn pass(&self, vectors: Vectors, terms: &[f64; MODES], x: &mut State) -> Outputs {
        vectors.run(
            #[inline(always)]
            || self.plain_pass(terms, x),
        )
    }

    #[inline(always)]
    fn plain_pass(&self, terms: &[f64; MODES], x: &mut State) -> Outputs {
        let (mut before, mut after) = ([0.0; WIDE], [0.0; WIDE]);
        let mut both = [0.0; BOTH];
        for k in 0..MODES {
            for state in 0..WIDE {
                before[state] += self.start[k][state] * terms[k];
                after[state] += self.end[k][state] * terms[k];
            }
            for i in 0..BOTH {
                both[i] += self.nodes[k][i] * terms[k];
            }
        }
        let mut ring = [0.0; STATES];
        for state in 0..STATES {
            ring[state] = x[state] - before[state];
            for i in 0..BOTH {
                both[i] += self.rings[state][i] * ring[state];
            }
        }
        let rung = self.free.step(&ring);
        for state in 0..STATES {
            x[state] = after[state] + rung[state];
        }
        let mut outputs = Outputs::default();
        outputs.p.copy_from_slice(&both[..gauss::NODES]);
        outputs.n.copy_from_slice(&both[gauss::NODES..]);
        for i in 0..gauss::NODES {
            outputs.flow[i] = 2.0 / LEAK_S * self.swell[i] * outputs.p[i] * outputs.p[i];
        }
        outputs
    }
}

/// Both filters at the nodes of a piece, um.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outputs {
    /// The Pacinian channel.
    pub p: [f64; gauss::NODES],
    /// The channel NP I.
    pub n: [f64; gauss::NODES],
    /// What flows into the leaky energy at the nodes, as if it had not leaked since the piece's start, um2/s.
    pub flow: [f64; gauss::NODES],
}

/// A parabola through three looks rises above the largest by an eighth of what they differ by, at most a quarter.
const PARABOLA: f64 = 1.25;

/// Raises `most` to the largest magnitude of what has these values at the nodes.
pub fn raise(rule: &Gauss, vectors: Vectors, values: &[f64; gauss::NODES], most: &mut f64) {
    let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if PARABOLA * rule.reach * largest > *most {
        *most = most.max(peak(rule, vectors, values));
    }
}

/// Largest magnitude of what has these values at the nodes, a parabola laid through the largest place and its neighbours.
fn peak(rule: &Gauss, vectors: Vectors, values: &[f64; gauss::NODES]) -> f64 {
    let looks = vectors.run(
        #[inline(always)]
        || {
            let mut looks = [0.0; gauss::LOOKS];
            for i in 0..gauss::NODES {
                for place in 0..gauss::LOOKS {
                    looks[place] += rule.looks[i][place] * values[i];
                }
            }
            looks
        },
    );
    let mut top = 0;
    for place in 1..gauss::LOOKS {
        if looks[place].abs() > looks[top].abs() {
            top = place;
        }
    }
    let at = looks[top].abs();
    if top == 0 || top + 1 == gauss::LOOKS {
        return at;
    }
    let sign = looks[top].signum();
    let (left, right) = (sign * looks[top - 1], sign * looks[top + 1]);
    let bend = 2.0 * at - left - right;
    let lean = right - left;
    if bend > 0.0 {
        at + lean * lean / (8.0 * bend)
    } else {
        at
    }
}

/// The tables of recurring pieces.
#[derive(Clone, Debug, Default)]
pub struct Tables(BTreeMap<[u64; 3], Box<Table>>);

impl Tables {
    /// The table of a regime's pieces of this length. What is kept changes no bit: a table follows from its key.
    pub fn of(
        &mut self,
        rule: &Gauss,
        regime: ModeKey,
        rates: &[f64; MODES],
        seconds: f64,
    ) -> &Table {
        let bits = [regime.latent, regime.feedback, seconds].map(f64::to_bits);
        if self.0.len() >= MOST {
            self.0.clear();
        }
        let table = self
            .0
            .entry(bits)
            .or_insert_with(|| Box::new(Table::new(rule, rates, seconds)));
        if table.rates.map(f64::to_bits) != rates.map(f64::to_bits) {
            **table = Table::new(rule, rates, seconds);
        }
        table
    }
}

#[cfg(test)]
#[path = "piece_tests.rs"]
mod tests;
