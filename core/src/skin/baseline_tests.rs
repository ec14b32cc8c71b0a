//! Reference, threshold and faulty taxels by hand.

use super::*;
use crate::skin::{Axes, Module};
use crate::units::{Duration, Instant};

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
    let settings = BaselineSettings {
        reference_frames: 2,
        ..Default::default()
    };
    let mut init = Baseline::new(&l, settings).unwrap();
    assert_eq!(
        init.feed(&scan(&l, |_| [100, 200, 37_000])),
        BaselinePhase::Collecting
    );
    assert_eq!(
        init.feed(&scan(&l, |_| [102, 200, 37_001])),
        BaselinePhase::Referenced
    );
    let third = scan(&l, |i| [101, 200, if i == 3 { 37_003 } else { 37_000 }]);
    assert_eq!(init.feed(&third), BaselinePhase::Ready);
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
    let settings = BaselineSettings {
        reference_frames: 1,
        fault_sigmas: Some(3.0),
        threshold: ThresholdRule::Fixed { counts: 10.0 },
        axes: Axes::Z,
        drift: None,
    };
    let mut init = Baseline::new(&l, settings).unwrap();
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
    let mut init = Baseline::new(&l, BaselineSettings::default()).unwrap();
    let empty = Scan::new(&l);
    for _ in 0..11 {
        init.feed(&empty);
    }
    assert_eq!(init.phase(), BaselinePhase::Ready);
    let mut f = init.frame(&l);
    init.relative(&scan(&l, |_| [9, 9, 9]), &mut f).unwrap();
    assert!(f.contacts().is_empty());
    for threshold in [-1.0, f32::NAN, f32::INFINITY] {
        let settings = BaselineSettings {
            threshold: ThresholdRule::Fixed { counts: threshold },
            ..Default::default()
        };
        assert!(Baseline::new(&l, settings).is_err());
    }
}

/// A pad at rest but for a wiggle of one count on every taxel, and of nine on taxel 3.
fn noisy(k: u64) -> impl Fn(usize) -> [u16; 3] {
    move |i| {
        [
            40_000,
            16_000,
            37_000 + (k % 2) as u16 * if i == 3 { 9 } else { 1 },
        ]
    }
}

fn following() -> BaselineSettings {
    BaselineSettings {
        threshold: ThresholdRule::Fixed { counts: 20.0 },
        drift: Some(Duration::from_millis(2000)),
        ..Default::default()
    }
}

fn ready(settings: BaselineSettings) -> (Layout, Baseline) {
    let l = pad();
    let mut init = Baseline::new(&l, settings).unwrap();
    let mut k = 0;
    while init.phase() != BaselinePhase::Ready {
        init.feed(&scan(&l, noisy(k)));
        init.feed(&scan(&l, noisy(k))); // every row twice, as boards do
        k += 1;
    }
    (l, init)
}

fn at(mut s: Scan, ms: u64, rows: impl Fn(usize) -> [u16; 3]) -> Scan {
    let rows: Vec<_> = (0..s.counts().len()).map(rows).collect();
    s.load(Instant::from_micros(ms * 1000), &rows).unwrap();
    s
}

#[test]
fn every_taxel_has_its_own_threshold_and_an_outlier_raises_no_other() {
    let rule = ThresholdRule::PerTaxel {
        sigmas: 5.0,
        floor: 10.0,
    };
    let (_, init) = ready(BaselineSettings {
        reference_frames: 40,
        threshold: rule,
        ..Default::default()
    });
    // A step of 1 between distinct rows: sqrt(1/2) counts. Taxel 3 counts as four times the median.
    let sigma = libm::sqrtf(0.5);
    assert!((init.thresholds()[0] - (10.0 + 5.0 * sigma)).abs() < 1e-4);
    assert!((init.thresholds()[3] - (10.0 + 20.0 * sigma)).abs() < 1e-4);
    assert!((init.threshold() - init.thresholds()[3]).abs() < 1e-6);
}

#[test]
fn a_single_reading_far_off_in_any_row_of_the_reference_has_it_taken_anew() {
    let l = pad();
    for leap in 0..10 {
        let mut init = Baseline::new(&l, following()).unwrap();
        for k in 0..11 {
            let rest = noisy(k);
            let rows = |i: usize| match rest(i) {
                [x, y, z] if k == leap && i == 5 => [x, y, z + 3000],
                rest => rest,
            };
            init.feed(&scan(&l, rows));
        }
        assert!(init.is_restarting(), "row {leap}");
    }
}

#[test]
fn the_reference_follows_drift_under_a_touch_too() {
    let (l, mut init) = ready(following());
    let mut f = init.frame(&l);
    let mut s = Scan::new(&l);
    // 8 counts a second for two minutes; taxel 5 is pressed all the while.
    let row = |ms: u64| {
        let drift = (ms * 8 / 1000) as u16;
        move |i: usize| {
            [
                40_000,
                16_000,
                37_000 + drift + if i == 5 { 1500 } else { 0 },
            ]
        }
    };
    for ms in (0..120_000).step_by(10) {
        s = at(s, ms, row(ms));
        init.advance(&s, &mut f).unwrap();
        assert_eq!(f.contacts(), [5], "at {ms} ms");
    }
    let moved = init.reference(0).unwrap()[2] - 37_000.0;
    assert!((moved - 960.0).abs() < 20.0, "{moved}");
    assert!((init.reference(5).unwrap()[2] - 37_960.0).abs() < 20.0);
}

#[test]
fn a_lone_leap_has_to_stay_once_one_was_gone_at_once() {
    let (l, mut init) = ready(following());
    let mut f = init.frame(&l);
    let mut s = Scan::new(&l);
    let leaps = [3..9, 20..21, 40..41, 60..66];
    for k in 0..80 {
        let leaps = leaps.iter().position(|frames| frames.contains(&k));
        let pressed = |i: usize| 900 * u16::from(leaps.is_some() && i == 5);
        let row = |i: usize| [40_000, 16_000, 37_000 + pressed(i)];
        s = at(s, k * 10, row);
        init.advance(&s, &mut f).unwrap();
        let counts = match leaps {
            Some(2) => false,
            Some(3) => k > 60,
            known => known.is_some(),
        };
        assert_eq!(f.contacts().len(), usize::from(counts), "frame {k}");
    }
}

#[test]
fn a_changed_board_starts_over_and_is_left_out_meanwhile() {
    let (l, mut init) = ready(BaselineSettings {
        threshold: ThresholdRule::Fixed { counts: 20.0 },
        ..Default::default()
    });
    let mut f = init.frame(&l);
    let other = |i: usize| [16_400, 48_900, 33_000 + if i == 2 { 500 } else { 0 }];
    let s = scan(&l, other);
    init.restart(0);
    for _ in 0..10 {
        assert!(init.missing[0] > 0 && !init.usable()[0]);
        init.mask(&mut f);
        init.advance(&s, &mut f).unwrap();
        assert!(f.contacts().is_empty());
    }
    assert!(init.missing[0] == 0 && init.usable()[0]);
    (0..16).for_each(|i| f.set_usable(i, init.usable()[i]));
    init.advance(&s, &mut f).unwrap();
    assert!(f.contacts().is_empty());
    init.advance(&scan(&l, |i| [16_400, 48_900, 33_100 + i as u16]), &mut f)
        .unwrap();
    assert_eq!(f.contacts().len(), 16);
    init.restart(7); // there is no such module
}

#[test]
fn a_repeated_scan_is_no_news_and_changes_nothing() {
    let (l, mut init) = ready(BaselineSettings {
        drift: Some(Duration::from_millis(500)),
        ..Default::default()
    });
    let mut f = init.frame(&l);
    let touched = |i: usize| [40_000, 16_000, 37_000 + 100 * u16::from(i == 9)];
    let s = at(Scan::new(&l), 10, touched);
    assert_eq!(init.advance(&s, &mut f), Ok(true));
    let before = f.clone();
    let later = at(s.clone(), 900, touched);
    assert_eq!(init.advance(&later, &mut f), Ok(false));
    assert_eq!(
        (before.magnitude(), before.contacts()),
        (f.magnitude(), f.contacts())
    );
    // The same scan with nothing known of it: the same frame.
    let mut anew = init.frame(&l);
    init.relative(&later, &mut anew).unwrap();
    assert_eq!(
        (anew.magnitude(), anew.contacts()),
        (f.magnitude(), f.contacts())
    );
    f.set_usable(9, false);
    assert_eq!(init.advance(&later, &mut f), Ok(true));
    assert!(f.contacts().is_empty());
}
