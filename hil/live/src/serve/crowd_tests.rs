//! Tests of `crowd.rs`.

use std::io::Read;
use std::net::TcpListener;
use std::time::Duration;

use super::*;

/// Both ends of so many connections.
fn connections(count: usize) -> Vec<(TcpStream, TcpStream)> {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let connect = |_| {
        let other = TcpStream::connect(address).unwrap();
        let patience = Some(Duration::from_millis(100));
        other.set_read_timeout(patience).unwrap();
        (listener.accept().unwrap().0, other)
    };
    (0..count).map(connect).collect()
}

/// Which of them are shut down, as their other ends see it.
fn gone(connections: &mut [(TcpStream, TcpStream)]) -> Vec<usize> {
    let ended = |other: &mut TcpStream| matches!(other.read(&mut [0]), Ok(0));
    let numbered = connections.iter_mut().enumerate();
    numbered
        .filter_map(|(number, (_, other))| ended(other).then_some(number))
        .collect()
}

#[test]
fn a_newcomer_has_the_place_of_the_first_or_of_the_last() {
    for (leaves, expected) in [(Leaves::First, [0, 1]), (Leaves::Last, [2, 3])] {
        let crowd = Crowd::new(3, leaves);
        let mut all = connections(5);
        let places: Vec<Place> = all
            .iter()
            .map(|(stream, _)| crowd.enter(stream).unwrap())
            .collect();
        assert_eq!(gone(&mut all), expected, "{leaves:?}");
        // Who was shut down gives no other one's place back.
        drop(places);
        assert!(held(&crowd.inside).streams.is_empty());
    }
}

#[test]
fn a_place_that_was_given_back_is_free() {
    let crowd = Crowd::new(2, Leaves::First);
    let mut all = connections(3);
    let first = crowd.enter(&all[0].0).unwrap();
    let second = crowd.enter(&all[1].0).unwrap();
    drop(second);
    let third = crowd.enter(&all[2].0).unwrap();
    assert!(gone(&mut all).is_empty());
    drop((first, third));
}
