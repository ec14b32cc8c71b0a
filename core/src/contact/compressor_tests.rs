//! Compression against closed forms and under hostile frames.

use super::super::levels::LevelTable;
use super::super::settings::Norm;
use super::*;
use crate::random::RandomStream;
use crate::skin::{Axes, Module};

fn pad() -> Layout {
    Layout::single(Module::grid("pad", 4, 4, 4.7).unwrap()).unwrap()
}

/// A frame of the normal axis, zero but for the given taxels.
fn frame(layout: &Layout, touched: &[(usize, f32)]) -> RelativeFrame {
    let mut f = RelativeFrame::new(layout);
    let mut d = alloc::vec![[0.0; 3]; layout.taxels()];
    for (i, v) in touched {
        d[*i][2] = *v;
    }
    f.load(&d, Axes::Z, 10.0).unwrap();
    f
}

fn compressor(layout: &Layout, clusters: u16) -> Compressor {
    let settings = Settings {
        clusters,
        ..Settings::default()
    };
    Compressor::new(layout, settings).unwrap()
}

fn ids(c: &[Contact]) -> Vec<u32> {
    c.iter().map(|c| c.id).collect()
}

#[test]
fn pass_through_keeps_places_values_and_identities() {
    let l = pad();
    let mut c = compressor(&l, 4);
    let out = c.compress(&frame(&l, &[(5, 100.0), (9, 50.0)])).unwrap();
    assert_eq!(out[0].place, l.modules()[0].points()[5]);
    assert!((out[0].intensity - 100.0).abs() < 1e-4 && out[0].members == 1);
    assert_eq!(ids(out), [1, 2]);
    // 5 moves on to 10, beyond 9, which stays: order changes, identity does not
    assert_eq!(
        ids(c.compress(&frame(&l, &[(9, 50.0), (10, 90.0)])).unwrap()),
        [2, 1]
    );
    assert_eq!(
        ids(c
            .compress(&frame(&l, &[(0, 40.0), (9, 50.0), (10, 90.0)]))
            .unwrap()),
        [3, 2, 1]
    );
    assert!(c.compress(&frame(&l, &[])).unwrap().is_empty());
    assert_eq!(ids(c.compress(&frame(&l, &[(9, 50.0)])).unwrap()), [4]);
}

#[test]
fn one_contact_is_the_weighted_mean_with_the_bilinear_intensity() {
    let l = pad();
    let mut c = compressor(&l, 1);
    let f = frame(&l, &[(5, 300.0), (6, 100.0)]);
    let out = c.compress(&f).unwrap();
    assert!((out[0].place.x - -1.175).abs() < 1e-5);
    assert!((out[0].place.y - 2.35).abs() < 1e-5);
    assert!((out[0].intensity - 250.0).abs() < 1e-3);
    assert_eq!((out[0].members, out[0].level, out[0].id), (2, 1, 1));
    assert_eq!(ids(c.compress(&frame(&l, &[(15, 30.0)])).unwrap()), [1]);
}

#[test]
fn two_fingers_keep_their_identities_as_they_move() {
    let l = Layout::single(Module::grid("wide", 4, 16, 4.7).unwrap()).unwrap();
    let mut c = compressor(&l, 2);
    let finger = |col: usize, v: f32| {
        let at = move |r: usize, c: usize| (r * 16 + c, v);
        [at(1, col), at(1, col + 1), at(2, col), at(2, col + 1)]
    };
    let mut seen = Vec::new();
    for step in 0..6 {
        let touched = [finger(step, 200.0), finger(14 - step, 100.0)].concat();
        let out = c.compress(&frame(&l, &touched)).unwrap().to_vec();
        assert_eq!(out.len(), 2);
        assert!(out.iter().all(|c| c.members == 4));
        let left = if out[0].place.x < out[1].place.x {
            0
        } else {
            1
        };
        assert!((out[left].intensity - 200.0).abs() < 1e-2);
        seen.push((out[left].id, out[1 - left].id));
    }
    assert!(seen.iter().all(|s| *s == seen[0]), "{seen:?}");
    assert_eq!((c.work().seeded, c.work().solves), (1, 6));
}

#[test]
fn levels_static_and_dynamic() {
    let l = pad();
    let touched = [(0, 100.0), (3, 110.0), (12, 500.0)];
    let level = |levels| {
        let settings = Settings {
            clusters: 4,
            levels,
            ..Settings::default()
        };
        let mut c = Compressor::new(&l, settings).unwrap();
        let out = c.compress(&frame(&l, &touched)).unwrap();
        out.iter().map(|c| c.level).collect::<Vec<_>>()
    };
    assert_eq!(level(Levels::Off), [1, 1, 1]);
    assert_eq!(level(Levels::Dynamic(2)), [1, 1, 2]);
    assert_eq!(level(Levels::Dynamic(10)), [1, 2, 3]);
    let table = LevelTable::new(&[100.0, 200.0, 300.0]).unwrap();
    assert_eq!(level(Levels::Table(table)), [1, 1, 3]);
}

/// (4.9) along each axis, and levels by direction where magnitudes are equal.
#[test]
fn intensities_that_are_vectors_keep_their_direction() {
    let l = pad();
    let mut f = RelativeFrame::new(&l);
    let mut d = alloc::vec![[0.0; 3]; 16];
    (d[5], d[6], d[0]) = ([300.0, 0.0, 0.0], [100.0, 40.0, 0.0], [0.0, 0.0, 250.0]);
    f.load(&d, Axes::XYZ, 10.0).unwrap();
    let found = |clusters, levels| {
        let settings = Settings {
            clusters,
            levels,
            vectors: true,
            ..Settings::default()
        };
        let mut c = Compressor::new(&l, settings).unwrap();
        c.compress(&f).unwrap().to_vec()
    };
    let passed = found(3, Levels::Dynamic(2));
    assert_eq!(
        passed.iter().map(|c| c.vector).collect::<Vec<_>>(),
        [d[0], d[5], d[6]]
    );
    assert!(passed[0].level != passed[1].level && passed[1].level == passed[2].level);
    d[0] = [0.0; 3];
    f.load(&d, Axes::XYZ, 10.0).unwrap();
    let mut c = Compressor::new(
        &l,
        Settings {
            vectors: true,
            ..Settings::default()
        },
    )
    .unwrap();
    let one = c.compress(&f).unwrap()[0];
    // |s|^1 weighs 300 : 107.7, so the place lies 0.2642 of the way from taxel 5 to 6.
    let part = 107.703_3 / 407.703_3;
    let expected = [300.0 - 200.0 * part, 40.0 * part, 0.0];
    for (axis, (v, e)) in one.vector.iter().zip(expected).enumerate() {
        assert!((v - e).abs() < 1e-2, "axis {axis}: {v}, {e}");
    }
    let norm = expected.iter().map(|v| v * v).sum::<f32>().sqrt();
    assert!((one.intensity - norm).abs() < 1e-2);
    let table = super::super::vectors::VectorTable::from_intensities(&[d[5], d[6]], 2).unwrap();
    let settings = Settings {
        levels: Levels::Vectors(table),
        ..Settings::default()
    };
    assert_eq!(settings.check(), Err(SettingsError::NoVectors));
}

#[test]
fn clusters_of_the_whole_skin_span_modules() {
    let at = |name, x| {
        let m = Module::grid(name, 4, 4, 4.7).unwrap();
        m.with_origin(Point::new(x, 0.0)).unwrap()
    };
    let l = Layout::new(alloc::vec![at("left", -10.0), at("right", 10.0)]).unwrap();
    let settings = Settings {
        scope: Scope::Skin,
        ..Settings::default()
    };
    let f = frame(&l, &[(7, 100.0), (16 + 4, 300.0)]);
    let mut c = Compressor::new(&l, settings).unwrap();
    let out = c.compress(&f).unwrap();
    // (-10 + 7.05) and (10 - 7.05), weighed 1 : 3
    assert!((out[0].place.x - 1.475).abs() < 1e-5);
    assert_eq!((out.len(), out[0].module, out[0].members), (1, 1, 2));
    assert!((out[0].intensity - 300.0).abs() < 1e-3); // beyond the edge counts as on it
    let mut c = compressor(&l, 1);
    let out = c.compress(&f).unwrap();
    assert_eq!([out[0].module, out[1].module], [0, 1]);
    assert!(c.compress(&frame(&pad(), &[])).is_err());
}

#[test]
fn settings_out_of_range_are_refused() {
    let bad = |f: fn(&mut Settings)| {
        let mut s = Settings::default();
        f(&mut s);
        Compressor::new(&pad(), s).unwrap_err()
    };
    assert_eq!(bad(|s| s.clusters = 0), SettingsError::BadClusters);
    assert_eq!(bad(|s| s.exponent = f32::NAN), SettingsError::BadExponent);
    assert_eq!(bad(|s| s.exponent = -1.0), SettingsError::BadExponent);
    assert_eq!(bad(|s| s.tolerance = f32::NAN), SettingsError::BadTolerance);
    assert_eq!(bad(|s| s.max_iterations = 0), SettingsError::NoIterations);
    assert_eq!(
        bad(|s| s.levels = Levels::Dynamic(0)),
        SettingsError::NoLevels
    );
}

/// Random frames with extreme values: finite contacts inside the pad, unique identities, every taxel in one cluster.
#[test]
fn whatever_comes_contacts_are_sound_and_reproducible() {
    let l = pad();
    let mut r = RandomStream::new(5, "frames");
    for case in 0..200u16 {
        let settings = Settings {
            clusters: 1 + case % 6,
            exponent: [0.0, 1.0, 2.0, 0.5, 16.0][usize::from(case % 5)],
            norm: [Norm::L1, Norm::L2, Norm::LInf][usize::from(case % 3)],
            levels: Levels::Dynamic(3),
            vectors: case % 2 == 0,
            seed: u64::from(case),
            ..Settings::default()
        };
        let mut a = Compressor::new(&l, settings.clone()).unwrap();
        let mut b = Compressor::new(&l, settings).unwrap();
        let mut f = RelativeFrame::new(&l);
        for _ in 0..40 {
            let share = r.uniform();
            let d: Vec<[f32; 3]> = (0..16)
                .map(|_| {
                    let on = r.uniform() < share;
                    let top = [1e-30, 1.0, 65_535.0, 1e9][(r.next_u64() % 4) as usize];
                    core::array::from_fn(|_| if on { (r.uniform() * top) as f32 } else { 0.0 })
                })
                .collect();
            f.load(&d, Axes::XYZ, 0.0).unwrap();
            let out = a.compress(&f).unwrap();
            assert_eq!(out, b.compress(&f).unwrap());
            assert_eq!(out.len(), f.contacts().len().min(usize::from(1 + case % 6)));
            for (i, c) in out.iter().enumerate() {
                assert!(c.place.x.abs() <= 7.0501 && c.place.y.abs() <= 7.0501);
                assert!(c.intensity.is_finite() && c.intensity >= 0.0);
                assert!((1..=3).contains(&c.level) && c.members > 0 && c.id > 0);
                assert!(out[..i].iter().all(|o| o.id != c.id));
            }
            let members: usize = out.iter().map(|c| c.members as usize).sum();
            assert_eq!(members, f.contacts().len());
        }
    }
}

/// Two modules, whose frames repeat, keep their set of taxels, or change altogether: what is left out is not missed.
#[test]
fn every_shortcut_gives_the_bits_of_the_long_way() {
    let module = |name, x| {
        let m = Module::grid(name, 4, 5, 4.7).unwrap();
        m.with_origin(Point::new(x, 0.0)).unwrap()
    };
    let l = Layout::new(alloc::vec![module("left", -15.0), module("right", 15.0)]).unwrap();
    let mut r = RandomStream::new(6, "shortcuts");
    let (mut work, mut rested) = (Work::default(), 0);
    for case in 0..10_000u32 {
        let settings = Settings {
            clusters: 1 + (case % 7) as u16,
            scope: [Scope::Module, Scope::Skin][(case / 7 % 2) as usize],
            norm: [Norm::L2, Norm::L1, Norm::LInf][(case / 14 % 3) as usize],
            exponent: [1.0, 2.0, 0.5, 0.0][(case / 42 % 4) as usize],
            tolerance: [1e-3, 0.0, 0.5][(case / 5 % 3) as usize],
            levels: Levels::Dynamic(3),
            vectors: case % 3 == 0,
            seed: u64::from(case),
            ..Settings::default()
        };
        let mut quick = Compressor::new(&l, settings.clone()).unwrap();
        let mut long = Compressor::new(&l, settings).unwrap();
        let mut f = RelativeFrame::new(&l);
        let mut d = alloc::vec![[0.0f32; 3]; 40];
        for _ in 0..10 {
            let change = r.next_u64() % 9 / 2;
            rested += u32::from(change == 4 && f.contacts().is_empty());
            for value in d.iter_mut() {
                let stays = value[2] > 0.0;
                match change {
                    0 => {} // the frame repeats
                    1 if stays => value[2] *= 1.0 + 0.01 * r.uniform() as f32,
                    2 if stays => {
                        *value = core::array::from_fn(|_| 1.0 + 99.0 * r.uniform() as f32)
                    }
                    3 => {
                        let on = r.uniform() < 0.6;
                        *value =
                            core::array::from_fn(|_| if on { r.uniform() as f32 } else { 0.0 });
                    }
                    4 => *value = [0.0; 3], // untouched
                    _ => {}
                }
            }
            f.load(&d, Axes::XYZ, 0.0).unwrap();
            if !(change == 0 && quick.repeat()) {
                quick.compress(&f).unwrap();
            }
            long.groups.iter_mut().for_each(Group::distrust);
            long.resting = false;
            let want = long.compress_with(&f, |groups, locate| {
                groups.iter_mut().rev().for_each(locate)
            });
            assert_eq!(quick.contacts(), want.unwrap(), "case {case}");
        }
        work.add(&quick.work());
        assert_eq!(quick.work().frames + quick.work().repeats, 10);
        assert_eq!(long.work().iterations, long.work().passes);
    }
    // Every shortcut was taken, or this would prove nothing.
    assert!(work.repeats > 1000 && work.repeated > 100, "{work:?}");
    assert!(rested > 500, "{rested}");
    assert!(
        work.passes < work.iterations && work.untouched > 100,
        "{work:?}"
    );
}

#[test]
fn the_number_of_contacts_follows_what_is_allowed() {
    let l = Layout::single(Module::grid("wide", 4, 16, 4.7).unwrap()).unwrap();
    let grown = |growth| {
        let settings = Settings {
            growth,
            ..Settings::default()
        };
        Compressor::new(&l, settings).unwrap()
    };
    let finger = |col: usize| [17 + col, 18 + col, 33 + col, 34 + col].map(|at| (at, 100.0));
    let two = frame(&l, &[finger(0), finger(9)].concat());
    let (mut c, mut fixed) = (grown(4), grown(0));
    let one = fixed.compress(&two).unwrap().to_vec();
    assert_eq!(c.compress(&two).unwrap(), one);
    // The same frame is no fixed point of another number.
    c.allow(2);
    assert!(!c.repeat());
    let out = c.compress(&two).unwrap().to_vec();
    assert!(
        out.len() == 2 && out.iter().all(|c| c.members == 4),
        "{out:?}"
    );
    assert!((out[0].place.x - out[1].place.x).abs() > 40.0);
    // No fewer than it began with, no more than there is room for.
    for (asked, found) in [(9, 4), (2, 2), (0, 1)] {
        c.allow(asked);
        assert_eq!(c.compress(&two).unwrap().len(), found, "{asked}");
    }
    assert_eq!(c.contacts()[0].place, one[0].place);
    fixed.allow(4);
    assert_eq!(fixed.compress(&two).unwrap(), one);
    let beyond = Settings {
        growth: MOST + 1,
        ..Settings::default()
    };
    assert_eq!(beyond.check(), Err(SettingsError::BadClusters));
}

/// The most clusters of a scope.
const MOST: u16 = 4096;
