//! Tests of `phantom.rs`.

use super::super::display::tests::{line, thimble};
use super::*;

const ONE: Shape = Shape { x: 1.0, y: 1.0 };

fn at(law: &LogPhantom, place: Point) -> [f32; 8] {
    let mut out = [f32::NAN; 8];
    law.activate(place, &mut out);
    out
}

#[test]
fn a_wire_under_the_contact_is_alone() {
    let display = thimble();
    let law = LogPhantom::new(&display, ONE).unwrap();
    for (n, wire) in display.wires().iter().enumerate() {
        let expected: [f32; 8] = core::array::from_fn(|m| if n == m { 1.0 } else { 0.0 });
        assert_eq!(at(&law, wire.place), expected, "contact on {n}");
    }
}

/// The dips of `(5.2)`: energy halfway between two wires, and in the centre of a cell, against a wire.
#[test]
fn midpoints_have_the_dip_of_the_thesis() {
    let db = |energy: f32| 10.0 * libm::log10(f64::from(energy));
    for (spacing, expected) in [(6.5, -8.0), (9.0, -8.7), (14.0, -9.7)] {
        let law = LogPhantom::new(&line(&[0.0, spacing]), ONE).unwrap();
        let mut out = [0.0; 2];
        law.activate(Point::new(spacing / 2.0, 0.0), &mut out);
        let dip = db(out[0] * out[0] + out[1] * out[1]);
        assert!((dip - expected).abs() < 0.1, "{spacing} mm: {dip:.2} dB");
    }
    // Four equal wires around the centre of a 9 x 14 mm cell.
    let one = |d: f32| Slope::new(d, 1.0).at(d / 2.0);
    let each = one(9.0) * one(14.0);
    assert!((db(4.0 * each * each) + 18.4).abs() < 0.1);
    for (spacing, expected) in [(9.0f32, -0.1), (14.0, -0.7)] {
        let a = Slope::new(spacing, 4.0).at(spacing / 2.0);
        assert!(
            (db(2.0 * a * a) - expected).abs() < 0.1,
            "s = 4, {spacing} mm"
        );
    }
}

#[test]
fn an_automatic_shape_makes_the_midpoint_flat() {
    for (spacing, expected) in [(6.5, 3.71), (9.0, 4.08), (14.0, 4.65)] {
        let shape = Shape::flat(spacing);
        assert!((shape - expected).abs() < 0.01, "{spacing} mm: {shape}");
        let a = Slope::new(spacing, shape).at(spacing / 2.0);
        assert!((2.0 * a * a - 1.0).abs() < 1e-4);
    }
    assert_eq!(Shape::flat(f32::INFINITY), 1.0);
}

#[test]
fn shape_one_is_the_power_law_at_one() {
    let display = thimble();
    let one = LogPhantom::new(&display, ONE).unwrap();
    let near = Shape {
        x: 1.0 + 1e-5,
        y: 1.0 + 1e-5,
    };
    let near = LogPhantom::new(&display, near).unwrap();
    for i in 0..200 {
        let place = Point::new(-11.0 + 0.11 * i as f32, 14.0 - 0.14 * i as f32);
        for (a, b) in at(&one, place).iter().zip(at(&near, place)) {
            assert!((a - b).abs() < 1e-4);
        }
    }
}

#[test]
fn bad_shapes_and_places_do_not_spread() {
    let display = thimble();
    for s in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(LogPhantom::new(&display, Shape { x: s, y: 1.0 }).is_err());
    }
    let law = LogPhantom::new(&display, ONE).unwrap();
    for bad in [f32::NAN, f32::INFINITY, f32::MAX] {
        assert_eq!(at(&law, Point::new(bad, 0.0)), [0.0; 8]);
    }
}
