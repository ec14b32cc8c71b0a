//! Distances from the reference that the taxels of a module have in common: a few of them speak for all.

use super::reference::Part;

/// Taxels that speak for a module at most.
const SAMPLE: usize = 64;
/// Fewest taxels that speak for a module.
pub(super) const FEWEST: usize = 3;
/// Rank of the median, as a share.
pub(super) const MIDDLE: f32 = 0.5;

/// Room for the distances of those that speak, counts along x, y, z.
#[derive(Clone, Debug)]
pub(super) struct Speakers([[f32; LANES]; SAMPLE]);

/// Axes of a distance, and one more: so many numbers are a vector of the processor.
const LANES: usize = 4;

impl Default for Speakers {
    fn default() -> Self {
        Self([[0.0; LANES]; SAMPLE])
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
        let mut all = 0;
        for (i, counts) in counts.iter().enumerate().step_by(stride) {
            if speaks(i) {
                let [x, y, z] = reference.away(i, *counts);
                self.0[all] = [x, y, z, 0.0];
                all += 1;
            }
        }
        let nth = |rank: f32| (rank * all as f32) as usize; // below `all`: a rank is below 1
        let common = || {
            let distances = &mut self.0[..all];
            sort(distances);
            let [x, y, ..] = distances[nth(MIDDLE)];
            [x, y, distances[nth(rank)][2]]
        };
        (all >= FEWEST).then(common)
    }
}

/// Sorts finite numbers along every axis on its own, by Batcher's merge of odd and even places (Knuth, volume 3, 5.2.2 M). Its
/// comparisons are the same for all values: they take no branch that a processor would have to guess, and all axes at once.
fn sort(values: &mut [[f32; LANES]]) {
    let n = values.len();
    let mut merged = n.next_power_of_two() / 2;
    let widest = merged;
    while merged > 0 {
        let (mut step, mut part, mut distance) = (widest, 0, merged);
        loop {
            for i in 0..n - distance {
                if i & merged == part {
                    order(values, i, i + distance);
                }
            }
            if step == merged {
                break;
            }
            distance = step - merged;
            step /= 2;
            part = merged;
        }
        merged /= 2;
    }
}

/// Puts two of the values into order, along every axis.
fn order(values: &mut [[f32; LANES]], i: usize, j: usize) {
    let (a, b) = (values[i], values[j]);
    values[i] = core::array::from_fn(|l| if b[l] < a[l] { b[l] } else { a[l] });
    values[j] = core::array::from_fn(|l| if b[l] < a[l] { a[l] } else { b[l] });
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn every_axis_is_sorted_as_the_standard_library_sorts_it(
            rows in prop::collection::vec(prop::array::uniform4(-9i8..9), 1..70),
        ) {
            let mut values: Vec<[f32; LANES]> =
                rows.iter().map(|row| row.map(|v| f32::from(v) / 4.0)).collect();
            sort(&mut values);
            for axis in 0..LANES {
                let mut alone: Vec<i8> = rows.iter().map(|row| row[axis]).collect();
                alone.sort_unstable();
                let sorted: Vec<i8> = values.iter().map(|v| (v[axis] * 4.0) as i8).collect();
                prop_assert_eq!(sorted, alone);
            }
        }
    }
}
