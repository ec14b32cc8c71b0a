//! Tests of `identity.rs`.

use super::*;

fn run(old: &[(f32, f32)], ids: &[u32], new: &[(f32, f32)], mut next: u32) -> Vec<u32> {
    let mut out = Vec::new();
    let distance2 = |o: usize, n: usize| {
        let (dx, dy) = (new[n].0 - old[o].0, new[n].1 - old[o].1);
        dx * dx + dy * dy
    };
    Matcher::new(8).match_up(ids, new.len(), &distance2, &mut out, &mut next);
    out
}

#[test]
fn births_deaths_and_moves() {
    let at = |x: f32| (x, 0.0);
    assert_eq!(run(&[], &[], &[at(0.0), at(1.0)], 1), [1, 2]);
    // one stays, one moves, one is born
    assert_eq!(
        run(
            &[at(0.0), at(5.0)],
            &[7, 8],
            &[at(4.0), at(9.0), at(0.0)],
            9
        ),
        [8, 9, 7]
    );
    // a merge keeps the nearer identity
    assert_eq!(run(&[at(0.0), at(5.0)], &[7, 8], &[at(3.0)], 9), [8]);
    assert_eq!(run(&[at(0.0)], &[7], &[], 9), [0u32; 0]);
}

#[test]
fn ties_go_to_the_lowest_indices() {
    let at = |x: f32| (x, 0.0);
    assert_eq!(run(&[at(-1.0), at(1.0)], &[7, 8], &[at(0.0)], 9), [7]);
    assert_eq!(run(&[at(0.0)], &[7], &[at(1.0), at(-1.0)], 9), [7, 9]);
}

#[test]
fn numbers_are_never_zero() {
    let mut next = u32::MAX;
    assert_eq!(
        [born(&mut next), born(&mut next), born(&mut next)],
        [u32::MAX, 1, 2]
    );
}
