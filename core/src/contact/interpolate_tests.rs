//! Tests of `interpolate.rs`.

use super::*;
use alloc::vec::Vec;

/// Bilinear interpolation is exact for a plane.
#[test]
fn a_plane_is_met_exactly_on_a_grid() {
    let m = Module::grid_xy("g", 4, 6, 2.0, 3.0).unwrap();
    let f = |p: Point| 100.0 + 3.0 * p.x - 2.0 * p.y;
    let v: Vec<f32> = m.points().iter().map(|p| f(*p)).collect();
    for (x, y) in [
        (0.3, 0.7),
        (-5.0, 4.5),
        (5.0, -4.5),
        (4.99, 0.0),
        (0.0, 0.0),
    ] {
        let p = Point::new(x, y);
        assert!((intensity(&m, &v, &[true; 24], p) - f(p)).abs() < 1e-4);
    }
    let outside = intensity(&m, &v, &[true; 24], Point::new(99.0, 99.0));
    assert!((outside - f(Point::new(5.0, 4.5))).abs() < 1e-4);
}

#[test]
fn a_taxel_left_out_gives_its_weight_to_the_others() {
    let m = Module::grid("g", 2, 2, 1.0).unwrap();
    let v = [10.0, 20.0, 30.0, 1e9];
    let at = Point::new(0.0, 0.0);
    let got = intensity(&m, &v, &[true, true, true, false], at);
    assert!((got - 20.0).abs() < 1e-4);
    assert!(intensity(&m, &v, &[false; 4], at).abs() < 1e-6);
    let one = Module::grid("g", 1, 1, 1.0).unwrap();
    assert!((intensity(&one, &[7.0], &[true], at) - 7.0).abs() < 1e-6);
}

#[test]
fn scattered_points_are_met_and_stay_in_range() {
    let points: Vec<Point> = (0..12)
        .map(|i| Point::new((i % 4) as f32 + 0.3 * (i / 4) as f32, (i / 4) as f32))
        .collect();
    let m = Module::scattered("s", &points).unwrap();
    let v: Vec<f32> = (0..12).map(|i| 100.0 * i as f32).collect();
    for (p, want) in points.iter().zip(&v) {
        assert!((intensity(&m, &v, &[true; 12], *p) - want).abs() < 1e-3);
        let near = intensity(&m, &v, &[true; 12], Point::new(p.x + 1e-4, p.y));
        assert!((near - want).abs() < 1.0, "{near} {want}");
    }
    let far = intensity(&m, &v, &[true; 12], Point::new(1e5, 1e5));
    assert!((far - 1100.0).abs() < 1e-3);
}
