//! Frequencies, oscillators, exactness (document: "Registers and reset", lines 3 and 4).

use super::*;

/// The slowest and the fastest oscillator seen on real lots.
const SLOWEST: Oscillator = Oscillator::from_hz(23_000_000);
const FASTEST: Oscillator = Oscillator::from_hz(27_400_000);

#[test]
fn two_hundred_hertz_is_pre_30_and_196_89_hz() {
    let mut bench = Bench::awake();
    bench.channel(0, 0, 100);
    let start = bench.now();
    bench.wait_ns(2 * PERIOD);
    let expected = [
        (start, true),
        (start + 124_000, false),
        (start + PERIOD, true),
        (start + PERIOD + 124_000, false),
        (start + 2 * PERIOD, true),
    ];
    assert_eq!(bench.take(0), expected);
    assert!((1e9 / PERIOD as f64 - 196.89).abs() < 0.005);
}

#[test]
fn every_pre_scale_gives_its_exact_period() {
    for pre in 3..=255_u8 {
        let mut bench = Bench::one();
        bench.write(&[map::PRE_SCALE, pre]);
        bench.wake();
        bench.channel(0, 0, 1);
        let (start, tick) = (bench.now(), (u64::from(pre) + 1) * 40);
        bench.wait_ns(1000 * 4096 * tick);
        let edges = bench.take(0);
        assert_eq!(edges.len(), 2001);
        for (k, pair) in (0..).zip(edges.chunks(2)) {
            assert_eq!(pair[0], (start + k * 4096 * tick, true));
            assert!(pair.len() < 2 || pair[1] == (start + k * 4096 * tick + tick, false));
        }
    }
}

#[test]
fn edges_are_exact_for_any_oscillator_after_an_hour() {
    for hz in [23_000_000, 24_999_999, 25_000_001, 26_111_111, 27_400_000] {
        let mut bench = Bench::with_oscillator(Oscillator::from_hz(hz));
        bench.wake();
        bench.channel(0, 512, 612);
        let start = bench.now();
        let mut rises = 0;
        let mut check = |edge: Edge| {
            if edge.pin == Pin::High {
                let exact = (512 + 4096 * rises) * 31 * 1_000_000_000; // in 1 / hz of a nanosecond
                let late = u128::from(edge.at.0 - start) * u128::from(hz) - exact;
                assert!(late < u128::from(hz), "{hz}: rise {rises}");
                rises += 1;
            }
        };
        bench
            .bus
            .with(|s| s.chips_mut()[0].advance(Nanos(start + 3_600_000_000_000), &mut check))
            .unwrap();
        assert!(rises > 600_000);
    }
}

#[test]
fn a_popular_simulators_whole_microseconds_are_244_hz() {
    // It rounds a tick of 1.240 us to 1 us. We do not.
    let wrong = 1e6 / 4096.0;
    assert!((wrong - 244.14_f64).abs() < 0.005);
    let mut bench = Bench::awake();
    bench.channel(0, 0, 2048);
    bench.wait_us(1_000_000);
    let rises = bench.take(0).iter().filter(|e| e.1).count();
    assert_eq!(rises, 197); // 196.89 periods begun in a second
}

#[test]
fn a_35_ms_stimulus_delivers_6_7_or_8_pulses() {
    // Pulses that begin in a window of 35 ms at a random phase, for the oscillators that have been seen.
    let count = |oscillator: Oscillator, phase: u64| {
        let mut bench = Bench::with_oscillator(oscillator);
        bench.wake();
        bench.channel(0, 0, 100);
        bench.wait_ns(phase);
        bench.forget();
        bench.wait_us(35_000);
        bench.take(0).iter().filter(|e| e.1).count()
    };
    let phases = 400;
    let spread = |o: Oscillator| -> Vec<usize> {
        let mut seen = vec![0; 10];
        for k in 0..phases {
            seen[count(o, 1 + k * PERIOD / phases)] += 1;
        }
        seen
    };
    let nominal = spread(Oscillator::NOMINAL);
    assert_eq!(nominal[6] + nominal[7], 400);
    assert!(
        (nominal[7] as f64 / 400.0 - 0.89).abs() < 0.01,
        "{nominal:?}"
    );
    let slow = spread(SLOWEST);
    assert_eq!(slow[6] + slow[7], 400, "{slow:?}");
    let fast = spread(FASTEST);
    assert_eq!(fast[7] + fast[8], 400, "{fast:?}");
    assert!(fast[8] > 0 && slow[6] > 0);
}

#[test]
fn oscillators_seen_span_181_to_216_hz() {
    for (oscillator, hz) in [(SLOWEST, 181.0), (FASTEST, 216.0)] {
        let mut bench = Bench::with_oscillator(oscillator);
        bench.wake();
        bench.channel(0, 0, 100);
        bench.wait_us(10_000_000);
        let rises: Vec<u64> = bench.take(0).iter().filter(|e| e.1).map(|e| e.0).collect();
        let span = (rises[rises.len() - 1] - rises[0]) as f64 * 1e-9;
        assert!(((rises.len() - 1) as f64 / span - hz).abs() < 0.5);
    }
}

#[test]
fn a_changed_oscillator_keeps_the_phase() {
    let mut bench = Bench::awake();
    bench.channel(0, 2048, 2049);
    let start = bench.now();
    bench.wait_ns(1024 * TICK);
    bench.chip(|chip, now| chip.set_oscillator(now, Oscillator::from_hz(12_500_000)));
    bench.wait_ns(2 * PERIOD);
    // 1024 ticks done, 1024 to go at twice the length.
    assert_eq!(
        bench.take(0)[0],
        (start + 1024 * TICK + 1024 * 2 * TICK, true)
    );
}

#[test]
fn a_drifting_oscillator_changes_the_period_and_not_with_how_often_one_looks() {
    // 0.1 % a second.
    let drifting = Oscillator::NOMINAL.with_drift(25_000_000);
    let run = |steps: u64| {
        let mut bench = Bench::with_oscillator(drifting);
        bench.wake();
        bench.channel(0, 0, 100);
        for _ in 0..steps {
            bench.wait_ns(20_000_000_000 / steps);
        }
        bench.take(0)
    };
    let edges = run(1);
    assert_eq!(edges, run(1000));
    let periods: Vec<u64> = edges.chunks_exact(2).map(|e| e[0].0).collect();
    let first = periods[1] - periods[0];
    let last = periods[periods.len() - 1] - periods[periods.len() - 2];
    assert!(
        (first as f64 / last as f64 - 1.02).abs() < 1e-4,
        "{first} {last}"
    );
}

#[test]
fn boards_are_asynchronous_to_one_another() {
    let mut fast = Config::new(0x41);
    fast.oscillator = FASTEST;
    let mut bench = Bench::new(&[Config::new(0x40), fast]);
    bench.try_write(0x70, &[map::MODE1, 0x21]).unwrap();
    bench.wait_us(500);
    bench.try_write(0x70, &[map::led(0), 0, 0, 100, 0]).unwrap();
    bench.wait_us(100_000);
    let rises = |n| {
        bench
            .edges
            .iter()
            .filter(|(chip, e)| *chip == n && e.pin == Pin::High)
            .count()
    };
    assert_eq!((rises(0), rises(1)), (20, 22));
}

#[test]
fn a_chip_at_rest_has_nothing_to_do() {
    let mut bench = Bench::awake();
    assert_eq!(bench.chip(|chip, _| chip.next_event()), None);
    bench.channel(0, 0, 0x1000); // full off
    assert_eq!(bench.chip(|chip, _| chip.next_event()), None);
    bench.channel(0, 0, 1);
    let now = bench.now();
    assert_eq!(
        bench.chip(|chip, _| chip.next_event()),
        Some(Nanos(now + TICK))
    );
    bench.channel(0, 0x1000, 0); // full on: moves once, then rests
    bench.wait_ns(2 * PERIOD);
    assert_eq!(bench.chip(|chip, _| chip.next_event()), None);
}
