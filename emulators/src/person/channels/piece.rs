//! One piece of a wire's motion: short enough that a rule of a few nodes is exact to rounding.

// Indices name modes, nodes and states, several arrays of them at once.
#![allow(clippy::needless_range_loop)]

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use super::filter::{self, Free, OUT_N, OUT_P, STATES, State};
use super::gauss::{self, Gauss};
use crate::display::finger::NODES as MODES;
use crate::display::solver::decay::{decays, exponentials};
use crate::display::solver::modal::ModeKey;
use palpate_core::vector::Vectors;

/// Nodes of both outputs, side by side.
const BOTH: usize = 2 * gauss::NODES;
/// States in whole vectors.
const WIDE: usize = 8;
/// Lengths remembered. Pulses have at most some hundred widths; those between events are met once.
const MOST: usize = 1024;

/// Time constant of the Pacinian channel's energy, s (Zwislocki).
pub const LEAK_S: f64 = 0.2;

/// Factor exp(t / tau) by which the leaky energy falls over a time.
pub fn swollen(seconds: f64) -> f64 {
    libm::exp(seconds / LEAK_S)
}

/// The modes of one regime, and its pieces by their length, as bits: no table of a length that was met once.
#[derive(Clone, Debug)]
struct Regime {
    rates: [f64; MODES],
    /// Forced states at the start of any piece, by mode.
    forced: [[f64; WIDE]; MODES],
    pieces: BTreeMap<u64, Option<Box<Table>>>,
}

impl Regime {
    fn new(rates: &[f64; MODES]) -> Self {
        let mut forced = [[0.0; WIDE]; MODES];
        for (wide, rate) in forced.iter_mut().zip(rates) {
            wide[..STATES].copy_from_slice(&filter::forced(*rate));
        }
        Self {
            rates: *rates,
            forced,
            pieces: BTreeMap::new(),
        }
    }
}

/// Effect of a piece of some length, for the modes of one regime: everything but the amplitudes.
#[derive(Clone, Debug)]
struct Table {
    /// exp(-rate t) at the end.
    decay: [f64; MODES],
    /// Integral of exp(-rate t) over the piece, s.
    lasting: [f64; MODES],
    /// exp(-rate t) at the nodes, by mode.
    nodes: [[f64; gauss::NODES]; MODES],
    /// Free outputs at the nodes, by state.
    rings: [[f64; BOTH]; STATES],
    free: Free,
    /// exp(t / tau) at the nodes, and at the end.
    swell: [f64; gauss::NODES],
    swollen: f64,
}

impl Table {
    /// A table without values: a later piece's are written over an earlier one's, as a table is too large to move about.
    const EMPTY: Self = Self {
        decay: [0.0; MODES],
        lasting: [0.0; MODES],
        nodes: [[0.0; gauss::NODES]; MODES],
        rings: [[0.0; BOTH]; STATES],
        free: Free::NONE,
        swell: [0.0; gauss::NODES],
        swollen: 0.0,
    };

    fn fill(&mut self, rule: &Gauss, vectors: Vectors, rates: &[f64; MODES], seconds: f64) {
        vectors.run(
            #[inline(always)]
            || self.plain(rule, rates, seconds),
        );
    }

    #[inline(always)]
    fn plain(&mut self, rule: &Gauss, rates: &[f64; MODES], seconds: f64) {
        let (decay, fallen) = decays(rates, seconds);
        self.decay = decay;
        for k in 0..MODES {
            self.lasting[k] = match rates[k] == 0.0 {
                true => seconds,
                false => fallen[k] / rates[k],
            };
        }
        self.swollen = swollen(seconds);
        let times = rule.nodes.map(
            #[inline(always)]
            |part| part * seconds,
        );
        for k in 0..MODES {
            let powers = times.map(
                #[inline(always)]
                |t| -rates[k] * t,
            );
            self.nodes[k] = exponentials(&powers).0;
        }
        let swell = times.map(
            #[inline(always)]
            |t| t / LEAK_S,
        );
        self.swell = exponentials(&swell).0;
        let mut ends = [seconds; gauss::NODES + 1];
        ends[..gauss::NODES].copy_from_slice(&times);
        let frees = Free::over(&ends);
        self.free = frees[gauss::NODES];
        for i in 0..gauss::NODES {
            let [p, n] = frees[i].outputs();
            for state in 0..STATES {
                self.rings[state][i] = p[state];
                self.rings[state][gauss::NODES + i] = n[state];
            }
        }
    }
}

/// A piece that comes again and again.
#[derive(Clone, Copy, Debug)]
pub struct Piece<'a> {
    forced: &'a [[f64; WIDE]; MODES],
    table: &'a Table,
}

impl Piece<'_> {
    /// Decay of each mode over the piece, 1.
    pub const fn decay(&self) -> &[f64; MODES] {
        &self.table.decay
    }

    /// Way of the displacement over the piece whose rate has these terms at the start, um/s: um.
    pub fn way(&self, terms: &[f64; MODES]) -> f64 {
        let ways = self.table.lasting.iter().zip(terms);
        ways.map(|(s, term)| s * term).sum()
    }

    /// exp(t / tau) over the piece, 1.
    pub const fn swollen(&self) -> f64 {
        self.table.swollen
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
        let Table {
            decay,
            lasting: _,
            nodes,
            rings,
            free,
            swell,
            swollen: _,
        } = self.table;
        let forced = self.forced;
        let (mut before, mut after) = ([0.0; WIDE], [0.0; WIDE]);
        let mut both = [0.0; BOTH];
        for k in 0..MODES {
            let end = decay[k] * terms[k];
            for state in 0..WIDE {
                before[state] += forced[k][state] * terms[k];
                after[state] += forced[k][state] * end;
            }
            let (p, n) = (forced[k][OUT_P] * terms[k], forced[k][OUT_N] * terms[k]);
            for i in 0..gauss::NODES {
                both[i] += nodes[k][i] * p;
                both[gauss::NODES + i] += nodes[k][i] * n;
            }
        }
        let mut ring = [0.0; STATES];
        for state in 0..STATES {
            ring[state] = x[state] - before[state];
            for i in 0..BOTH {
                both[i] += rings[state][i] * ring[state];
            }
        }
        let rung = free.step(&ring);
        for state in 0..STATES {
            x[state] = after[state] + rung[state];
        }
        let mut outputs = Outputs::default();
        outputs.p.copy_from_slice(&both[..gauss::NODES]);
        outputs.n.copy_from_slice(&both[gauss::NODES..]);
        for i in 0..gauss::NODES {
            outputs.flow[i] = 2.0 / LEAK_S * swell[i] * outputs.p[i] * outputs.p[i];
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
    /// Flow into the leaky energy at the nodes, as if the energy had not leaked since the piece's start, um2/s.
    pub flow: [f64; gauss::NODES],
}

/// A parabola through three looks rises above the largest by an eighth of what they differ by, at most a quarter.
const PARABOLA: f64 = 1.25;

/// Raises `most` to the largest magnitude of what has these values at the nodes.
#[inline(always)]
pub fn raise(rule: &Gauss, vectors: Vectors, values: &[f64; gauss::NODES], most: &mut f64) {
    let mut largest = 0.0;
    for value in values {
        let value = value.abs();
        largest = if value > largest { value } else { largest };
    }
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

/// Tables of recurring pieces, by regime. A table follows from its key, so keeping it changes no bit.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    regimes: BTreeMap<[u64; 2], Regime>,
    count: usize,
    /// Table of the last length that was met for the first time.
    once: Option<Box<Table>>,
}

impl Tables {
    /// A regime's piece of this length.
    pub fn piece(
        &mut self,
        rule: &Gauss,
        vectors: Vectors,
        key: ModeKey,
        rates: &[f64; MODES],
        seconds: f64,
    ) -> Piece<'_> {
        if self.count >= MOST {
            *self = Self::default();
        }
        let bits = [key.latent, key.feedback].map(f64::to_bits);
        let regime = self.regimes.entry(bits);
        let regime = regime.or_insert_with(|| Regime::new(rates));
        if regime.rates.map(f64::to_bits) != rates.map(f64::to_bits) {
            *regime = Regime::new(rates);
        }
        let table = match regime.pieces.entry(seconds.to_bits()) {
            Entry::Occupied(met) => met.into_mut().get_or_insert_with(|| {
                let mut table = Box::new(Table::EMPTY);
                table.fill(rule, vectors, rates, seconds);
                table
            }),
            Entry::Vacant(first) => {
                first.insert(None);
                self.count += 1;
                let table = self.once.get_or_insert_with(|| Box::new(Table::EMPTY));
                table.fill(rule, vectors, rates, seconds);
                table
            }
        };
        Piece {
            forced: &regime.forced,
            table,
        }
    }
}

#[cfg(test)]
#[path = "piece_tests.rs"]
mod tests;
