//! When a write reaches an output (document: "Outputs" lines 4 and 5, "Torn updates burn wires").

use super::*;

#[test]
fn och_0_changes_outputs_on_stop_and_a_repeated_start_commits_nothing() {
    let mut bench = Bench::awake();
    let before = bench.now();
    let mut byte = [0];
    let message = [map::led(0), 0, 0x10, 0, 0];
    let mut operations = [Operation::Write(&message), Operation::Read(&mut byte)];
    bench.transaction(ADDRESS, &mut operations).unwrap();
    // START, 6 bytes, START, 2 bytes, STOP: the output rises with the STOP.
    assert_eq!(bench.now() - before, 75 * 2_500);
    let stop = bench.now();
    assert_eq!(bench.take(0), [(stop, true)]);
}

#[test]
fn och_1_changes_outputs_on_the_acknowledge_of_a_channels_fourth_register() {
    let mut bench = Bench::awake();
    bench.write(&[map::MODE2, 0x0C]);
    let before = bench.now();
    bench.write(&[map::led(0), 0, 0x10, 0, 0, 0, 0x10, 0, 0]);
    // START, address, control and four bytes; four more for the next channel.
    let fourth = before + (1 + 6 * 9) * 2_500;
    let seen: Vec<_> = (bench.edges.iter())
        .map(|(_, e)| (e.channel.0, e.at.0))
        .collect();
    // The counter starts with the first channel; the second waits for the end of the cycle.
    assert_eq!(seen, [(0, fourth)]);
    bench.wait_ns(PERIOD);
    assert_eq!(bench.take(1), [(fourth + PERIOD, true)]);
}

#[test]
fn och_1_commits_nothing_with_fewer_than_four_registers() {
    let mut bench = Bench::awake();
    bench.write(&[map::MODE2, 0x0C]);
    bench.write(&[map::led(0), 0, 0x10, 0]);
    assert_eq!(bench.duty(0, 2 * PERIOD), 0.0);
    bench.write(&[map::led(0) + 3, 0]); // the fourth, in a transaction of its own
    assert_eq!(bench.duty(0, PERIOD), 1.0);
    // A fast stop by one register does not work with OCH = 1.
    bench.write(&[map::ALL_LED_OFF_H, 0x10]);
    assert_eq!(bench.duty(0, 2 * PERIOD), 1.0);
}

#[test]
fn mid_period_writes_apply_at_the_end_of_the_low_part() {
    // STOP in the leading low part, in the pulse, in the trailing low part: always the cycle's end.
    for phase in [100, 1500, 3000] {
        let mut bench = Bench::awake();
        bench.channel(0, 1000, 2000);
        let start = bench.now();
        bench.wait_ns(PERIOD + phase * TICK);
        bench.forget();
        bench.channel(0, 500, 3500);
        assert!(bench.now() < start + PERIOD + (phase + 900) * TICK);
        bench.wait_ns(2 * PERIOD);
        let edges = bench.take(0);
        let at = |tick: u64| start + 2 * PERIOD + tick * TICK;
        let new = edges.iter().position(|e| *e == (at(500), true)).unwrap();
        assert_eq!(edges[new + 1], (at(3500), false));
        for (t, _) in &edges[..new] {
            let tick = (t - start) / TICK % 4096;
            assert!(tick == 1000 || tick == 2000, "the old pulse is not cut");
        }
    }
}

#[test]
fn an_update_with_on_above_off_in_force_costs_one_whole_blank_period() {
    let mut bench = Bench::awake();
    bench.channel(0, 2048, 100);
    let start = bench.now();
    bench.wait_ns(PERIOD + 1000 * TICK);
    bench.forget();
    bench.channel(0, 2048, 200);
    bench.wait_ns(3 * PERIOD);
    let at = |period: u64, tick: u64| start + period * PERIOD + tick * TICK;
    assert_eq!(
        bench.take(0),
        [
            (at(1, 2048), true),
            (at(2, 0), false), // blank from wrap to wrap
            (at(3, 0), true),
            (at(3, 200), false),
            (at(3, 2048), true),
            (at(4, 200), false),
        ]
    );
}

#[test]
fn one_write_a_cycle_with_on_above_off_halves_the_duty() {
    // The logic-analyser traces: a ramp of OFF with ON = 2048 falls from 50 % to 25 %.
    let mut bench = Bench::awake();
    bench.channel(0, 2048, 4095);
    let start = bench.now();
    bench.wait_ns(PERIOD);
    let mut high = 0.0;
    for k in 1..=200_u16 {
        let next = start + u64::from(k) * PERIOD + PERIOD / 2;
        let span = next - bench.now();
        high += bench.duty(0, span) * span as f64;
        bench.channel(0, 2048, 10 + k % 2);
    }
    let duty = high / (200.0 * PERIOD as f64);
    assert!((duty - 0.25).abs() < 0.02, "{duty}");
}

#[test]
fn the_blank_period_ends_in_full_on_that_starts_at_on() {
    let mut bench = Bench::awake();
    bench.channel(0, 2048, 100);
    let start = bench.now();
    bench.wait_ns(PERIOD / 4);
    bench.channel(0, 0x1000 | 300, 0);
    bench.forget();
    bench.wait_ns(5 * PERIOD);
    let at = |period: u64, tick: u64| start + period * PERIOD + tick * TICK;
    assert_eq!(
        bench.take(0),
        [(at(0, 2048), true), (at(1, 0), false), (at(2, 300), true)]
    );
}

#[test]
fn the_immediate_model_applies_at_stop() {
    let mut bench = Bench::with_updates(UpdateModel::Immediate);
    bench.wake();
    bench.channel(0, 3000, 2000);
    let start = bench.now();
    bench.wait_ns(1000 * TICK);
    bench.forget();
    bench.channel(0, 3500, 500);
    let stop = bench.now();
    bench.wait_ns(PERIOD);
    assert_eq!(
        bench.take(0)[..3],
        [
            (stop, false),
            (start + 3500 * TICK, true),
            (start + PERIOD + 500 * TICK, false)
        ]
    );
    bench.channel(0, 0, 0x1000);
    assert!(!bench.chip(|chip, _| chip.is_running()), "held at once");
}

#[test]
fn full_off_of_a_running_output_waits_for_the_end_of_the_cycle() {
    // Figure 10, example 4: why OE is the faster stop.
    let mut bench = Bench::awake();
    bench.channel(0, 0, 4000);
    let start = bench.now();
    bench.wait_ns(1000 * TICK);
    bench.forget();
    bench.write(&[map::ALL_LED_OFF_H, 0x10]);
    bench.wait_ns(3 * PERIOD);
    assert_eq!(bench.take(0), [(start + 4000 * TICK, false)]);
    assert!(!bench.chip(|chip, _| chip.is_running()));
}

#[test]
fn a_register_at_a_time_exposes_a_mixed_pair_of_90_percent_duty() {
    // 0/100 to 512/612, ON first: 512/100 for a period at least.
    let mut bench = Bench::awake();
    bench.channel(0, 0, 100);
    let start = bench.now();
    bench.wait_ns(PERIOD / 2);
    bench.write(&[map::led(0), 0, 2]);
    bench.wait_ns(start + PERIOD - bench.now());
    assert_eq!(bench.now(), start + PERIOD);
    let duty = bench.duty(0, PERIOD);
    assert!((duty - 3684.0 / 4096.0).abs() < 1e-3, "{duty}");
    bench.write(&[map::led(0) + 2, 100, 2]);
    bench.wait_ns(2 * PERIOD);
    let duty = bench.duty(0, 4 * PERIOD);
    assert!((duty - 100.0 / 4096.0).abs() < 1e-3, "{duty}");
}

#[test]
fn one_contiguous_write_never_exposes_a_mixed_pair() {
    for phase in (0..4096).step_by(64) {
        let mut bench = Bench::awake();
        bench.channel(0, 0, 100);
        bench.wait_ns(PERIOD + phase * TICK);
        bench.channel(0, 512, 612);
        bench.wait_ns(3 * PERIOD);
        let edges = bench.take(0);
        for pair in edges.windows(2).filter(|p| p[0].1) {
            assert_eq!(pair[1].0 - pair[0].0, 100 * TICK);
        }
    }
}

#[test]
fn several_boards_prepared_in_one_transaction_change_together_on_its_stop() {
    // One STOP for all, as I2C_RDWR can send it.
    let mut bench = Bench::new(&[Config::new(0x40), Config::new(0x41)]);
    bench.try_write(0x70, &[map::MODE1, 0x21]).unwrap();
    bench.wait_us(500);
    let message = [map::led(0), 0, 0, 100, 0];
    let mut messages = [
        (0x40, Operation::Write(&message)),
        (0x41, Operation::Write(&message)),
    ];
    bench
        .bus
        .with(|s| s.transfer(&mut messages))
        .unwrap()
        .unwrap();
    bench.collect();
    let stop = Nanos(bench.now());
    let edges: Vec<_> = bench.edges.iter().map(|(n, e)| (*n, e.at)).collect();
    assert_eq!(edges, [(0, stop), (1, stop)]);
}

#[test]
fn adjacent_messages_without_nostart_write_somewhere_else() {
    let tail = [0, 2, 100, 2];
    let run = |adjacent| {
        let chip = Pca9685::new(Config::new(ADDRESS));
        let mut bench =
            Bench::over(I2cSegment::new(BusClock::Fast, vec![chip]).with_adjacent(adjacent));
        bench.wake();
        let mut operations = [Operation::Write(&[map::led(0)]), Operation::Write(&tail)];
        let result = bench.transaction(ADDRESS, &mut operations);
        let registers: Vec<u8> = (0..4).map(|k| bench.read(map::led(0) + k)).collect();
        (result, registers)
    };
    assert_eq!(run(Adjacent::Merge), (Ok(()), tail.to_vec()));
    // The second message's first byte is a control byte: MODE1 gets 2, auto-increment goes, SUBADR.. stay.
    assert_eq!(run(Adjacent::RepeatedStart), (Ok(()), vec![0, 0, 0, 0x10]));
    assert_eq!(
        run(Adjacent::Refuse),
        (Err(Error::Unsupported), vec![0, 0, 0, 0x10])
    );
}
