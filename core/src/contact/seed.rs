//! k-means++ seeds (Arthur & Vassilvitskii 2007), weighted and from a seeded stream.

use crate::random::Stream;

use super::kmeans::{Points, Workspace};

/// Fills the first `k` centroids of `into`. `distance` is memory for one value a point.
///
/// A point is drawn with probability in proportion to weight times squared distance to the nearest seed.
/// When all that is left lies on seeds (duplicates), the lowest index that is no seed yet is taken: no
/// division by zero, no repeated draw.
pub(super) fn plus_plus(
    points: Points<'_>,
    k: usize,
    stream: &mut Stream,
    distance: &mut [f32],
    into: &mut Workspace,
) {
    let n = points.len().min(distance.len());
    if n == 0 {
        return;
    }
    let place = |into: &mut Workspace, c: usize, i: usize| {
        (into.cx[c], into.cy[c]) = (points.x[i], points.y[i]);
    };
    let distance = &mut distance[..n];
    let first = draw(points.w.iter().take(n).map(|&w| f64::from(w)), stream).unwrap_or(0);
    place(into, 0, first);
    distance.fill(f32::INFINITY);
    for c in 1..k.min(into.cx.len()) {
        let (cx, cy) = (into.cx[c - 1], into.cy[c - 1]);
        for (i, d) in distance.iter_mut().enumerate() {
            let (dx, dy) = (points.x[i] - cx, points.y[i] - cy);
            *d = d.min(dx * dx + dy * dy);
        }
        let mass = |i: usize| f64::from(points.w[i]) * f64::from(distance[i]);
        let next = draw((0..n).map(mass), stream)
            .or_else(|| distance.iter().position(|&d| d > 0.0))
            .unwrap_or(c.min(n - 1));
        place(into, c, next);
    }
}

/// An index in proportion to its mass; `None` when all masses are zero.
fn draw(masses: impl Iterator<Item = f64> + Clone, stream: &mut Stream) -> Option<usize> {
    let total: f64 = masses.clone().sum();
    if !(total.is_finite() && total > 0.0) {
        return None;
    }
    let target = stream.uniform() * total;
    let mut reached = 0.0;
    let mut last = None;
    for (i, mass) in masses.enumerate() {
        if mass > 0.0 {
            reached += mass;
            last = Some(i);
            if target < reached {
                return last;
            }
        }
    }
    last
}
