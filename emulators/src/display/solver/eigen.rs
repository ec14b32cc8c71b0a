//! Eigenvalues and eigenvectors of a symmetric tridiagonal matrix.
//!
//! A wire on its tissue is a chain, and the matrix of a chain is tridiagonal from the start: a general decomposition
//! would spend most of its time on making it so. Implicit QL with Wilkinson's shifts (Golub and Van Loan, Matrix
//! Computations, 8.3; EISPACK's imtql2) needs the same products and sums in a fixed order on every machine.

use crate::display::finger::NODES;
use palpate_core::vector::Vectors;

/// Steps towards one eigenvalue after which it is taken as it is. Two or three suffice; a matrix with a NaN would
/// never end.
const STEPS: usize = 60;

/// Eigenvalues in no order, and the eigenvector of each, of length 1: `vectors[k][node]`.
#[derive(Clone, Debug)]
pub struct Eigen {
    pub values: [f64; NODES],
    pub vectors: [[f64; NODES]; NODES],
}

impl Eigen {
    /// Solves the matrix with this diagonal and with `beside[i]` between i and i + 1; the last of these is ignored.
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
#[path = "eigen_tests.rs"]
mod tests;
