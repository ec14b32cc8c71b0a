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
#[inline(always)] // in every frame
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
        let at = at.clamp(0.0, f32::from(n - 1));
        let low = (at as u16).min(n.saturating_sub(2));
        (usize::from(low), at - f32::from(low))
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
#[path = "interpolate_tests.rs"]
mod tests;
