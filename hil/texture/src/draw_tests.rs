//! What lies far out does not set the scale.

use super::*;

#[test]
fn a_stray_point_does_not_set_the_scale() {
    let mut points: Vec<f64> = (0..200).map(|i| f64::from(i) / 200.0).collect();
    points.push(1e6);
    let scale = inner(points.clone(), [-0.5, 0.4].into_iter());
    assert!(scale.at(-0.5) >= 0.0 && scale.at(-0.5) < 0.2);
    assert!(scale.at(0.95) <= 1.0 && scale.at(0.95) > 0.8);
    // few points are all in view
    let scale = inner(vec![3.0, -2.0], core::iter::empty());
    assert!(within(&scale.at(3.0)) && within(&scale.at(-2.0)));
    assert!(inner(Vec::new(), core::iter::empty()).at(0.5).is_finite());
}
