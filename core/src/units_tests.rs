//! Tests of `units.rs`.

use super::*;

#[test]
fn two_hundred_hertz_is_prescale_30_and_196_89_hz() {
    let pre = Prescale::from_hz(Clock::INTERNAL, 200.0).unwrap();
    assert_eq!(pre.get(), 30);
    assert_eq!(pre.tick_ns(), 1_240);
    assert_eq!(pre.period_ns(), 5_079_040);
    assert!((pre.hz() - 196.89).abs() < 0.005);
}

#[test]
fn prescale_is_clamped_to_what_the_chip_can_do() {
    assert_eq!(Prescale::from_hz(Clock::INTERNAL, 1600.0).unwrap().get(), 3);
    assert!((Prescale::from_hz(Clock::INTERNAL, 1e9).unwrap().hz() - 1525.88).abs() < 0.01);
    assert_eq!(Prescale::from_hz(Clock::INTERNAL, 1.0).unwrap().get(), 255);
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(Prescale::from_hz(Clock::INTERNAL, bad), None);
    }
}

#[test]
fn a_clock_on_extclk_is_divided_like_the_oscillator() {
    let clock = Clock::external(16_000_000, 50).unwrap();
    let pre = Prescale::from_hz(clock, 200.0).unwrap();
    // round(16 MHz / (4096 * 200)) - 1, and 19.53 us / 20 of a tick.
    assert_eq!(
        (pre.get(), pre.tick_ns(), pre.period_ns()),
        (19, 1_250, 5_120_000)
    );
    assert!((pre.hz() - 195.3125).abs() < 1e-9);
    for (hz, ppm) in [(0, 50), (50_000_001, 50), (1, 50_001)] {
        assert_eq!(Clock::external(hz, ppm), None);
    }
}

#[test]
fn counted_stimuli_end_half_a_period_before_a_whole_number() {
    let free = Prescale::new(30);
    let clocked = free.with_clock(Clock::external(25_000_000, 100).unwrap());
    for (us, counted) in [
        (0, 2_539),
        (5_079, 2_539),
        (7_618, 2_539),
        (7_619, 7_618),
        (35_000, 33_013),
        (50_000, 48_250),
    ] {
        let length = Duration::from_micros(us);
        assert_eq!(
            clocked.counted(length),
            Duration::from_micros(counted),
            "{us}"
        );
        assert_eq!(free.counted(length), length);
    }
}

#[test]
fn duty_rounds_to_ticks_and_never_exceeds_a_period() {
    assert_eq!(Ticks::from_duty(0.0244).get(), 100);
    assert_eq!(Ticks::from_duty(7.0).get(), 4096);
    assert_eq!(Ticks::from_duty(-1.0).get(), 0);
    assert_eq!(Ticks::from_duty(f32::NAN).get(), 0);
}

#[test]
fn time_saturates() {
    assert_eq!(Instant::ZERO - Duration::from_millis(1), Instant::ZERO);
    assert_eq!(
        Instant::FAR_FUTURE + Duration::from_millis(1),
        Instant::FAR_FUTURE
    );
    assert_eq!(Instant::ZERO.since(Instant::from_micros(5)), Duration::ZERO);
}
