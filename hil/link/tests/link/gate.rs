//! The gate behind networks that do whatever networks do, in virtual time: what it lets through is fresh, always.

use palpate_core::units::Instant;
use palpate_link::judge::{Gate, Head, Patience, Refusal};
use proptest::prelude::*;

use crate::weather::{Dice, LAYOUT, Passed, Weather, frames};

fn weather() -> impl Strategy<Value = Weather> {
    let numbers = (
        0..200_000_u64,
        0..200_000_u64,
        0..60_000_u64,
        0..300_u64,
        0..300_u64,
    );
    let clocks = (any::<bool>(), 0..10_000_000_000_u64, -200..200_i64);
    (numbers, clocks).prop_map(
        |((there_us, back_us, jitter_us, loss, double), (holds, ahead_us, fast_ppm))| Weather {
            there_us,
            back_us,
            jitter_us,
            loss,
            double,
            holds,
            ahead_us,
            fast_ppm,
        },
    )
}

/// What must hold whatever the network does.
fn check(passed: &[Passed]) {
    for one in passed {
        assert!(
            one.at <= one.taken,
            "a reading of {} passed as of {}",
            one.taken,
            one.at
        );
        assert!(
            one.now - one.taken < 100_000,
            "{} us old at {}",
            one.now - one.taken,
            one.now
        );
    }
    for two in passed.windows(2) {
        assert!(
            two[0].taken < two[1].taken,
            "an older reading after a newer one"
        );
    }
}

proptest! {
    #[test]
    fn what_passes_is_fresh_in_any_weather(weather in weather(), seed in any::<u64>(), cut in 0..3_000_000_u64, length in 0..3_000_000_u64) {
        check(&frames(weather, vec![(cut, cut + length)], 6_000_000, seed));
    }

    #[test]
    fn near_enough_everything_passes(there in 0..12_000_u64, back in 0..12_000_u64, ahead_us in 0..10_000_000_000_u64, seed in any::<u64>()) {
        let weather = Weather { there_us: there, back_us: back, jitter_us: 500, loss: 0, double: 0, holds: true, ahead_us, fast_ppm: 100 };
        let passed = frames(weather, vec![], 5_000_000, seed);
        check(&passed);
        // All but those before publisher and wearer had heard of each other.
        prop_assert!(passed.len() > 480, "{}", passed.len());
    }
}

/// A thousand cuts, of every length, each way that kernels treat what was on its way.
#[test]
fn a_thousand_cuts_let_nothing_stale_through_and_all_heal() {
    let (mut slowest, mut cuts) = (0, 0);
    for seed in 0..50 {
        let mut dice = Dice(seed);
        let weather = Weather {
            there_us: 1000 + dice.below(29_000),
            back_us: 1000 + dice.below(29_000),
            jitter_us: dice.below(10_000),
            loss: dice.below(30),
            double: dice.below(30),
            holds: seed % 2 == 0,
            ahead_us: dice.below(1 << 33),
            fast_ppm: 50,
        };
        let mut at = 500_000;
        let mut all = Vec::new();
        for _ in 0..20 {
            let from = at + dice.below(500_000);
            let to = from + dice.below(3_000_000);
            all.push((from, to));
            at = to + 1_000_000;
        }
        let passed = frames(weather, all.clone(), at + 1_000_000, seed);
        check(&passed);
        for (from, to) in all {
            cuts += 1;
            // What was on its way when the link was cut may come a little later.
            let silent = passed
                .iter()
                .filter(|p| (from + 100_000..to).contains(&p.now));
            assert_eq!(
                silent.count(),
                0,
                "seed {seed}: something passed a cut link"
            );
            let back = passed.iter().map(|p| p.now).find(|now| *now >= to);
            let took = back.expect("the link healed") - to;
            assert!(took < 500_000, "seed {seed}: back after {took} us");
            slowest = slowest.max(took);
        }
    }
    assert_eq!(cuts, 1000);
    assert!(slowest > 0);
}

#[test]
fn clocks_that_are_set_end_in_nothing_felt_until_both_have_heard_of_each_other_again() {
    let mut gate = Gate::new(Patience::new(1, LAYOUT));
    let head = |sequence: u64, sent_us: u64| Head {
        version: 1,
        session: 3,
        sequence,
        sent_us,
        taken_us: sent_us,
        layout: LAYOUT,
    };
    let at = Instant::from_micros;
    // Offset zero, no delay.
    assert_eq!(gate.judge(&head(1, 1000), at(1000)), Err(Refusal::NoClock));
    gate.echoed(3, at(1500), 1500, at(1500));
    assert!(gate.judge(&head(2, 11_000), at(11_000)).is_ok());
    // The robot's clock leaps ahead by a second: its frames would come before they were sent.
    assert_eq!(
        gate.judge(&head(3, 1_021_000), at(21_000)),
        Err(Refusal::Jumped)
    );
    assert_eq!(
        gate.judge(&head(4, 1_031_000), at(31_000)),
        Err(Refusal::NoClock)
    );
    // An echo of what was said before the leap says nothing about the clock after it.
    gate.echoed(3, at(20_000), 20_000, at(32_000));
    assert_eq!(
        gate.judge(&head(5, 1_041_000), at(41_000)),
        Err(Refusal::NoClock)
    );
    gate.echoed(3, at(42_000), 1_042_000, at(42_000));
    assert_eq!(
        gate.judge(&head(6, 1_051_000), at(51_000))
            .map(Instant::as_micros),
        Ok(50_995)
    );
    // And back: its readings look a second old, and an echo shows that they are not.
    let late = gate.judge(&head(7, 61_000), at(61_000));
    assert_eq!(late, Err(Refusal::Order));
}
