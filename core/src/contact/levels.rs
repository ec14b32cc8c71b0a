//! Intensity levels: exact one-dimensional K-means by dynamic programming (Wang & Song 2011,
//! Ckmeans.1d.dp, with divide and conquer over the monotone split points), and Weber levels.

use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

/// Why there are no levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelsError {
    /// No value, or none asked for.
    Empty,
    /// This value is not a finite number.
    NotFinite(usize),
    /// Weber levels need 0 < lowest < highest and a fraction above zero.
    Range,
}

impl fmt::Display for LevelsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "expected at least one intensity and one level"),
            Self::NotFinite(i) => write!(f, "intensity {i}: expected a finite number"),
            Self::Range => write!(
                f,
                "expected 0 < lowest < highest and a Weber fraction above 0"
            ),
        }
    }
}

impl core::error::Error for LevelsError {}

/// The `k` levels (ascending means) that minimise the sum of squared distances of all values to their
/// level: exact, O(k n log n). Fewer distinct values than `k` give one level each.
///
/// Allocates: levels are found over a recording, not in the loop.
///
/// # Errors
/// [`LevelsError`] for no values, `k` = 0, or a value that is not finite.
pub fn optimal_levels(values: &[f32], k: usize) -> Result<Vec<f32>, LevelsError> {
    if values.is_empty() || k == 0 {
        return Err(LevelsError::Empty);
    }
    if let Some(i) = values.iter().position(|v| !v.is_finite()) {
        return Err(LevelsError::NotFinite(i));
    }
    let mut sorted: Vec<f64> = values.iter().map(|&v| f64::from(v)).collect();
    sorted.sort_by(f64::total_cmp);
    let distinct = 1 + sorted.windows(2).filter(|w| w[0] < w[1]).count();
    let k = k.min(distinct);
    let n = sorted.len();

    // Sums from the median, so that a cost is a small difference of small numbers.
    let shift = sorted[n / 2];
    let mut sums = vec![(0.0, 0.0); n + 1];
    for (i, v) in sorted.iter().enumerate() {
        let d = v - shift;
        sums[i + 1] = (sums[i].0 + d, sums[i].1 + d * d);
    }
    // Cost of one level for values from ..= to.
    let cost = |from: usize, to: usize| {
        let (s, s2) = (sums[to + 1].0 - sums[from].0, sums[to + 1].1 - sums[from].1);
        (s2 - s * s / (to - from + 1) as f64).max(0.0)
    };
    let mut best: Vec<f64> = (0..n).map(|to| cost(0, to)).collect();
    let mut starts: Vec<Vec<u32>> = vec![vec![0; n]];
    for level in 1..k {
        let mut next = vec![f64::INFINITY; n];
        let mut start = vec![0u32; n];
        // Ranges (values lo..=hi, split points from..=to) still to do: a stack, not a recursion.
        let mut pending = vec![(level, n - 1, level, n - 1)];
        while let Some((lo, hi, from, to)) = pending.pop() {
            let mid = lo + (hi - lo) / 2;
            for split in from..=to.min(mid) {
                let total = best[split - 1] + cost(split, mid);
                if total < next[mid] {
                    (next[mid], start[mid]) = (total, split as u32);
                }
            }
            let at = start[mid] as usize;
            if mid > lo {
                pending.push((lo, mid - 1, from, at.max(from)));
            }
            if mid < hi {
                pending.push((mid + 1, hi, at.max(level), to));
            }
        }
        best = next;
        starts.push(start);
    }
    let mut levels = vec![0.0; k];
    let mut to = n - 1;
    for level in (0..k).rev() {
        let from = starts[level][to] as usize;
        let mean = (sums[to + 1].0 - sums[from].0) / (to - from + 1) as f64 + shift;
        levels[level] = mean as f32;
        to = from.saturating_sub(1);
    }
    Ok(levels)
}

/// Levels a just noticeable difference apart: `lowest (1 + w)^n` up to `highest` (Weber's law).
///
/// # Errors
/// [`LevelsError::Range`] unless 0 < lowest < highest and w > 0; at most 4096 levels.
pub fn jnd_levels(lowest: f32, highest: f32, weber: f32) -> Result<Vec<f32>, LevelsError> {
    let count = libm::log(f64::from(highest) / f64::from(lowest)) / libm::log1p(f64::from(weber));
    if !(lowest > 0.0 && highest > lowest && weber > 0.0 && count < 4095.0) {
        return Err(LevelsError::Range);
    }
    let step = 1.0 + f64::from(weber);
    let level = |n: u32| (f64::from(lowest) * libm::pow(step, f64::from(n))) as f32;
    Ok((0..=count as u32).map(level).collect())
}

/// The level nearest to `intensity`, counted from 1; the lower one of two equally near. 1 if there are
/// no levels.
pub fn assign(levels: &[f32], intensity: f32) -> u16 {
    let above = levels.partition_point(|&l| l < intensity);
    let below = above.saturating_sub(1);
    let nearer = match levels.get(above) {
        Some(&high) if high - intensity < intensity - levels[below] => above,
        _ => below,
    };
    nearer as u16 + 1 // at most 4096 levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    fn cost(values: &[f32], levels: &[f32]) -> f64 {
        let nearest = |v: f32| {
            levels
                .iter()
                .map(|&l| f64::from(v - l).powi(2))
                .fold(f64::MAX, f64::min)
        };
        values.iter().map(|&v| nearest(v)).sum()
    }

    /// Least cost over all ways to cut the sorted values into `k` runs.
    fn exhaustive(sorted: &[f32], k: usize) -> f64 {
        let one = |part: &[f32]| {
            let mean = part.iter().map(|&v| f64::from(v)).sum::<f64>() / part.len() as f64;
            part.iter()
                .map(|&v| (f64::from(v) - mean).powi(2))
                .sum::<f64>()
        };
        if k == 1 || sorted.len() <= 1 {
            return one(sorted);
        }
        let cuts = (1..sorted.len()).map(|c| one(&sorted[..c]) + exhaustive(&sorted[c..], k - 1));
        cuts.fold(one(sorted), f64::min)
    }

    #[test]
    fn no_cut_is_better() {
        let mut stream = Stream::new(11, "levels");
        for case in 0..400 {
            let n = 1 + (stream.next_u64() % 9) as usize;
            let k = 1 + (stream.next_u64() % 4) as usize;
            let coarse = if case % 2 == 0 { 4.0 } else { 1000.0 };
            let mut values: Vec<f32> = (0..n)
                .map(|_| (stream.uniform() * coarse).floor() as f32)
                .collect();
            let levels = optimal_levels(&values, k).unwrap();
            assert!(
                levels.windows(2).all(|w| w[0] < w[1]),
                "{values:?} {levels:?}"
            );
            values.sort_by(f32::total_cmp);
            let (ours, least) = (cost(&values, &levels), exhaustive(&values, k));
            assert!(
                (ours - least).abs() <= 1e-6 * least.max(1.0),
                "{values:?} k {k}: {ours} > {least}"
            );
        }
    }

    #[test]
    fn raw_counts_keep_their_digits_and_duplicates_do_no_harm() {
        let values = [37_000.0, 37_001.0, 37_500.0, 37_501.0, 37_501.0];
        let levels = optimal_levels(&values, 2).unwrap();
        assert!((levels[0] - 37_000.5).abs() < 0.01 && (levels[1] - 37_500.668).abs() < 0.01);
        assert_eq!(optimal_levels(&[5.0; 100], 10).unwrap(), [5.0]);
        assert_eq!(optimal_levels(&[], 3), Err(LevelsError::Empty));
        assert_eq!(optimal_levels(&[1.0], 0), Err(LevelsError::Empty));
        assert_eq!(
            optimal_levels(&[1.0, f32::NAN], 1),
            Err(LevelsError::NotFinite(1))
        );
    }

    #[test]
    fn the_nearest_level_the_lower_of_equals() {
        let levels = [10.0, 20.0, 40.0];
        let cases = [
            (0.0, 1),
            (10.0, 1),
            (15.0, 1),
            (15.1, 2),
            (30.0, 2),
            (30.1, 3),
            (99.0, 3),
        ];
        for (intensity, level) in cases {
            assert_eq!(assign(&levels, intensity), level, "{intensity}");
        }
        assert_eq!(assign(&[], 5.0), 1);
        assert_eq!(assign(&[7.0], 5.0), 1);
    }

    #[test]
    fn twenty_decibel_at_a_fifth_are_twelve_steps() {
        // ln(10) / ln(1.2) = 12.6 (anchors.md), so 13 levels from the lowest.
        let levels = jnd_levels(10.0, 100.0, 0.2).unwrap();
        assert_eq!(levels.len(), 13);
        assert!(levels.windows(2).all(|w| (w[1] / w[0] - 1.2).abs() < 1e-5));
        for bad in [
            (0.0, 1.0, 0.2),
            (2.0, 1.0, 0.2),
            (1.0, 2.0, 0.0),
            (1.0, 2.0, 1e-9),
            (1.0, f32::NAN, 0.1),
        ] {
            assert_eq!(jnd_levels(bad.0, bad.1, bad.2), Err(LevelsError::Range));
        }
    }
}
