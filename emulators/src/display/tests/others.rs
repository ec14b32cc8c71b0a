//! Time constants, bursts, dose, and vectors of any width.

use super::*;
use crate::display::finger::dose::{cem43_rate, omega_rate};
use crate::display::solver::WireDrive;
use crate::display::solver::exact::Exact;
use crate::display::solver::record::Peaks;
use palpate_core::physics::{TissueParameters, WireParameters};
use palpate_core::vector::Vectors;

const MS: u64 = 1_000_000;
/// Around a wire stretched in still air, away from any skin.
const FREE: TissueParameters = TissueParameters {
    contact_fraction: 0.0,
    ..TissueParameters::DEFAULT
};

/// Time until a wire that starts 20 K above its surroundings is 20 / e above them, s.
fn time_constant(wire: &WireParameters, tissue: &TissueParameters) -> f64 {
    let tissue = TissueParameters {
        air_c: 33.0,
        ..*tissue
    };
    let mut w = Wire::new(wire, &tissue, 33.0).unwrap();
    // A pulse so short that nothing has left the wire.
    let joule = 20.0 * wire.heat_capacity() / wire.wire_share;
    w.set_power(Nanos::ZERO, joule * 1e9);
    w.set_power(Nanos(1), 0.0);
    let (mut low, mut high) = (1_u64, 2_000_000_000_u64);
    while high - low > 1000 {
        let middle = low.midpoint(high);
        let c = w.clone().temperature(Nanos(middle));
        if c - 33.0 > 20.0 / std::f64::consts::E {
            low = middle
        } else {
            high = middle
        }
    }
    high as f64 * 1e-9
}

#[test]
fn time_constants() {
    let wire = WireParameters::FINAL.taut();
    let no_ends = WireParameters {
        conductivity: 0.0,
        ..wire
    };
    let air = time_constant(&no_ends, &FREE);
    let ends = time_constant(&wire, &FREE);
    println!("air {air:.4} s, with ends {ends:.4} s");
    assert!((air - 0.32).abs() < 0.01 && (ends - 0.17).abs() < 0.01);
    for (contact_h, fraction) in [(1000.0, 0.5), (2000.0, 0.5), (10_000.0, 0.5)] {
        let tissue = TissueParameters {
            contact_h,
            contact_fraction: fraction,
            ..TissueParameters::DEFAULT
        };
        println!("h_c {contact_h}: {:.4} s", time_constant(&wire, &tissue));
    }
}

#[test]
fn a_burst_is_counted() {
    let mut w = Wire::new(&WireParameters::FINAL, &TissueParameters::DEFAULT, 33.0).unwrap();
    play(
        &mut w,
        &edges(Nanos(35 * MS), Nanos(468 * MS), Nanos(500 * MS)),
    );
    let first = w.burst().unwrap();
    assert_eq!(first.pulses, 7);
    assert!((first.electrical_j - 7.0 * 0.914e-3).abs() < 2e-6);
    assert!((first.wire_j - 0.602 * first.electrical_j).abs() < 1e-12);
    assert!(
        first.ripple_k > 5.0 && first.ripple_max_k < 8.5,
        "{first:?}"
    );
}

#[test]
fn dose_of_known_plateaus() {
    assert!((cem43_rate(43.0) * 60.0 - 1.0).abs() < 1e-12);
    assert!((cem43_rate(44.0) * 60.0 - 2.0).abs() < 1e-12);
    assert!((cem43_rate(42.0) * 60.0 - 0.25).abs() < 1e-12);
    assert!(cem43_rate(38.9) < 1e-300);
    // 44 C for six hours: Moritz and Henriques' threshold, Omega about 1.
    let omega = omega_rate(44.0) * 6.0 * 3600.0;
    assert!(omega > 0.3 && omega < 3.0, "{omega}");
    let tissue = TissueParameters {
        body_c: 43.0,
        air_c: 43.0,
        ..TissueParameters::DEFAULT
    };
    let wire = WireParameters {
        ends_c: 43.0,
        ..WireParameters::FINAL
    };
    let mut w = Wire::new(&wire, &tissue, 43.0).unwrap().with_dose();
    let dose = w.dose(Nanos(60_000 * MS)).unwrap();
    assert!((dose.cem43_min - 1.0).abs() < 1e-9, "{dose:?}");
}

#[test]
fn wide_vectors_give_the_same_bits() {
    let wide = Exact::new(
        &WireParameters::FINAL.taut(),
        &TissueParameters::DEFAULT,
        33.0,
    )
    .unwrap();
    let plain = wide.with_vectors(Vectors::plain());
    // Bursts and pauses: the wire transforms both ways.
    let [wide, plain] = [wide, plain].map(|mut solver| {
        let mut least = 1.0_f64;
        for pulse in 0..40 {
            let start = Nanos(pulse * 5_000_000 + pulse / 8 * 200_000_000);
            solver.drive(start, WireDrive::Power(7.4));
            solver.drive(start + Nanos(124_000), WireDrive::Off);
            least = least.min(solver.fraction());
        }
        solver.advance(Nanos(2_000_000_000));
        assert!(least < 1.0 && solver.fraction() > least);
        let (peaks, energy) = (solver.peaks(&Peaks::NONE), solver.energy());
        let mut bits = solver.nodes().map(f64::to_bits).to_vec();
        let all = [
            peaks.wire_c,
            peaks.shallow_c,
            peaks.deep_c,
            energy.wire_j,
            energy.body_j,
        ];
        bits.extend(all.map(f64::to_bits));
        bits
    });
    assert_eq!(wide, plain);
}
