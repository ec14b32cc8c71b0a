//! Bands under stress, and phases that are refused.

use super::*;

fn close(alloy: &Alloy, expected: [f64; 4]) {
    let found = [
        alloy.austenite_start_c,
        alloy.austenite_finish_c,
        alloy.martensite_start_c,
        alloy.martensite_finish_c,
    ];
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 0.006, "{found:?} for {expected:?}");
    }
}

/// The vendor states its temperatures at 172 MPa.
#[test]
fn bands_shift_with_stress() {
    close(&Alloy::LOW.under(172e6), [68.0, 78.0, 52.0, 42.0]);
    close(&Alloy::HIGH.under(172e6), [88.0, 98.0, 72.0, 62.0]);
    close(&Alloy::LOW.under(10e6), [44.86, 54.86, 28.86, 18.86]);
    close(&Alloy::LOW, [43.43, 53.43, 27.43, 17.43]);
    close(&RPhase::LOW.bands.under(10e6), [37.67, 47.67, 45.67, 35.67]);
    close(&Alloy::LOW.reversible(), [30.43, 40.43, 40.43, 30.43]);
}

#[test]
fn phases_that_cannot_be_are_refused_by_name() {
    let good = WireParameters::FINAL;
    let of = |r: RPhase| {
        WireParameters {
            r_phase: Some(r),
            ..good
        }
        .check()
    };
    assert_eq!(of(RPhase::LOW), Ok(()));
    let bands = Alloy {
        martensite_start_c: 48.0,
        ..RPhase::LOW.bands
    };
    let refused = [
        (
            of(RPhase {
                bands,
                ..RPhase::LOW
            }),
            "hysteresis",
        ),
        (
            of(RPhase {
                strain: f64::NAN,
                ..RPhase::LOW
            }),
            "r_phase.strain",
        ),
        (
            of(RPhase {
                strain: 3e-3,
                ..RPhase::LOW
            }),
            "mechanics.transformation_strain",
        ),
        (
            of(RPhase {
                latent_heat: 13e3,
                ..RPhase::LOW
            }),
            "latent_heat",
        ),
        (
            WireParameters {
                reversible: 1.5,
                ..good
            }
            .check(),
            "1 - reversible",
        ),
    ];
    for (found, name) in refused {
        assert_eq!(found.unwrap_err().name, name);
    }
}
