//! Tests of `shares.rs`.

use super::super::display::tests::thimble;
use super::*;

fn law(exponent: f32, level: bool) -> CellShares {
    let cells = Cells::new(&thimble()).unwrap();
    CellShares::new(cells, Power { exponent, level }, 4.0)
}

#[test]
fn energy_and_linear_by_hand() {
    let mut out = [0.0; 8];
    // A quarter of the way from wire 2 to wire 3.
    law(0.5, false).activate(Point::new(0.0, 7.125), &mut out);
    assert!((out[2] - libm::sqrtf(0.75)).abs() < 1e-5 && (out[3] - 0.5).abs() < 1e-5);
    law(1.0, false).activate(Point::new(0.0, 7.125), &mut out);
    assert!((out[2] - 0.75).abs() < 1e-5 && (out[3] - 0.25).abs() < 1e-5);
    law(2.0, false).activate(Point::new(5.5, 0.0), &mut out);
    assert!((out[1] - 0.0625).abs() < 1e-5);
}

#[test]
fn a_level_law_has_one_energy_inside_and_fades_outside() {
    let law = law(0.7, true);
    let mut out = [0.0; 8];
    let energy = |out: &[f32]| out.iter().map(|a| a * a).sum::<f32>();
    for i in 0..200 {
        law.activate(
            Point::new((i % 14) as f32 - 6.5, (i / 14) as f32 - 7.0),
            &mut out,
        );
        assert!((energy(&out) - 1.0).abs() < 1e-5);
    }
    law.activate(Point::new(13.0, 0.0), &mut out);
    assert!((energy(&out) - 0.25).abs() < 1e-5);
    for nowhere in [15.1, f32::INFINITY, f32::NAN] {
        law.activate(Point::new(nowhere, 0.0), &mut out);
        assert_eq!(out, [0.0; 8]);
    }
}
