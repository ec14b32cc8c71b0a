//! Tests of `sync.rs`.

use super::*;

const fn at(us: u64) -> Instant {
    Instant::from_micros(us)
}

/// An exchange with a unit whose clock is `offset` ahead, over ways of these lengths.
fn exchange(sent: u64, offset: u64, there: u64, back: u64) -> Exchange {
    let taken = sent + there;
    Exchange {
        sent: at(sent),
        taken: at(taken + offset),
        answered: at(taken + offset + 100),
        heard: at(taken + 100 + back),
    }
}

#[test]
fn even_ways_give_the_offset_and_uneven_ones_half_their_difference() {
    for (there, back, wrong) in [(3000, 3000, 0), (9000, 3000, 3000), (3000, 9000, -3000)] {
        let mut sync = Sync::default();
        sync.add(exchange(0, 7_000_000, there, back));
        let found = sync.unit_time(at(50_000)).unwrap().as_micros() as i64;
        assert_eq!(found - 7_050_000, wrong);
        assert!(sync.earliest(at(50_000)).unwrap() <= at(7_050_000));
        assert_eq!(sync.now().unwrap().width(), (there + back) as i64);
    }
}

#[test]
fn the_narrowest_of_half_a_second_counts() {
    let mut sync = Sync::default();
    for n in 0..200 {
        let (there, back) = if n % 20 == 7 {
            (3000, 3000)
        } else {
            (30_000, 3000)
        };
        sync.add(exchange(10_000 * n, 500, there, back));
        if n > 7 {
            assert_eq!(sync.unit_time(at(20_000)), Some(at(20_500)), "{n}");
        }
    }
}

#[test]
fn an_old_enclosure_is_given_up() {
    let mut sync = Sync::default();
    sync.add(exchange(0, 500, 10, 10));
    for n in 1..100 {
        sync.add(exchange(10_000 * n, 900, 3000, 3000));
    }
    assert_eq!(sync.unit_time(at(0)), Some(at(900)));
}

#[test]
fn an_answer_before_its_question_is_none() {
    let mut sync = Sync::default();
    sync.add(Exchange {
        sent: at(1000),
        taken: at(0),
        answered: at(9000),
        heard: at(1100),
    });
    assert_eq!(sync.unit_time(at(0)), None);
}
