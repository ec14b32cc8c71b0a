//! Tests of `levels.rs`.

use super::*;
use crate::random::RandomStream;

fn cost(values: &[f32], levels: &[f32]) -> f64 {
    let d = |v: f32, l: f32| (f64::from(v) - f64::from(l)) * (f64::from(v) - f64::from(l));
    let best = |v: f32| {
        levels
            .iter()
            .map(|l| d(v, *l))
            .fold(f64::INFINITY, f64::min)
    };
    values.iter().map(|v| best(*v)).sum()
}

/// Tries all ways to cut sorted values into `k` runs.
fn exhaustive(sorted: &[f32], k: usize) -> f64 {
    let one = |v: &[f32]| {
        let mean = v.iter().map(|x| f64::from(*x)).sum::<f64>() / v.len() as f64;
        v.iter()
            .map(|x| (f64::from(*x) - mean) * (f64::from(*x) - mean))
            .sum::<f64>()
    };
    if k == 1 || sorted.len() <= 1 {
        return if sorted.is_empty() { 0.0 } else { one(sorted) };
    }
    (1..=sorted.len())
        .map(|cut| one(&sorted[..cut]) + exhaustive(&sorted[cut..], k - 1))
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn levels_are_optimal_against_every_cut() {
    let mut r = RandomStream::new(3, "levels");
    for case in 0..100_000 {
        let n = 1 + (r.next_u64() % 8) as usize;
        let k = 1 + (r.next_u64() % 5) as usize;
        let coarse = if case % 2 == 0 { 5.0 } else { 60_000.0 };
        let mut v: Vec<f32> = (0..n)
            .map(|_| libm::floorf((r.uniform() * coarse) as f32))
            .collect();
        let table = LevelTable::from_intensities(&v, k).unwrap();
        v.sort_by(f32::total_cmp);
        let (got, want) = (cost(&v, table.values()), exhaustive(&v, k));
        assert!(
            (got - want).abs() <= 1e-6 * want + 1e-3 * n as f64,
            "{v:?} {k}: {got} {want}"
        );
    }
}

#[test]
fn nearest_level_ties_to_the_lower() {
    let t = LevelTable::new(&[30.0, 10.0, 20.0, 10.0]).unwrap();
    let got = [0.0, 10.0, 15.0, 15.1, 25.0, 30.0, 99.0].map(|v| t.level(v));
    assert_eq!(got, [1, 1, 1, 2, 2, 3, 3]);
    assert_eq!(t.level(f32::NAN), 1);
    assert_eq!(t.level(f32::INFINITY), 3);
}

#[test]
fn weber_levels_count_as_the_law_says() {
    let t = LevelTable::weber(100.0, 1000.0, 0.2).unwrap(); // 20 dB: 12.6 steps
    assert_eq!(t.values().len(), 13);
    assert!(
        t.values()
            .windows(2)
            .all(|p| (p[1] / p[0] - 1.2).abs() < 1e-5)
    );
    assert_eq!(LevelTable::weber(0.0, 1.0, 0.2), Err(LevelError::BadRange));
    assert_eq!(
        LevelTable::weber(1.0, f32::INFINITY, 0.2),
        Err(LevelError::BadRange)
    );
}

#[test]
fn hostile_values() {
    assert_eq!(LevelTable::from_intensities(&[], 3), Err(LevelError::Empty));
    assert_eq!(
        LevelTable::from_intensities(&[1.0], 0),
        Err(LevelError::BadCount)
    );
    let e = LevelTable::from_intensities(&[1.0, f32::NAN], 2);
    assert_eq!(e, Err(LevelError::NotFinite { index: 1 }));
    let same = LevelTable::from_intensities(&[37_000.0; 50], 10).unwrap();
    assert_eq!(same.values().len(), 1);
    let mut s = LevelSolver::new(4, 0);
    s.solve(&[1.0, 2.0]).unwrap();
    assert_eq!((s.levels().len(), s.level(3.0)), (0, 1));
}
