//! Tests of `pulses.rs`.

use super::*;
use alloc::vec::Vec;

const CARRIER: Prescale = Prescale::new(30);

fn activation() -> Activation {
    let (lead, interval) = (Duration::from_millis(80), Duration::from_millis(600));
    Activation::new(0.02, 0.7, lead, interval).unwrap()
}

fn control(delta_ms: u64, sigma_ms: u64, rate_mhz: u32) -> Control {
    Control {
        delta_mu: Duration::from_millis(delta_ms),
        sigma: Duration::from_millis(sigma_ms),
        rate_mhz,
    }
}

/// Over 60 s: pulses of every wire, and the mean and variance that (3.1) gives them, from its own formula.
fn minute(draw: Draw, gaps: &[f32], control: Control, seed: u64) -> Vec<(f64, f64, f64)> {
    let mut pulses = Pulses::new(activation(), draw, CARRIER, gaps, seed);
    let mut sums = alloc::vec![(0.0, 0.0, 0.0); gaps.len()];
    let (mut slots, mut turns) = (0u64, 0u64);
    while pulses.at() < Instant::from_micros(60_000_000) {
        let at = pulses.at().as_micros();
        turns += 1;
        // The n-th slot is in the first period at whose end n periods of f_PWM have passed.
        let passed =
            u128::from(turns) * u128::from(CARRIER.period_ns()) * u128::from(control.rate_mhz);
        let open = u128::from(slots + 1) * 1_000_000_000_000 <= passed;
        slots += u64::from(open);
        let fired = pulses.next(&control);
        for ((sum, &gap), &fired) in sums.iter_mut().zip(gaps).zip(fired) {
            assert!(open || !fired, "a pulse in a skipped period");
            let mu = 80_000.0 + f64::from(gap) * control.delta_mu.as_micros() as f64;
            let far = ((at % 600_000) as f64 - mu) / control.sigma.as_micros() as f64;
            let p = if open {
                0.02 + 0.7 * libm::exp(-far * far / 2.0)
            } else {
                0.0
            };
            *sum = (
                sum.0 + f64::from(u8::from(fired)),
                sum.1 + p,
                sum.2 + p * (1.0 - p),
            );
        }
    }
    sums
}

const LINE: [f32; 3] = [0.0, 1.0, 2.0];
const THIMBLE: [f32; 8] = [0.0, 1.0, 2.0, 3.0, 1.0, 2.0, 1.0, 2.0];

#[test]
fn a_minutes_density_is_that_of_the_activation() {
    for (gaps, seed) in [(&LINE[..], 1), (&LINE, 2), (&THIMBLE, 1), (&THIMBLE, 2)] {
        for control in [
            control(60, 50, 196_000),
            control(160, 20, 40_000),
            control(100, 35, 17_300),
        ] {
            for (found, mean, variance) in minute(Draw::Bernoulli, gaps, control, seed) {
                let bound = 3.0 * libm::sqrt(variance);
                assert!(
                    (found - mean).abs() <= bound,
                    "{found} {mean} {bound} {control:?}"
                );
            }
            for (found, mean, _) in minute(Draw::Diffusion, gaps, control, seed) {
                assert!((found - mean).abs() <= 1.0, "{found} {mean} {control:?}");
            }
        }
    }
}

#[test]
fn the_rate_is_kept_and_never_above_the_carriers() {
    let always = Activation::new(0.0, 0.999_999, Duration::ZERO, Duration::from_micros(1));
    for (rate, expected) in [
        (5_000, 300),
        (23_000, 1380),
        (98_443, 5906),
        (190_000, 11_400),
        (400_000, 11_814),
    ] {
        let mut pulses = Pulses::new(always.unwrap(), Draw::Diffusion, CARRIER, &[0.0], 1);
        let mut found = 0;
        while pulses.at() < Instant::from_micros(60_000_000) {
            found += i32::from(pulses.next(&control(0, 1000, rate))[0]);
        }
        assert!((found - expected).abs() <= 1, "{rate}: {found}");
    }
}

/// A minute's pulses are as dense as their density says, and a wire's passes have as many. The means lie two spreads and
/// more within the interval, so its ends cut off a hundredth.
#[test]
fn the_density_is_that_of_the_pulses() {
    for control in [
        control(60, 35, 196_000),
        control(160, 20, 40_000),
        control(160, 20, 400_000),
    ] {
        let mut pulses = Pulses::new(activation(), Draw::Diffusion, CARRIER, &LINE, 1);
        let mut fired = 0;
        while pulses.at() < Instant::from_micros(60_000_000) {
            fired += pulses.next(&control).iter().filter(|fired| **fired).count();
        }
        let density = pulses.density(&control);
        let each_second = fired as f32 / 60.0;
        let off = each_second / density.all_hz - 1.0;
        assert!(off.abs() < 0.02, "{control:?}: {each_second} {density:?}");
        // All but the offset's pulses are of a pass; there are 100 in a minute.
        let rate_hz = (control.rate_mhz as f32 * 1e-3).min(196.89);
        let passes = each_second / 3.0 - 0.02 * rate_hz;
        let off = passes * 0.6 / density.pass - 1.0;
        assert!(off.abs() < 0.02, "{control:?}: {passes} {density:?}");
    }
}

#[test]
fn a_sum_of_one_or_more_is_refused() {
    let of = |alpha, beta| Activation::new(alpha, beta, Duration::ZERO, Duration::from_millis(1));
    for (alpha, beta) in [
        (0.5, 0.5),
        (-0.1, 0.5),
        (0.1, -0.5),
        (f64::NAN, 0.1),
        (0.1, f64::NAN),
        (2.0, 0.0),
    ] {
        assert_eq!(of(alpha, beta), Err(ActivationError::Sum));
    }
    assert!(of(0.0, 0.0).is_ok() && of(0.09, 0.9).is_ok());
    let none = Activation::new(0.1, 0.1, Duration::ZERO, Duration::ZERO);
    assert_eq!(none, Err(ActivationError::Interval));
}

#[test]
fn wires_in_line_and_on_a_thimble_stand_along_the_longer_side() {
    let p = Point::new;
    let line = [p(-6.5, 0.0), p(0.0, 0.0), p(6.5, 0.0)];
    assert_eq!(*along(&line, 6.5), LINE);
    let thimble = [p(0.0, -14.25), p(0.0, -4.75), p(-11.0, 4.75), p(0.0, 14.25)];
    assert_eq!(*along(&thimble, 9.5), [0.0, 1.0, 2.0, 3.0]);
}

#[test]
fn the_same_seed_gives_the_same_pulses_and_a_further_wire_leaves_the_others_alone() {
    let of = |gaps: &[f32], seed| {
        let mut pulses = Pulses::new(activation(), Draw::Bernoulli, CARRIER, gaps, seed);
        (0..500)
            .map(|_| pulses.next(&control(100, 30, 150_000))[..2].to_vec())
            .collect::<Vec<_>>()
    };
    assert_eq!(of(&LINE, 5), of(&LINE, 5));
    assert_eq!(of(&LINE, 5), of(&LINE[..2], 5));
    assert_ne!(of(&LINE, 5), of(&LINE, 6));
}
