//! The law that is an inverse: amplitudes and numbers of pulses that both centroids feel at the contact.
//!
//! The amplitude centroid weighs a wire by the peak of its pulses, the energy centroid by their number times the peak's
//! square. With as many pulses on every wire no amplitudes satisfy both. Where a weak wire gets more pulses than a strong
//! one, as the inverse of their shares, some do. Numbers are whole, so what is left of both errors is made least.

use crate::units::Point;

use super::cells::Cells;
use super::law::Illusion;

/// A wire whose share is at least this part of the largest is strong: it may do with a pulse less.
const STRONG: f32 = 0.8;
/// Of a contact on a wire that wire has more than this share. There all wires have as many pulses, so that crossing it
/// changes nothing.
const ON_WIRE: f32 = 0.85;
/// Times that the compromise between both centroids is corrected. Two bring it to 0.01 mm on gaps of 9 mm.
const CORRECTIONS: u32 = 2;

/// Shares by the cells between wires, turned into what both centroids feel where the contact is.
#[derive(Clone, Debug)]
pub struct Inverse {
    cells: Cells,
    /// Beyond the hull a contact is rendered on its edge, weaker with distance and not at all from here on, mm.
    margin: f32,
}

/// One way to distribute pulses over wires, and the amplitudes that go best with it.
#[derive(Clone, Copy, Debug)]
struct Split {
    most: u8,
    /// Wires of this share or more have a pulse less.
    fewer_from: f32,
    /// From 0, where the energy centroid is exact, to 1, where the amplitude centroid is.
    blend: f32,
}

/// Distances of both centroids from the contact, mm.
#[derive(Clone, Copy, Debug)]
struct Misses {
    energy: f32,
    amplitude: f32,
}

impl Split {
    fn pulses(&self, share: f32) -> u8 {
        self.most - u8::from(share >= self.fewer_from)
    }

    /// Between the two exact laws, sqrt(share / pulses) and share.
    fn amplitude(&self, share: f32) -> f32 {
        let fewer = f32::from(self.pulses(share)) / f32::from(self.most);
        let exponent =
            (1.0 + self.blend) * libm::logf(share) - (1.0 - self.blend) * libm::logf(fewer);
        libm::expf(0.5 * exponent)
    }
}

impl Inverse {
    pub(super) const fn new(cells: Cells, margin: f32) -> Self {
        Self { cells, margin }
    }

    /// Writes amplitude and number of pulses, `most` or one less, of every wire for a contact at `at` (display mm). One wire
    /// alone has the amplitude 1. The energy, pulses times squared amplitudes, is `most` everywhere inside the hull: a wire
    /// with a pulse less may have a little over 1.
    pub fn split(&self, at: Point, most: u8, amplitudes: &mut [f32], pulses: &mut [u8]) {
        pulses.fill(most);
        self.solve(at, most, true, amplitudes, |wire, n| pulses[wire] = n);
    }

    fn solve(
        &self,
        at: Point,
        most: u8,
        unequal: bool,
        out: &mut [f32],
        mut count: impl FnMut(usize, u8),
    ) {
        let (near, beyond) = self.cells.nearest(at);
        // What is no number compares false.
        let within = beyond < self.margin;
        if !within {
            out.fill(0.0);
            return;
        }
        self.cells.shares(near, out);
        let largest = out.iter().copied().fold(0.0, f32::max);
        let mut best = self.fit(near, out, most, f32::INFINITY);
        if unequal && most > 1 && largest <= ON_WIRE {
            let other = self.fit(near, out, most, STRONG * largest);
            if other.1 < best.1 {
                best = other;
            }
        }
        let mut energy = 0.0;
        for (wire, a) in out.iter_mut().enumerate().filter(|(_, a)| **a > 0.0) {
            let n = best.0.pulses(*a);
            *a = best.0.amplitude(*a);
            energy += f32::from(n) * *a * *a;
            count(wire, n);
        }
        let scale = libm::sqrtf(f32::from(most) / energy) * (1.0 - beyond / self.margin);
        out.iter_mut().for_each(|a| *a *= scale);
    }

    /// The blend that makes the sum of both squared misses least, and that sum, mm2. Each miss grows about evenly from the
    /// end where it is none, so the least is known in closed form; measuring there again corrects it.
    fn fit(&self, at: Point, shares: &[f32], most: u8, fewer_from: f32) -> (Split, f32) {
        let mut split = Split {
            most,
            fewer_from,
            blend: 0.0,
        };
        let amplitude = self.misses(at, shares, &split).amplitude;
        split.blend = 1.0;
        let energy = self.misses(at, shares, &split).energy;
        let mut slopes = Misses { energy, amplitude };
        let mut sum = 0.0;
        for _ in 0..=CORRECTIONS {
            let (e2, a2) = (
                slopes.energy * slopes.energy,
                slopes.amplitude * slopes.amplitude,
            );
            // Where neither centroid misses, any blend will do.
            split.blend = if e2 + a2 > 0.0 { a2 / (e2 + a2) } else { 0.5 };
            let misses = self.misses(at, shares, &split);
            sum = misses.energy * misses.energy + misses.amplitude * misses.amplitude;
            if split.blend > 0.0 && split.blend < 1.0 {
                slopes.energy = misses.energy / split.blend;
                slopes.amplitude = misses.amplitude / (1.0 - split.blend);
            }
        }
        (split, sum)
    }

    fn misses(&self, at: Point, shares: &[f32], split: &Split) -> Misses {
        let mut sums = [[0.0f32; 3]; 2];
        let active = shares.iter().enumerate().filter(|(_, s)| **s > 0.0);
        for (wire, &share) in active {
            let place = self.cells.place(wire);
            let a = split.amplitude(share);
            let weights = [f32::from(split.pulses(share)) * a * a, a];
            for (sum, weight) in sums.iter_mut().zip(weights) {
                sum[0] += weight;
                sum[1] += weight * (place.x - at.x);
                sum[2] += weight * (place.y - at.y);
            }
        }
        let [energy, amplitude] = sums.map(|[all, x, y]| libm::sqrtf(x * x + y * y) / all);
        Misses { energy, amplitude }
    }
}

impl Illusion for Inverse {
    /// With as many pulses on every wire.
    fn activate(&self, at: Point, out: &mut [f32]) {
        self.solve(at, 1, false, out, |_, _| ());
    }
}

#[cfg(test)]
#[path = "inverse_tests.rs"]
mod tests;
