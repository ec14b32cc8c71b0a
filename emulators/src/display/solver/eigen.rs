//! Eigenvalues and eigenvectors of a symmetric tridiagonal matrix.
//!
//! A wire on its tissue is a chain, and the matrix of a chain is tridiagonal as it stands: a general decomposition would
//! spend most of its time on making it so. Implicit QL with Wilkinson's shifts (Golub and Van Loan, Matrix
//! Computations, 8.3; EISPACK's imtql2): the same products and sums in a fixed order on every machine.

use crate::display::finger::NODES;
use palpate_core::vector::Vectors;

/// Steps towards one eigenvalue after which it is taken as it is. Two or three do; what is no number never ends.
const STEPS: usize = 60;

/// Eigenvalues in no order, and the eigenvector of each, of length 1: `vectors[k][node]`.
#[derive(Clone, Debug)]
pub struct Eigen {
    pub values: [f64; NODES],
    pub vectors: [[f64; NODES]; NODES],
}

impl Eigen {
    /// Of the matrix with this diagonal, and with `beside[i]` between i and i + 1; the last of these is not looked at.
    pub fn new(diagonal: [f64; NODES], beside: [f64; NODES]) -> Self {
        Vectors::widest().run(
            #[inline(always)]
            || Self::plain(diagonal, beside),
        )
    }

    #[inline(always)]
    fn plain(diagonal: [f64; NODES], beside: [f64; NODES]) -> Self {
        let (mut d, mut e) = (diagonal, beside);
        let mut vectors = [[0.0; NODES]; NODES];
        for (k, row) in vectors.iter_mut().enumerate() {
            row[k] = 1.0;
        }
        for low in 0..NODES {
            for _ in 0..STEPS {
                let high = (low..NODES - 1).find(|&i| {
                    let size = d[i].abs() + d[i + 1].abs();
                    e[i].abs() <= f64::EPSILON * size
                });
                let high = high.unwrap_or(NODES - 1);
                if high == low {
                    break;
                }
                step(&mut d, &mut e, &mut vectors, low, high);
            }
        }
        Self { values: d, vectors }
    }
}

/// One QL step on the block from `low` to `high`: chases the shift's bulge up from the bottom.
#[inline(always)]
fn step(
    d: &mut [f64; NODES],
    e: &mut [f64; NODES],
    vectors: &mut [[f64; NODES]; NODES],
    low: usize,
    high: usize,
) {
    let half = (d[low + 1] - d[low]) / (2.0 * e[low]);
    let root = libm::sqrt(half * half + 1.0);
    let mut g = d[high] - d[low] + e[low] / (half + libm::copysign(root, half));
    let (mut sine, mut cosine, mut p) = (1.0, 1.0, 0.0);
    for i in (low..high).rev() {
        let (f, b) = (sine * e[i], cosine * e[i]);
        let r = libm::sqrt(f * f + g * g);
        e[i + 1] = r;
        if r == 0.0 {
            // The block falls apart here.
            d[i + 1] -= p;
            e[high] = 0.0;
            return;
        }
        (sine, cosine) = (f / r, g / r);
        g = d[i + 1] - p;
        let r = (d[i] - g) * sine + 2.0 * cosine * b;
        p = sine * r;
        d[i + 1] = g + p;
        g = cosine * r - b;
        let (front, back) = vectors.split_at_mut(i + 1);
        let (a, b) = (&mut front[i], &mut back[0]);
        for k in 0..NODES {
            (a[k], b[k]) = (cosine * a[k] - sine * b[k], sine * a[k] + cosine * b[k]);
        }
    }
    d[low] -= p;
    e[low] = g;
    e[high] = 0.0;
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact by construction
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Farthest that S v = lambda v and V^T V = 1 are missed by, the first relative to the largest entry of S.
    fn missed(diagonal: &[f64; NODES], beside: &[f64; NODES], eigen: &Eigen) -> (f64, f64) {
        let size = diagonal.iter().chain(&beside[..NODES - 1]);
        let size = size.fold(0.0, |m: f64, v| m.max(v.abs()));
        let (mut residual, mut angle) = (0.0_f64, 0.0_f64);
        for (k, v) in eigen.vectors.iter().enumerate() {
            for i in 0..NODES {
                let mut image = diagonal[i] * v[i];
                if i > 0 {
                    image += beside[i - 1] * v[i - 1];
                }
                if i + 1 < NODES {
                    image += beside[i] * v[i + 1];
                }
                residual = residual.max((image - eigen.values[k] * v[i]).abs());
            }
            for (l, w) in eigen.vectors.iter().enumerate() {
                let dot: f64 = v.iter().zip(w).map(|(a, b)| a * b).sum();
                angle = angle.max((dot - if k == l { 1.0 } else { 0.0 }).abs());
            }
        }
        (residual / size.max(f64::MIN_POSITIVE), angle)
    }

    /// 2 on the diagonal and -1 beside it: 2 - 2 cos(k pi / (n + 1)).
    #[test]
    fn second_differences_have_the_eigenvalues_they_are_known_for() {
        let mut values = Eigen::new([2.0; NODES], [-1.0; NODES]).values;
        values.sort_by(f64::total_cmp);
        for (k, value) in values.iter().enumerate() {
            let angle = core::f64::consts::PI * (k + 1) as f64 / (NODES + 1) as f64;
            assert!(
                (value - (2.0 - 2.0 * libm::cos(angle))).abs() < 2e-15,
                "{k}: {value}"
            );
        }
    }

    #[test]
    fn what_falls_apart_or_is_no_number_ends() {
        let alone = Eigen::new([3.0; NODES], [0.0; NODES]);
        assert_eq!(alone.values, [3.0; NODES]);
        let mut beside = [1.0; NODES];
        beside[5] = 0.0;
        let eigen = Eigen::new([0.0; NODES], beside);
        let (residual, angle) = missed(&[0.0; NODES], &beside, &eigen);
        assert!(residual < 1e-14 && angle < 1e-14, "{residual} {angle}");
        for bad in [f64::NAN, f64::INFINITY, f64::MAX] {
            Eigen::new([bad; NODES], [bad; NODES]);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// Entries over twelve decades, as rates of a thin wire on thick shells are.
        #[test]
        fn any_chain_is_decomposed(
            decades in prop::array::uniform17(-6.0_f64..6.0),
            shares in prop::array::uniform17(-1.0_f64..1.0),
        ) {
            let diagonal = decades.map(|x| libm::pow(10.0, x));
            let beside = core::array::from_fn(|i| {
                shares[i] * libm::sqrt(diagonal[i] * diagonal[(i + 1) % NODES])
            });
            let eigen = Eigen::new(diagonal, beside);
            let (residual, angle) = missed(&diagonal, &beside, &eigen);
            // Backwards stable: off by a few n units of rounding (Golub and Van Loan, 8.3.5).
            let bound = NODES as f64 * f64::EPSILON;
            prop_assert!(residual < bound && angle < 1e-14, "{} {}", residual, angle);
        }
    }
}
