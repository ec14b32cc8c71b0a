//! Tests of `reach.rs`.

use super::super::display::tests::thimble;
use super::*;

#[test]
fn three_nearest_by_hand() {
    let display = thimble();
    let law = ThreeNearest::new(
        &display,
        Metric::new(&display, Surface::Flat),
        Cells::new(&display).unwrap(),
    );
    let mut out = [0.0; 8];
    // In the upper right triangle (0, 4.75), (11, 4.75), (0, 14.25).
    let at = Point::new(3.0, 7.0);
    law.activate(at, &mut out);
    let near = |wire: usize| 1.0 / at.distance(display.wires()[wire].place);
    let sum = near(2) + near(3) + near(7);
    for wire in [2, 3, 7] {
        assert!((out[wire] - libm::sqrtf(near(wire) / sum)).abs() < 1e-5);
    }
    let energy: f32 = out.iter().map(|a| a * a).sum();
    assert!((energy - 1.0).abs() < 1e-5);
    // On an edge: two wires, sqrt(d of the other / gap).
    law.activate(Point::new(0.0, 7.125), &mut out);
    assert!((out[2] - libm::sqrtf(0.75)).abs() < 1e-4 && (out[3] - 0.5).abs() < 1e-4);
    assert_eq!(out[7], 0.0);
    law.activate(Point::new(0.0, 4.75), &mut out);
    assert_eq!(out, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
}

#[test]
fn equally_near_wires_share_the_energy() {
    let display = thimble();
    let law = Nearest::new(Metric::new(&display, Surface::Flat));
    let mut out = [0.0; 8];
    law.activate(Point::new(5.5, 0.0), &mut out);
    assert_eq!(out, [0.0, 0.5, 0.5, 0.0, 0.0, 0.0, 0.5, 0.5]);
    law.activate(Point::new(f32::NAN, 0.0), &mut out);
    assert_eq!(out, [0.0; 8]);
}
