//! Compression against closed forms, exhaustive splits and hostile frames.

use super::*;
use crate::skin::Grid;

fn module(rows: u16, columns: u16) -> Module {
    Module::grid(Grid {
        rows,
        columns,
        pitch: 4.7,
        centre: Point::default(),
    })
    .unwrap()
}

fn compressor(kc: u16, p: f32) -> Compressor {
    let settings = Settings {
        kc,
        weight_exponent: p,
        seed: 1,
        ..Settings::default()
    };
    Compressor::new(&module(4, 4), settings, "module 0").unwrap()
}

fn run(c: &mut Compressor, norms: &[f32]) -> usize {
    c.compress(norms, 10.0, &vec![false; norms.len()], |i| {
        [norms[i], 0.0, 0.0]
    })
}

/// A bump of height 1000 and 3 mm spread.
fn bump(at: &[Point]) -> Vec<f32> {
    let value = |t: &Point| {
        at.iter()
            .map(|p| 1000.0 * libm::expf(-t.distance2(*p) / 18.0))
            .fold(0.0, f32::max)
    };
    module(4, 4).taxels().iter().map(value).collect()
}

#[test]
fn one_contact_is_the_weighted_mean() {
    for p in [0.0, 1.0, 2.0, 3.5] {
        let mut c = compressor(1, p);
        let norms = bump(&[Point::new(1.3, -2.2)]);
        let n = run(&mut c, &norms);
        let (mut sx, mut sy, mut sw) = (0.0f64, 0.0f64, 0.0f64);
        for (t, &s) in module(4, 4)
            .taxels()
            .iter()
            .zip(&norms)
            .filter(|(_, s)| **s > 10.0)
        {
            let w = f64::from(s).powf(f64::from(p));
            sx += w * f64::from(t.x);
            sy += w * f64::from(t.y);
            sw += w;
        }
        let place = c.contacts()[0].place;
        assert!(
            (f64::from(place.x) - sx / sw).abs() < 1e-5
                && (f64::from(place.y) - sy / sw).abs() < 1e-5
        );
        assert_eq!(
            (c.stage(), usize::from(c.contacts()[0].members)),
            (Stage::Mean, n)
        );
    }
}

#[test]
fn few_contacts_pass_through_unchanged() {
    let mut c = compressor(4, 2.0);
    let mut norms = vec![0.0; 16];
    (norms[0], norms[6], norms[15]) = (50.0, 60.0, 70.0);
    run(&mut c, &norms);
    assert_eq!(c.stage(), Stage::PassThrough);
    let places: Vec<Point> = c.contacts().iter().map(|c| c.place).collect();
    let taxels = module(4, 4);
    assert_eq!(places, [0, 6, 15].map(|i| taxels.taxels()[i]));
    assert_eq!(c.contacts()[1].intensity, 60.0);
    // The same taxels keep their names when another one joins before them.
    let ids: Vec<u32> = c.contacts().iter().map(|c| c.id).collect();
    norms[3] = 55.0;
    run(&mut c, &norms);
    let now: Vec<u32> = c.contacts().iter().map(|c| c.id).collect();
    assert_eq!(now, [ids[0], 3, ids[1], ids[2]]);
}

#[test]
fn two_moving_contacts_keep_their_names() {
    let mut c = compressor(2, 2.0);
    let mut names = None;
    for step in 0..60 {
        let t = step as f32 * 0.1;
        run(
            &mut c,
            &bump(&[Point::new(-6.0 + t, -5.0), Point::new(6.0 - t, 5.0)]),
        );
        let mut here: Vec<(u32, f32)> = c.contacts().iter().map(|c| (c.id, c.place.y)).collect();
        here.sort_by_key(|h| h.0);
        assert!(
            (here[0].1 > 0.0) != (here[1].1 > 0.0),
            "step {step}: {here:?}"
        );
        let top = here.iter().find(|h| h.1 > 0.0).unwrap().0;
        assert_eq!(*names.get_or_insert(top), top, "step {step}");
        if step > 0 {
            assert!(matches!(c.stage(), Stage::Warm(_)));
        }
    }
}

#[test]
fn a_rest_state_of_k_means_no_single_move_improves() {
    let mut stream = Stream::new(5, "cases");
    for _ in 0..300 {
        let mut c = compressor(3, 1.0);
        let norms: Vec<f32> = (0..16)
            .map(|_| (stream.uniform() * 1000.0) as f32)
            .collect();
        run(&mut c, &norms);
        let Stage::Cold(iterations) = c.stage() else {
            continue;
        };
        assert!(iterations < 20);
        let n = norms.iter().filter(|&&s| s > 10.0).count();
        for i in 0..n {
            let d = |k: usize| {
                Point::new(c.x[i], c.y[i]).distance2(Point::new(c.work.cx[k], c.work.cy[k]))
            };
            let mine = c.work.assignment[i] as usize;
            assert!((0..3).all(|k| d(mine) <= d(k) + 1e-3));
        }
    }
}

#[test]
fn two_clusters_come_near_the_best_split_in_most_cases() {
    // Every linear split of the plane, by brute force over all subsets of at most 10 points.
    let mut stream = Stream::new(6, "splits");
    let (mut worst, mut within) = (0.0f64, 0);
    const CASES: usize = 200;
    for _ in 0..CASES {
        let mut norms = vec![0.0f32; 16];
        for _ in 0..9 {
            norms[(stream.next_u64() % 16) as usize] = 20.0 + (stream.uniform() * 500.0) as f32;
        }
        let mut c = compressor(2, 1.0);
        let n = run(&mut c, &norms);
        if n <= 2 {
            within += 1;
            continue;
        }
        let points = Points {
            x: &c.x[..n],
            y: &c.y[..n],
            w: &c.w[..n],
        };
        let side = |mask: usize, which: usize| {
            let (mut s, mut q) = ([0.0f64; 3], 0.0f64);
            for i in (0..n).filter(|i| mask >> i & 1 == which) {
                let (x, y, w) = (
                    f64::from(points.x[i]),
                    f64::from(points.y[i]),
                    f64::from(points.w[i]),
                );
                (s[0], s[1], s[2]) = (s[0] + w * x, s[1] + w * y, s[2] + w);
                q += w * (x * x + y * y);
            }
            if s[2] > 0.0 {
                q - (s[0] * s[0] + s[1] * s[1]) / s[2]
            } else {
                0.0
            }
        };
        let best = (1..(1usize << n) - 1)
            .map(|m| side(m, 0) + side(m, 1))
            .fold(f64::MAX, f64::min);
        let ratio = c.work.inertia(points) / best;
        worst = worst.max(ratio);
        within += usize::from(ratio < 1.1);
    }
    assert!(worst < 2.5, "worst ratio to the optimum {worst}");
    assert!(within * 10 >= CASES * 7, "{within} of {CASES} within 10 %");
}

#[test]
fn hostile_frames_neither_panic_nor_yield_nan() {
    let specials = [
        0.0,
        -0.0,
        -1.0,
        1e-40,
        10.0,
        113_510.0,
        f32::MAX,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];
    let mut stream = Stream::new(9, "hostile");
    for kc in [1, 2, 4, 16, 300] {
        for p in [0.0, 1.0, 2.0, 16.0] {
            let mut c = compressor(kc, p);
            for _ in 0..500 {
                let norms: Vec<f32> = (0..16)
                    .map(|_| specials[(stream.next_u64() % 10) as usize])
                    .collect();
                let threshold = specials[(stream.next_u64() % 10) as usize];
                let faulty: Vec<bool> = (0..16).map(|_| stream.uniform() < 0.2).collect();
                c.compress(&norms, threshold, &faulty, |i| [norms[i]; 3]);
                for contact in c.contacts() {
                    let place = contact.place;
                    assert!(
                        place.x.abs() <= 7.06 && place.y.abs() <= 7.06,
                        "{contact:?} {norms:?}"
                    );
                    assert!(contact.level >= 1);
                }
            }
        }
    }
}

#[test]
fn short_inputs_and_a_single_taxel() {
    let mut c = compressor(2, 2.0);
    assert_eq!(c.compress(&[50.0], 10.0, &[false], |_| [50.0, 0.0, 0.0]), 1);
    assert_eq!(c.compress(&[], 10.0, &[], |_| [0.0; 3]), 0);
    assert!(c.contacts().is_empty());
}

#[test]
fn settings_that_mean_nothing_are_refused() {
    let make = |settings| Compressor::new(&module(4, 4), settings, "m").err();
    let good = Settings::default;
    assert_eq!(
        make(Settings { kc: 0, ..good() }),
        Some(CompressError::NoContacts)
    );
    assert_eq!(
        make(Settings {
            weight_exponent: -1.0,
            ..good()
        }),
        Some(CompressError::Exponent(-1.0))
    );
    assert_eq!(
        make(Settings {
            zeta_mm: f32::NAN,
            ..good()
        }),
        Some(CompressError::Stop)
    );
    assert_eq!(
        make(Settings {
            max_iterations: 0,
            ..good()
        }),
        Some(CompressError::Stop)
    );
    assert_eq!(
        make(Settings {
            levels: vec![2.0, 1.0],
            ..good()
        }),
        Some(CompressError::Levels)
    );
}
