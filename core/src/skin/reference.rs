//! The reference frame of (4.1), taxel by taxel: its collection, the noise of a taxel at rest, and the slow drift
//! that the reference follows afterwards.

use alloc::vec::Vec;

use super::scan::Scan;
use crate::statistics::quantile;
use crate::vector::Vectors;

/// Largest noise over the median: a noisier taxel was touched or is ill, and counts as this noisy.
const NOISIEST: f32 = 4.0;

/// Number at which an `f32` is good to whole ones: a smaller one that is added and taken away again is rounded.
const WHOLE: f32 = 12_582_912.0;

/// Most by which a taxel at rest may leave its first reading, and its mean drift from one half to the next, in
/// deviations of noise.
const CALM_SIGMAS: f64 = 8.0;
const SLOPE_SIGMAS: f64 = 3.0;

/// Sums of a taxel at the middle of the collection.
#[derive(Clone, Copy, Debug, Default)]
struct Half {
    first: [u16; 3],
    away: u16,
    sums: [u64; 3],
    seen: u32,
    /// Squared step across the middle.
    across: u32,
    steps: (u64, u32),
}

/// Reference and noise of every taxel along the chosen axes; the others stay 0.
#[derive(Clone, Debug)]
pub(super) struct Reference {
    axes: [bool; 3],
    vectors: Vectors,
    /// The reference, split into whole counts and the rest: at 49,000 counts one `f32` is good to 0.002 counts
    /// only, while a difference of whole counts is exact.
    whole: Vec<[f32; 3]>,
    rest: Vec<[f32; 3]>,
    sums: Vec<[u64; 3]>,
    seen: Vec<u32>,
    last: Vec<[u16; 3]>,
    /// Sums of the first half of the collection, and the furthest distance of a reading from the first on any chosen
    /// axis.
    halves: Vec<Half>,
    /// Squared steps from one distinct reading to the next over all chosen axes, and their number.
    steps: Vec<(u64, u32)>,
    sorted: Vec<f32>,
}

impl Reference {
    pub(super) fn new(taxels: usize, axes: [bool; 3]) -> Self {
        let zeros = || alloc::vec![[0.0; 3]; taxels];
        Self {
            axes,
            vectors: Vectors::widest(),
            whole: zeros(),
            rest: zeros(),
            sums: alloc::vec![[0; 3]; taxels],
            seen: alloc::vec![0; taxels],
            last: alloc::vec![[0; 3]; taxels],
            halves: alloc::vec![Half::default(); taxels],
            steps: alloc::vec![(0, 0); taxels],
            sorted: Vec::with_capacity(taxels),
        }
    }

    pub(super) fn taxels(&self) -> usize {
        self.sums.len()
    }

    /// Starts over with these taxels.
    pub(super) fn restart(&mut self, range: core::ops::Range<usize>) {
        for i in range {
            self.sums[i] = [0; 3];
            self.seen[i] = 0;
            self.halves[i] = Half::default();
            self.steps[i] = (0, 0);
        }
    }

    /// Takes a contact-free reading of these taxels; those never received are left out.
    pub(super) fn collect(&mut self, scan: &Scan, range: core::ops::Range<usize>) {
        for i in range {
            if !scan.seen()[i] {
                continue;
            }
            let counts = scan.counts()[i];
            let half = &mut self.halves[i];
            if self.seen[i] == 0 {
                (half.first, self.last[i]) = (counts, counts);
            }
            let axes = counts.iter().zip(half.first).zip(self.axes);
            let chosen = axes.filter(|(_, chosen)| *chosen);
            let away = chosen.map(|((a, b), _)| a.abs_diff(b)).max();
            half.away = half.away.max(away.unwrap_or(0));
            let before = self.steps[i].0;
            self.hear(i, counts, f32::INFINITY);
            if self.seen[i] == self.halves[i].seen {
                let across = u32::try_from(self.steps[i].0 - before);
                self.halves[i].across = across.unwrap_or(u32::MAX);
            }
            self.seen[i] += 1;
            for (sum, c) in self.sums[i].iter_mut().zip(counts) {
                *sum += u64::from(c);
            }
        }
    }

    /// Takes a reading at rest for the noise alone. A step of more than `most` counts is none.
    pub(super) fn hear(&mut self, taxel: usize, counts: [u16; 3], most: f32) {
        // Half the mean squared step is the variance, whatever slow drift there is (von Neumann 1941).
        // Rows that merely repeat carry no noise.
        if counts != self.last[taxel] {
            let axes = counts.iter().zip(self.last[taxel]).zip(self.axes);
            let chosen = axes.filter(|(_, chosen)| *chosen);
            let square = chosen.map(|((a, b), _)| u64::from(a.abs_diff(b)).pow(2));
            let square = square.sum::<u64>();
            if square as f32 <= most * most {
                self.steps[taxel].0 += square;
                self.steps[taxel].1 += 1;
            }
        }
        self.last[taxel] = counts;
    }

    /// Marks the first half of the collection of these taxels as complete.
    pub(super) fn halve(&mut self, range: core::ops::Range<usize>) {
        for i in range {
            let half = &mut self.halves[i];
            (half.sums, half.seen, half.steps) = (self.sums[i], self.seen[i], self.steps[i]);
        }
    }

    /// Returns true if a taxel moved by more than noise and `most` counts while the reference was collected. A step
    /// makes one half noisy; a slope makes both halves alike and their means different.
    pub(super) fn moved(&self, taxel: usize, most: f32) -> bool {
        let (half, sums) = (&self.halves[taxel], &self.sums[taxel]);
        let (square, n) = self.steps[taxel];
        let noise = |square: u64, n: u32| libm::sqrt(0.5 * square as f64 / f64::from(n.max(1)));
        // A single reading far off makes two steps. Beside the middle they would make both halves noisy.
        let (late, across) = (square - half.steps.0, u64::from(half.across));
        let late = (late - across, n - half.steps.1 - u32::from(across > 0));
        let calm = noise(half.steps.0, half.steps.1).min(noise(late.0, late.1));
        let most = f64::from(most);
        if f64::from(half.away) > most + CALM_SIGMAS * calm {
            return true;
        }
        let (early, late) = (half.seen, self.seen[taxel] - half.seen);
        if early == 0 || late == 0 {
            return false;
        }
        let sigmas = libm::sqrt(1.0 / f64::from(early) + 1.0 / f64::from(late));
        let slope = SLOPE_SIGMAS * sigmas * noise(square, n);
        (0..3).filter(|a| self.axes[*a]).any(|a| {
            let before = half.sums[a] as f64 / f64::from(early);
            let after = (sums[a] - half.sums[a]) as f64 / f64::from(late);
            libm::fabs(after - before) > 0.5 * most + slope
        })
    }

    /// Makes the reference of these taxels: the mean of their collected readings.
    pub(super) fn finish(&mut self, range: core::ops::Range<usize>) {
        for i in range {
            for axis in 0..3 {
                let mean = self.sums[i][axis] as f64 / f64::from(self.seen[i].max(1));
                let whole = libm::floor(mean);
                self.whole[i][axis] = whole as f32;
                self.rest[i][axis] = (mean - whole) as f32;
            }
        }
    }

    /// Returns true if a taxel was received while the reference was collected.
    pub(super) fn knows(&self, taxel: usize) -> bool {
        self.seen[taxel] > 0
    }

    /// Sets thresholds by the noise of every taxel at rest, counts (Euclidean over the chosen axes): `floor` and so many
    /// deviations. Robust: a taxel that never changed counts as the median one, and none as more than four times that.
    pub(super) fn weigh(&mut self, floor: f32, sigmas: f32, thresholds: &mut [f32]) {
        let own = |&(square, n): &(u64, u32)| {
            (n > 0).then(|| libm::sqrt(0.5 * square as f64 / f64::from(n)) as f32)
        };
        self.sorted.clear(); // its capacity is all taxels
        self.sorted.extend(self.steps.iter().filter_map(own));
        self.sorted.sort_unstable_by(f32::total_cmp);
        let median = quantile(&self.sorted, 0.5).map_or(0.0, |middle| middle.above);
        for (threshold, steps) in thresholds.iter_mut().zip(&self.steps) {
            let noise = own(steps).unwrap_or(median).min(NOISIEST * median);
            *threshold = floor + sigmas * noise;
        }
    }

    /// The reference of a taxel along an axis, counts.
    pub(super) fn at(&self, axis: usize, taxel: usize) -> Option<f64> {
        let (whole, rest) = (
            self.whole.get(taxel)?.get(axis)?,
            self.rest.get(taxel)?.get(axis)?,
        );
        Some(f64::from(*whole) + f64::from(*rest))
    }

    /// |G - Gref| of one value, as [`Reference::measure`] computes it.
    pub(super) fn difference(&self, axis: usize, taxel: usize, counts: u16) -> f32 {
        libm::fabsf(f32::from(counts) - self.whole[taxel][axis] - self.rest[taxel][axis])
    }

    /// (4.2) for all taxels and axes.
    pub(super) fn measure(&self, counts: &[[u16; 3]], measured: &mut [[f32; 3]]) {
        let counts = counts.as_flattened();
        let (whole, rest) = (self.whole.as_flattened(), self.rest.as_flattened());
        let measured = measured.as_flattened_mut();
        self.vectors.run(
            #[inline(always)]
            || {
                let reference = whole.iter().zip(rest);
                for ((out, (whole, rest)), counts) in measured.iter_mut().zip(reference).zip(counts)
                {
                    *out = libm::fabsf(f32::from(*counts) - whole - rest);
                }
            },
        );
    }

    /// The reference of some taxels.
    pub(super) fn part(&mut self, range: core::ops::Range<usize>) -> Part<'_> {
        Part {
            axes: self.axes,
            whole: &mut self.whole[range.clone()],
            rest: &mut self.rest[range],
        }
    }
}

/// Reference of some taxels, which are counted from the first of them. Slices of one length need one check of an index.
pub(super) struct Part<'a> {
    axes: [bool; 3],
    whole: &'a mut [[f32; 3]],
    rest: &'a mut [[f32; 3]],
}

impl Part<'_> {
    /// Signed distance of a reading from its reference along x, y, z, counts; 0 where the axis is not chosen.
    #[inline]
    pub(super) fn away(&self, taxel: usize, counts: [u16; 3]) -> [f32; 3] {
        let along = |axis| self.along(axis, taxel, counts);
        [along(0), along(1), along(2)]
    }

    /// Signed distance of a reading from its reference along one axis.
    #[inline]
    pub(super) fn along(&self, axis: usize, taxel: usize, counts: [u16; 3]) -> f32 {
        match self.axes[axis] {
            true => f32::from(counts[axis]) - self.whole[taxel][axis] - self.rest[taxel][axis],
            false => 0.0,
        }
    }

    /// Moves the reference of a taxel by some counts along x, y, z.
    #[inline]
    pub(super) fn shift(&mut self, taxel: usize, by: [f32; 3]) {
        let (whole, rest) = (&mut self.whole[taxel], &mut self.rest[taxel]);
        for ((whole, rest), by) in whole.iter_mut().zip(rest).zip(by) {
            let moved = *rest + by;
            let nearest = (moved + WHOLE) - WHOLE;
            let floor = nearest - if nearest > moved { 1.0 } else { 0.0 };
            *whole += floor;
            *rest = moved - floor;
        }
    }
}
