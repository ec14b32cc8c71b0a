//! Tests of `relative.rs`.

use super::*;
use crate::skin::Module;

fn frame() -> RelativeFrame {
    let pad = Module::grid("pad", 1, 3, 1.0).unwrap();
    RelativeFrame::new(&Layout::single(pad).unwrap())
}

#[test]
fn contact_is_strictly_above_the_threshold_in_the_chosen_axes() {
    let mut f = frame();
    let d = [[3.0, 0.0, -4.0], [0.0, 0.0, 5.1], [9.0, 0.0, 0.0]];
    f.load(&d, Axes::XYZ, 5.0).unwrap();
    assert_eq!(f.contacts(), [1, 2]);
    f.load(&d, Axes::Z, 3.9).unwrap();
    assert_eq!(f.contacts_of(0), [0, 1]);
    f.set_usable(0, false);
    f.load(&d, Axes::Z, 3.9).unwrap();
    assert_eq!(f.contacts(), [1]);
    assert_eq!(f.contacts_of(7), []);
}

#[test]
fn what_is_not_finite_is_refused_with_its_place() {
    let mut f = frame();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
        let d = [[0.0; 3], [0.0, bad, 0.0], [0.0; 3]];
        let e = f.load(&d, Axes::XYZ, 1.0);
        assert_eq!(e, Err(FrameError::NotFinite { taxel: 1, axis: 1 }));
        assert_eq!(f.load(&d, Axes::Z, 1.0), Ok(()));
    }
    assert!(f.load(&[[0.0; 3]; 2], Axes::Z, 1.0).is_err());
    assert!(f.load(&[[0.0; 3]; 3], Axes::Z, f32::NAN).is_err());
}

/// Few taxels and many go different ways.
#[test]
fn magnitudes_are_the_same_for_any_number_of_taxels() {
    for n in 1..80 {
        let pad = Module::grid("pad", 1, n, 1.0).unwrap();
        let mut f = RelativeFrame::new(&Layout::single(pad).unwrap());
        let d: Vec<[f32; 3]> = (0..n)
            .map(|i| [0.3, 1.7, -0.9].map(|c| c * f32::from(i * i + 1)))
            .collect();
        f.load(&d, Axes::XYZ, 1.0).unwrap();
        for (i, [x, y, z]) in d.iter().map(|d| d.map(libm::fabsf)).enumerate() {
            let axes = [0, 1, 2].map(|a| f.axis(a)[i].to_bits());
            assert_eq!(axes, [x, y, z].map(f32::to_bits), "{n} {i}");
            let want = libm::sqrtf(x * x + y * y + z * z);
            assert_eq!(f.magnitude()[i].to_bits(), want.to_bits(), "{n} {i}");
        }
    }
}
