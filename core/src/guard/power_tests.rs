//! Tests of `power.rs`.

use super::*;
use crate::random::RandomStream;
use alloc::vec::Vec;

const S: u64 = 1_000_000;

fn bucket(short_uw: u64, long_uw: u64, long_s: u64) -> Bucket {
    let window = |s: u64, mean_uw| Window {
        length: Duration::from_micros(s * S),
        mean_uw,
    };
    let reach = Duration::from_millis(50);
    Bucket::new(window(1, short_uw), window(long_s, long_uw), reach)
}

#[test]
fn no_window_is_ever_passed_by_spending_greedily_at_random_times() {
    for (short, long, long_s) in [
        (45_000, 20_000, 10),
        (110_000, 60_000, 60),
        (5, 20_000, 10),
        (45_000, 100, 10),
    ] {
        let mut bucket = bucket(short, long, long_s);
        let mut stream = RandomStream::new(3, "bucket");
        let (mut now, mut spent): (u64, Vec<(u64, u64)>) = (0, Vec::new());
        for _ in 0..6_000 {
            now += stream.next_u64()
                % if stream.next_u64().is_multiple_of(40) {
                    9 * S
                } else {
                    80_000
                };
            let left = bucket.left_nj(Instant::from_micros(now));
            let take = if stream.uniform() < 0.5 {
                left
            } else {
                left / 3
            };
            bucket.spend(take);
            spent.push((now, take));
            for (window, uw) in [(S, short), (long_s * S, long)] {
                let since = now.saturating_sub(window + 50_000);
                let sum: u64 = spent
                    .iter()
                    .rev()
                    .take_while(|(t, _)| *t >= since)
                    .map(|(_, e)| e)
                    .sum();
                assert!(
                    sum * 1000 <= uw * window,
                    "{sum} nJ over {window} us at {now} us"
                );
            }
        }
    }
}

#[test]
fn the_rest_of_the_budget_is_there_to_be_used() {
    // 45 mJ over 1 s and 200 mJ over 10 s: r = 155 / 9 = 17.2 mW, C = 45 - 1.05 r = 26.9 mJ.
    let mut wire = bucket(45_000, 20_000, 10);
    assert_eq!(wire.left_nj(Instant::ZERO) / 100_000, 269);
    wire.spend(u64::MAX);
    assert_eq!(wire.left_nj(Instant::ZERO), 0);
    assert_eq!(wire.left_nj(Instant::from_micros(S)) / 100_000, 172);
    assert_eq!(wire.left_nj(Instant::from_micros(10)) / 100_000, 172);
    assert_eq!(wire.left_nj(Instant::FAR_FUTURE) / 100_000, 269);
}
