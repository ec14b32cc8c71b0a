//! Tests of `tracks.rs`.

use super::*;

/// Onsets 117 ms apart.
fn onset(n: u64) -> Instant {
    Instant::from_micros(117_000 * n)
}

#[test]
fn a_contact_that_stays_rests_and_one_that_goes_moves() {
    let mut tracks = Tracks::default();
    let mut rests = |n: u64, x: f32| tracks.follow(Point::new(x, 0.0), onset(n)).rests;
    for n in 1..=4 {
        assert!(!rests(n, 0.0), "a new contact moves");
    }
    assert!(rests(6, 0.01));
    let mut x = 0.0;
    for n in 7..12 {
        x += 1.2; // 10 mm/s
        rests(n, x);
    }
    assert!(!rests(12, x + 1.2));
    for n in 13..24 {
        x += 0.3; // 2.6 mm/s: between rest and motion it goes on as it did
        assert!(!rests(n, x + 1.2), "{n}");
    }
}

#[test]
fn two_contacts_keep_their_scales_and_a_lost_one_is_forgotten() {
    let mut tracks = Tracks::default();
    let place = |x: f32| Point::new(x, 0.0);
    for n in 1..5 {
        for (x, scale) in [(0.0, 0.25), (20.0, 0.5)] {
            let track = tracks.follow(place(x + 0.1 * n as f32), onset(n));
            assert_eq!(track.scale, (n > 1).then_some(scale));
            track.scale = Some(scale);
        }
    }
    // In the other order, and both at one onset.
    assert_eq!(tracks.follow(place(20.4), onset(5)).scale, Some(0.5));
    assert_eq!(tracks.follow(place(0.4), onset(5)).scale, Some(0.25));
    assert_eq!(tracks.follow(place(0.4), onset(5)).scale, None);
    assert_eq!(tracks.follow(place(0.4), onset(9)).scale, None);
}

#[test]
fn more_contacts_than_are_remembered_take_the_places_of_the_oldest() {
    let mut tracks = Tracks::default();
    for n in 0..=SLOTS as u64 {
        let track = tracks.follow(
            Point::new(30.0 * n as f32, 0.0),
            onset(1) + Duration::from_micros(n),
        );
        track.scale = Some(n as f32);
    }
    let found = |x: f32, tracks: &mut Tracks| tracks.follow(Point::new(x, 0.0), onset(2)).scale;
    assert_eq!(found(30.0 * SLOTS as f32, &mut tracks), Some(SLOTS as f32));
    assert_eq!(found(0.0, &mut tracks), None);
}
