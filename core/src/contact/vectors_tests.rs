//! Levels of vectors against every way to share them out, and under hostile values.

use super::*;

fn mean(cluster: &[[f32; 3]]) -> [f64; 3] {
    core::array::from_fn(|axis| {
        cluster.iter().map(|v| f64::from(v[axis])).sum::<f64>() / cluster.len() as f64
    })
}

fn cost_to(vectors: &[[f32; 3]], levels: &[[f64; 3]]) -> f64 {
    let off =
        |v: &[f32; 3], level: &[f64; 3]| (0..3).map(|a| (f64::from(v[a]) - level[a]).powi(2)).sum();
    let least = |v| {
        levels
            .iter()
            .map(|l| off(v, l))
            .fold(f64::INFINITY, f64::min)
    };
    vectors.iter().map(least).sum()
}

/// The least cost of `k` clusters, over every way to share the vectors out.
fn least_cost(vectors: &[[f32; 3]], k: usize) -> f64 {
    let ways = k.pow(vectors.len() as u32);
    let cost = |way: usize| {
        let own = |i: usize| way / k.pow(i as u32) % k;
        let levels = (0..k).filter_map(|cluster| {
            let of_cluster = vectors
                .iter()
                .enumerate()
                .filter(|(i, _)| own(*i) == cluster);
            let members: Vec<[f32; 3]> = of_cluster.map(|(_, v)| *v).collect();
            (!members.is_empty()).then(|| mean(&members))
        });
        cost_to(vectors, &levels.collect::<Vec<_>>())
    };
    (0..ways).map(cost).fold(f64::INFINITY, f64::min)
}

/// K-means ends in a fixed point, which mostly is the best of all ways to share out, and never far from that.
#[test]
fn levels_are_means_of_what_is_nearest_and_mostly_the_best() {
    let mut stream = RandomStream::new(7, "vectors");
    let (mut short, mut worst) = (0, 1.0f64);
    for case in 0..1000 {
        let (n, k) = (1 + case % 7, 1 + case % 3);
        let mut draw = || (stream.uniform() * 400.0).round() as f32;
        let vectors: Vec<[f32; 3]> = (0..n).map(|_| core::array::from_fn(|_| draw())).collect();
        let table = VectorTable::from_intensities(&vectors, k).unwrap();
        let levels: Vec<[f64; 3]> = table.values().iter().map(|v| v.map(f64::from)).collect();
        for (number, level) in (1..).zip(&levels) {
            let nearest = vectors.iter().filter(|v| table.level(**v) == number);
            let mean = mean(&nearest.copied().collect::<Vec<_>>());
            assert!(
                (0..3).all(|a| (mean[a] - level[a]).abs() < 1e-3),
                "case {case}: {mean:?} {level:?}"
            );
        }
        let strength = |v: &[f32; 3]| v.iter().map(|a| a * a).sum::<f32>();
        assert!(table.values().is_sorted_by_key(strength), "case {case}");
        let (ours, best) = (cost_to(&vectors, &levels), least_cost(&vectors, k));
        short += u32::from(ours > best * (1.0 + 1e-5) + 1e-3);
        worst = worst.max((ours + 1.0) / (best + 1.0));
    }
    assert!(
        short <= 10 && worst < 1.1,
        "{short} of 1000, {worst} times at worst"
    );
}

/// Vectors of one strength that point elsewhere are other levels, which magnitudes cannot tell apart.
#[test]
fn directions_are_told_apart() {
    let vectors = [
        [300.0, 0.0, 0.0],
        [0.0, 0.0, 300.0],
        [290.0, 10.0, 0.0],
        [0.0, 10.0, 290.0],
    ];
    let table = VectorTable::from_intensities(&vectors, 2).unwrap();
    let level = vectors.map(|v| table.level(v));
    assert_eq!([level[0], level[1]], [level[2], level[3]]);
    assert_ne!(level[0], level[1]);
}

#[test]
fn few_values_equal_values_and_no_numbers() {
    let same = [[5.0, 1.0, 2.0]; 9];
    assert_eq!(
        VectorTable::from_intensities(&same, 4).unwrap().values(),
        &same[..1]
    );
    let huge = [[0.0; 3], [1e9; 3], [f32::MIN_POSITIVE; 3]];
    let table = VectorTable::from_intensities(&huge, 10).unwrap();
    assert_eq!(huge.map(|v| table.level(v)), [1, 3, 2]);
    assert_eq!(table.level([f32::NAN; 3]), 1);
    assert_eq!(table.level([f32::INFINITY; 3]), 1);
    let bad = |v: &[[f32; 3]], k| VectorTable::from_intensities(v, k).unwrap_err();
    assert_eq!(bad(&huge, 0), LevelError::BadCount);
    assert_eq!(bad(&[], 2), LevelError::Empty);
    let wild = [[1.0; 3], [1.0, f32::NAN, 1.0]];
    assert_eq!(bad(&wild, 2), LevelError::NotFinite { index: 1 });
}
