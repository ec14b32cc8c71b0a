//! Tests of `array.rs`.

use super::*;
use crate::sensor::ModuleConfig;

fn pad(number: usize) -> EmulatedModule {
    EmulatedModule::new(ModuleConfig {
        number,
        ..ModuleConfig::default()
    })
}

/// When the scans of each module arrive within a second, microseconds.
fn arrivals(delivery: Delivery, modules: usize) -> (Vec<Vec<u64>>, u64) {
    let mut skin = SkinArray::new((0..modules).map(pad).collect(), 30.0, delivery, 5);
    let mut times = vec![Vec::new(); modules];
    for ms in 0..1000 {
        let now = Instant::from_micros(1000 * ms);
        skin.advance(now.into());
        let read = skin.scans(now, &mut |scan| {
            assert_eq!((scan.counts.len(), scan.fresh), (16, None));
            assert!(scan.at <= now);
            times[usize::from(scan.module)].push(scan.at.as_micros());
        });
        read.unwrap();
    }
    (times, skin.lost())
}

#[test]
fn all_modules_are_scanned_together_at_the_rate() {
    let (times, lost) = arrivals(Delivery::DIRECT, 2);
    let due = (0..30).map(|n| n * 1_000_000 / 30);
    assert_eq!(times[0], due.collect::<Vec<_>>());
    assert_eq!((&times[1], lost), (&times[0], 0));
}

#[test]
fn over_a_network_scans_come_late_in_order_and_some_never() {
    let network = Delivery {
        delay_s: 0.002,
        jitter_s: 0.050,
        late: (0.1, 0.2),
        loss: 0.2,
    };
    let (times, lost) = arrivals(network, 1);
    let arrived = times[0].len() as u64;
    assert!(
        (1..15).contains(&lost) && (28..=30).contains(&(arrived + lost)),
        "{arrived} {lost}"
    );
    assert!(times[0].is_sorted(), "none overtakes");
    assert!(times[0][0] >= 2000);
    let gaps: Vec<u64> = times[0].windows(2).map(|t| t[1] - t[0]).collect();
    assert!(
        gaps.iter().any(|g| *g > 150_000) && gaps.contains(&0),
        "{gaps:?}"
    );
    assert_eq!(
        arrivals(network, 1),
        (times, lost),
        "the same seed, the same network"
    );
}
