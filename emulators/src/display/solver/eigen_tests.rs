//! The decomposition against its definition, for chains of every kind.

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
