//! Tests of `faults.rs`.

use super::*;
use crate::sensor::board::BoardConfig;
use crate::sensor::rig::{Handle, SkinBus};
use crate::sensor::{EmulatedModule, ModuleConfig};
use crate::time::Nanos;

fn run(rates: Rates, rules: Vec<Rule>, seed: u64) -> (Vec<Received>, Counts) {
    let mut bus = SkinBus::new(1_000_000);
    let config = BoardConfig {
        autostart: true,
        ..BoardConfig::default()
    };
    bus.add_board(config, vec![EmulatedModule::new(ModuleConfig::default())])
        .unwrap();
    let handle = Handle::new(vec![bus]);
    let mut faulty = Faulty::new(handle.clone(), seed, "can");
    faulty.set_rates(rates);
    faulty.set_rules(rules);
    handle.advance(Nanos::from_micros(1_999_000)); // 200 scans, 3200 frames
    let frames = std::iter::from_fn(|| faulty.receive().unwrap()).collect();
    (frames, faulty.counts())
}

#[test]
fn random_faults_hit_their_share_and_repeat_with_the_seed() {
    let rates = Rates {
        lost: 0.3,
        duplicated: 0.1,
        late: 0.05,
        late_by: Duration::from_millis(2),
        corrupted: 0.02,
        short: 0.02,
    };
    let (frames, counts) = run(rates, vec![], 5);
    assert_eq!(
        (&frames, counts),
        (&run(rates, vec![], 5).0, run(rates, vec![], 5).1)
    );
    assert_ne!(frames, run(rates, vec![], 6).0);
    assert!((860..1060).contains(&counts.lost), "{counts:?}");
    assert!(
        counts.duplicated > 100 && counts.late > 50 && counts.short > 20 && counts.corrupted > 20
    );
    assert!(
        frames.windows(2).all(|w| w[0].at <= w[1].at),
        "arrival times never go back"
    );
    let alone = run(
        Rates {
            lost: 0.3,
            ..Rates::default()
        },
        vec![],
        5,
    )
    .1;
    assert_eq!(alone.lost, counts.lost, "streams are independent");
    assert_eq!(run(Rates::default(), vec![], 5).0.len(), 3200);
}

#[test]
fn rules_silence_freeze_and_zero() {
    let rule = |id, mask, effect| Rule {
        bus: None,
        id,
        mask,
        effect,
    };
    let (frames, counts) = run(
        Rates::default(),
        vec![
            rule(0x300, 0x700, Effect::Silent),
            rule(0x010, 0x7FF, Effect::Frozen),
            rule(0x020, 0x7FF, Effect::Zero),
        ],
        1,
    );
    assert_eq!((counts.silent, counts.frozen, counts.zero), (800, 200, 200));
    assert!(frames.iter().all(|r| r.frame.id() < 0x300));
    let of = |id| {
        frames
            .iter()
            .filter(move |r| r.frame.id() == id)
            .map(|r| r.frame)
    };
    assert!(of(0x010).all(|f| Some(f) == of(0x010).next()));
    assert!(of(0x020).all(|f| f.data()[1..7] == [0; 6]));
    assert!(of(0x000).any(|f| Some(f) != of(0x000).next()));
}
