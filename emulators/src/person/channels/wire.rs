//! The contribution of one wire to both channels.

use super::filter::{LIFT, STATES, State};
use super::gauss::{self, Gauss};
use super::piece::{Tables, raise, swollen};
use crate::display::finger::NODES as MODES;
use crate::display::solver::modal::ModeKey;
use crate::display::solver::stretch::Stretch;
use palpate_core::vector::Vectors;

/// The longest piece in which anything rings, s: a period of the chip at 192 Hz or faster. The rule's nodes are enough for
/// it, and places 0.25 ms apart.
const PIECE_S: f64 = 5.25e-3;

/// Terms that differ by less than this part go on: what they make ring counts for nothing.
const SAME: f64 = 1e-6;

/// Parts that all wires share.
#[derive(Clone, Debug)]
pub struct Shared {
    pub rule: Gauss,
    pub tables: Tables,
    pub vectors: Vectors,
}

/// A piece that has passed.
#[derive(Clone, Copy, Debug)]
pub struct Passed {
    /// Start of the piece, s since the last [`WireFilter::settle`].
    pub from_s: f64,
    pub seconds: f64,
    /// Energy that had flowed in before it, as if nothing had leaked since then, um2.
    pub before: f64,
    /// Energy that flowed in during the piece, as if nothing had leaked since then, um2, and its flow at the nodes.
    pub energy: f64,
    flow: [f64; gauss::NODES],
    /// Square of the Pacinian output at the start, um2, where that output only falls in the piece.
    fades: Option<f64>,
}

/// Tells whether all values are finite. It skips none, so that they are looked at side by side.
fn finite(values: &[f64]) -> bool {
    values.iter().fold(true, |all, v| all & v.is_finite())
}

/// One wire's filters, and what they gave since the last onset.
#[derive(Clone, Debug, Default)]
pub struct WireFilter {
    pub x: State,
    /// Regime and terms with which the last stretch ended, and for how long nothing but decay has gone on, s.
    last: Option<(ModeKey, [f64; MODES])>,
    quiet_s: f64,
    /// Pieces since the last [`WireFilter::settle`].
    pub passed: Vec<Passed>,
    /// Time computed up to since then, s, exp(now / tau) - 1, and energy that flowed in, um2.
    pub now_s: f64,
    swollen: f64,
    pub energy: f64,
    /// Displacement of the tissue from where it was at first, um.
    um: f64,
    /// Way that lifted tissue still has to sink, um.
    pub lifted_um: f64,
    pub met: Met,
}

/// Outputs of a wire since the last onset.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Met {
    /// Integral of the squared Pacinian output, without a leak, um2 s.
    pub energy: f64,
    /// Largest output of both channels, um.
    pub peak_p: f64,
    pub peak_n: f64,
    /// Least and most displacement from where the onset found the tissue, um.
    pub reach_um: [f64; 2],
}

impl Met {
    /// Displacement of the tissue from its one end to the other, um.
    pub const fn swing_um(&self) -> f64 {
        let [low, high] = self.reach_um;
        high - low
    }
}

impl WireFilter {
    /// Lifts the tissue at once, um.
    pub fn lift(&mut self, um: f64) {
        if um.is_finite() {
            for (x, by) in self.x.iter_mut().zip(LIFT) {
                *x += um * by;
            }
            self.lifted_um += um;
            self.go(um);
        }
        self.quiet_s = 0.0;
    }

    /// Moves the tissue by a way whose ends are its extremes, um.
    fn go(&mut self, way: f64) {
        let at = self.um + way;
        if at.is_finite() {
            self.um = at;
            let [low, high] = self.met.reach_um;
            self.met.reach_um = [low.min(at), high.max(at)];
        }
    }

    /// Begins an onset: what is met from here on is its.
    pub fn onset(&mut self) {
        self.met = Met::default();
        self.um = 0.0;
    }

    /// Lets a stretch pass. A stretch that is not finite does not move the tissue.
    pub fn pass(&mut self, shared: &mut Shared, stretch: &Stretch) {
        if !(stretch.seconds.is_finite() && stretch.seconds > 0.0) {
            return;
        }
        let moves = stretch.um_per_k.is_finite() && finite(&stretch.rates);
        let resting = Stretch::rest(stretch.seconds);
        let stretch = match moves && finite(&stretch.slopes) {
            true => stretch,
            false => &resting,
        };
        let mut terms = stretch.slopes.map(|k_per_s| k_per_s * stretch.um_per_k);
        if !self.goes_on(stretch.regime, &terms) {
            self.quiet_s = 0.0;
        }
        let mut left = stretch.seconds;
        while left > 0.0 {
            // What rang has died away after some pieces, and what decays is as smooth as it is old.
            let piece = left.min(self.quiet_s.max(PIECE_S));
            self.piece(shared, stretch, &mut terms, piece);
            self.quiet_s += piece;
            left -= piece;
        }
        self.last = Some((stretch.regime, terms));
    }

    /// Tells whether a stretch only goes on with the decay of the last one.
    fn goes_on(&self, regime: ModeKey, terms: &[f64; MODES]) -> bool {
        self.last.is_some_and(|(of, expected)| {
            let all: f64 = expected.iter().map(|term| term.abs()).sum();
            let apart = terms.iter().zip(expected).map(|(a, b)| (a - b).abs());
            of == regime && apart.sum::<f64>() <= SAME * all
        })
    }

    fn piece(
        &mut self,
        shared: &mut Shared,
        stretch: &Stretch,
        terms: &mut [f64; MODES],
        piece: f64,
    ) {
        match self.rests(terms) {
            true => self.rest(piece),
            false => shared.vectors.run(
                #[inline(always)]
                || self.move_on(shared, stretch, terms, piece),
            ),
        }
    }

    /// A piece in which something moves, or rings.
    #[inline(always)]
    fn move_on(
        &mut self,
        shared: &mut Shared,
        stretch: &Stretch,
        terms: &mut [f64; MODES],
        piece: f64,
    ) {
        let Shared {
            rule,
            tables,
            vectors,
        } = shared;
        let known = tables.piece(rule, *vectors, stretch.regime, &stretch.rates, piece);
        let mut outputs = known.pass(*vectors, terms, &mut self.x);
        let (grown, way) = (known.swollen(), known.way(terms));
        for (term, decay) in terms.iter_mut().zip(known.decay()) {
            *term *= decay;
        }
        if !(finite(&self.x) && finite(&outputs.flow)) {
            // Beyond any number: the tissue is taken to stand still from here on.
            (self.x, *terms, outputs) = ([0.0; STATES], [0.0; MODES], <_>::default());
        }
        let swollen = 1.0 + self.swollen;
        let flow = outputs.flow.map(|v| v * swollen);
        let energy = piece * rule.mean(&flow);
        let drifts = self.quiet_s > 0.0 || energy == 0.0;
        let fades = drifts.then(|| gauss::fades(&rule.coefficients(&outputs.p)));
        self.passed.push(Passed {
            fades: fades.flatten(),
            from_s: self.now_s,
            seconds: piece,
            before: self.energy,
            energy,
            flow,
        });
        self.now_s += piece;
        self.swollen = swollen * grown - 1.0;
        self.energy += energy;
        self.met.energy += piece * rule.mean(&outputs.p.map(|y| y * y));
        raise(rule, *vectors, &outputs.p, &mut self.met.peak_p);
        raise(rule, *vectors, &outputs.n, &mut self.met.peak_n);
        self.go(way);
    }

    /// Tells whether nothing moves, and nothing rings.
    fn rests(&self, terms: &[f64; MODES]) -> bool {
        let still = |values: &[f64]| values.iter().fold(true, |all, v| all & (*v == 0.0));
        still(&self.x) && still(terms)
    }

    /// A piece in which nothing moves: what [`Self::move_on`] comes to then, without a table.
    fn rest(&mut self, piece: f64) {
        self.passed.push(Passed {
            from_s: self.now_s,
            seconds: piece,
            before: self.energy,
            energy: 0.0,
            flow: [0.0; gauss::NODES],
            fades: Some(0.0),
        });
        self.now_s += piece;
        let grown = swollen(piece);
        self.swollen = (1.0 + self.swollen) * grown - 1.0;
    }

    /// Adds the energy that had flowed in until each of these times, which rise, s.
    #[inline(always)]
    pub fn add_energies(&self, rule: &Gauss, times: &[f64], sums: &mut [f64]) {
        let mut known = None;
        for (&t, sum) in times.iter().zip(sums) {
            let index = self.at(t);
            let Some(piece) = self.passed.get(index) else {
                *sum += self.energy;
                continue;
            };
            if piece.energy == 0.0 {
                *sum += piece.before;
                continue;
            }
            let coefficients = match known {
                Some((of, coefficients)) if of == index => coefficients,
                _ => rule.coefficients(&piece.flow),
            };
            known = Some((index, coefficients));
            let part = ((t - piece.from_s) / piece.seconds).clamp(0.0, 1.0);
            *sum += piece.before + piece.seconds * gauss::integral(&coefficients, part);
        }
    }

    /// Adds bounds of the energy that had flowed in until the end of each cell: what it was before and after the piece.
    pub fn add_bounds(&self, edge: impl Fn(usize) -> f64, bounds: &mut [(f64, f64)]) {
        let mut pieces = self.passed.iter().peekable();
        for (cell, (low, high)) in bounds.iter_mut().enumerate() {
            let to = edge(cell + 1);
            while pieces.next_if(|p| p.from_s + p.seconds < to).is_some() {}
            let (before, energy) = pieces
                .peek()
                .map_or((self.energy, 0.0), |p| (p.before, p.energy));
            *low += before;
            *high += before + energy;
        }
    }

    /// Time from which the wire's Pacinian output only falls, s.
    pub fn fades_from(&self) -> f64 {
        let fading = self.passed.iter().rev().take_while(|p| p.fades.is_some());
        fading.last().map_or(self.now_s, |p| p.from_s)
    }

    /// Bounds at a time from which the output only falls: most of the output's square, um2, and least of the energy
    /// that had flowed in, um2.
    pub fn fading_at(&self, t: f64) -> (f64, f64) {
        let begun = self.passed.iter().rev().find(|p| p.from_s <= t);
        begun.map_or((0.0, 0.0), |p| (p.fades.unwrap_or(f64::INFINITY), p.before))
    }

    /// Index of the piece that a time is in.
    fn at(&self, t: f64) -> usize {
        self.passed.partition_point(|p| p.from_s + p.seconds < t)
    }

    /// Begins a new account of the leaky energy.
    pub fn settle(&mut self) {
        self.passed.clear();
        (self.now_s, self.swollen, self.energy) = (0.0, 0.0, 0.0);
    }
}

#[cfg(test)]
#[path = "wire_tests.rs"]
mod tests;
