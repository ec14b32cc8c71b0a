//! Tests of `surface.rs`.

use super::*;

const FINGER: Surface = Surface::Finger {
    radius_mm: 8.0,
    tip_mm: 6.0,
};

#[test]
fn lengths_along_the_finger_are_kept_and_chords_are_shorter_than_arcs() {
    let far = |a: Point, b: Point| libm::sqrtf(distance2(FINGER.lift(a), FINGER.lift(b)));
    let along = far(Point::new(0.0, -14.25), Point::new(0.0, -4.75));
    assert!((along - 9.5).abs() < 1e-5);
    // A chord over an arc of 11 mm at radius 8 mm.
    let around = far(Point::new(0.0, 4.75), Point::new(11.0, 4.75));
    assert!((around - 16.0 * libm::sinf(11.0 / 16.0)).abs() < 1e-4);
    assert!(far(Point::new(0.0, 4.75), Point::new(0.0, 14.25)) < 9.5);
}

#[test]
fn the_tip_is_round_and_ends_at_the_pole() {
    let pole = FINGER.lift(Point::new(5.0, 100.0));
    assert!(pole[0].abs() < 1e-3 && (pole[1] - 14.0).abs() < 1e-3 && pole[2].abs() < 1e-3);
    for y in [6.0, 8.0, 14.25] {
        let [x, along, z] = FINGER.lift(Point::new(3.0, y));
        let from_centre = libm::sqrtf(x * x + (along - 6.0) * (along - 6.0) + z * z);
        assert!((from_centre - 8.0).abs() < 1e-4);
    }
}
