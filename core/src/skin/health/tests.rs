//! Conditions, rates, and what a module's scan says at once.

use super::*;
use crate::random::RandomStream;
use crate::skin::Module;

#[test]
fn every_condition_is_told_apart() {
    let pad = Module::grid("pad", 1, 6, 1.0).unwrap();
    let pad = pad
        .with_active(&[true, true, true, true, true, false])
        .unwrap();
    let l = Layout::single(pad).unwrap();
    let mut m = Monitor::new(&l, HealthSettings::default());
    let mut s = Scan::new(&l);
    let mut now = Instant::ZERO;
    for k in 0..300u16 {
        now = Instant::from_micros(u64::from(k) * 10_000);
        let noise = 100 + k % 2;
        let jump = if k % 4 == 0 { 60_000 } else { noise };
        let row = [noise, 7, u16::MAX - k % 2, jump, noise, noise].map(|z| [5, 5, z]);
        s.load(now, &row).unwrap();
        m.observe(&s);
    }
    let got: Vec<_> = (0..7).map(|i| m.condition(i, now)).collect();
    use Condition::*;
    // taxel 2 sits at the upper end on every other frame, the last one (odd) is just below
    assert_eq!(got, [Good, Frozen, Good, Jumping, Good, Inactive, Inactive]);
    let sum = m.summary(&[], now);
    assert!((sum.refresh_median_hz - 100.0).abs() < 0.1, "{sum:?}");
    assert!(sum.refresh_min_hz.abs() < 1e-6);
    assert_eq!((sum.frozen, sum.jumping, sum.repeated), (1, 1, 0));
    let later = now + Duration::from_millis(1001);
    assert_eq!(m.summary(&[], later).dead, 5);
    s.load(later, &[[5, 5, u16::MAX]; 6]).unwrap();
    m.observe(&s);
    assert_eq!(m.condition(0, later), Saturated);
}

/// Compensated readings of an 8-bit skin are 0 without a touch: that is no end of the range to be ill at.
#[test]
fn the_end_of_the_range_that_a_skin_rests_at_is_no_saturation() {
    let condition = |axes: u8, first: [u16; 4], then: [u16; 4]| {
        let pad = Module::grid("pad", 1, 4, 1.0).unwrap();
        let l = Layout::single(pad.with_axes(axes).unwrap()).unwrap();
        let mut m = Monitor::new(&l, HealthSettings::default());
        let mut s = Scan::new(&l);
        for (k, z) in [first, then].into_iter().enumerate() {
            let at = Instant::from_micros(k as u64 * 10_000);
            s.load(at, &z.map(|z| [0, 0, z])).unwrap();
            m.observe(&s);
        }
        [0, 1, 2, 3].map(|i| m.condition(i, s.at()))
    };
    use Condition::*;
    assert_eq!(
        condition(1, [0, 0, 1, 0], [0, 40, u16::MAX, 0]),
        [Good, Good, Saturated, Good]
    );
    // One that reads 0 where the others do not is ill, and so is a board that sends zeros on three axes.
    assert_eq!(
        condition(1, [0, 90, 91, 92], [0, 90, 91, 0]),
        [Saturated, Good, Good, Saturated]
    );
    assert_eq!(condition(3, [0; 4], [0; 4]), [Saturated; 4]);
}

#[test]
fn never_seen_is_dead_and_repeats_are_counted() {
    let l = Layout::single(Module::grid("pad", 1, 2, 1.0).unwrap()).unwrap();
    let mut m = Monitor::new(&l, HealthSettings::default());
    let empty = Scan::new(&l);
    m.observe(&empty);
    assert_eq!(
        m.condition(0, Instant::from_micros(1_000_001)),
        Condition::Dead
    );
    let mut s = Scan::new(&l);
    for k in 0..8u64 {
        s.load(
            Instant::from_micros(k * 10_000),
            &[[1, 2, 3 + (k / 4) as u16]; 2],
        )
        .unwrap();
        m.observe(&s);
    }
    let sum = m.summary(&[], s.at());
    assert_eq!((sum.frames, sum.repeated), (9, 7));
    assert!((sum.received_median_hz - 100.0).abs() < 0.1);
}

/// What a module's scan says at once, against every taxel's condition.
#[test]
fn a_module_is_well_where_all_of_its_taxels_are() {
    let pads = ["a", "b"].map(|name| Module::grid(name, 1, 5, 1.0).unwrap());
    let [a, b] = pads;
    let b = b.with_active(&[true, true, false, true, true]).unwrap();
    let l = Layout::new(alloc::vec![a, b]).unwrap();
    let settings = HealthSettings {
        frozen_after: Duration::from_millis(60),
        ..HealthSettings::default()
    };
    let (mut m, mut r) = (Monitor::new(&l, settings), RandomStream::new(5, "health"));
    let (mut s, mut row) = (Scan::new(&l), [[1000u16; 3]; 10]);
    let (mut well, mut all_good) = (0, 0);
    for frame in 0..20_000u64 {
        let at = Instant::from_micros(10_000 * frame);
        for counts in &mut row {
            let event = r.next_u64() % 1000;
            match event {
                0 => {
                    counts[r.next_u64() as usize % 3] =
                        [0, 1, u16::MAX, u16::MAX - 1][frame as usize % 4]
                }
                1..150 => {}
                _ => *counts = [900, 1000, 1100].map(|c| c + (r.next_u64() % 5) as u16),
            }
        }
        s.load(at, &row).unwrap();
        for module in 0..2 {
            let range = l.range(module);
            let said = m.observe_module(&s, module);
            let good = |i: usize| {
                let condition = m.condition(i, at);
                condition == Condition::Inactive
                    || (condition == Condition::Good && !m.has_jumped(i))
            };
            let good = range.clone().all(good);
            assert!(good || !said, "frame {frame}");
            let latest = at + settings.dead_after;
            assert_eq!(m.is_well(module, latest), said, "frame {frame}");
            let still = |i| {
                matches!(
                    m.condition(i, latest),
                    Condition::Good | Condition::Inactive
                )
            };
            assert!(!said || range.clone().all(still), "frame {frame}");
            assert!(!m.is_well(module, latest + Duration::from_micros(1)));
            well += usize::from(said);
            all_good += usize::from(good);
        }
    }
    assert!(
        well > 20_000 && well <= all_good && all_good < 39_999,
        "{well} {all_good}"
    );
}
