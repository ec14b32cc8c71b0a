//! Figures of many numbers: where a part of them lies, their mean, and what lies between two of them. Health, summaries,
//! reports and studies all count ranks as here.

use alloc::vec::Vec;

/// The place of a part of sorted values: on one of them, or between two neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantile<T> {
    /// The last value up to there.
    pub below: T,
    /// The first value from there on.
    pub above: T,
    /// The way from the one to the other, 0 to 1.
    pub way: f64,
}

/// Finds the place of a part (0 to 1) of sorted values: the first is at 0, the last at 1, and all are equally far apart.
/// `None` where there is no value.
pub fn quantile<T: Copy>(sorted: &[T], part: f64) -> Option<Quantile<T>> {
    let place = part.clamp(0.0, 1.0) * sorted.len().checked_sub(1)? as f64;
    let whole = libm::floor(place);
    Some(Quantile {
        below: *sorted.get(whole as usize)?,
        above: *sorted.get(libm::ceil(place) as usize)?,
        way: place - whole,
    })
}

impl<T: Into<f64>> Quantile<T> {
    /// The value there, linearly between the neighbours.
    pub fn between(self) -> f64 {
        let (below, above) = (self.below.into(), self.above.into());
        below + (above - below) * self.way
    }
}

/// The median of values in any order, between the two in the middle. `None` of none.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    sorted.sort_unstable_by(f64::total_cmp);
    quantile(&sorted, 0.5).map(Quantile::between)
}

/// The mean, summed in the order of the values. `None` of none.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut count = 0_usize;
    let sum: f64 = values.into_iter().inspect(|_| count += 1).sum();
    (count > 0).then(|| sum / count as f64)
}

/// The value at `x` on straight lines between points `[x, y]` of ascending x, whose ends hold. `None` of no points.
pub fn interpolated(points: &[[f64; 2]], x: f64) -> Option<f64> {
    let next = points.partition_point(|[at, _]| *at <= x);
    let before = next.checked_sub(1).and_then(|n| points.get(n));
    match (before, points.get(next)) {
        (Some([t, a]), Some([u, b])) => Some(a + (b - a) * (x - t) / (u - t)),
        (Some([_, only]), None) | (None, Some([_, only])) => Some(*only),
        (None, None) => None,
    }
}

#[cfg(test)]
#[path = "statistics_tests.rs"]
mod tests;
