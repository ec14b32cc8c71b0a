//! Reference, threshold and faulty taxels by hand.

use super::*;
use crate::skin::Module;
use crate::units::Instant;

fn pad() -> Layout {
    Layout::single(Module::grid("pad", 4, 4, 4.7).unwrap()).unwrap()
}

fn scan(layout: &Layout, f: impl Fn(usize) -> [u16; 3]) -> Scan {
    let mut s = Scan::new(layout);
    let rows: Vec<_> = (0..layout.taxels()).map(f).collect();
    s.load(Instant::ZERO, &rows).unwrap();
    s
}

#[test]
fn reference_threshold_and_contact_follow_the_equations() {
    let l = pad();
    let settings = InitialiserSettings {
        reference_frames: 2,
        ..Default::default()
    };
    let mut init = Initialiser::new(&l, settings).unwrap();
    assert_eq!(
        init.feed(&scan(&l, |_| [100, 200, 37_000])),
        Phase::Collecting
    );
    assert_eq!(
        init.feed(&scan(&l, |_| [102, 200, 37_001])),
        Phase::Referenced
    );
    let third = scan(&l, |i| [101, 200, if i == 3 { 37_003 } else { 37_000 }]);
    assert_eq!(init.feed(&third), Phase::Ready);
    assert!((init.threshold() - 2.5).abs() < 1e-6);
    let mut f = init.frame(&l);
    init.relative(&third, &mut f).unwrap();
    assert!(f.contacts().is_empty()); // 2.5 is not strictly above 2.5
    init.relative(&scan(&l, |i| [101, 200 - i as u16, 37_000]), &mut f)
        .unwrap();
    assert_eq!(f.contacts().len(), 13);
    assert!((f.magnitude()[4] - libm::sqrtf(16.25)).abs() < 1e-6);
}

#[test]
fn a_far_taxel_is_faulty_and_left_out() {
    let l = pad();
    let settings = InitialiserSettings {
        reference_frames: 1,
        fault_sigmas: Some(3.0),
        threshold: ThresholdRule::Fixed { counts: 10.0 },
        axes: Axes::Z,
    };
    let mut init = Initialiser::new(&l, settings).unwrap();
    let rest = |i: usize| [32_000, if i == 7 { 9 } else { 32_000 + i as u16 }, 37_000];
    init.feed(&scan(&l, rest));
    init.feed(&scan(&l, rest));
    assert_eq!(init.faulty().iter().position(|f| *f), Some(7));
    let mut f = init.frame(&l);
    init.relative(&scan(&l, |_| [0, 0, 38_000]), &mut f)
        .unwrap();
    assert_eq!(f.contacts().len(), 15);
}

#[test]
fn unseen_taxels_never_touch_and_bad_settings_are_refused() {
    let l = pad();
    let mut init = Initialiser::new(&l, InitialiserSettings::default()).unwrap();
    let empty = Scan::new(&l);
    for _ in 0..11 {
        init.feed(&empty);
    }
    assert_eq!(init.phase(), Phase::Ready);
    let mut f = init.frame(&l);
    init.relative(&scan(&l, |_| [9, 9, 9]), &mut f).unwrap();
    assert!(f.contacts().is_empty());
    for threshold in [-1.0, f32::NAN, f32::INFINITY] {
        let settings = InitialiserSettings {
            threshold: ThresholdRule::Fixed { counts: threshold },
            ..Default::default()
        };
        assert!(Initialiser::new(&l, settings).is_err());
    }
}
