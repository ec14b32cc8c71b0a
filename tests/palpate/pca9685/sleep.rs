//! SLEEP and RESTART (document: "Sleep and restart").

use super::*;
use palpate_emulators::display::pca9685::Hazard;

/// A chip that slept with channel 0 at half duty and is awake again, paused.
fn paused() -> Bench {
    let mut bench = Bench::awake();
    bench.channel(0, 0, 2048);
    bench.wait_us(1000);
    bench.write(&[map::MODE1, 0x31]);
    bench.wait_ns(PERIOD);
    assert_eq!(bench.read(map::MODE1), 0xB1);
    bench.write(&[map::MODE1, 0x21]);
    bench.forget();
    bench
}

#[test]
fn sleep_stops_the_oscillator_and_sets_restart_at_the_end_of_the_cycle() {
    let mut bench = Bench::awake();
    bench.channel(0, 2048, 3000);
    let start = bench.now();
    bench.wait_us(1000);
    bench.write(&[map::MODE1, 0x31]);
    assert_eq!(bench.read(map::MODE1), 0x31, "not yet");
    bench.wait_ns(start + PERIOD - bench.now());
    assert_eq!(bench.read(map::MODE1), 0xB1);
    bench.wait_ns(10 * PERIOD);
    let pulse = [(start + 2048 * TICK, true), (start + 3000 * TICK, false)];
    assert_eq!(bench.take(0), pulse, "the last cycle is whole");
}

#[test]
fn outputs_stay_paused_after_wake_until_restart_is_written_with_1() {
    let mut bench = paused();
    assert_eq!(bench.duty(0, 20 * PERIOD), 0.0);
    assert_eq!(bench.read(map::MODE1), 0xA1);
    bench.write(&[map::MODE1, 0x21]); // 0 does nothing
    assert_eq!(bench.read(map::MODE1), 0xA1);
    assert_eq!(bench.duty(0, 2 * PERIOD), 0.0);
    let before = bench.now();
    bench.write(&[map::MODE1, 0xA1]);
    let acknowledge = before + (1 + 3 * 9) * 2_500;
    assert_eq!(bench.read(map::MODE1), 0x21);
    assert_eq!(
        bench.take(0),
        [(acknowledge, true)],
        "from the beginning of a cycle"
    );
}

#[test]
fn restart_before_500_us_is_ignored_and_recorded() {
    let mut bench = paused();
    bench.wait_us(400);
    bench.write(&[map::MODE1, 0xA1]);
    assert_eq!(bench.read(map::MODE1), 0xA1);
    let hazards = bench.chip(|chip, _| chip.hazards().to_vec());
    assert_eq!(hazards[0].1, Hazard::RestartTooEarly);
    bench.wait_us(100);
    bench.write(&[map::MODE1, 0xA1]);
    assert_eq!(bench.read(map::MODE1), 0x21);
}

#[test]
fn with_och_0_a_write_to_any_led_register_and_stop_ends_the_pause() {
    let mut bench = paused();
    bench.wait_us(500);
    bench.write(&[map::led(9), 0]);
    let stop = bench.now();
    assert_eq!(bench.read(map::MODE1), 0x21);
    assert_eq!(bench.take(0), [(stop, true)]);
}

#[test]
fn with_och_1_all_four_registers_of_a_channel_end_the_pause() {
    let mut bench = paused();
    bench.wait_us(500);
    bench.write(&[map::MODE2, 0x0C]);
    bench.write(&[map::led(9), 0, 0, 0]);
    assert_eq!(bench.read(map::MODE1), 0xA1);
    bench.write(&[map::led(9) + 3, 0x10]);
    assert_eq!(bench.read(map::MODE1), 0x21);
    assert_eq!(bench.take(0).len(), 1);
}

#[test]
fn outputs_start_500_us_after_wake() {
    let mut bench = Bench::one();
    bench.write(&[map::led(0), 0]);
    bench.write(&[map::led(0) + 1, 0x10]);
    bench.write(&[map::led(0) + 3, 0]);
    let before = bench.now();
    bench.write(&[map::MODE1, 0x21]);
    let acknowledge = before + (1 + 3 * 9) * 2_500;
    assert_eq!(
        bench.chip(|chip, _| chip.next_event()),
        Some(Nanos(acknowledge + 500_000))
    );
    bench.wait_us(1000);
    assert_eq!(bench.take(0), [(acknowledge + 500_000, true)]);
}

#[test]
fn an_led_write_while_asleep_clears_restart_and_wake_alone_resumes() {
    let mut bench = Bench::awake();
    bench.channel(0, 0, 2048);
    bench.write(&[map::MODE1, 0x31]);
    bench.wait_ns(PERIOD);
    bench.channel(0, 0, 1024);
    assert_eq!(bench.read(map::MODE1), 0x31);
    bench.write(&[map::MODE1, 0x21]);
    bench.wait_us(500);
    assert_eq!(bench.duty(0, PERIOD), 0.25);
}

#[test]
fn an_orderly_shutdown_clears_restart_and_the_led_registers_must_be_loaded_again() {
    let mut bench = Bench::awake();
    bench.channel(0, 0, 2048);
    bench.wait_us(1000);
    bench.write(&[map::ALL_LED_OFF_H, 0x10]);
    bench.write(&[map::MODE1, 0x31]); // in the same cycle: the shutdown is still under way
    bench.wait_ns(2 * PERIOD);
    assert_eq!(bench.read(map::MODE1), 0x31);
    let registers: Vec<u8> = (0..4).map(|k| bench.read(map::led(0) + k)).collect();
    assert_eq!(registers, [0, 0, 0, 0x10]);
    bench.write(&[map::MODE1, 0xA1]); // nothing to restart
    bench.wait_us(500);
    assert_eq!(bench.duty(0, 2 * PERIOD), 0.0);
    bench.channel(0, 0, 2048);
    assert_eq!(bench.duty(0, PERIOD), 0.5);
}

#[test]
fn full_off_in_each_channel_is_an_orderly_shutdown_too() {
    let mut bench = Bench::awake();
    bench.channel(3, 0, 2048);
    bench.wait_ns(PERIOD);
    bench.channel(3, 0, 0x1000);
    bench.wait_ns(PERIOD);
    bench.write(&[map::MODE1, 0x31]);
    assert_eq!(bench.read(map::MODE1), 0x31);
    assert_eq!(bench.read(map::led(3) + 3), 0x10);
}

#[test]
fn a_short_sleep_pauses_all_the_same() {
    // Awake again before the end of the cycle: how set_prescale() loses its outputs.
    let mut bench = Bench::awake();
    bench.channel(0, 0, 2048);
    bench.write(&[map::MODE1, 0x31]);
    bench.write(&[map::MODE1, 0x21]);
    bench.wait_ns(PERIOD);
    assert_eq!(bench.read(map::MODE1), 0xA1);
    assert_eq!(bench.duty(0, 5 * PERIOD), 0.0);
}

#[test]
fn a_paused_chip_that_sleeps_again_still_has_something_to_restart() {
    let mut bench = paused();
    bench.write(&[map::MODE1, 0x31]);
    assert_eq!(bench.read(map::MODE1), 0xB1);
    bench.write(&[map::MODE1, 0x21]);
    bench.wait_us(500);
    bench.write(&[map::MODE1, 0xA1]);
    assert_eq!(bench.duty(0, PERIOD), 0.5);
}
