//! A bow that grows and shrinks: displacement and stress over strain, in straight pieces.
//!
//! With the excess length a (s^2 - s0^2), a = pi^2 / (4 L^2), the balance of the bow's forces makes strain and stress plain
//! functions of the sag s:
//!
//! ```text
//! strain = a (s^2 - s0^2) + b (1 - s0 / s)      stress = E b (s0 / s - 1)      b = 2 L (K_b + K_s) / (pi^2 E A)
//! ```
//!
//! Knots stand so close that a straight piece lies at most [`BEND_M`] from them.

use alloc::vec::Vec;
use core::f64::consts::PI;

use super::{Bow, DEEPEST, WireParameters};

/// Largest distance of a piece's displacement from the bow's own, m.
pub const BEND_M: f64 = 0.01e-6;
/// Displacement over rest sag past which a bow is beyond the model: a wire that tight is no bow.
pub const TIGHTEST: f64 = 0.9;
/// Smallest sag that has a knot, over the rest sag. A tighter wire is a straight rod.
const STRAIGHT: f64 = 0.02;
/// Number of places between a piece's ends at which its distance from the bow is taken.
const LOOKS: u32 = 15;
/// Number of steps in which a piece's length is looked for.
const STEPS: u32 = 1 << 24;
/// Number of guesses at a length before it is halved: they end after some six, unless rounding misleads them.
const GUESSES: u32 = 16;

/// A range of strains over which displacement and stress are straight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Lowest strain of the piece, 1; strains count from rest, longer being positive.
    pub low: f64,
    /// Highest strain of the piece, 1.
    pub high: f64,
    /// Strain that displacement and stress are counted from, 1.
    pub from: f64,
    /// Displacement of the bow's middle at `from`, m, positive into the skin.
    pub u_m: f64,
    /// Change of the displacement with strain, m; never positive.
    pub u_per: f64,
    /// Stress at `from` beyond the bias stress, Pa.
    pub stress_pa: f64,
    /// Fall of the stress with strain (kappa), Pa; never negative.
    pub stiffness_pa: f64,
    /// True where skin and wire are apart.
    pub apart: bool,
    /// True past [`TIGHTEST`].
    pub tight: bool,
}

impl Piece {
    /// Displacement of the bow's middle at a strain, m, positive into the skin.
    pub fn u_at(&self, strain: f64) -> f64 {
        self.u_m + self.u_per * (strain - self.from)
    }

    /// Stress beyond the bias stress at a strain, Pa.
    pub fn stress_at(&self, strain: f64) -> f64 {
        self.stress_pa - self.stiffness_pa * (strain - self.from)
    }
}

/// The pieces of a bow, the tightest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// One piece or more, from minus to plus infinity, each beginning where the one before ends.
    pub pieces: Vec<Piece>,
}

impl Curve {
    /// Makes the curve of a wire in its bow.
    pub fn new(bow: &Bow, wire: &WireParameters) -> Self {
        let shape = Shape::new(bow, wire);
        let rest = shape.rest;
        let mut down = alloc::vec![rest];
        for to in [rest * (1.0 - TIGHTEST), rest * STRAIGHT] {
            shape.fill(to, &mut down);
        }
        let mut up = alloc::vec![rest];
        let parting = rest - bow.parting_m / bow.skin_share;
        let deepest = wire.length_m * DEEPEST;
        for to in [parting, deepest.max(parting)] {
            shape.fill(to, &mut up);
        }
        down.reverse();
        down.extend_from_slice(&up[1..]);
        let mut pieces = Vec::with_capacity(down.len() + 1);
        for ends in down.windows(2) {
            let [a, b] = [ends[0], ends[1]];
            let (low, high) = (shape.strain(a), shape.strain(b));
            let span = high - low;
            // Each piece is counted from the end nearer to rest, where displacement and stress are small.
            let (s, from) = if b <= rest { (b, high) } else { (a, low) };
            pieces.push(Piece {
                low,
                high,
                from,
                u_m: bow.skin_share * (rest - s),
                u_per: bow.skin_share * (a - b) / span,
                stress_pa: shape.stress(s),
                stiffness_pa: (shape.stress(a) - shape.stress(b)) / span,
                apart: a >= parting,
                tight: b <= rest * (1.0 - TIGHTEST),
            });
        }
        let first = pieces[0];
        let straight = Piece {
            low: f64::NEG_INFINITY,
            high: first.low,
            from: first.low,
            u_m: first.u_at(first.low),
            u_per: 0.0,
            stress_pa: first.stress_at(first.low),
            stiffness_pa: shape.modulus,
            ..first
        };
        pieces.insert(0, straight);
        if let Some(last) = pieces.last_mut() {
            last.high = f64::INFINITY;
        }
        Self { pieces }
    }

    /// Index of the piece that a strain is in.
    pub(super) fn at(&self, strain: f64) -> usize {
        let before = self.pieces.partition_point(|piece| piece.high < strain);
        before.min(self.pieces.len() - 1)
    }
}

/// The bow as its balance of forces describes it.
struct Shape {
    /// Sag at rest, m.
    rest: f64,
    /// Excess length over the sag's square, 1/m2.
    a: f64,
    /// Stiffness of bending and tissue over that of stretching (b above), 1.
    b: f64,
    /// Young's modulus, Pa.
    modulus: f64,
}

impl Shape {
    fn new(bow: &Bow, wire: &WireParameters) -> Self {
        let (rest, length) = (wire.mount.sag_m, wire.length_m);
        let a = PI * PI / (4.0 * length * length);
        let geometric = 2.0 * length / (PI * PI * rest);
        Self {
            rest,
            a,
            b: 2.0 * a * rest * rest * (geometric * bow.skin_share / bow.gain - 1.0),
            modulus: wire.mechanics.modulus_martensite_pa,
        }
    }

    fn strain(&self, sag: f64) -> f64 {
        self.a * (sag * sag - self.rest * self.rest) + self.b * (1.0 - self.rest / sag)
    }

    fn stress(&self, sag: f64) -> f64 {
        self.modulus * self.b * (self.rest / sag - 1.0)
    }

    /// Adds knots from the last one up to the sag `to`.
    fn fill(&self, to: f64, knots: &mut Vec<f64>) {
        let mut from = knots.last().copied().unwrap_or(to);
        let mut length = 0.0;
        while (to - from).abs() > 0.0 {
            let bend = self.bend(from, to);
            if bend.is_nan() || bend <= BEND_M {
                break;
            }
            let whole = to - from;
            // The piece before is the best guess; the first one has the bend of all.
            let guess = match length > 0.0 {
                true => length / whole.abs(),
                false => libm::sqrt(BEND_M / bend),
            };
            let part = self.reach(from, whole, guess);
            length = (whole * part).abs();
            from += whole * part;
            knots.push(from);
        }
        if (to - from).abs() > 0.0 {
            knots.push(to);
        }
    }

    /// Largest part of `whole`, in steps of 1 / [`STEPS`], that is straight enough from the sag `from` on.
    fn reach(&self, from: f64, whole: f64, guess: f64) -> f64 {
        let part = |steps: u32| f64::from(steps) / f64::from(STEPS);
        let (mut good, mut bad) = (0, STEPS);
        let mut next = guess * f64::from(STEPS);
        let mut looks = 0;
        while bad - good > 1 {
            let steps = match looks < GUESSES {
                true => (next as u32).clamp(good + 1, bad - 1),
                false => u32::midpoint(good, bad),
            };
            looks += 1;
            let bend = self.bend(from, from + whole * part(steps));
            match bend <= BEND_M {
                true => good = steps,
                false => bad = steps,
            }
            // The bend of a short piece grows with the square of its length.
            next = f64::from(steps) * libm::sqrt(BEND_M / bend);
        }
        part(good.max(1))
    }

    /// Largest distance of a straight piece between two sags from the bow, m.
    fn bend(&self, from: f64, to: f64) -> f64 {
        let (first, last) = (self.strain(from), self.strain(to));
        let per_strain = (to - from) / (last - first);
        let mut most = 0.0_f64;
        for look in 1..=LOOKS {
            let sag = from + (to - from) * f64::from(look) / f64::from(LOOKS + 1);
            let straight = from + per_strain * (self.strain(sag) - first);
            most = most.max((sag - straight).abs());
        }
        most
    }
}

#[cfg(test)]
#[path = "curve_tests.rs"]
mod tests;
