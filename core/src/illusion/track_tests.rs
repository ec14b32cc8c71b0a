//! Tests of `track.rs`.

use super::*;

fn at(ms: u64) -> Instant {
    Instant::from_micros(ms * 1000)
}

fn x(tracks: &Tracks, id: u32, ms: u64) -> f32 {
    tracks.place(id, at(ms)).unwrap().x
}

#[test]
fn a_moving_contact_is_carried_to_the_tick_and_not_for_ever() {
    let mut tracks = Tracks::new(1, AHEAD);
    for frame in 0..60u64 {
        let place = Point::new(frame as f32 * 0.1, 0.0); // 10 mm/s
        tracks.observe(at(frame * 10), [(7, place)].into_iter());
    }
    assert!((x(&tracks, 7, 590) - 5.9).abs() < 1e-4);
    assert!((x(&tracks, 7, 595) - 5.95).abs() < 1e-3);
    assert!((x(&tracks, 7, 900) - 6.1).abs() < 1e-3);
}

#[test]
fn a_contact_that_is_not_carried_on_stands_where_its_newest_frame_had_it() {
    let mut tracks = Tracks::new(1, Duration::ZERO);
    for frame in 0..60u64 {
        let place = Point::new(frame as f32 * 0.1, 0.0);
        tracks.observe(at(frame * 10), [(7, place)].into_iter());
        assert_eq!(x(&tracks, 7, frame * 10 + 9), place.x);
    }
}

#[test]
fn a_new_contact_stands_and_a_lost_one_is_gone() {
    let mut tracks = Tracks::new(2, AHEAD);
    let (a, b) = (Point::new(1.0, 0.0), Point::new(5.0, 0.0));
    tracks.observe(at(0), [(1, a), (2, b)].into_iter());
    assert_eq!(x(&tracks, 2, 15), 5.0);
    tracks.observe(at(10), [(2, b), (3, a)].into_iter());
    assert!(tracks.place(1, at(15)).is_none());
    assert_eq!(x(&tracks, 3, 15), 1.0);
    // The same frame once more, and one from the past.
    tracks.observe(at(10), [(2, a), (3, b)].into_iter());
    assert_eq!(x(&tracks, 3, 15), 1.0);
}
