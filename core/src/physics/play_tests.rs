//! Bands under stress, shares that add up, and what is refused.

use super::*;

fn bands(alloy: &Alloy) -> [f64; 4] {
    [
        alloy.austenite_start_c,
        alloy.austenite_finish_c,
        alloy.martensite_start_c,
        alloy.martensite_finish_c,
    ]
}

fn close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 0.006, "{found:?} for {expected:?}");
    }
}

#[test]
fn bands_shift_with_stress() {
    close(
        &bands(&Alloy::LOW.under(10e6)),
        &[44.86, 54.86, 28.86, 18.86],
    );
    close(
        &bands(&Alloy::LOW.under(0.0)),
        &[43.43, 53.43, 27.43, 17.43],
    );
    assert_eq!(Alloy::LOW.under(172e6), Alloy::LOW);
    close(
        &bands(&Play::R_PHASE.bands.under(10e6)),
        &[37.67, 47.67, 45.67, 35.67],
    );
}

#[test]
fn shares_add_up() {
    let taut = WireParameters::FINAL.plays().unwrap();
    assert_eq!(taut.len(), 1);
    assert_eq!(taut[0].bands, Alloy::LOW);
    for hysteresis in [
        Hysteresis::Play,
        Hysteresis::Plays {
            count: 5,
            narrowest: 0.2,
        },
    ] {
        let wire = WireParameters {
            hysteresis,
            ..WireParameters::FINAL.loose()
        };
        let plays = wire.plays().unwrap();
        let sum = |of: fn(&Play) -> f64| plays.iter().map(of).sum::<f64>();
        close(
            &[
                sum(|p| p.martensite),
                sum(|p| p.strain) * 1e3,
                sum(|p| p.latent_heat) / 1e3,
            ],
            &[1.0, 11.0, 16.0],
        );
        // The part without hysteresis, about the middle of 60 C at 172 MPa.
        let reversible = plays[plays.len() - 2];
        close(&bands(&reversible.bands), &[31.86, 41.86, 41.86, 31.86]);
        close(
            &[reversible.martensite, reversible.latent_heat],
            &[0.02, 240.0],
        );
    }
}

#[test]
fn bands_that_cross_are_refused_by_name() {
    let crossed = Play {
        bands: Alloy {
            martensite_start_c: 48.0,
            ..Play::R_PHASE.bands
        },
        ..Play::R_PHASE
    };
    let of = |beside: Play| {
        WireParameters {
            beside: [Some(beside), None, None, None],
            ..WireParameters::FINAL
        }
        .check()
    };
    assert_eq!(of(crossed).unwrap_err().name, "hysteresis");
    let strained = Play {
        strain: f64::NAN,
        ..Play::R_PHASE
    };
    assert_eq!(of(strained).unwrap_err().name, "beside.strain");
    assert_eq!(of(Play::R_PHASE), Ok(()));
    let more_than_all = WireParameters {
        reversible: 1.5,
        ..WireParameters::FINAL
    };
    assert_eq!(more_than_all.check().unwrap_err().name, "1 - reversible");
}
