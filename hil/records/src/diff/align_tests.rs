//! Tests of `align.rs`.

use super::*;
use crate::bursts::DrivenOutput;

fn burst(from_us: u64, to_us: u64) -> Burst {
    Burst {
        output: DrivenOutput::Wire(0),
        from_us,
        to_us,
        width: 80,
        requested: 80,
        reason: None,
    }
}

fn train(n: u64) -> Vec<Burst> {
    (0..n)
        .map(|i| burst(i * 58_500, i * 58_500 + 35_000))
        .collect()
}

#[test]
fn both_ways_find_one_that_is_gone_and_one_that_moved() {
    let a = train(20);
    let mut b = a.clone();
    b.remove(7);
    b[12].from_us += 5_000;
    let found = align(&a, &b, 58_500);
    assert_eq!(
        (found.gone.as_slice(), found.new.len()),
        ([7].as_slice(), 0)
    );
    assert!(found.pairs.contains(&(13, 12)));
    assert_eq!(sweep(&a, &b, 58_500), found);
    let back = align(&b, &a, 58_500);
    assert_eq!(back.new, [7]);
}

#[test]
fn a_burst_in_another_place_is_gone_and_new() {
    let a = train(20);
    let mut b = a.clone();
    b.remove(3);
    b.insert(10, burst(10 * 58_500 + 40_000, 10 * 58_500 + 45_000));
    let found = align(&a, &b, 58_500);
    assert_eq!((found.gone.len(), found.new.len()), (1, 1));
}

#[test]
fn nothing_and_extremes_align() {
    assert_eq!(align(&[], &[], 0), Alignment::default());
    let a = [burst(0, u64::MAX), burst(u64::MAX, u64::MAX)];
    let found = align(&a, &a[1..], u64::MAX);
    assert_eq!(found.pairs.len() + found.gone.len(), 2);
    assert_eq!(align(&[], &a, 1).new, [0, 1]);
}
