//! Tests of `packed.rs`.

use super::*;
use proptest::prelude::*;

fn sample() -> impl Strategy<Value = HandSample> {
    let near = -300_i64..300;
    let wide = -1_000_000_i64..1_000_000;
    let value = prop_oneof![4 => near, 1 => wide, 1 => Just(0)];
    (1_i64..40_000, [value.clone(), value.clone(), value])
        .prop_map(|(t, [x, y, force])| [t, x, y, force, 12_000])
}

proptest! {
    #[test]
    fn nothing_is_lost_and_what_still_holds_stays(
        steps in proptest::collection::vec(sample(), 0..2500),
        part in 0_i64..100,
    ) {
        let mut t_us = 0;
        let mut all = steps;
        for sample in &mut all {
            t_us += sample[0];
            sample[0] = t_us;
        }
        let (mut packed, mut kept) = (Packed::default(), all.clone());
        let until_us = t_us * part / 100;
        packed.take(&mut kept, until_us);
        prop_assert!(kept.len() <= PIECE + all.iter().filter(|s| s[0] > until_us).count());
        // The one that holds at that time, if there is one.
        let holds = all.iter().rfind(|sample| sample[0] <= until_us);
        prop_assert_eq!(kept.iter().rfind(|sample| sample[0] <= until_us), holds);
        let again: Vec<HandSample> = packed.samples().chain(kept).collect();
        prop_assert_eq!(again, all);
    }
}

#[test]
fn an_hour_takes_a_quarter() {
    let at = |n: i64| {
        let a = n as f64 / 60.0;
        let um = |v: f64| (v * 5000.0) as i64;
        [
            n * 16_667 + n % 3,
            um(libm::sin(a * 1.3)),
            um(libm::cos(a)),
            600 + um(libm::sin(a)) / 20,
            12_000,
        ]
    };
    let (mut packed, mut samples) = (Packed::default(), (0..216_000).map(at).collect());
    packed.take(&mut samples, i64::MAX);
    let bytes: usize = packed.0.iter().map(|piece| piece.len()).sum();
    assert!(bytes < 216_000 * 10, "{bytes}");
}

#[test]
fn the_ends_of_all_numbers() {
    let (mut bytes, all) = (Vec::new(), [0, 1, -1, 63, 64, -64, -65, i64::MAX, i64::MIN]);
    all.iter().for_each(|value| put(&mut bytes, *value));
    let mut rest = &*bytes;
    let again: Vec<i64> = std::iter::from_fn(|| next(&mut rest)).collect();
    assert_eq!(again, all);
}
