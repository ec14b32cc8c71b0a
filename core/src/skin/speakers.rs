//! Distances from the reference that the taxels of a module have in common: a few of them speak for all.

use super::reference::Part;

/// Taxels that speak for a module at most.
const SAMPLE: usize = 64;
/// Fewest taxels that speak for a module.
pub(super) const FEWEST: usize = 3;
/// Rank of the median, as a share.
pub(super) const MIDDLE: f32 = 0.5;

/// Room for the distances of those that speak, counts, by axis.
#[derive(Clone, Debug)]
pub(super) struct Speakers([[f32; SAMPLE]; 3]);

impl Default for Speakers {
    fn default() -> Self {
        Self([[0.0; SAMPLE]; 3])
    }
}

impl Speakers {
    /// Distance from the reference along x, y, z that a module's taxels have in common, counts: the median along x and y, and the
    /// distance of a rank along z, of some of those that speak. `None` where too few do.
    pub(super) fn common(
        &mut self,
        reference: &Part<'_>,
        counts: &[[u16; 3]],
        rank: f32,
        speaks: impl Fn(usize) -> bool,
    ) -> Option<[f32; 3]> {
        let stride = counts.len().div_ceil(SAMPLE).max(1);
        let ([x, y, z], mut all) = (&mut self.0, 0);
        for (i, counts) in counts.iter().enumerate().step_by(stride) {
            if speaks(i) {
                [x[all], y[all], z[all]] = reference.away(i, *counts);
                all += 1;
            }
        }
        let nth = |rank: f32| (rank * all as f32) as usize; // below `all`: a rank is below 1
        let common = || {
            let [x, y, z] = [x, y, z].map(|axis| &axis[..all]);
            let middle = nth(MIDDLE);
            [nth_of(x, middle), nth_of(y, middle), nth_of(z, nth(rank))]
        };
        (all >= FEWEST).then(common)
    }
}

/// The value with `nth` others before it in the order of finite ones: the largest that at most so many are below. Counting takes
/// no branch that a processor would have to guess, which for a few values is the faster way.
fn nth_of(values: &[f32], nth: usize) -> f32 {
    let candidates = values.iter().map(|v| {
        let lower: u32 = values.iter().map(|w| u32::from(w < v)).sum();
        match lower as usize <= nth {
            true => *v,
            false => f32::NEG_INFINITY,
        }
    });
    candidates.fold(f32::NEG_INFINITY, f32::max)
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn counting_finds_the_value_that_sorting_finds(
            values in prop::collection::vec(prop_oneof![-9i8..9, Just(0)], 1..70),
            nth in 0usize..70,
        ) {
            let values: Vec<f32> = values.iter().map(|v| f32::from(*v) / 4.0).collect();
            let nth = nth % values.len();
            let mut sorted = values.clone();
            sorted.sort_unstable_by(f32::total_cmp);
            prop_assert_eq!(nth_of(&values, nth).to_bits(), sorted[nth].to_bits());
        }
    }
}
