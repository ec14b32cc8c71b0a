//! The curve against the published values and against the cubic's own root.

use super::super::{Mount, TissueParameters};
use super::*;

fn wire(diameter_um: f64, length_mm: f64, sag_um: f64) -> WireParameters {
    WireParameters {
        diameter_m: diameter_um * 1e-6,
        length_m: length_mm * 1e-3,
        mount: Mount {
            sag_m: sag_um * 1e-6,
            ..Mount::DEFAULT
        },
        ..WireParameters::FINAL
    }
}

/// Stiffness of bending and tissue, N/m, from their own formulas.
fn held(wire: &WireParameters, bow: &Bow) -> f64 {
    let d = wire.diameter_m;
    let second = PI / 64.0 * d * d * d * d;
    let bending = 2.0 * wire.mechanics.modulus_martensite_pa * second * PI * PI * PI * PI
        / (wire.length_m * wire.length_m * wire.length_m);
    bending + 3.0 / 8.0 * bow.line_n_per_m
}

/// The positive root of the balance of forces at a strain, m: halving, so that it is slow and plain.
fn root(wire: &WireParameters, bow: &Bow, strain: f64) -> f64 {
    let (modulus, length, rest) = (
        wire.mechanics.modulus_martensite_pa,
        wire.length_m,
        wire.mount.sag_m,
    );
    let section = PI / 4.0 * wire.diameter_m * wire.diameter_m;
    let force = |s: f64| {
        let excess = PI * PI * (s * s - rest * rest) / (4.0 * length * length) - strain;
        modulus * section * PI * PI * s / (2.0 * length) * excess + held(wire, bow) * (s - rest)
    };
    let (mut low, mut high) = (0.0, 10.0 * length);
    for _ in 0..200 {
        let middle = f64::midpoint(low, high);
        if force(middle) < 0.0 {
            low = middle
        } else {
            high = middle
        }
    }
    low
}

/// Rows by strain, ppm: displacement, um, and stress beyond the bias, MPa.
type Row = (f64, f64, f64);

/// The published rows are of a curve whose pieces may lie 0.05 um beside the bow.
#[test]
#[expect(clippy::approx_constant, reason = "a shift of 3.14 um is not pi")]
fn bows_saturate_as_published() {
    let table: [(WireParameters, f64, f64, [Row; 7]); 4] = [
        (
            wire(75.0, 8.0, 170.0),
            1114.0,
            5.657,
            [
                (100.0, -4.58, -1.12),
                (-100.0, 4.47, 1.15),
                (-300.0, 13.38, 3.66),
                (-1000.0, 42.58, 14.30),
                (-2000.0, 75.72, 34.37),
                (-5000.0, 122.8, 111.2),
                (-10_000.0, 145.1, 249.4),
            ],
        ),
        (
            wire(75.0, 8.0, 500.0),
            9638.0,
            3.004,
            [
                (100.0, -2.42, -0.21),
                (-100.0, 2.38, 0.20),
                (-300.0, 7.23, 0.63),
                (-1000.0, 24.47, 2.20),
                (-2000.0, 49.95, 4.75),
                (-5000.0, 133.0, 15.5),
                (-10_000.0, 288.5, 58.4),
            ],
        ),
        (
            wire(75.0, 5.0, 100.0),
            987.0,
            6.488,
            [
                (100.0, -3.28, -0.99),
                (-100.0, 3.21, 1.03),
                (-300.0, 9.63, 3.31),
                (-1000.0, 30.56, 13.66),
                (-2000.0, 52.66, 34.53),
                (-5000.0, 78.5, 113.6),
                (-10_000.0, 89.1, 252.7),
            ],
        ),
        (
            wire(50.0, 8.0, 250.0),
            2410.0,
            3.973,
            [
                (100.0, -3.21, -1.08),
                (-100.0, 3.14, 1.09),
                (-300.0, 9.47, 3.36),
                (-1000.0, 31.22, 12.17),
                (-2000.0, 60.53, 27.26),
                (-5000.0, 127.4, 88.7),
                (-10_000.0, 179.7, 217.9),
            ],
        ),
    ];
    for (wire, slack, gain, rows) in table {
        let bow = Bow::new(&wire, &TissueParameters::DEFAULT).unwrap();
        let shape = Shape::new(&bow, &wire);
        assert!((shape.a * shape.rest * shape.rest * 1e6 - slack).abs() < 0.6);
        assert!((bow.gain - gain).abs() < 6e-4, "{}", bow.gain);
        for (strain, u_um, stress) in rows {
            let sag = root(&wire, &bow, strain * 1e-6);
            let (u, pa) = ((shape.rest - sag) * 1e6, shape.stress(sag));
            let close = if u_um.abs() < 100.0 { 0.055 } else { 0.1 };
            assert!((u - u_um).abs() < close, "{strain}: {u} for {u_um}");
            let mpa = pa * 1e-6;
            assert!(
                (mpa - stress).abs() < 0.02 + 0.004 * stress.abs(),
                "{strain}: {mpa} for {stress}"
            );
        }
    }
}

#[test]
fn pieces_stay_beside_the_cubics_root() {
    for wire in [
        wire(75.0, 8.0, 170.0),
        wire(75.0, 5.0, 100.0),
        wire(50.0, 8.0, 250.0),
        wire(100.0, 5.0, 43.0),
        wire(75.0, 8.0, 500.0),
    ] {
        let bow = Bow::new(&wire, &TissueParameters::DEFAULT).unwrap();
        let (curve, shape) = (Curve::new(&bow, &wire), Shape::new(&bow, &wire));
        let (first, last) = (
            curve.pieces[1].low,
            curve.pieces[curve.pieces.len() - 1].low,
        );
        let (mut worst, mut before) = (0.0_f64, f64::INFINITY);
        for look in 0..20_000 {
            let strain = first + (last - first) * f64::from(look) / 2e4;
            let piece = &curve.pieces[curve.at(strain)];
            assert!(piece.low <= strain && strain <= piece.high);
            let sag = root(&wire, &bow, strain);
            worst = worst.max((piece.u_at(strain) - (shape.rest - sag)).abs());
            assert!(piece.u_at(strain) <= before && piece.stiffness_pa >= 0.0);
            assert_eq!(piece.apart, piece.u_at(strain) < bow.parting_m - 1e-12);
            let over = piece.u_at(strain) / shape.rest - TIGHTEST;
            assert!(over.abs() < 1e-9 || piece.tight == (over > 0.0));
            before = piece.u_at(strain);
        }
        assert!(worst < 1.02 * BEND_M, "{worst}");
        // No step at a knot, in displacement or in stress.
        for pair in curve.pieces.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            assert!((a.u_at(a.high) - b.u_at(b.low)).abs() < 1e-15);
            assert!((a.stress_at(a.high) - b.stress_at(b.low)).abs() < 1e-3);
            assert!(a.high.to_bits() == b.low.to_bits());
        }
        assert!(curve.pieces.iter().any(|p| p.low == 0.0 && p.u_m == 0.0));
    }
}

#[test]
fn the_longest_piece_is_the_one_that_halving_finds() {
    for wire in [
        wire(75.0, 8.0, 170.0),
        wire(50.0, 8.0, 250.0),
        wire(100.0, 5.0, 43.0),
        wire(75.0, 8.0, 500.0),
    ] {
        let bow = Bow::new(&wire, &TissueParameters::DEFAULT).unwrap();
        let shape = Shape::new(&bow, &wire);
        let (mut from, to, mut pieces) = (shape.rest, shape.rest * (1.0 - TIGHTEST), 0);
        while shape.bend(from, to) > BEND_M {
            let whole = to - from;
            let (mut good, mut bad) = (0.0, 1.0);
            for _ in 0..24 {
                let part = f64::midpoint(good, bad);
                match shape.bend(from, from + whole * part) <= BEND_M {
                    true => good = part,
                    false => bad = part,
                }
            }
            for guess in [0.0, 1e-6, good * 0.99, good, 1.0, 1e9, f64::NAN] {
                let found = shape.reach(from, whole, guess);
                assert_eq!(found.to_bits(), f64::to_bits(good), "from {guess}");
            }
            from += whole * good;
            pieces += 1;
        }
        assert!(pieces > 20, "{pieces}");
    }
}
