//! What registers mean for an output (document: "Outputs").

use super::*;

#[test]
fn on_below_off_is_high_for_on_to_off() {
    let mut bench = Bench::awake();
    bench.channel(5, 1000, 3000);
    let start = bench.now();
    bench.wait_ns(PERIOD);
    assert_eq!(
        bench.take(5),
        [(start + 1000 * TICK, true), (start + 3000 * TICK, false)]
    );
}

#[test]
fn on_above_off_wraps() {
    let mut bench = Bench::awake();
    bench.channel(5, 3000, 1000);
    let start = bench.now();
    bench.wait_ns(PERIOD + 1001 * TICK);
    assert_eq!(
        bench.take(5),
        [
            (start, true),
            (start + 1000 * TICK, false),
            (start + 3000 * TICK, true),
            (start + PERIOD + 1000 * TICK, false)
        ]
    );
}

#[test]
fn on_equal_to_off_is_low() {
    for count in [0, 1, 2048, 4095] {
        let mut bench = Bench::awake();
        bench.channel(5, count, count);
        assert_eq!(bench.duty(5, 3 * PERIOD), 0.0);
    }
}

#[test]
fn full_off_beats_full_on_and_compare() {
    let mut bench = Bench::awake();
    bench.channel(0, 0x1000, 0x1000);
    bench.channel(1, 0, 0x1000 | 2000);
    assert_eq!(bench.duty(0, 3 * PERIOD), 0.0);
    assert_eq!(bench.duty(1, 3 * PERIOD), 0.0);
}

#[test]
fn full_on_beats_compare_and_starts_at_on() {
    let mut bench = Bench::awake();
    bench.channel(0, 0x1000 | 777, 10);
    let start = bench.now();
    bench.wait_ns(10 * PERIOD);
    assert_eq!(bench.take(0), [(start + 777 * TICK, true)]);
}

#[test]
fn full_on_ends_with_the_cycle_that_brings_full_off() {
    let mut bench = Bench::awake();
    bench.channel(0, 0x1000, 0);
    let start = bench.now();
    bench.wait_ns(PERIOD + 5);
    bench.channel(0, 0, 0x1000);
    bench.forget();
    bench.wait_ns(2 * PERIOD);
    assert_eq!(bench.take(0), [(start + 2 * PERIOD, false)]);
}

#[test]
fn the_counter_is_held_while_all_outputs_are_full_off() {
    let mut bench = Bench::awake();
    bench.wait_ns(12_345_678); // wherever a free-running counter would stand
    bench.channel(7, 100, 200);
    let start = bench.now();
    bench.wait_ns(PERIOD / 2);
    assert_eq!(
        bench.take(7),
        [(start + 100 * TICK, true), (start + 200 * TICK, false)]
    );
    bench.write(&[map::ALL_LED_OFF_H, 0x10]);
    bench.wait_ns(PERIOD);
    assert!(!bench.chip(|chip, _| chip.is_running()));
    bench.forget();
    bench.wait_ns(7_777_777);
    bench.channel(7, 100, 200);
    let start = bench.now();
    bench.wait_ns(PERIOD / 2);
    assert_eq!(bench.take(7)[0], (start + 100 * TICK, true));
}

#[test]
fn on_equal_to_off_does_not_hold_the_counter() {
    let mut bench = Bench::awake();
    bench.channel(0, 5, 5);
    let start = bench.now();
    bench.wait_ns(3 * PERIOD + 1000);
    bench.channel(1, 100, 200); // waits for the end of the cycle
    bench.wait_ns(PERIOD + 300 * TICK);
    assert_eq!(bench.take(1)[0].0, start + 4 * PERIOD + 100 * TICK);
}

#[test]
fn all_channels_share_one_frequency_and_one_counter() {
    let mut bench = Bench::awake();
    let mut bytes = vec![map::LED0_ON_L];
    for n in 0..16_u16 {
        bytes.extend((n * 256).to_le_bytes());
        bytes.extend((n * 256 + 100).to_le_bytes());
    }
    bench.write(&bytes);
    let start = bench.now();
    bench.wait_ns(PERIOD - 1);
    let rises: Vec<_> = (bench.edges.iter())
        .filter(|(_, e)| e.pin == Pin::High)
        .map(|(_, e)| (e.channel.0, e.at.0))
        .collect();
    let expected: Vec<_> = (0..16_u8)
        .map(|n| (n, start + u64::from(n) * 256 * TICK))
        .collect();
    assert_eq!(rises, expected);
}
