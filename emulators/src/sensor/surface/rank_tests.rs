//! Tests of `rank.rs`.

use super::*;

#[test]
fn ranks_correlate_as_by_hand() {
    let near = |found: f64, expected: f64| (found - expected).abs() < 1e-12;
    assert!(near(
        spearman(&[1.0, 2.0, 3.0, 4.0], &[10.0, 20.0, 25.0, 90.0]),
        1.0
    ));
    assert!(near(spearman(&[1.0, 2.0, 3.0], &[3.0, 2.0, 1.0]), -1.0));
    // ranks 0, 1.5, 1.5, 3 against 0, 1, 2, 3: 4.5 / sqrt(4.5 * 5)
    let tied = spearman(&[1.0, 2.0, 2.0, 3.0], &[1.0, 2.0, 3.0, 4.0]);
    assert!(near(tied, 4.5 / (4.5f64 * 5.0).sqrt()));
    // zeros are equal, whatever their sign
    assert!(near(spearman(&[0.0, -0.0, 1.0], &[0.0, 0.0, 1.0]), 1.0));
}

#[test]
fn nothing_to_rank_is_no_correlation() {
    assert!(near_zero(&[1.0, 1.0], &[1.0, 2.0]));
    assert!(near_zero(&[], &[]) && near_zero(&[1.0], &[2.0]));
    // the third of the first list has no partner
    assert!((spearman(&[1.0, 2.0, 0.0], &[3.0, 4.0]) - 1.0).abs() < 1e-12);
    let odd = [f64::NAN, f64::INFINITY, -1.0];
    assert!(spearman(&odd, &odd) > 0.999);

    fn near_zero(a: &[f64], b: &[f64]) -> bool {
        spearman(a, b).abs() < 1e-12
    }
}
