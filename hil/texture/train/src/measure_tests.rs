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

/// Three labels in the corners of a triangle, however long its sides: a linear probe tells them, one of two corners not.
#[test]
fn a_linear_probe_finds_what_planes_part() {
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1000.0_f32]];
    let near = |n: usize| {
        let [x, y] = corners[n % 3];
        let off = (n / 3) as f32 * 0.02;
        (vec![x + off, y - 1000.0 * off], n % 3)
    };
    let known: Vec<_> = (0..15).map(near).collect();
    let asked: Vec<_> = (15..30).map(near).collect();
    assert!((linear(&known, &asked, 3) - 1.0).abs() < 1e-12);
    // The same points, labelled by turns: no plane has them.
    let mixed = |(n, (z, _)): (usize, (Vec<f32>, usize))| (z, n / 3 % 2);
    let known: Vec<_> = known.into_iter().enumerate().map(mixed).collect();
    let asked: Vec<_> = asked.into_iter().enumerate().map(mixed).collect();
    assert!(linear(&known, &asked, 2) < 0.7);
    assert!(linear(&[], &asked, 2).abs() < 1e-12);
}
