//! Tests of `network.rs`.

use super::*;

/// Times of 200 000 datagrams, microseconds and sorted, and the share that was lost.
fn play(profile: Profile) -> (Vec<u64>, f64, usize) {
    let mut way = Way::new(profile, 1, "a test");
    let (mut times, mut run, mut longest) = (Vec::new(), 0, 0);
    let count = 200_000;
    for n in 0..count {
        let sent = Nanos::from_micros(10_000_000 * n);
        let before = way.lost();
        way.send(sent, &[0]);
        run = if way.lost() > before { run + 1 } else { 0 };
        longest = longest.max(run);
        while let Some(lands) = way.next() {
            times.push(lands.since(sent).0 / 1000);
            way.land(lands);
        }
    }
    times.sort_unstable();
    (times, way.lost() as f64 / count as f64, longest)
}

#[test]
fn times_and_losses_are_those_of_the_profile() {
    for profile in [Profile::WIRE, Profile::WIFI, Profile::ROUGH] {
        let (times, lost, longest) = play(profile);
        let at = |share: f64| times[(share * (times.len() - 1) as f64) as usize];
        let near = |found: u64, wanted: u32| {
            let wanted = f64::from(wanted);
            assert!(
                (found as f64 - wanted).abs() < 0.06 * wanted + 3.0,
                "{found} {wanted}"
            );
        };
        near(at(0.0), profile.delay_us[0]);
        near(at(0.5), profile.delay_us[1]);
        near(at(0.95), profile.delay_us[2]);
        assert!(at(1.0) <= profile.delay_us[4].into());
        let loss = f64::from(profile.loss_ppm) * 1e-6;
        assert!((lost - loss).abs() < 0.15 * loss + 1e-9, "{lost} of {loss}");
        assert_eq!(longest > 3, profile.loss_ppm > 0, "{longest}");
    }
}

#[test]
fn jitter_reorders_and_a_cut_way_loses_all() {
    let mut way = Way::new(Profile::ROUGH, 3, "a test");
    for n in 0..100 {
        way.send(Nanos::from_micros(1000 * u64::from(n)), &[n]);
    }
    let far = Nanos::from_micros(10_000_000);
    let mut order = Vec::new();
    while let Some(bytes) = way.land(far) {
        order.push(bytes[0]);
    }
    assert!(!order.is_sorted() && order.len() > 50);
    way.set_cut(true);
    way.send(far, &[1]);
    assert_eq!(way.next(), None);
    way.set_cut(false);
    (0..100).for_each(|_| way.send(far, &[1]));
    assert!(way.next().is_some());
}

#[test]
fn the_same_seed_gives_the_same_network() {
    let times = |seed| {
        let mut way = Way::new(Profile::WIFI, seed, "a test");
        (0..50).for_each(|n| way.send(Nanos(n), &[]));
        way.flying.iter().map(|f| f.lands).collect::<Vec<_>>()
    };
    assert_eq!(times(1), times(1));
    assert_ne!(times(1), times(2));
}
