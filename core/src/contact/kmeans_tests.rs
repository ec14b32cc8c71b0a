//! K-means against exhaustive splits and on degenerate clouds.

use super::*;
use alloc::vec::Vec;

const STOP: Stop = Stop {
    tolerance: 1e-6,
    max_iterations: 100,
};

#[derive(Clone)]
struct Cloud {
    x: Vec<f32>,
    y: Vec<f32>,
    w: Vec<f32>,
}

impl Cloud {
    fn random(r: &mut RandomStream, n: usize, lattice: bool) -> Self {
        let mut draw = |scale: f64| {
            let v = (r.uniform() * scale) as f32;
            if lattice { libm::floorf(v) } else { v }
        };
        Self {
            x: (0..n).map(|_| draw(4.0)).collect(),
            y: (0..n).map(|_| draw(4.0)).collect(),
            w: (0..n).map(|_| draw(3.0)).collect(),
        }
    }
    fn points(&self) -> Points<'_> {
        Points {
            x: &self.x,
            y: &self.y,
            w: &self.w,
        }
    }
}

/// sum(w d²) of the points to their nearest centroid.
fn inertia(kmeans: &KMeans, cloud: &Cloud) -> f64 {
    let points = cloud.x.iter().zip(&cloud.y).zip(&cloud.w);
    let cost = points.map(|((&x, &y), &w)| {
        let d = kmeans.centroids().map(|(cx, cy)| {
            let (dx, dy) = (f64::from(x) - f64::from(cx), f64::from(y) - f64::from(cy));
            dx * dx + dy * dy
        });
        f64::from(w) * d.fold(f64::INFINITY, f64::min)
    });
    cost.sum()
}

/// The best two clusters: an optimal pair is split by a line, and every such split is by a line through two points,
/// so all bit masks of few points hold them all.
fn best_pair(c: &Cloud) -> f64 {
    let n = c.x.len();
    let cost = |mask: u32, side: u32| {
        let own = || (0..n).filter(move |i| mask >> i & 1 == side);
        let w: f64 = own().map(|i| f64::from(c.w[i])).sum();
        if w <= 0.0 {
            return 0.0;
        }
        let mean = |v: &[f32]| {
            own()
                .map(|i| f64::from(c.w[i]) * f64::from(v[i]))
                .sum::<f64>()
                / w
        };
        let (mx, my) = (mean(&c.x), mean(&c.y));
        own()
            .map(|i| {
                let (dx, dy) = (f64::from(c.x[i]) - mx, f64::from(c.y[i]) - my);
                f64::from(c.w[i]) * (dx * dx + dy * dy)
            })
            .sum::<f64>()
    };
    (0..1u32 << n)
        .map(|m| cost(m, 0) + cost(m, 1))
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn best_of_several_seeds_is_the_exhaustive_optimum() {
    let mut r = RandomStream::new(1, "pairs");
    for _ in 0..60 {
        let cloud = Cloud::random(&mut r, 9, false);
        let mut k = KMeans::new(9, 2);
        let mut best = f64::INFINITY;
        for _ in 0..30 {
            k.seed(cloud.points(), 2, &mut r);
            assert!(k.solve(cloud.points(), STOP).converged);
            best = best.min(inertia(&k, &cloud));
        }
        let want = best_pair(&cloud);
        assert!(
            best >= want - 1e-5 && best <= want + 1e-4 * want + 1e-5,
            "{best} {want}"
        );
    }
}

#[test]
fn a_solution_is_a_fixed_point_and_warm_start_confirms_it() {
    let mut r = RandomStream::new(2, "fixed");
    for case in 0..500 {
        let n = 2 + case % 30;
        let cloud = Cloud::random(&mut r, n, false);
        let p = cloud.points();
        let mut k = KMeans::new(n, 5);
        k.seed(p, 5.min(n), &mut r);
        k.solve(p, STOP);
        let solved: Vec<_> = k.centroids().collect();
        for (i, a) in k.assigned()[..n].iter().enumerate() {
            let d = |c: &(f32, f32)| square(p.x[i], p.y[i], c.0, c.1);
            let least = solved.iter().map(d).fold(f32::INFINITY, f32::min);
            assert!(d(&solved[*a as usize]) <= least + 1e-4);
        }
        let before = inertia(&k, &cloud);
        let warm = k.solve(p, STOP);
        assert!(warm.converged && warm.iterations <= 2);
        assert!((inertia(&k, &cloud) - before).abs() <= 1e-5 * (1.0 + before));
    }
}

/// Lattice points: duplicates, zero weights, more clusters than places, ties everywhere.
#[test]
fn hostile_points_end_and_stay_finite() {
    let mut r = RandomStream::new(3, "hostile");
    for case in 0..100_000 {
        let n = 1 + case % 12;
        let mut cloud = Cloud::random(&mut r, n, true);
        match case % 5 {
            0 => cloud.w.fill(0.0),
            1 => {
                cloud.x.fill(37_000.0);
                cloud.y.fill(37_000.0);
            }
            2 => cloud.w[0] = 1e30,
            _ => {}
        }
        let clusters = 1 + case % 7;
        let mut k = KMeans::new(n, clusters);
        if case % 3 == 0 {
            k.set_centroids((0..clusters).map(|_| (1e6, -1e6))); // all far off and equal: all but one empty
        } else {
            k.seed(cloud.points(), clusters, &mut r);
        }
        let out = k.solve(cloud.points(), STOP);
        assert!(out.iterations <= 100);
        assert!(k.centroids().all(|(x, y)| x.is_finite() && y.is_finite()));
        let members: u32 = (0..clusters).map(|c| k.members(c)).sum();
        assert_eq!(members as usize, n);
    }
}

#[test]
fn empty_clusters_are_filled_when_there_are_places_enough() {
    let x: Vec<f32> = (0..8).map(|i| i as f32).collect();
    let cloud = Cloud {
        y: alloc::vec![0.0; 8],
        w: alloc::vec![1.0; 8],
        x,
    };
    let mut k = KMeans::new(8, 4);
    k.set_centroids([(0.0, 0.0); 4].into_iter());
    assert!(k.solve(cloud.points(), STOP).converged);
    assert!((0..4).all(|c| k.members(c) > 0));
}

/// Raw counts around 37,000 as coordinates: expanded squares would have no digit left.
#[test]
fn far_from_the_origin_assignments_are_exact() {
    let at = |v: f32| 37_000.0 + v;
    let x = [at(0.0), at(0.25), at(1.0), at(1.25)];
    let points = Points {
        x: &x,
        y: &[at(0.0); 4],
        w: &[1.0; 4],
    };
    let mut k = KMeans::new(4, 2);
    k.set_centroids([(x[0], at(0.0)), (x[3], at(0.0))].into_iter());
    k.solve(points, STOP);
    assert_eq!(k.assigned(), [0, 0, 1, 1]);
    assert_eq!(
        k.centroids().collect::<Vec<_>>(),
        [(at(0.125), at(0.0)), (at(1.125), at(0.0))]
    );
}

#[test]
fn ties_go_to_the_lowest_cluster() {
    let points = Points {
        x: &[-1.0, 0.0, 1.0],
        y: &[0.0; 3],
        w: &[1.0; 3],
    };
    let mut k = KMeans::new(3, 2);
    k.set_centroids([(-1.0, 0.0), (1.0, 0.0)].into_iter());
    k.solve(
        points,
        Stop {
            max_iterations: 1,
            ..STOP
        },
    );
    assert_eq!(k.assigned(), [0, 0, 1]);
}

#[test]
fn one_cluster_is_the_weighted_mean() {
    let mut r = RandomStream::new(4, "mean");
    for _ in 0..200 {
        let cloud = Cloud::random(&mut r, 10, false);
        let mut k = KMeans::new(10, 1);
        k.seed(cloud.points(), 1, &mut r);
        k.solve(cloud.points(), STOP);
        assert_eq!(k.centroids().next(), Some(weighted_mean(cloud.points())));
    }
}

/// Wide vectors and plain ones, with what is known of the last solve and without: the same bits.
#[test]
fn widths_and_knowledge_change_no_bit() {
    let mut r = RandomStream::new(7, "widths");
    let (mut passes, mut iterations) = (0, 0);
    for case in 0..100_000 {
        let n = 1 + case % 70;
        let k = 1 + case % 9;
        let mut cloud = Cloud::random(&mut r, n, case % 4 == 0);
        let mut wide = KMeans::new(n, k);
        wide.seed(cloud.points(), k, &mut r);
        let mut plain = wide.clone().with_vectors(Vectors::plain());
        for frame in 0..3 {
            let stop = Stop {
                tolerance: [0.0, 1e-3][case % 2],
                max_iterations: [100, 2][usize::from(case % 11 == 0)],
            };
            let got = wide.resume(cloud.points(), stop);
            let want = plain.solve(cloud.points(), stop);
            assert_eq!(
                (got.iterations, got.converged, got.settled),
                (want.iterations, want.converged, want.settled)
            );
            assert!(
                wide.centroids().eq(plain.centroids()),
                "case {case}, frame {frame}"
            );
            assert_eq!(wide.assigned(), plain.assigned());
            assert!((0..k).all(|c| wide.members(c) == plain.members(c)));
            if want.settled {
                let before: Vec<_> = plain.centroids().collect();
                plain.solve(cloud.points(), stop);
                assert!(plain.centroids().eq(before), "settled is a fixed point");
            }
            (passes, iterations) = (passes + got.passes, iterations + got.iterations);
            let change = [1.0, 0.01, 0.0][frame];
            cloud
                .w
                .iter_mut()
                .for_each(|w| *w *= 1.0 + (change * r.uniform()) as f32);
        }
    }
    assert!(
        passes < iterations,
        "{passes} of {iterations}: nothing was left out"
    );
}
