//! Exact levels of at most sixteen values: every split at once in wide vectors, which for so few is quicker than
//! the divide and conquer of [`super::levels`]. Same costs, same ties, same result.

use crate::vector::Vectors;

/// The most values.
pub(super) const FEW: usize = 16;

type Row = [f64; FEW];

/// Start of each of the `k` clusters of `n` sorted values, from prefix sums of values and squares over the first i
/// values. Of equal splits the lowest is taken. n is 1 to [`FEW`], k 1 to n.
pub(super) fn starts(vectors: Vectors, sum: &[f64], square: &[f64], k: usize) -> [usize; FEW] {
    vectors.run(
        #[inline(always)]
        || solve(sum, square, k),
    )
}

#[inline(always)]
fn solve(sum: &[f64], square: &[f64], k: usize) -> [usize; FEW] {
    let n = (sum.len() - 1).min(FEW);
    let k = k.clamp(1, n);
    let (mut s, mut q) = ([0.0; FEW], [0.0; FEW]);
    s[..n].copy_from_slice(&sum[1..=n]);
    q[..n].copy_from_slice(&square[1..=n]);
    // shares[FEW + m] = 1/m, the share of a value in a cluster of m.
    let mut shares = [0.0; 2 * FEW + 1];
    for m in 1..=FEW {
        shares[FEW + m] = 1.0 / m as f64;
    }
    // Cost of values j ..= i as one cluster.
    let mut within: [Row; FEW] = [[f64::INFINITY; FEW]; FEW];
    for (j, row) in within.iter_mut().enumerate().take(n) {
        let (s0, q0) = (sum[j], square[j]);
        let mut cost = [0.0; FEW];
        let shares = &shares[FEW + 1 - j..][..FEW];
        for i in 0..FEW {
            let (s, q) = (s[i] - s0, q[i] - q0);
            cost[i] = (q - s * s * shares[i]).max(0.0);
        }
        row[j..].copy_from_slice(&cost[j..]);
    }
    // best[row][i]: least cost of values 0 ..= i in row + 1 clusters.
    let mut best: [Row; FEW] = [[f64::INFINITY; FEW]; FEW];
    best[0] = within[0];
    for row in 1..k {
        let mut least = [f64::INFINITY; FEW];
        for j in row..n {
            let before = best[row - 1][j - 1];
            for (least, within) in least.iter_mut().zip(&within[j]) {
                let cost = before + within;
                *least = if cost < *least { cost } else { *least };
            }
        }
        best[row] = least;
    }
    let mut starts = [0; FEW];
    let mut end = n - 1;
    for row in (1..k).rev() {
        let meets = |j: &usize| best[row - 1][j - 1] + within[*j][end] <= best[row][end];
        starts[row] = (row..=end).find(meets).unwrap_or(end);
        end = starts[row] - 1;
    }
    starts
}
