//! The coil against the resonator's closed form, against a Runge-Kutta of small steps, and against its transfer function.

use super::super::Drive;
use super::super::lra::Lra;
use super::*;

const RATE: u32 = 48_000;
const COIL: LraParameters = LraParameters {
    resonance_hz: 120.0,
    mass_kg: 1e-3,
    quality: 2.5,
    force_n_a: 0.5,
    ohm: 8.0,
};

/// A burst of a sine in samples.
fn burst(n: u32, hz: f64) -> f64 {
    let envelope = (f64::from(n) / 200.0).min(1.0);
    0.4 * envelope * libm::sin(TAU * hz * f64::from(n) / f64::from(RATE))
}

#[test]
fn every_sample_is_the_resonators_step_of_a_steady_voltage() {
    for fault in [None, Some(MotorFault::Open), Some(MotorFault::Stuck)] {
        let (mut coil, mut lra) = (VoiceCoil::new(COIL, RATE), Lra::new(COIL));
        for n in 0..4000 {
            if n == 2000 {
                (coil.fault, lra.fault) = (fault, fault);
            }
            let volts = burst(n, 250.0);
            coil.sample(volts);
            lra.pass(&Drive::Steady(volts), 1.0 / f64::from(RATE));
            assert!((coil.x - lra.x_m()).abs() < 1e-15, "{fault:?} {n}");
            assert!((coil.v - lra.v_m_s()).abs() < 1e-11, "{fault:?} {n}");
        }
    }
}

/// A thousand samples of a burst in steps of fourth order, 20 for each sample.
fn stepped(p: &LraParameters) -> (f64, f64) {
    let omega = TAU * p.resonance_hz;
    let rate = |volts: f64, x: f64, v: f64| {
        let push = p.force_n_a * (volts - p.force_n_a * v) / p.ohm;
        let mechanical = p.mass_kg * omega / p.quality * v + p.mass_kg * omega * omega * x;
        (v, (push - mechanical) / p.mass_kg)
    };
    let (mut x, mut v, h) = (0.0, 0.0, 1.0 / f64::from(20 * RATE));
    for n in 0..20_000 {
        let volts = burst(n / 20, 250.0);
        let a = rate(volts, x, v);
        let b = rate(volts, x + h / 2.0 * a.0, v + h / 2.0 * a.1);
        let c = rate(volts, x + h / 2.0 * b.0, v + h / 2.0 * b.1);
        let d = rate(volts, x + h * c.0, v + h * c.1);
        x += h / 6.0 * (a.0 + 2.0 * b.0 + 2.0 * c.0 + d.0);
        v += h / 6.0 * (a.1 + 2.0 * b.1 + 2.0 * c.1 + d.1);
    }
    (x, v)
}

#[test]
fn any_damping_is_exact() {
    // Light, critical by quality alone, and far beyond critical by the magnet.
    let critical = LraParameters {
        quality: 0.5,
        force_n_a: 1e-9,
        ..COIL
    };
    let heavy = LraParameters {
        force_n_a: 6.0,
        ..COIL
    };
    for parameters in [COIL, critical, heavy] {
        let mut coil = VoiceCoil::new(parameters, RATE);
        (0..1000).for_each(|n| coil.sample(burst(n, 250.0)));
        let (x, v) = stepped(&parameters);
        let size = x.abs().max(1e-15);
        assert!((coil.x - x).abs() < 1e-8 * size, "{} {x}", coil.x);
        assert!((coil.v - v).abs() < 1e-6 * v.abs(), "{} {v}", coil.v);
    }
}

#[test]
fn a_long_sine_has_the_amplitude_of_the_transfer_function_and_its_heat() {
    for hz in [60.0, 120.0, 250.0, 400.0] {
        let mut coil = VoiceCoil::new(COIL, RATE);
        let mut most = 0.0_f64;
        for n in 0..RATE {
            coil.sample(0.4 * libm::sin(TAU * hz * f64::from(n) / f64::from(RATE)));
            if n > RATE / 2 {
                most = most.max(coil.x_m().abs());
            }
        }
        let wanted = steady_m(&COIL, 0.4, hz);
        assert!(
            (most / wanted - 1.0).abs() < 2e-3,
            "{hz} Hz: {most} {wanted}"
        );
        let now = coil.amplitude_m(hz);
        assert!((now / wanted - 1.0).abs() < 2e-2, "{hz} Hz: {now} {wanted}");
    }
    // A stuck coil is a resistor: V^2 / 2R for a second of twenty.
    let mut coil = VoiceCoil::new(COIL, RATE);
    coil.fault = Some(MotorFault::Stuck);
    (0..RATE).for_each(|n| coil.sample(libm::sin(TAU * 250.0 * f64::from(n) / f64::from(RATE))));
    coil.warm();
    let wanted = coil.coil.kelvin_per_watt / 16.0 * (1.0 - libm::exp(-1.0 / coil.coil.warming_s));
    let rise = coil.coil.celsius - coil.coil.air_c;
    assert!((rise / wanted - 1.0).abs() < 1e-3, "{rise} {wanted}");
}

#[test]
fn a_coil_comes_to_rest_and_stays_there() {
    let mut coil = VoiceCoil::new(COIL, RATE);
    (0..2000).for_each(|n| coil.sample(burst(n, 250.0)));
    let moving = coil.amplitude_m(250.0);
    coil.silence(RATE / 20);
    assert!(coil.amplitude_m(250.0) < 1e-3 * moving);
    coil.silence(RATE);
    assert!(coil.x_m().abs() < 1e-14);
    let (mut one, mut all) = (coil.clone(), coil);
    (0..100).for_each(|_| one.silence(1));
    all.silence(100);
    assert_eq!(one, all);
}
