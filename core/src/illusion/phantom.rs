//! The logarithmic phantom sensation of the thesis, (5.2), and its form over true distances.

use alloc::boxed::Box;

use crate::units::Point;

use super::display::Display;
use super::law::{Illusion, IllusionError};
use super::reach::Metric;

/// Shape factors (s_x, s_y) of (5.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shape {
    /// Factor along x.
    pub x: f32,
    /// Factor along y.
    pub y: f32,
}

impl Shape {
    /// The factor with which two wires `spacing` mm apart are both at 2^-1/2 halfway, so that the energy
    /// there is that on a wire: 3.71, 4.08 and 4.65 for 6.5, 9 and 14 mm. Any factor does where there is
    /// no spacing.
    pub fn flat(spacing: f32) -> f32 {
        if !spacing.is_finite() {
            return 1.0;
        }
        let half = 1.0 - core::f64::consts::FRAC_1_SQRT_2;
        let spacing = f64::from(spacing);
        let ratio = libm::log2(spacing / 2.0 + 1.0) / libm::log2(spacing + 1.0);
        (libm::log(half) / libm::log(ratio)) as f32
    }
}

/// One factor of (5.2): `max(1 - (log2(|d| + 1) / log2(D + 1))^s, 0)`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Slope {
    /// D, mm; infinite where nothing attenuates.
    spacing: f32,
    /// 1 / ln(D + 1): the base of the logarithms cancels.
    scale: f32,
    shape: f32,
}

impl Slope {
    fn new(spacing: f32, shape: f32) -> Self {
        let scale = (1.0 / libm::log1p(f64::from(spacing))) as f32;
        Self {
            spacing,
            scale,
            shape,
        }
    }

    /// Tells whether a wire at this distance has any part; for NaN
    /// it has none. Most wires have none and need no logarithm.
    fn reaches(&self, distance: f32) -> bool {
        libm::fabsf(distance) < self.spacing
    }

    /// The factor at a distance within reach.
    fn at(&self, distance: f32) -> f32 {
        let distance = libm::fabsf(distance);
        let ratio = libm::logf(distance + 1.0) * self.scale;
        // s = 1, the thesis's value, needs no power.
        let fall = if (self.shape - 1.0).abs() < f32::EPSILON {
            ratio
        } else {
            // Half the time of a power function, whose last bits are not felt.
            libm::expf(self.shape * libm::logf(ratio))
        };
        (1.0 - fall).max(0.0)
    }
}

/// The activation of the thesis, (5.2), axis by axis:
///
/// `a_n = max(1 - (log2(|dx| + 1) / log2(D_x + 1))^s_x, 0) * (the same in y)`
///
/// Distances are in millimetres; the `+ 1` makes the law depend on that unit. On a wire a = 1 and its
/// neighbours are 0. Between two wires with s = 1 both get 0.23 .. 0.28: the gap that the thesis's users
/// felt, and this model keeps.
#[derive(Clone, Debug)]
pub(super) struct LogPhantom {
    slopes: (Slope, Slope),
    wires: Box<[Point]>,
}

impl LogPhantom {
    /// The law for a display's spacings.
    ///
    /// # Errors
    /// A shape factor that is not finite and positive.
    pub fn new(display: &Display, shape: Shape) -> Result<Self, IllusionError> {
        let good = |s: f32| s.is_finite() && s > 0.0;
        if !(good(shape.x) && good(shape.y)) {
            return Err(IllusionError::Shape);
        }
        let (dx, dy) = display.spacing();
        Ok(Self {
            slopes: (Slope::new(dx, shape.x), Slope::new(dy, shape.y)),
            wires: display.wires().iter().map(|w| w.place).collect(),
        })
    }
}

impl Illusion for LogPhantom {
    fn activate(&self, at: Point, out: &mut [f32]) {
        let (x, y) = &self.slopes;
        for (a, wire) in out.iter_mut().zip(&self.wires) {
            let (dx, dy) = (at.x - wire.x, at.y - wire.y);
            *a = if x.reaches(dx) && y.reaches(dy) {
                x.at(dx) * y.at(dy)
            } else {
                0.0
            };
        }
    }
}

/// (5.2) with one factor over the true distance, in the plane or straight through space. D is each wire's
/// distance to its nearest neighbour, so that on a wire its neighbours are still 0.
#[derive(Clone, Debug)]
pub(super) struct RadialPhantom {
    metric: Metric,
    slopes: Box<[Slope]>,
}

impl RadialPhantom {
    /// The law over `metric`; `shape` gives each wire's factor from its D.
    ///
    /// # Errors
    /// A shape factor that is not finite and positive.
    pub(super) fn new(metric: Metric, shape: impl Fn(f32) -> f32) -> Result<Self, IllusionError> {
        let gaps = metric.gaps();
        if !gaps.iter().all(|&d| shape(d).is_finite() && shape(d) > 0.0) {
            return Err(IllusionError::Shape);
        }
        let slopes = gaps.iter().map(|&d| Slope::new(d, shape(d))).collect();
        Ok(Self { metric, slopes })
    }
}

impl Illusion for RadialPhantom {
    fn activate(&self, at: Point, out: &mut [f32]) {
        let at = self.metric.lift(at);
        for (i, (a, slope)) in out.iter_mut().zip(&self.slopes).enumerate() {
            let distance = libm::sqrtf(self.metric.distance2(at, i));
            *a = if slope.reaches(distance) {
                slope.at(distance)
            } else {
                0.0
            };
        }
    }
}

#[cfg(test)]
#[path = "phantom_tests.rs"]
mod tests;
