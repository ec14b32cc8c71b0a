//! Tests of `paths.rs`.

use super::*;

fn line(seconds: f64, from: Place, to: Place) -> Vec<[f64; 3]> {
    (0..=50)
        .map(|n| f64::from(n) / 50.0)
        .map(|p| {
            [
                p * seconds,
                from[0] + p * (to[0] - from[0]),
                from[1] + p * (to[1] - from[1]),
            ]
        })
        .collect()
}

fn drawn(path: &[[f64; 3]], tempo: f64, shift: Place) -> Vec<Vec<Sample>> {
    let sample = |[t, x, y]: &[f64; 3]| Sample {
        t_ms: 1e3 * t * tempo + 700.0,
        x_mm: x + shift[0],
        y_mm: y + shift[1],
    };
    vec![path.iter().map(sample).collect()]
}

#[test]
fn a_drawing_of_the_path_at_another_speed_has_no_error() {
    let path = line(2.0, [-10.0, 0.0], [10.0, 5.0]);
    let found = compare_paths(&path, &drawn(&path, 3.0, [0.0, 0.0])).unwrap();
    assert!(
        found.rmse_mm < 1e-9 && found.frechet_mm < 1e-9 && found.lag == 0.0,
        "{found:?}"
    );
    assert_eq!(found.breaks, 0);
}

#[test]
fn a_drawing_beside_the_path_is_as_far_off_as_it_lies() {
    let path = line(2.0, [-10.0, 0.0], [10.0, 0.0]);
    let found = compare_paths(&path, &drawn(&path, 1.0, [0.0, 3.0])).unwrap();
    assert!((found.rmse_mm - 3.0).abs() < 1e-9, "{found:?}");
    assert!((found.frechet_mm - 3.0).abs() < 1e-9, "{found:?}");
}

#[test]
fn a_drawing_backwards_is_as_far_off_as_the_path_is_long() {
    let path = line(2.0, [-10.0, 0.0], [10.0, 0.0]);
    let mut back = drawn(&path, 1.0, [0.0, 0.0]);
    let places: Vec<f64> = back[0].iter().rev().map(|s| s.x_mm).collect();
    back[0].iter_mut().zip(places).for_each(|(s, x)| s.x_mm = x);
    let found = compare_paths(&path, &back).unwrap();
    assert!((found.frechet_mm - 20.0).abs() < 1e-9, "{found:?}");
    assert!(found.rmse_mm > 8.0, "{found:?}");
}

#[test]
fn a_hand_that_rests_at_the_end_trails() {
    let path = line(2.0, [-10.0, 0.0], [10.0, 0.0]);
    let mut rests = drawn(&path, 1.0, [0.0, 0.0]);
    // It waits at the start for a tenth of the time.
    for sample in rests[0].iter_mut().skip(1) {
        sample.t_ms += 220.0;
    }
    let found = compare_paths(&path, &rests).unwrap();
    assert!(found.lag > 0.0 && found.rmse_mm < 1.0, "{found:?}");
    assert!(found.frechet_mm < 0.5, "{found:?}");
}

/// Every pair of walks through few points, by their definition.
#[test]
fn the_shortest_leash_is_that_of_all_walks() {
    fn walks(a: &[Place], b: &[Place], i: usize, j: usize) -> f64 {
        let here = distance(a[i], b[j]);
        let mut best = f64::INFINITY;
        for (di, dj) in [(0, 1), (1, 0), (1, 1)] {
            if i + di < a.len() && j + dj < b.len() {
                best = best.min(walks(a, b, i + di, j + dj));
            }
        }
        if i + 1 == a.len() && j + 1 == b.len() {
            best = 0.0;
        }
        here.max(best)
    }
    let mut random = palpate_core::random::RandomStream::new(5, "walks");
    for _ in 0..40 {
        let mut path = |n: usize| -> Vec<Place> {
            (0..n).map(|_| [random.normal(), random.normal()]).collect()
        };
        let (a, b) = (path(6), path(5));
        assert!((frechet(&a, &b) - walks(&a, &b, 0, 0)).abs() < 1e-12);
    }
}

#[test]
fn a_dot_is_no_path() {
    let path = line(1.0, [0.0, 0.0], [1.0, 0.0]);
    let dot = vec![vec![Sample {
        t_ms: 0.0,
        x_mm: 0.0,
        y_mm: 0.0,
    }]];
    assert_eq!(compare_paths(&path, &dot), None);
    assert_eq!(compare_paths(&[], &drawn(&path, 1.0, [0.0; 2])), None);
}
