//! Compression against oracles, a hundred thousand random cases each: the closed form, the `ckmeans` crate, all
//! splits in two; and modules on many threads against one.

use palpate_core::contact::kmeans::{KMeans, Points, Stop, weighted_mean};
use palpate_core::contact::{Compressor, LevelTable, Settings};
use palpate_core::random::RandomStream;
use palpate_core::skin::{Axes, Layout, RelativeFrame};
use palpate_files::{LayoutFile, load_layout};
use palpate_run::plan;
use rayon::prelude::*;

const CASES: usize = 100_000;

/// Random coordinates and weights; every fourth cloud on a lattice, with duplicates and ties.
struct Cloud {
    x: Vec<f32>,
    y: Vec<f32>,
    w: Vec<f32>,
}

impl Cloud {
    fn new(r: &mut RandomStream, n: usize, case: usize) -> Self {
        let lattice = case.is_multiple_of(4);
        let far = if case.is_multiple_of(7) {
            37_000.0
        } else {
            0.0
        };
        let mut draw = |offset: f32| {
            let v = (4.0 * r.uniform()) as f32;
            offset + if lattice { v.floor() } else { v }
        };
        Self {
            x: (0..n).map(|_| draw(far)).collect(),
            y: (0..n).map(|_| draw(far)).collect(),
            w: (0..n).map(|_| draw(0.0)).collect(),
        }
    }

    fn points(&self) -> Points<'_> {
        Points {
            x: &self.x,
            y: &self.y,
            w: &self.w,
        }
    }

    fn at(&self, i: usize) -> (f64, f64, f64) {
        (
            f64::from(self.x[i]),
            f64::from(self.y[i]),
            f64::from(self.w[i]),
        )
    }

    /// The weighted squared distance of all points to their nearest centroid.
    fn inertia(&self, kmeans: &KMeans) -> f64 {
        let square = |p: (f64, f64, f64), c: (f32, f32)| {
            let (dx, dy) = (p.0 - f64::from(c.0), p.1 - f64::from(c.1));
            dx * dx + dy * dy
        };
        let nearest = |p| {
            let squares = kmeans.centroids().map(|c| square(p, c));
            squares.fold(f64::INFINITY, f64::min)
        };
        let points = (0..self.x.len()).map(|i| self.at(i));
        points.map(|p| p.2 * nearest(p)).sum()
    }

    /// The weighted squared distance of chosen points to their weighted mean.
    fn cost(&self, mine: impl Fn(usize) -> bool) -> f64 {
        let own = || (0..self.x.len()).filter(|i| mine(*i)).map(|i| self.at(i));
        let w: f64 = own().map(|p| p.2).sum();
        if w <= 0.0 {
            return 0.0;
        }
        let mean = (
            own().map(|p| p.2 * p.0).sum::<f64>() / w,
            own().map(|p| p.2 * p.1).sum::<f64>() / w,
        );
        own()
            .map(|p| p.2 * ((p.0 - mean.0) * (p.0 - mean.0) + (p.1 - mean.1) * (p.1 - mean.1)))
            .sum()
    }

    /// The best two clusters out of all splits, those that a line makes among them: their cost, and a bit a point.
    fn best_pair(&self) -> (f64, u32) {
        let splits = 0..1u32 << (self.x.len() - 1);
        let cost = |split: u32| {
            let mine = |i: usize| split >> i & 1 == 1;
            (self.cost(mine) + self.cost(|i| !mine(i)), split)
        };
        let pairs = splits.map(cost);
        pairs.fold((f64::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a })
    }

    /// The weighted mean of a side of a split; its plain mean where nothing weighs, the first point if it is empty.
    fn mean(&self, split: u32, side: u32) -> (f32, f32) {
        let own: Vec<usize> = (0..self.x.len())
            .filter(|i| split >> i & 1 == side)
            .collect();
        let of = |v: &[f32]| own.iter().map(|&i| v[i]).collect::<Vec<_>>();
        let (x, y, w) = (of(&self.x), of(&self.y), of(&self.w));
        if own.is_empty() {
            return (self.x[0], self.y[0]);
        }
        weighted_mean(Points {
            x: &x,
            y: &y,
            w: &w,
        })
    }
}

#[test]
fn one_cluster_is_the_closed_form() {
    let mut r = RandomStream::new(11, "closed form");
    for case in 0..CASES {
        let n = 1 + case % 20;
        let cloud = Cloud::new(&mut r, n, case);
        let w: f64 = cloud.w.iter().map(|w| f64::from(*w)).sum();
        let all = || (0..n).map(|i| cloud.at(i));
        let want = if w > 0.0 {
            (
                all().map(|p| p.0 * p.2).sum::<f64>() / w,
                all().map(|p| p.1 * p.2).sum::<f64>() / w,
            )
        } else {
            (
                all().map(|p| p.0).sum::<f64>() / n as f64,
                all().map(|p| p.1).sum::<f64>() / n as f64,
            )
        };
        let (x, y) = weighted_mean(cloud.points());
        let near = |a: f32, b: f64| (f64::from(a) - b).abs() <= 1e-7 * b.abs() + 1e-6;
        assert!(
            near(x, want.0) && near(y, want.1),
            "case {case}: {x} {y} {want:?}"
        );
    }
}

/// No result from any seed is below the optimum, and from the optimum's own centroids it is kept.
#[test]
fn two_clusters_against_every_split() {
    let mut r = RandomStream::new(12, "splits");
    let stop = Stop {
        tolerance: 0.0,
        max_iterations: 100,
    };
    for case in 0..CASES {
        let n = 2 + case % 6;
        let cloud = Cloud::new(&mut r, n, case);
        // Points in f32 far from the origin have less room for a centroid.
        let slack = if case.is_multiple_of(7) { 0.05 } else { 1e-4 };
        let mut kmeans = KMeans::new(n, 2);
        let (want, split) = cloud.best_pair();
        kmeans.seed(cloud.points(), 2, &mut r);
        assert!(kmeans.solve(cloud.points(), stop).converged);
        let got = cloud.inertia(&kmeans);
        assert!(
            got >= want - slack,
            "case {case}: {got} below the optimum {want}"
        );
        kmeans.set_centroids([0, 1].map(|side| cloud.mean(split, side)).into_iter());
        kmeans.solve(cloud.points(), stop);
        let kept = cloud.inertia(&kmeans);
        assert!(
            (kept - want).abs() <= slack,
            "case {case}: {kept}, the optimum is {want}"
        );
    }
}

#[test]
fn levels_cost_what_those_of_the_ckmeans_crate_cost() {
    let mut r = RandomStream::new(13, "levels");
    let cost = |values: &[f32], levels: &mut dyn Iterator<Item = f64>| {
        let levels: Vec<f64> = levels.collect();
        let d = |v: f32| {
            levels
                .iter()
                .map(|l| (f64::from(v) - l) * (f64::from(v) - l))
                .fold(f64::INFINITY, f64::min)
        };
        values.iter().map(|v| d(*v)).sum::<f64>()
    };
    for case in 0..CASES {
        let n = 1 + (r.next_u64() % 40) as usize;
        let k = 1 + (r.next_u64() % n.min(12) as u64) as usize;
        let scale = [9.0, 500.0, 60_000.0][case % 3];
        let values: Vec<f32> = (0..n)
            .map(|_| (scale * r.uniform()).floor() as f32)
            .collect();
        let ours = LevelTable::from_intensities(&values, k).unwrap();
        let wide: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
        let theirs = ckmeans::ckmeans(&wide, k as u8).unwrap();
        let means = theirs.iter().filter(|c| !c.is_empty());
        let a = cost(&values, &mut ours.values().iter().map(|v| f64::from(*v)));
        let b = cost(
            &values,
            &mut means.map(|c| c.iter().sum::<f64>() / c.len() as f64),
        );
        assert!(
            a <= b + 1e-6 * b + 1e-3 * n as f64,
            "case {case}: {values:?} in {k}: {a}, ckmeans {b}"
        );
    }
}

fn skin(name: &str) -> Layout {
    match load_layout(name).unwrap().value {
        LayoutFile::Sensor(file) => plan::layout(&file).unwrap(),
        LayoutFile::Display(_) => panic!("{name} is no sensor"),
    }
}

#[test]
fn skins_of_every_size_are_laid_out() {
    for (name, taxels, modules) in [
        ("icub-forearm", 60, 1),
        ("icub-patch", 168, 1),
        ("icub-body", 2040, 204),
        ("h1-body", 1260, 35),
        ("digit", 307_200, 1),
        ("digit-64x48", 3072, 1),
        ("million", 1_000_000, 100),
    ] {
        let layout = skin(name);
        assert_eq!(
            (layout.taxels(), layout.modules().len()),
            (taxels, modules),
            "{name}"
        );
    }
    // Six neighbours of a hexagonal cell are equally far.
    let layout = skin("h1-body");
    let points = layout.modules()[0].points();
    let near = points
        .iter()
        .filter(|p| (p.distance2(points[14]).sqrt() - 26.0).abs() < 1e-3);
    assert_eq!(near.count(), 6);
}

/// Frames with blobs of touch, on one thread and on many: the same contacts in the same order.
#[test]
fn many_threads_find_what_one_finds() {
    for (name, frames) in [("allegro", 40), ("icub-body", 20), ("million", 2)] {
        let layout = skin(name);
        let settings = Settings {
            clusters: 3,
            exponent: 2.0,
            ..Settings::default()
        };
        let mut one = Compressor::new(&layout, settings.clone()).unwrap();
        let (mut threads, mut pool) = (one.clone(), Compressor::new(&layout, settings).unwrap());
        let mut frame = RelativeFrame::new(&layout);
        let mut r = RandomStream::new(14, name);
        for _ in 0..frames {
            let rows: Vec<[f32; 3]> = (0..layout.taxels())
                .map(|_| {
                    [
                        0.0,
                        0.0,
                        if r.next_u64().is_multiple_of(3) {
                            (100.0 * r.uniform()) as f32
                        } else {
                            0.0
                        },
                    ]
                })
                .collect();
            frame.load(&rows, Axes::Z, 20.0).unwrap();
            let want = one.compress(&frame).unwrap().to_vec();
            let got = threads.compress_with(&frame, |scopes, locate| {
                let share = scopes.len().div_ceil(4);
                std::thread::scope(|threads| {
                    for part in scopes.chunks_mut(share).rev() {
                        threads.spawn(|| part.iter_mut().for_each(locate));
                    }
                });
            });
            assert_eq!(got.unwrap(), want, "{name}");
            let got = pool.compress_with(&frame, |scopes, locate| {
                scopes.par_iter_mut().for_each(locate);
            });
            assert_eq!(got.unwrap(), want, "{name}");
        }
        assert!(one.work().solves > 0);
    }
}
