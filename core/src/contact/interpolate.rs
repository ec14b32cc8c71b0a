//! Intensity between taxels (4.9): the relative frame's magnitude, bilinear on grids, inverse-distance elsewhere.
//!
//! On a grid the four taxels around the place weigh bilinearly; taxels left out give their weight to the others,
//! and where all four are out the scattered rule holds. Places outside the grid count as on its edge.
//!
//! Scattered points weigh `((R - d) / (R d))²` within R = 2.5 spacings (Franke & Little's form of Shepard's
//! inverse-distance weights, which ends at R, so far taxels do not drown near ones). On a taxel its own value
//! holds; with no usable taxel within R the nearest one's.

use crate::skin::layout::{Grid, Module};
use crate::units::Point;

/// Radius of the scattered rule in spacings.
const RADIUS: f32 = 2.5;

/// The magnitude at `place` (module coordinates, mm), counts. `magnitude` and `usable` cover the module's taxels.
/// 0 if none is usable. Never leaves the range of the values it weighs by more than rounding.
pub fn intensity(module: &Module, magnitude: &[f32], usable: &[bool], place: Point) -> f32 {
    let on_grid = module
        .as_grid()
        .and_then(|g| bilinear(g, magnitude, usable, place));
    match on_grid {
        Some(v) => v,
        None => scattered(module, magnitude, usable, place),
    }
}

fn bilinear(grid: &Grid, magnitude: &[f32], usable: &[bool], place: Point) -> Option<f32> {
    let cell = |at: f32, n: u16| {
        let last = f32::from(n - 1);
        let at = at.clamp(0.0, last);
        let low = libm::floorf(at).min((last - 1.0).max(0.0));
        (low as usize, at - low)
    };
    let first = grid.place(0, 0);
    let (col, right) = cell((place.x - first.x) / grid.pitch_x, grid.cols);
    let (row, down) = cell((first.y - place.y) / grid.pitch_y, grid.rows);
    let cols = usize::from(grid.cols);
    let (mut sum, mut weight) = (0.0f32, 0.0f32);
    for (r, wr) in [(row, 1.0 - down), (row + 1, down)] {
        for (c, wc) in [(col, 1.0 - right), (col + 1, right)] {
            let (i, w) = (r * cols + c, wr * wc);
            if w > 0.0 && usable.get(i).copied().unwrap_or(false) {
                sum += w * magnitude.get(i).copied().unwrap_or(0.0);
                weight += w;
            }
        }
    }
    // A single far corner is no interpolation: the scattered rule looks further.
    (weight > 1e-3).then(|| sum / weight)
}

fn scattered(module: &Module, magnitude: &[f32], usable: &[bool], place: Point) -> f32 {
    let radius = RADIUS * module.spacing();
    let (mut sum, mut weight) = (0.0f32, 0.0f32);
    let mut nearest = (f32::INFINITY, 0.0f32);
    for ((p, m), _) in module
        .points()
        .iter()
        .zip(magnitude)
        .zip(usable)
        .filter(|t| *t.1)
    {
        let d2 = p.distance2(place);
        if d2 < nearest.0 {
            nearest = (d2, *m);
        }
        if d2 < radius * radius && d2 > 0.0 {
            let d = libm::sqrtf(d2);
            let w = ((radius - d) / d) * ((radius - d) / d); // the common factor 1/R² falls out
            sum += w * m;
            weight += w;
        }
    }
    // On a taxel, or so near that its weight would overflow, the taxel's own value holds.
    let on_taxel = nearest.0 <= 1e-8 * radius * radius;
    if on_taxel || weight <= 0.0 {
        nearest.1
    } else {
        sum / weight
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    /// Bilinear interpolation is exact for a plane.
    #[test]
    fn a_plane_is_met_exactly_on_a_grid() {
        let m = Module::grid_xy("g", 4, 6, 2.0, 3.0).unwrap();
        let f = |p: Point| 100.0 + 3.0 * p.x - 2.0 * p.y;
        let v: Vec<f32> = m.points().iter().map(|p| f(*p)).collect();
        for (x, y) in [
            (0.3, 0.7),
            (-5.0, 4.5),
            (5.0, -4.5),
            (4.99, 0.0),
            (0.0, 0.0),
        ] {
            let p = Point::new(x, y);
            assert!((intensity(&m, &v, &[true; 24], p) - f(p)).abs() < 1e-4);
        }
        let outside = intensity(&m, &v, &[true; 24], Point::new(99.0, 99.0));
        assert!((outside - f(Point::new(5.0, 4.5))).abs() < 1e-4);
    }

    #[test]
    fn a_taxel_left_out_gives_its_weight_to_the_others() {
        let m = Module::grid("g", 2, 2, 1.0).unwrap();
        let v = [10.0, 20.0, 30.0, 1e9];
        let at = Point::new(0.0, 0.0);
        let got = intensity(&m, &v, &[true, true, true, false], at);
        assert!((got - 20.0).abs() < 1e-4);
        assert!(intensity(&m, &v, &[false; 4], at).abs() < 1e-6);
        let one = Module::grid("g", 1, 1, 1.0).unwrap();
        assert!((intensity(&one, &[7.0], &[true], at) - 7.0).abs() < 1e-6);
    }

    #[test]
    fn scattered_points_are_met_and_stay_in_range() {
        let points: Vec<Point> = (0..12)
            .map(|i| Point::new((i % 4) as f32 + 0.3 * (i / 4) as f32, (i / 4) as f32))
            .collect();
        let m = Module::scattered("s", &points).unwrap();
        let v: Vec<f32> = (0..12).map(|i| 100.0 * i as f32).collect();
        for (p, want) in points.iter().zip(&v) {
            assert!((intensity(&m, &v, &[true; 12], *p) - want).abs() < 1e-3);
            let near = intensity(&m, &v, &[true; 12], Point::new(p.x + 1e-4, p.y));
            assert!((near - want).abs() < 1.0, "{near} {want}");
        }
        let far = intensity(&m, &v, &[true; 12], Point::new(1e5, 1e5));
        assert!((far - 1100.0).abs() < 1e-3);
    }
}
