//! Tests of `units.rs`.

use super::*;

#[test]
fn two_hundred_hertz_is_prescale_30_and_196_89_hz() {
    let pre = Prescale::from_hz(200.0).unwrap();
    assert_eq!(pre.get(), 30);
    assert_eq!(pre.tick_ns(), 1_240);
    assert_eq!(pre.period_ns(), 5_079_040);
    assert!((pre.hz() - 196.89).abs() < 0.005);
}

#[test]
fn prescale_is_clamped_to_what_the_chip_can_do() {
    assert_eq!(Prescale::from_hz(1600.0).unwrap().get(), 3);
    assert!((Prescale::from_hz(1e9).unwrap().hz() - 1525.88).abs() < 0.01);
    assert_eq!(Prescale::from_hz(1.0).unwrap().get(), 255);
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(Prescale::from_hz(bad), None);
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
