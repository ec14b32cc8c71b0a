//! The resonator against a Runge-Kutta of small steps, and against what makers of such coins state.

use super::*;

/// A motor's equation in small steps of fourth order, with the drive as it is said.
fn stepped(
    p: &LraParameters,
    drive: &Drive,
    (mut x, mut v): (f64, f64),
    seconds: f64,
) -> (f64, f64) {
    let omega = TAU * p.resonance_hz;
    let closed = !matches!(drive, Drive::Open);
    let rate = |t: f64, x: f64, v: f64| {
        let mut force = -p.mass_kg * omega * omega * x - p.mass_kg * omega / p.quality * v;
        if closed {
            let amps = (drive.volts(t) - p.force_n_a * v) / p.ohm;
            force += p.force_n_a * amps;
        }
        (v, force / p.mass_kg)
    };
    let count = (seconds / 2e-6).ceil() as u32;
    let h = seconds / f64::from(count);
    for i in 0..count {
        let t = f64::from(i) * h;
        let a = rate(t, x, v);
        let b = rate(t + h / 2.0, x + h / 2.0 * a.0, v + h / 2.0 * a.1);
        let c = rate(t + h / 2.0, x + h / 2.0 * b.0, v + h / 2.0 * b.1);
        let d = rate(t + h, x + h * c.0, v + h * c.1);
        x += h / 6.0 * (a.0 + 2.0 * b.0 + 2.0 * c.0 + d.0);
        v += h / 6.0 * (a.1 + 2.0 * b.1 + 2.0 * c.1 + d.1);
    }
    (x, v)
}

#[test]
fn every_drive_is_exact() {
    let p = LraParameters::COIN_10MM;
    let mut lra = Lra::new(p);
    let wave = |hz: f64, phase| Drive::Wave {
        peak: 2.8,
        omega: TAU * hz,
        phase,
    };
    let mut state = (0.0, 0.0);
    for (drive, seconds) in [
        (wave(175.0, 0.3), 0.0213),
        (wave(160.0, -1.0), 0.0301),
        (Drive::Steady(0.0), 0.0124),
        (Drive::Steady(1.5), 0.0411),
        (Drive::Open, 0.0533),
        (wave(300.0, 2.0), 0.0092),
    ] {
        state = stepped(&p, &drive, state, seconds);
        lra.pass(&drive, seconds);
        let (x, v) = (lra.x_m() - state.0, lra.v_m_s() - state.1);
        assert!(x.abs() < 1e-11 && v.abs() < 1e-8, "{drive:?}: {x} {v}");
    }
}

#[test]
fn cutting_a_stretch_changes_nothing() {
    let drive = |phase: f64| Drive::Wave {
        peak: 2.8,
        omega: 1000.0,
        phase,
    };
    let mut whole = Lra::new(LraParameters::COIN_10MM);
    let mut cut = whole.clone();
    whole.pass(&drive(0.5), 0.05);
    for piece in 0..50 {
        cut.pass(&drive(0.5 + f64::from(piece)), 1e-3);
    }
    assert!((whole.x_m() - cut.x_m()).abs() < 1e-15);
    assert!((whole.v_m_s() - cut.v_m_s()).abs() < 1e-12);
}

/// Makers of coins of 10 mm state 1.0 to 1.4 g on 100 g at 2 Vrms, and a narrow resonance.
#[test]
fn the_coin_shakes_100_g_as_makers_of_coins_state() {
    let p = LraParameters::COIN_10MM;
    let after_a_second = |hz: f64| {
        let mut lra = Lra::new(p);
        let wave = Drive::Wave {
            peak: 2.0 * core::f64::consts::SQRT_2,
            omega: TAU * hz,
            phase: 0.0,
        };
        lra.pass(&wave, 1.0);
        let omega = TAU * p.resonance_hz;
        p.mass_kg * omega * omega * lra.amplitude_m() / 0.1 / 9.81
    };
    let at_resonance = after_a_second(175.0);
    assert!((1.0..1.4).contains(&at_resonance), "{at_resonance}");
    assert!(after_a_second(165.0) < 0.5 * at_resonance);
    assert!(after_a_second(185.0) < 0.5 * at_resonance);
    let steady = p.steady_m(2.0 * core::f64::consts::SQRT_2);
    let omega = TAU * p.resonance_hz;
    let stated = p.mass_kg * omega * omega * steady / 0.1 / 9.81;
    assert!((at_resonance / stated - 1.0).abs() < 1e-3, "{stated}");
}

#[test]
fn faults_let_no_current_or_no_mass_move() {
    let wave = Drive::Wave {
        peak: 2.8,
        omega: 1100.0,
        phase: 0.0,
    };
    for fault in [MotorFault::Open, MotorFault::Short, MotorFault::Stuck] {
        let mut lra = Lra::new(LraParameters::COIN_10MM);
        lra.fault = Some(fault);
        lra.pass(&wave, 0.5);
        assert!(lra.amplitude_m() == 0.0, "{fault:?}");
        assert_eq!(lra.coil.celsius > 25.0, fault == MotorFault::Stuck);
    }
}

#[test]
fn the_coil_warms_to_its_loss_and_cools_again() {
    let mut lra = Lra::new(LraParameters::COIN_10MM);
    lra.fault = Some(MotorFault::Stuck);
    let wave = Drive::Wave {
        peak: 2.0 * core::f64::consts::SQRT_2,
        omega: TAU * 175.0,
        phase: 0.0,
    };
    // Half waves, as a chip drives it: 2 Vrms over 25 ohm are 160 mW.
    for _ in 0..350 * 200 {
        lra.pass(&wave, 0.5 / 175.0);
    }
    assert!((lra.coil.celsius - (25.0 + 0.16 * 150.0)).abs() < 0.01);
    lra.pass(&Drive::Open, 20.0);
    assert!((lra.coil.celsius - (25.0 + 24.0 / core::f64::consts::E)).abs() < 0.01);
}
