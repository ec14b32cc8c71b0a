//! Tests of `statistics.rs`.

use super::*;

#[test]
fn middles_are_between_neighbours() {
    assert_eq!(median([3.0, 1.0, 2.0]), Some(2.0));
    assert_eq!(median([4.0, 1.0, 2.0, 3.0]), Some(2.5));
    assert_eq!(median([]), None);
    let quarter = quantile(&[0_u8, 10], 0.25).unwrap();
    assert_eq!((quarter.below, quarter.above, quarter.way), (0, 10, 0.25));
    assert_eq!(quarter.between(), 2.5);
}

#[test]
fn ends_and_samples_are_found_exactly() {
    let sorted: Vec<f32> = (1..=101).map(|n| n as f32).collect();
    for (part, value) in [
        (-1.0, 1.0),
        (0.0, 1.0),
        (0.5, 51.0),
        (1.0, 101.0),
        (2.0, 101.0),
    ] {
        let found = quantile(&sorted, part).unwrap();
        assert_eq!((found.below, found.above), (value, value), "{part}");
    }
    assert_eq!(quantile::<f64>(&[], 0.5), None);
    assert_eq!([mean([]), mean([1.0, 2.0, 6.0])], [None, Some(3.0)]);
}

#[test]
fn ends_hold_and_values_between_lie_on_straight_lines() {
    let points = [[1.0, 10.0], [2.0, 20.0], [4.0, 0.0]];
    let at = |x| interpolated(&points, x);
    assert_eq!([at(0.0), at(1.0), at(1.5)], [10.0, 10.0, 15.0].map(Some));
    assert_eq!([at(2.0), at(3.0), at(9.0)], [20.0, 10.0, 0.0].map(Some));
    assert_eq!(at(f64::NAN), Some(10.0));
    assert_eq!(interpolated(&[], 1.0), None);
}
