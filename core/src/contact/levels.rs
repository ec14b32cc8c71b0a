//! Intensity levels, the second stage (4.10) to (4.13): exact one-dimensional K-means, and assignment.
//!
//! On a line K-means has an exact answer by dynamic programming (Wang & Song 2011, Ckmeans.1d.dp), here with
//! divide and conquer over the monotone split points: O(k n log n). [`LevelTable::from_intensities`] runs it once
//! over a recording; [`LevelSolver`] per frame in memory made beforehand.

use alloc::vec::Vec;

use super::few::{self, FEW};
use crate::vector::Vectors;

/// Reasons for which levels cannot be found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LevelError {
    /// K_I = 0, or more than 65,535.
    #[error("the number of levels must be 1 to 65535")]
    BadCount,
    /// No intensity to find levels in.
    #[error("no intensity to find levels in")]
    Empty,
    /// A value is NaN or infinite.
    #[error("intensity {index} is not a finite number")]
    NotFinite {
        /// Index of that intensity.
        index: usize,
    },
    /// Weber spacing needs 0 < lowest <= highest and a positive fraction, all finite.
    #[error("expected 0 < lowest <= highest and a positive Weber fraction")]
    BadRange,
}

/// Intensity levels, ascending raw counts; level 1 is the lowest.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelTable(Vec<f32>);

impl LevelTable {
    /// Levels as given: sorted here, equal ones kept once.
    pub fn new(levels: &[f32]) -> Result<Self, LevelError> {
        if let Some(index) = levels.iter().position(|v| !v.is_finite()) {
            return Err(LevelError::NotFinite { index });
        }
        if levels.is_empty() {
            return Err(LevelError::Empty);
        }
        let mut sorted: Vec<f32> = levels.iter().map(|v| v + 0.0).collect();
        sorted.sort_unstable_by(f32::total_cmp);
        sorted.dedup();
        if sorted.len() > usize::from(u16::MAX) {
            return Err(LevelError::BadCount);
        }
        Ok(Self(sorted))
    }

    /// The optimal `k` levels over a recording's intensities (fewer if they take fewer values).
    pub fn from_intensities(intensities: &[f32], k: usize) -> Result<Self, LevelError> {
        check_count(k, intensities.len())?;
        let k = k.min(intensities.len());
        let mut solver = LevelSolver::new(intensities.len(), k);
        solver.solve(intensities)?;
        Self::new(solver.levels())
    }

    /// Just-noticeable differences: levels `lowest * (1 + weber)^i` up to `highest` (Weber's law).
    /// Their number is `floor(ln(highest/lowest) / ln(1 + weber)) + 1`.
    pub fn weber(lowest: f32, highest: f32, weber: f32) -> Result<Self, LevelError> {
        let sound = lowest > 0.0 && highest >= lowest && highest.is_finite();
        if !(sound && weber > 0.0 && weber.is_finite()) {
            return Err(LevelError::BadRange);
        }
        let step = libm::log1p(f64::from(weber));
        let span = libm::log(f64::from(highest) / f64::from(lowest));
        let top = libm::floor(span / step + 1e-9);
        if top >= f64::from(u16::MAX) {
            return Err(LevelError::BadCount);
        }
        let level = |i: u32| (f64::from(lowest) * libm::exp(step * f64::from(i))) as f32;
        Self::new(&(0..=top as u32).map(level).collect::<Vec<_>>())
    }

    /// The level nearest to an intensity, 1 ..= K_I; the lower of two equally near (4.12). NaN gives 1.
    pub fn level(&self, intensity: f32) -> u16 {
        nearest(&self.0, intensity)
    }

    /// All levels, ascending, counts.
    pub fn values(&self) -> &[f32] {
        &self.0
    }
}

/// Checks the number of levels that are to be found in so many intensities.
pub(super) fn check_count(k: usize, intensities: usize) -> Result<(), LevelError> {
    if k == 0 || k > usize::from(u16::MAX) {
        return Err(LevelError::BadCount);
    }
    match intensities {
        0 => Err(LevelError::Empty),
        _ => Ok(()),
    }
}

fn nearest(levels: &[f32], v: f32) -> u16 {
    let above = levels.partition_point(|l| *l < v);
    let (Some(high), Some(low)) = (levels.get(above), levels.get(above.wrapping_sub(1))) else {
        return above.clamp(1, levels.len().max(1)) as u16; // below the first or above the last
    };
    let up = f64::from(*high) - f64::from(v) < f64::from(v) - f64::from(*low);
    (above + usize::from(up)) as u16
}

/// Exact one-dimensional K-means in memory made beforehand.
#[derive(Clone, Debug)]
pub struct LevelSolver {
    most: usize,
    k: usize,
    vectors: Vectors,
    sorted: Vec<f32>,
    /// Prefix sums of values and squares, taken from the median: index i covers the first i values.
    sum: Vec<f64>,
    square: Vec<f64>,
    /// 1/m for clusters of m values: the divisions of the inner loop.
    share: Vec<f64>,
    /// Best cost of values 0 ..= i in `row + 1` clusters, row by row.
    cost: Vec<f64>,
    levels: Vec<f32>,
    todo: Vec<[u32; 4]>,
}

impl LevelSolver {
    /// Room for `most` values and up to `k` levels.
    pub fn new(most: usize, k: usize) -> Self {
        let k = k.min(most);
        Self {
            most,
            k,
            vectors: Vectors::widest(),
            sorted: Vec::with_capacity(most),
            sum: alloc::vec![0.0; most + 1],
            square: alloc::vec![0.0; most + 1],
            share: (0..=most).map(|m| 1.0 / m.max(1) as f64).collect(),
            cost: alloc::vec![0.0; if most > FEW { most * k } else { 0 }],
            levels: Vec::with_capacity(k),
            todo: Vec::with_capacity(64),
        }
    }

    /// Finds the levels of `values`; of equal splits the lowest. Values beyond the room made are dropped.
    pub fn solve(&mut self, values: &[f32]) -> Result<(), LevelError> {
        self.levels.clear();
        if let Some(index) = values.iter().position(|v| !v.is_finite()) {
            return Err(LevelError::NotFinite { index });
        }
        self.sorted.clear();
        self.sorted
            .extend(values.iter().take(self.most).map(|v| v + 0.0));
        self.sorted.sort_unstable_by(f32::total_cmp);
        let n = self.sorted.len();
        if n == 0 || self.k == 0 {
            return Ok(());
        }
        let centre = f64::from(self.sorted[n / 2]);
        for (i, v) in self.sorted.iter().enumerate() {
            let d = f64::from(*v) - centre;
            self.sum[i + 1] = self.sum[i] + d;
            self.square[i + 1] = self.square[i] + d * d;
        }
        let distinct = 1 + self.sorted.windows(2).filter(|p| p[0] < p[1]).count();
        let k = self.k.min(distinct);
        if n <= FEW {
            let starts = few::starts(self.vectors, &self.sum[..=n], &self.square[..=n], k);
            for row in 0..k {
                let end = if row + 1 < k { starts[row + 1] } else { n };
                self.push_mean(centre, starts[row], end);
            }
            return Ok(());
        }
        for i in 0..n {
            self.cost[i] = self.within(0, i);
        }
        for row in 1..k {
            // The clusters still to come take a value each, and after the last row only the whole counts.
            let to = n - (k - 1 - row);
            self.fill_row(row, if row + 1 == k { n - 1 } else { row }, to);
        }
        // Walk back from the last value.
        let mut end = n;
        for row in (0..k).rev() {
            let start = self.split(row, end - 1);
            self.push_mean(centre, start, end);
            end = start;
        }
        self.levels.reverse();
        Ok(())
    }

    /// Adds the level of values start .. end.
    fn push_mean(&mut self, centre: f64, start: usize, end: usize) {
        let mean = (self.sum[end] - self.sum[start]) / (end - start) as f64;
        self.levels.push((centre + mean) as f32);
    }

    /// Cost of values a ..= b as one cluster.
    fn within(&self, a: usize, b: usize) -> f64 {
        let s = self.sum[b + 1] - self.sum[a];
        let q = self.square[b + 1] - self.square[a];
        (q - s * s * self.share[b + 1 - a]).max(0.0)
    }

    /// Start of the last of `row + 1` clusters over values 0 ..= i: the first split of least cost.
    fn split(&self, row: usize, i: usize) -> usize {
        if row == 0 {
            return 0;
        }
        let before = &self.cost[(row - 1) * self.most..];
        let best = self.cost[row * self.most + i];
        let meets = |j: &usize| before[j - 1] + self.within(*j, i) <= best;
        (row..=i).find(meets).unwrap_or(i)
    }

    /// Best costs of values 0 ..= i for i in `from .. to`. The split point never goes back as i grows, so the middle
    /// i halves the range for both sides.
    fn fill_row(&mut self, row: usize, from: usize, to: usize) {
        self.todo.clear();
        self.todo
            .push([from as u32, to as u32, row as u32, to as u32]); // i in [0], [1]; split in [2], [3]
        let before = (row - 1) * self.most;
        while let Some([from, to, low, high]) = self.todo.pop() {
            if from >= to {
                continue;
            }
            let i = from + (to - from) / 2;
            let mut best = (f64::INFINITY, low);
            for j in low..high.min(i + 1) {
                let c = self.cost[before + j as usize - 1] + self.within(j as usize, i as usize);
                if c < best.0 {
                    best = (c, j);
                }
            }
            self.cost[row * self.most + i as usize] = best.0;
            self.todo.push([i + 1, to, best.1, high]);
            self.todo.push([from, i, low, best.1 + 1]);
        }
    }

    /// The levels found, ascending, counts.
    pub fn levels(&self) -> &[f32] {
        &self.levels
    }

    /// The level nearest to an intensity, as [`LevelTable::level`].
    pub fn level(&self, intensity: f32) -> u16 {
        nearest(&self.levels, intensity)
    }
}

#[cfg(test)]
#[path = "levels_tests.rs"]
mod tests;
