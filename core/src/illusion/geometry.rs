//! Lines in the plane of the display.

use crate::units::Point;

/// Positive where `p` lies to the left of the line from `a` to `b`.
pub(super) fn left_of(a: Point, b: Point, p: Point) -> f32 {
    (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)
}

/// The place of the segment from `a` to `b` that is nearest to `p`.
pub(super) fn foot(a: Point, b: Point, p: Point) -> Point {
    let length2 = a.distance2(b);
    if length2 <= 0.0 {
        return a;
    }
    let t = ((p.x - a.x) * (b.x - a.x) + (p.y - a.y) * (b.y - a.y)) / length2;
    let t = t.clamp(0.0, 1.0);
    Point::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y))
}
