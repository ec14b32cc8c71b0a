//! Tests of `clock.rs`.

use super::*;

fn at(us: u64) -> Instant {
    Instant::from_micros(us)
}

#[test]
fn both_directions_bound_the_age() {
    let mut clock = Clock::default();
    // Theirs is 1000 us ahead; 300 us there, 200 us back.
    assert_eq!(clock.arrived(11_000, at(10_300)), Ok(()));
    assert_eq!(clock.most_since(11_000, at(10_300)), None);
    assert_eq!(clock.echoed(at(20_000), 21_200, at(20_500)), Ok(()));
    assert_eq!(clock.offset(at(20_500)), Some((-1200 - 1, -700 + 6)));
    // Read at 30_000 of ours: 300 us old when it comes, and at most what was spent on the way back more.
    let most = clock.most_since(31_000, at(30_300)).unwrap();
    assert_eq!(most.as_micros(), 300 + 200 + 6);
}

#[test]
fn bounds_give_way_with_time() {
    let mut clock = Clock::default();
    clock.arrived(0, at(100)).unwrap();
    clock.echoed(at(100), 0, at(100)).unwrap();
    let (low, high) = clock.offset(at(2_000_100)).unwrap();
    assert_eq!((low, high), (100 - 1000, 100 + 1000));
}

#[test]
fn a_contradiction_is_a_jump_and_forgets_all() {
    let mut clock = Clock::default();
    clock.arrived(0, at(1000)).unwrap();
    clock.echoed(at(2000), 1500, at(2100)).unwrap();
    assert_eq!(clock.arrived(10_000, at(9000)), Err(Jumped));
    assert_eq!(clock.offset(at(9000)), None);
    // What was said before the jump counts no more.
    assert_eq!(clock.echoed(at(8999), 9000, at(9100)), Ok(()));
    clock.arrived(10_100, at(9100)).unwrap();
    assert_eq!(clock.offset(at(9100)), None);
}

#[test]
fn numbers_that_no_clock_has_are_no_panic() {
    let mut clock = Clock::default();
    let _ = clock.arrived(u64::MAX, at(u64::MAX));
    let _ = clock.echoed(at(u64::MAX), u64::MAX, at(u64::MAX));
    let _ = clock.arrived(0, at(u64::MAX));
    let _ = clock.echoed(at(0), u64::MAX, at(5));
    let _ = clock.most_since(u64::MAX, at(0));
    let _ = clock.most_since(0, at(u64::MAX));
    // An answer to what was not said yet.
    assert_eq!(Clock::default().echoed(at(10), 0, at(9)), Ok(()));
}
