//! Tests of `dose.rs`.

use super::*;

const HARD: Doses = Doses {
    omega: 0.01,
    cem43_min: 2.0,
};

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} is not {b}");
}

#[test]
fn the_logarithm_is_that_of_the_constant() {
    assert_eq!(LN_HENRIQUES_A.to_bits(), libm::log(HENRIQUES_A).to_bits());
}

#[test]
fn two_minutes_at_43_c_are_two_minutes() {
    let mut dose = Dose::new(43.0);
    dose.relax(43.0, 60.0);
    dose.heat(43.0, 60.0);
    close(dose.cem43_min, 2.0);
    // Henriques at 43 C: 3.1e98 exp(-6.27e5 / (R 316.15 K)) = 7.939e-6 1/s.
    assert!((dose.omega / 120.0 - 7.939e-6).abs() < 5e-9);
}

#[test]
fn a_degree_halves_above_43_c_and_quarters_below() {
    let rate = |t: f64| Rates::at(t).cem43_min * 60.0;
    close(rate(44.0), 2.0);
    close(rate(43.0), 1.0);
    close(rate(42.0), 0.25);
    close(rate(33.0), libm::exp2(-20.0));
}

#[test]
fn relaxing_counts_the_mean_of_its_ends_and_a_burst_its_hotter_one() {
    let mut dose = Dose::new(44.0);
    dose.relax(42.0, 60.0);
    close(dose.cem43_min, (2.0 + 0.25) / 2.0);
    let mean = (Rates::at(44.0).omega + Rates::at(42.0).omega) / 2.0;
    close(dose.omega, 60.0 * mean);
    let before = dose.clone();
    dose.heat(43.0, 30.0);
    close(dose.cem43_min - before.cem43_min, 0.5);
    close(dose.omega - before.omega, 30.0 * Rates::at(43.0).omega);
    let before = dose.clone();
    dose.heat(41.0, 30.0);
    close(dose.cem43_min - before.cem43_min, 0.5);
    close(dose.omega - before.omega, 30.0 * Rates::at(43.0).omega);
}

#[test]
fn ample_dose_lasts_a_minute_at_that_temperature() {
    let ample = Doses::ample(43_000);
    close(ample.cem43_min, 1.001);
    close(ample.omega, 60.06 * Rates::at(43.0).omega);
}

#[test]
fn dose_is_left_while_more_than_that_of_both_is() {
    let mut dose = Dose::new(33.0);
    let both = |omega, cem43_min| Doses { omega, cem43_min };
    for (omega, cem43_min, more) in [
        (0.0, 0.0, true),
        (6.0, 1.0, false),
        (5.999, 1.499, true),
        (0.0, 1.5, false),
        (9.0, 0.0, false),
        (6.5, 1.6, false),
    ] {
        (dose.omega, dose.cem43_min) = (omega, cem43_min);
        let leaves = dose.leaves(&both(8.0, 2.0), &both(2.0, 0.5));
        assert_eq!(leaves, more, "{omega} {cem43_min}");
    }
}

#[test]
fn the_ceiling_spends_what_is_left_within_a_minute() {
    let mut dose = Dose::new(33.0);
    // Two minutes at 44 C are two a minute.
    close(dose.ceiling_c(&HARD), 44.0);
    for (spent, ceiling) in [
        (1.0, 43.0),
        (1.5, 42.5),
        (1.75, 42.0),
        (2.0 - 0.015625, 40.0),
    ] {
        dose.cem43_min = spent;
        close(dose.ceiling_c(&HARD), ceiling);
    }
    dose.cem43_min = 2.0;
    assert!(dose.ceiling_c(&HARD) < 0.0);
    dose.cem43_min = 0.0;
    for left in [1e-3, 1e-4, 1e-5] {
        dose.omega = 0.01 - left;
        let rate = Rates::at(dose.ceiling_c(&HARD)).omega;
        assert!((rate * HORIZON_S / left - 1.0).abs() < 1e-6);
    }
    dose.omega = 0.02;
    assert!(dose.ceiling_c(&HARD) < 0.0);
}
