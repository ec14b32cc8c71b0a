//! Tests of `control.rs`.

use super::*;

fn map(falls: bool) -> ControlMap {
    let ends = |smooth, rough| Span {
        smooth: Duration::from_millis(smooth),
        rough: Duration::from_millis(rough),
    };
    let driver = LatentDriver {
        coordinate: 1,
        falls,
        low: -0.5,
        high: 0.3,
    };
    let rate = Span {
        smooth: 180_000,
        rough: 40_000,
    };
    ControlMap::new(driver.into(), ends(60, 160), ends(50, 20), rate).unwrap()
}

#[test]
fn friction_alone_says_how_slowly_a_surface_slides() {
    let friction = LatentDriver {
        coordinate: 0,
        falls: true,
        low: 0.0,
        high: 1.0,
    };
    let good = map(false);
    let with = |friction| {
        let drivers = Drivers {
            friction: Some(friction),
            ..good.drivers
        };
        ControlMap::new(drivers, good.delta_mu, good.sigma, good.rate_mhz)
    };
    let of = |z: [f32; 2]| {
        let c = with(friction).unwrap().control(&z);
        (c.delta_mu.as_micros(), c.sigma.as_micros(), c.rate_mhz)
    };
    // the coordinate falls with friction: 0.25 of it is three quarters of the way to the slow end
    assert_eq!(of([0.25, -0.5]), (135_000, 50_000, 180_000));
    assert_eq!(of([0.25, 0.3]), (135_000, 20_000, 40_000));
    let empty = LatentDriver {
        high: 0.0,
        ..friction
    };
    assert_eq!(with(empty), Err(ControlError::Latent));
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
        let driver = LatentDriver {
            low,
            high,
            ..good.drivers.roughness
        };
        let found = ControlMap::new(driver.into(), good.delta_mu, good.sigma, good.rate_mhz);
        assert_eq!(found, Err(ControlError::Latent));
    }
    let none = Span {
        smooth: 0,
        rough: 1,
    };
    let found = ControlMap::new(good.drivers, good.delta_mu, good.sigma, none);
    assert_eq!(found, Err(ControlError::Rate));
}
