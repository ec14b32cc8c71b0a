//! The reference frame of (4.1), taxel by taxel: how it is collected, how noisy a taxel is at rest, and how the
//! reference follows slow drift afterwards.

use alloc::vec::Vec;

use super::relative::RelativeFrame;
use super::scan::Scan;
use crate::statistics::quantile;
use crate::vector::Vectors;

/// A taxel noisier than this many times the median was touched or is ill; it counts as this noisy.
const NOISIEST: f32 = 4.0;

/// Reference and noise of every taxel. The axes are those chosen; the others stay 0.
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
    /// Squared steps from one distinct reading to the next, all chosen axes, and how many.
    steps: Vec<(u64, u32)>,
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
            steps: alloc::vec![(0, 0); taxels],
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
            if self.seen[i] > 0 && counts != self.last[i] {
                // Half the mean squared step is the variance, whatever slow drift there is (von Neumann 1941).
                // Rows that merely repeat say nothing about noise.
                let axes = counts.iter().zip(self.last[i]).zip(self.axes);
                let chosen = axes.filter(|(_, chosen)| *chosen);
                let square = chosen.map(|((a, b), _)| u64::from(a.abs_diff(b)).pow(2));
                self.steps[i].0 += square.sum::<u64>();
                self.steps[i].1 += 1;
            }
            self.last[i] = counts;
            self.seen[i] += 1;
            for (sum, c) in self.sums[i].iter_mut().zip(counts) {
                *sum += u64::from(c);
            }
        }
    }

    /// Makes the reference of these taxels: the mean of what was collected.
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

    /// Whether a taxel was received while the reference was collected.
    pub(super) fn knows(&self, taxel: usize) -> bool {
        self.seen[taxel] > 0
    }

    /// Noise of every taxel at rest, counts (Euclidean over the chosen axes), robust: a taxel that never changed
    /// counts as the median one, and none as more than four times that.
    pub(super) fn noise(&self) -> Vec<f32> {
        let own = |&(square, n): &(u64, u32)| {
            (n > 0).then(|| libm::sqrt(0.5 * square as f64 / f64::from(n)) as f32)
        };
        let mut sorted: Vec<f32> = self.steps.iter().filter_map(own).collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let median = quantile(&sorted, 0.5).map_or(0.0, |middle| middle.above);
        let robust = |s| own(s).unwrap_or(median).min(NOISIEST * median);
        self.steps.iter().map(robust).collect()
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

    /// Moves the reference of every usable taxel not in contact by `share` (0 to 1) of its way to the readings the
    /// frame was made from.
    pub(super) fn follow(&mut self, frame: &RelativeFrame, thresholds: &[f32], share: f32) {
        let limits = thresholds.iter().take(self.taxels());
        for (i, &threshold) in limits.enumerate() {
            if !frame.usable()[i] || frame.magnitude()[i] > threshold {
                continue;
            }
            for axis in 0..3 {
                if self.axes[axis] {
                    let (whole, rest) = (&mut self.whole[i][axis], &mut self.rest[i][axis]);
                    let away = f32::from(frame.counts[i][axis]) - *whole - *rest;
                    *rest += share * away;
                    let carry = libm::floorf(*rest);
                    *whole += carry;
                    *rest -= carry;
                }
            }
        }
    }
}
