//! The rotating mass: start, speed, coasting and brake, against small steps.

#![allow(clippy::float_cmp)] // ends of ranges and a rotor at rest are exact

use super::*;

fn coin() -> Erm {
    Erm::new(ErmParameters::COIN_10MM)
}

#[test]
fn it_starts_only_beyond_its_static_friction() {
    let p = ErmParameters::COIN_10MM;
    let least = p.static_nm * p.ohm / p.torque_nm_a;
    let mut erm = coin();
    erm.pass(&Drive::Steady(least * 0.99), 1.0);
    assert!(erm.hz() == 0.0 && erm.amplitude_m() == 0.0);
    erm.pass(&Drive::Steady(least * 1.01), 1.0);
    assert!(erm.hz() > 10.0 && erm.amplitude_m() == p.unbalance_m);
}

#[test]
fn it_spins_up_as_small_steps_have_it() {
    let p = ErmParameters::COIN_10MM;
    let mut erm = coin();
    erm.pass(&Drive::Steady(3.0), 0.05);
    let mut speed = 0.0_f64;
    for _ in 0..500_000 {
        let torque = p.torque_nm_a * (3.0 - p.torque_nm_a * speed) / p.ohm - p.friction_nm;
        speed += torque / p.inertia_kg_m2 * 1e-7;
    }
    assert!((erm.hz() - speed / TAU).abs() < 1e-2, "{}", erm.hz());
    erm.pass(&Drive::Steady(3.0), 2.0);
    assert!((150.0..260.0).contains(&erm.hz()), "{}", erm.hz());
}

#[test]
fn a_reverse_voltage_stops_it_sooner_than_a_short_and_a_short_sooner_than_coasting() {
    let stops = |drive: Drive| {
        let mut erm = coin();
        erm.pass(&Drive::Steady(3.0), 2.0);
        let mut ms = 0;
        while erm.hz() > 5.0 && ms < 10_000 {
            erm.pass(&drive, 1e-3);
            ms += 1;
        }
        ms
    };
    let (reverse, short, open) = (
        stops(Drive::Steady(-3.0)),
        stops(Drive::Steady(0.0)),
        stops(Drive::Open),
    );
    assert!(reverse < short && short < open, "{reverse} {short} {open}");
}

#[test]
fn it_turns_round_through_rest() {
    let mut erm = coin();
    erm.pass(&Drive::Steady(3.0), 1.0);
    let forward = erm.hz();
    erm.pass(&Drive::Steady(-3.0), 2.0);
    assert!((erm.hz() - forward).abs() < 1e-6);
    erm.pass(&Drive::Open, 100.0);
    assert!(erm.hz() == 0.0);
}

#[test]
fn faults_let_it_rest() {
    for fault in [MotorFault::Open, MotorFault::Short, MotorFault::Stuck] {
        let mut erm = coin();
        erm.fault = Some(fault);
        erm.pass(&Drive::Steady(3.0), 1.0);
        assert!(erm.hz() == 0.0, "{fault:?}");
        assert_eq!(erm.coil.celsius > 25.0, fault == MotorFault::Stuck);
    }
}
