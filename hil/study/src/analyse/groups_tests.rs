//! Tests of `groups.rs`.

use super::*;

/// Against SciPy 1.17.1: `binomtest(7, 20).proportion_ci(method="exact")` and `binomtest(7, 20).pvalue`.
#[test]
fn proportions_agree_with_scipy() {
    let found = proportion(7, 20).unwrap();
    assert!((found.low - 0.15390920).abs() < 1e-6, "{found:?}");
    assert!((found.high - 0.59218853).abs() < 1e-6, "{found:?}");
    assert!((sign_test(7, 20) - 0.26317596).abs() < 1e-6);
    assert_eq!(sign_test(0, 0), 1.0);
    assert_eq!(proportion(0, 9).unwrap().low, 0.0);
    assert_eq!(proportion(9, 9).unwrap().high, 1.0);
    assert_eq!(proportion(0, 0), None);
}

#[test]
fn the_effect_is_that_of_u() {
    let (a, b) = ([1.0, 2.0, 2.0, 5.0], [2.0, 3.0, 6.0]);
    let found = compared("x", ("a", "b"), [&a, &b]).unwrap();
    assert!((found.effect.value - (2.0 * found.u / 12.0 - 1.0)).abs() < 1e-12);
    assert!(found.effect.low <= found.effect.value && found.effect.value <= found.effect.high);
    assert!(compared("x", ("a", "b"), [&a, &[]]).is_none());
}

/// The interval of a mean holds the truth of a known distribution about as often as it says.
#[test]
fn intervals_hold_the_truth() {
    let mut random = RandomStream::new(3, "coverage");
    let holds = |_: &i32| {
        let values: Vec<f64> = (0..30).map(|_| random.normal()).collect();
        let mean = |groups: &[Vec<f64>]| groups[0].iter().sum::<f64>() / groups[0].len() as f64;
        let found = bootstrap(&[&values], mean).unwrap();
        found.low <= 0.0 && 0.0 <= found.high
    };
    let held = (0..200).filter(holds).count();
    assert!((178..=198).contains(&held), "{held} of 200");
}
