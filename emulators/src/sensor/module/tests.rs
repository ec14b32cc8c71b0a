//! The emulated skin against the figures it is calibrated by.

use super::*;
use crate::sensor::Generation;

const SPHERE_MM: f64 = 19.45;

fn still(at: Point, force_n: f64) -> Box<dyn Touches> {
    Box::new(move |_: Nanos, out: &mut Vec<Press>| {
        out.push(Press {
            at,
            force_n,
            diameter_mm: SPHERE_MM,
        });
    })
}

fn noiseless() -> EmulatedModule {
    EmulatedModule::new(ModuleConfig {
        noise_lsb: (0.0, 0.0),
        ..ModuleConfig::default()
    })
}

fn norms(module: &mut EmulatedModule, at: Point, force: f64) -> Vec<f64> {
    module.touch(still(at, force));
    module.sampled_at = None; // settled at once
    module.respond(Nanos::ZERO);
    let norm = |s: &[f64; 3]| (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]).sqrt();
    module.response.iter().map(norm).collect()
}

fn hull() -> impl Iterator<Item = Point> {
    let along = |i: i32| 7.05 * i as f32 / 15.0;
    (-15..=15).flat_map(move |i| (-15..=15).map(move |j| Point::new(along(i), along(j))))
}

/// The weighted mean of chapter 4 with K_C = 1 and weights norm², computed directly.
fn weighted_mean(norms: &[f64], threshold: f64) -> (usize, f64, f64) {
    let (mut members, mut sum, mut x, mut y) = (0, 0.0, 0.0, 0.0);
    for (norm, at) in norms.iter().zip(grid(4, 4, 4.7)) {
        if *norm > threshold {
            members += 1;
            sum += norm * norm;
            x += norm * norm * f64::from(at.x);
            y += norm * norm * f64::from(at.y);
        }
    }
    (members, x / sum, y / sum)
}

#[test]
fn a_newton_is_about_1190_counts() {
    let mut module = noiseless();
    for force in [0.1, 0.5, 1.0] {
        norms(&mut module, Point::default(), force);
        let sum: f64 = module.response.iter().map(|s| s[2]).sum();
        assert!(
            (sum / force / 1190.0 - 1.0).abs() < 0.05,
            "{sum} at {force} N"
        );
    }
}

#[test]
fn the_sphere_at_its_strongest_puts_up_to_12_of_16_taxels_in_contact() {
    let mut module = noiseless();
    for threshold in [12.0, 15.0, 18.0, 20.0] {
        let counts = hull().map(|at| weighted_mean(&norms(&mut module, at, 1.0), threshold).0);
        assert_eq!(counts.max(), Some(12), "threshold {threshold}");
    }
    let weak = hull()
        .map(|at| weighted_mean(&norms(&mut module, at, 0.3), 15.0).0)
        .max();
    assert!(weak < Some(12), "{weak:?}");
}

#[test]
fn the_weighted_mean_follows_the_sphere() {
    let mut module = noiseless();
    for force in [0.2, 0.5, 1.0] {
        let (mut all, mut inside, mut edge) = (Vec::new(), Vec::new(), Vec::new());
        for at in hull() {
            let (_, x, y) = weighted_mean(&norms(&mut module, at, force), 15.0);
            let (dx, dy) = (x - f64::from(at.x), y - f64::from(at.y));
            all.push(dx * dx + dy * dy);
            if at.x.abs().max(at.y.abs()) < 4.71 {
                inside.push(dx * dx + dy * dy);
            }
            if at.x > 7.04 {
                edge.push(dx);
            }
        }
        let rms = |v: &[f64]| (v.iter().sum::<f64>() / v.len() as f64).sqrt();
        let bias = edge.iter().sum::<f64>() / edge.len() as f64;
        println!(
            "{force} N: rmse {:.3}, inside {:.3}, edge bias {bias:.3} mm",
            rms(&all),
            rms(&inside)
        );
        assert!(
            rms(&all) <= 0.3 && rms(&inside) <= 0.25,
            "{} {}",
            rms(&all),
            rms(&inside)
        );
        assert!(
            (-0.7..-0.2).contains(&bias),
            "the edge pulls inwards: {bias}"
        );
    }
}

#[test]
fn noise_and_rest_values_are_those_of_the_generation() {
    for (generation, x, y, z) in [
        (Generation::Y2019, 16_400.0, 16_400.0, 34_000.0),
        (Generation::Y2021, 48_900.0, 16_400.0, 37_400.0),
        (Generation::Now, 32_800.0, 32_800.0, 37_400.0),
    ] {
        let mut module = EmulatedModule::new(ModuleConfig {
            transducer: Transducer::Magnetic(generation),
            seed: 3,
            ..ModuleConfig::default()
        });
        let mut readings = Vec::new();
        let mut sums = [[0.0f64; 2]; 48];
        let n = 2000;
        for i in 0..n {
            module.sample(Nanos::from_micros(i * 10_000), &mut readings);
            for (t, r) in readings.iter().enumerate() {
                for (axis, v) in [r.x, r.y, r.z].into_iter().enumerate() {
                    let d = f64::from(v) - module.rest(t).unwrap()[axis];
                    sums[3 * t + axis][0] += d;
                    sums[3 * t + axis][1] += d * d;
                }
            }
        }
        for [sum, square] in sums {
            let mean = sum / n as f64;
            let std = (square / n as f64 - mean * mean).sqrt();
            assert!((0.95..2.45).contains(&std), "{std}");
            assert!(mean.abs() < 0.3);
        }
        let rest = module.rest(5).unwrap();
        assert!((rest[0] - x).abs() <= 600.0 && (rest[1] - y).abs() <= 600.0);
        assert!((rest[2] - z).abs() <= 2000.0);
    }
}

#[test]
fn the_silicone_lags_exactly_whatever_the_step() {
    // A ramp sampled finely and coarsely ends at the same place.
    let ramp = |now: Nanos, out: &mut Vec<Press>| {
        let force_n = now.as_secs_f64().min(0.1) * 0.0 + 1.0;
        out.push(Press {
            at: Point::default(),
            force_n,
            diameter_mm: SPHERE_MM,
        });
    };
    let run = |step_us: u64| {
        let mut module = noiseless();
        module.respond(Nanos::ZERO);
        module.touch(Box::new(ramp));
        // The input jumps between 0 and 1 ms in every case, and rests then.
        module.respond(Nanos::from_micros(1000));
        let mut us = 1000;
        while us < 21_000 {
            us += step_us;
            module.respond(Nanos::from_micros(us));
        }
        module.response[5][2]
    };
    assert!((run(500) - run(10_000)).abs() < 1e-9);
}

#[test]
fn a_released_skin_comes_back_to_rest_and_bad_touches_do_nothing() {
    let mut module = noiseless();
    module.touch(still(Point::default(), 1.0));
    module.respond(Nanos::ZERO);
    module.touch(still(Point::default(), 0.0));
    for i in 1..200 {
        module.respond(Nanos::from_micros(i * 10_000));
    }
    assert!(module.quiet && module.response.iter().flatten().all(|s| s.to_bits() == 0));
    for force in [f64::NAN, f64::INFINITY, -1.0] {
        norms(&mut module, Point::default(), force)
            .iter()
            .for_each(|n| assert!(*n < 1e-12));
    }
}

#[test]
fn counts_saturate_and_drift_stays_in_its_bounds() {
    let mut module = EmulatedModule::new(ModuleConfig {
        drift_counts: 1000.0,
        ..ModuleConfig::default()
    });
    let mut readings = Vec::new();
    module.touch(still(Point::default(), 1e6));
    module.sample(Nanos::ZERO, &mut readings);
    assert_eq!(readings[5].z, u16::MAX);
    module.touch(still(Point::default(), 0.0));
    module.sample(Nanos::from_micros(1_000_000), &mut readings);
    module.sample(Nanos::from_micros(600_000_000), &mut readings);
    let moved = f64::from(readings[5].z) - module.rest(5).unwrap()[2];
    assert!(moved.abs() < 1010.0);
    let any = |r: &Reading, rest: [f64; 3]| (f64::from(r.z) - rest[2]).abs() > 300.0;
    assert!(
        readings
            .iter()
            .enumerate()
            .any(|(t, r)| any(r, module.rest(t).unwrap()))
    );
}

#[test]
fn eight_bit_skins_stay_within_their_range_and_answer_in_their_own_sense() {
    for (transducer, pitch_mm, sphere_mm, sense) in [
        (Transducer::Capacitive, 6.5, SPHERE_MM, -1.0),
        (Transducer::Camera, 0.3, 4.0, 1.0),
    ] {
        let mut module = EmulatedModule::new(ModuleConfig {
            taxels: grid(7, 7, pitch_mm),
            pitch_mm,
            transducer,
            mechanics: transducer.silicone(),
            noise_lsb: (0.2, 0.5),
            ..ModuleConfig::default()
        });
        let press = |force_n| {
            Box::new(move |_: Nanos, out: &mut Vec<Press>| {
                out.push(Press {
                    at: Point::default(),
                    force_n,
                    diameter_mm: sphere_mm,
                });
            })
        };
        let mut readings = Vec::new();
        module.touch(press(0.5));
        module.sample(Nanos::ZERO, &mut readings);
        let moved = f64::from(readings[24].z) - module.rest(24).unwrap()[2];
        assert!(moved * sense > 15.0, "{transducer:?} {moved}");
        assert_eq!((readings[24].x, readings[24].y), (0, 0), "one axis");
        module.touch(press(1e4));
        module.sample(Nanos::from_micros(1_000_000), &mut readings);
        let end = if sense > 0.0 { 255 } else { 0 };
        assert_eq!(readings[24].z, end, "{transducer:?}");
    }
}
