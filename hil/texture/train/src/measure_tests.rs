//! Components find a plane, neighbours vote.

use super::*;

#[test]
fn components_find_a_plane() {
    let mut stream = RandomStream::new(5, "plane");
    let plane: Vec<f32> = (0..2 * 30).map(|_| stream.normal() as f32).collect();
    let plane = Array2::from_shape_vec((2, 30), plane).unwrap();
    let places = Array2::from_shape_fn((200, 2), |(_, c)| stream.normal() as f32 * [3.0, 1.0][c]);
    let rows = places.dot(&plane) + 5.0;
    let two = Components::fit(&rows, 2);
    assert!(two.error(&rows) < 1e-6 * two.error_of_mean(&rows));
    let one = Components::fit(&rows, 1);
    assert!(one.error(&rows) > 1e-2 * one.error_of_mean(&rows));
    assert!(one.error(&rows) < 0.3 * one.error_of_mean(&rows));
}

#[test]
fn neighbours_vote_and_units_do_not_matter() {
    let known: Vec<_> = (0..10)
        .map(|i| (vec![(i % 2) as f32, 1000.0 * i as f32], i % 2))
        .collect();
    let asked = vec![(vec![0.1, 3000.0], 0), (vec![0.9, 4000.0], 1)];
    assert!((neighbours(&known, &asked, 3) - 1.0).abs() < 1e-12);
    assert!(neighbours(&[], &asked, 3).abs() < 1e-12);
}
