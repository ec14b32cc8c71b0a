//! Tests of `map.rs`.

use super::*;

fn rect(x: f32, y: f32) -> Rect {
    Rect {
        min: Point::new(-x, -y),
        max: Point::new(x, y),
    }
}

#[test]
fn corners_go_to_corners() {
    let map = Map::new(rect(7.05, 7.05), None, rect(11.0, 14.25)).unwrap();
    let p = map.apply(Point::new(7.05, -7.05));
    assert!((p.x - 11.0).abs() < 1e-5 && (p.y + 14.25).abs() < 1e-5);
    assert_eq!(map.apply(Point::new(0.0, 0.0)), Point::new(0.0, 0.0));
}

#[test]
fn a_line_of_wires_takes_the_other_axis_flat() {
    let map = Map::new(rect(7.05, 7.05), None, rect(6.5, 0.0)).unwrap();
    assert_eq!(map.apply(Point::new(0.0, 5.0)).y, 0.0);
}

#[test]
fn what_cannot_be_mapped_is_refused() {
    let outside = Map::new(rect(7.05, 7.05), Some(rect(8.0, 1.0)), rect(1.0, 1.0));
    assert_eq!(outside, Err(MapError::NotContained));
    let flat = Map::new(rect(7.05, 0.0), None, rect(1.0, 1.0));
    assert_eq!(flat, Err(MapError::Degenerate));
}
