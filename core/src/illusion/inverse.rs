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
/// Least share of all weak wires together at which strong wires do with a pulse less. The pulse that makes the burst a
/// vibration then has to be felt on weak wires, and the numbers stay while a contact crosses a wire. With a fifth, the
/// numbers change where the weak wire already moves the place, which jumps then.
const WEAK: f32 = 0.1;
/// Largest number of pulses that every wire keeps: a tap has two, and a tap less one pulse would be half.
const TAP: u8 = 2;
/// Times that the compromise between both centroids is corrected. Two bring it to 0.01 mm on gaps of 9 mm.
const CORRECTIONS: u32 = 2;
/// Number of Gauss-Newton steps that then move every wire by itself, and the largest step of an amplitude's logarithm.
const STEPS: (u32, f32) = (2, 0.4);
/// Damping of a step, as a part of the matrix's trace: what no amplitudes can mend shall not move them.
const DAMPING: f32 = 2e-3;

/// Shares by the cells between wires, turned into what both centroids feel where the contact is.
#[derive(Clone, Debug)]
pub struct Inverse {
    cells: Cells,
    /// Distance beyond the hull from which on a contact is not rendered, mm. Nearer to the hull it is rendered on the
    /// edge, weaker with distance.
    margin: f32,
}

/// One way to distribute pulses over wires, and the amplitudes that go best with it.
#[derive(Clone, Copy, Debug)]
struct Split {
    /// Largest number of pulses of a wire; a wire has as many, or one less.
    most: u8,
    /// Logarithm of the part of all pulses that a wire with a pulse less has.
    fewer: f32,
    /// Place of the law between both exact ones: 0 where the energy
    /// centroid is exact, 1 where the amplitude centroid is.
    blend: f32,
}

/// The logarithm of a share of zero.
const NO_SHARE: f32 = f32::NEG_INFINITY;

/// Distances of both centroids from the contact, mm.
#[derive(Clone, Copy, Debug)]
struct Misses {
    energy: f32,
    amplitude: f32,
}

impl Split {
    /// Amplitude between the two exact laws, sqrt(share / pulses) and share.
    fn amplitude(&self, log_share: f32, pulses: u8) -> f32 {
        let fewer = if pulses < self.most { self.fewer } else { 0.0 };
        let exponent = (1.0 + self.blend) * log_share - (1.0 - self.blend) * fewer;
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
        let Some((near, scale)) = self.share(at, amplitudes) else {
            return;
        };
        let largest = amplitudes.iter().copied().fold(0.0, f32::max);
        let weak = amplitudes.iter().filter(|s| **s < STRONG * largest);
        let spares = most > TAP && weak.sum::<f32>() >= WEAK;
        for (share, n) in amplitudes.iter().zip(&mut *pulses) {
            *n -= u8::from(spares && *share >= STRONG * largest);
        }
        logarithms(amplitudes);
        let mut best = self.fit(near, amplitudes, most, |_| most);
        let mut spared = false;
        if spares {
            let other = self.fit(near, amplitudes, most, |wire| pulses[wire]);
            if other.1 < best.1 {
                (best, spared) = (other, true);
            }
        }
        if !spared {
            pulses.fill(most);
        }
        self.settle(near, &best.0, amplitudes, |wire| pulses[wire]);
        let energies = amplitudes.iter().zip(pulses);
        let energy: f32 = energies.map(|(a, n)| f32::from(*n) * a * a).sum();
        let scale = scale * libm::sqrtf(f32::from(most) / energy);
        amplitudes.iter_mut().for_each(|a| *a *= scale);
    }

    /// Writes the shares of the nearest place inside the hull. Returns
    /// that place, and the part of full level that is left there.
    fn share(&self, at: Point, out: &mut [f32]) -> Option<(Point, f32)> {
        let (near, beyond) = self.cells.nearest(at);
        // What is no number compares false.
        let within = beyond < self.margin;
        if !within {
            out.fill(0.0);
            return None;
        }
        self.cells.shares(near, out);
        Some((near, 1.0 - beyond / self.margin))
    }

    /// Logarithms of shares in place to amplitudes.
    fn settle(&self, at: Point, split: &Split, out: &mut [f32], pulses: impl Fn(usize) -> u8) {
        let mut active = 0;
        for (wire, a) in out.iter_mut().enumerate() {
            if *a > NO_SHARE {
                *a = split.amplitude(*a, pulses(wire));
                active += 1;
            } else {
                *a = 0.0;
            }
        }
        // Of two wires the blend says all there is to say.
        if active > 2 {
            for _ in 0..STEPS.0 {
                self.step(at, out, &pulses);
            }
        }
    }

    /// One Gauss-Newton step of the logarithms of amplitudes towards the least squares of both misses, the smallest of all
    /// steps that lead there.
    fn step(&self, at: Point, amplitudes: &mut [f32], pulses: &impl Fn(usize) -> u8) {
        let active = |a: &[f32]| -> [f32; 6] {
            let mut sums = [0.0; 6];
            for (wire, &a) in a.iter().enumerate().filter(|(_, a)| **a > 0.0) {
                let (place, energy) = (self.cells.place(wire), f32::from(pulses(wire)) * a * a);
                let (x, y) = (place.x - at.x, place.y - at.y);
                let terms = [energy, energy * x, energy * y, a, a * x, a * y];
                sums.iter_mut().zip(terms).for_each(|(s, t)| *s += t);
            }
            sums
        };
        let [e, ex, ey, p, px, py] = active(amplitudes);
        let misses = [ex / e, ey / e, px / p, py / p];
        // How both centroids move with the logarithm of a wire's amplitude.
        let moves = |wire: usize, a: f32| -> [f32; 4] {
            let place = self.cells.place(wire);
            let (x, y) = (place.x - at.x, place.y - at.y);
            let (energy, peak) = (2.0 * f32::from(pulses(wire)) * a * a / e, a / p);
            let to = [x - misses[0], y - misses[1], x - misses[2], y - misses[3]];
            [energy * to[0], energy * to[1], peak * to[2], peak * to[3]]
        };
        let mut matrix = [[0.0; 4]; 4];
        for (wire, &a) in amplitudes.iter().enumerate().filter(|(_, a)| **a > 0.0) {
            let moves = moves(wire, a);
            for (row, of) in matrix.iter_mut().zip(moves) {
                row.iter_mut().zip(moves).for_each(|(m, by)| *m += of * by);
            }
        }
        let trace: f32 = (0..4).map(|i| matrix[i][i]).sum();
        (0..4).for_each(|i| matrix[i][i] += DAMPING * trace);
        let forces = solved(matrix, misses);
        for (wire, a) in amplitudes.iter_mut().enumerate().filter(|(_, a)| **a > 0.0) {
            let terms = moves(wire, *a).into_iter().zip(forces);
            let step: f32 = terms.map(|(m, f)| -m * f).sum();
            *a *= libm::expf(step.clamp(-STEPS.1, STEPS.1));
        }
    }

    /// The blend that makes the sum of both squared misses least, and that sum, mm2. Each miss grows about evenly from the
    /// end where it is none, so the least is known in closed form; measuring there again corrects it.
    fn fit(
        &self,
        at: Point,
        log_shares: &[f32],
        most: u8,
        pulses: impl Fn(usize) -> u8,
    ) -> (Split, f32) {
        let mut split = Split {
            most,
            fewer: libm::logf(f32::from(most.saturating_sub(1)) / f32::from(most)),
            blend: 0.0,
        };
        let misses = |split: &Split| self.misses(at, log_shares, split, &pulses);
        let amplitude = misses(&split).amplitude;
        split.blend = 1.0;
        let energy = misses(&split).energy;
        let mut slopes = Misses { energy, amplitude };
        let mut sum = 0.0;
        for _ in 0..=CORRECTIONS {
            let (e2, a2) = (
                slopes.energy * slopes.energy,
                slopes.amplitude * slopes.amplitude,
            );
            // Where neither centroid misses, any blend will do.
            split.blend = if e2 + a2 > 0.0 { a2 / (e2 + a2) } else { 0.5 };
            let misses = misses(&split);
            sum = misses.energy * misses.energy + misses.amplitude * misses.amplitude;
            if split.blend > 0.0 && split.blend < 1.0 {
                slopes.energy = misses.energy / split.blend;
                slopes.amplitude = misses.amplitude / (1.0 - split.blend);
            }
        }
        (split, sum)
    }

    fn misses(
        &self,
        at: Point,
        log_shares: &[f32],
        split: &Split,
        pulses: &impl Fn(usize) -> u8,
    ) -> Misses {
        let mut sums = [[0.0f32; 3]; 2];
        let active = log_shares.iter().enumerate();
        for (wire, &log) in active.filter(|(_, log)| **log > NO_SHARE) {
            let (place, n) = (self.cells.place(wire), pulses(wire));
            let a = split.amplitude(log, n);
            let weights = [f32::from(n) * a * a, a];
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
    /// Writes amplitudes for as many pulses on every wire.
    fn activate(&self, at: Point, out: &mut [f32]) {
        let Some((near, scale)) = self.share(at, out) else {
            return;
        };
        logarithms(out);
        let (split, _) = self.fit(near, out, 1, |_| 1);
        self.settle(near, &split, out, |_| 1);
        let energy: f32 = out.iter().map(|a| a * a).sum();
        let scale = scale / libm::sqrtf(energy);
        // One wire alone has no more than 1, whatever the rounding.
        out.iter_mut().for_each(|a| *a = (*a * scale).min(1.0));
    }
}

/// Shares in place to their logarithms, which every blend needs.
fn logarithms(shares: &mut [f32]) {
    for share in shares {
        *share = match *share > 0.0 {
            true => libm::logf(*share),
            false => NO_SHARE,
        };
    }
}

/// The solution of a symmetric positive system.
fn solved(mut matrix: [[f32; 4]; 4], mut right: [f32; 4]) -> [f32; 4] {
    for pivot in 0..4 {
        for row in pivot + 1..4 {
            let part = matrix[row][pivot] / matrix[pivot][pivot];
            let above = matrix[pivot];
            let columns = matrix[row].iter_mut().zip(above);
            columns.for_each(|(m, above)| *m -= part * above);
            right[row] -= part * right[pivot];
        }
    }
    for row in (0..4).rev() {
        let known: f32 = (row + 1..4).map(|c| matrix[row][c] * right[c]).sum();
        right[row] = (right[row] - known) / matrix[row][row];
    }
    right
}

#[cfg(test)]
#[path = "inverse_tests.rs"]
mod tests;
