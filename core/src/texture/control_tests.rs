//! Tests of `control.rs`.

use super::*;

fn map(falls: bool) -> ControlMap {
    let ends = |smooth, rough| Span {
        smooth: Duration::from_millis(smooth),
        rough: Duration::from_millis(rough),
    };
    let driver = RoughnessDriver {
        coordinate: 1,
        falls,
        low: -0.5,
        high: 0.3,
    };
    let rate = Span {
        smooth: 180_000,
        rough: 40_000,
    };
    ControlMap::new(driver, ends(60, 160), ends(50, 20), rate).unwrap()
}

#[test]
fn ends_of_the_range_give_ends_of_the_parameters_and_the_middle_the_middle() {
    let of = |falls, z: f32| {
        let c = map(falls).control(&[9.0, z, 9.0]);
        (c.delta_mu.as_micros(), c.sigma.as_micros(), c.rate_mhz)
    };
    let (smooth, rough) = ((60_000, 50_000, 180_000), (160_000, 20_000, 40_000));
    assert_eq!((of(false, -0.5), of(false, 0.3)), (smooth, rough));
    assert_eq!((of(true, -0.5), of(true, 0.3)), (rough, smooth));
    assert_eq!((of(false, -1.0), of(false, 1.0)), (smooth, rough));
    assert_eq!(of(false, -0.1), (110_000, 35_000, 110_000));
}

#[test]
fn no_latent_vector_leaves_the_limits() {
    for z in [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        1e30,
        -0.0,
        1e-40,
    ] {
        let c = map(false).control(&[0.0, z]);
        assert!((60_000..=160_000).contains(&c.delta_mu.as_micros()));
        assert!((40_000..=180_000).contains(&c.rate_mhz));
    }
    assert_eq!(map(false).control(&[]), map(false).control(&[0.0, -0.5]));
}

#[test]
fn an_empty_range_is_refused() {
    let good = map(false);
    for (low, high) in [
        (0.3, 0.3),
        (0.3, -0.5),
        (f32::NAN, 0.3),
        (0.0, f32::INFINITY),
    ] {
        let driver = RoughnessDriver {
            low,
            high,
            ..good.driver
        };
        let found = ControlMap::new(driver, good.delta_mu, good.sigma, good.rate_mhz);
        assert_eq!(found, Err(ControlError::Latent));
    }
    let none = Span {
        smooth: 0,
        rough: 1,
    };
    let found = ControlMap::new(good.driver, good.delta_mu, good.sigma, none);
    assert_eq!(found, Err(ControlError::Rate));
}
