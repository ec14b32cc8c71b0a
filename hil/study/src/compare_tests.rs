//! Tests of `compare.rs`.

use super::*;

/// Against `scipy.stats.mannwhitneyu(b, a, method="asymptotic")` of SciPy 1.17.1.
#[test]
fn it_agrees_with_scipy_with_ties() {
    let a = [1.0, 2.0, 2.0, 3.0, 4.0, 4.0, 5.0];
    let b = [2.0, 3.0, 4.0, 5.0, 5.0, 6.0, 6.0, 6.0];
    let (u, p) = test(&a, &b).unwrap();
    assert!((u - 44.5).abs() < 1e-12, "{u}");
    assert!((p - 0.06005331406956138).abs() < 1e-9, "{p}");
    let (_, other) = test(&b, &a).unwrap();
    assert!((other - p).abs() < 1e-12, "{other}");
}

/// Against `scipy.stats.mannwhitneyu(range(n), range(n, n + m), method="exact")` and `binomtest(n, n)`.
#[test]
fn few_people_cannot_differ_by_less_than_chance_allows() {
    for (sizes, p) in [
        ([1, 2], 2.0 / 3.0),
        ([2, 2], 1.0 / 3.0),
        ([3, 3], 0.1),
        ([4, 4], 1.0 / 35.0),
        ([5, 3], 1.0 / 28.0),
        ([0, 7], 1.0),
        ([1, 1], 1.0),
    ] {
        assert!((least_p(sizes) - p).abs() < 1e-12, "{sizes:?}");
    }
    assert!((0.0..1e-300).contains(&least_p([1000, 1000])));
    assert!((least_sign_p(5) - 0.0625).abs() < 1e-12);
    assert!((least_sign_p(0) - 1.0).abs() < 1e-12 && least_sign_p(6) < LEVEL);
    assert!(least_sign_p(u64::MAX) < 1e-300);
    let (_, p) = test(&[1.0, 2.0, 3.0], &[4.0, 5.0, 6.0]).unwrap();
    assert!((p - 0.1).abs() < 1e-12, "the approximation says 0.081: {p}");
}

#[test]
fn equal_groups_do_not_differ_and_no_number_is_no_group() {
    let same = test(&[3.0; 5], &[3.0; 4]);
    assert_eq!(same.map(|(_, p)| p), Some(1.0));
    assert!(test(&[], &[1.0]).is_none());
    assert!(test(&[f64::NAN, 1.0], &[1.0]).is_none());
}
