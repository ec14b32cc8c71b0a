//! Tests of `cells.rs`.

use super::super::display::tests::{line, thimble};
use super::*;

#[test]
fn the_thimble_has_two_rectangles_and_four_triangles() {
    let cells = Cells::new(&thimble()).unwrap();
    let mut counts: Vec<usize> = (0..cells.starts.len() - 1)
        .map(|i| cells.cell(i).len())
        .collect();
    counts.sort_unstable();
    assert_eq!(counts, [3, 3, 3, 3, 4, 4]);
    assert!(!cells.in_line());
}

#[test]
fn the_mean_of_the_corners_is_the_place() {
    let display = thimble();
    let cells = Cells::new(&display).unwrap();
    let mut shares = [0.0; 8];
    for i in 0..400 {
        let at = Point::new((i % 20) as f32 - 9.5, (i / 20) as f32 * 1.2 - 11.4);
        let (at, _) = cells.nearest(at);
        cells.shares(at, &mut shares);
        let sum: f32 = shares.iter().sum();
        let mean = |pick: fn(Point) -> f32| -> f32 {
            let each = shares.iter().zip(display.wires());
            each.map(|(s, w)| s * pick(w.place)).sum()
        };
        assert!((sum - 1.0).abs() < 1e-5);
        assert!((mean(|p| p.x) - at.x).abs() < 1e-3, "{at:?}");
        assert!((mean(|p| p.y) - at.y).abs() < 1e-3, "{at:?}");
    }
}

#[test]
fn a_line_shares_between_neighbours() {
    let cells = Cells::new(&line(&[6.5, -6.5, 0.0])).unwrap();
    assert!(cells.in_line());
    let mut shares = [0.0; 3];
    cells.shares(Point::new(-1.625, 3.0), &mut shares);
    assert_eq!(shares, [0.0, 0.25, 0.75]);
    cells.shares(Point::new(9.0, 0.0), &mut shares);
    assert_eq!(shares, [1.0, 0.0, 0.0]);
    assert!(Cells::new(&line(&[1.0])).is_none());
}

#[test]
fn outside_counts_as_the_nearest_place_of_the_hull() {
    let cells = Cells::new(&thimble()).unwrap();
    let (near, distance) = cells.nearest(Point::new(15.0, 0.0));
    assert_eq!((near, distance), (Point::new(11.0, 0.0), 4.0));
    assert_eq!(cells.nearest(Point::new(1.0, 1.0)).1, 0.0);
}

#[test]
fn a_stroke_crosses_the_edges_between_cells() {
    let cells = Cells::new(&thimble()).unwrap();
    // Up the middle column: from wire to wire.
    let parts = cells.crossings(Point::new(0.0, -14.25), Point::new(0.0, 14.25));
    let expected = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0];
    assert_eq!(parts.len(), 4);
    assert!(
        parts
            .iter()
            .zip(expected)
            .all(|(p, e)| (p - e).abs() < 1e-4)
    );
    // Across the middle of both rectangles.
    let parts = cells.crossings(Point::new(-11.0, 0.0), Point::new(11.0, 0.0));
    assert_eq!(parts.len(), 3);
}
