//! Counts that a touch would add to a taxel, before noise: quasi-static.
//!
//! A sphere pressed into silicone makes a Hertz contact; its pressure reaches the buried magnets
//! through a layer that spreads it like a Gaussian. Convolved, that is close to one Gaussian whose
//! variances add up (the Hertz pressure of contact radius a has a²/5 along each axis). Shear follows
//! the slope of the normal response: the skin is pushed away from the touch.

use palpate_core::units::Point;

use crate::time::Nanos;

/// One sphere on the skin at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Press {
    /// Centre of the sphere over the module, mm in the module's coordinates.
    pub at: Point,
    /// Normal force, N; zero or less is no touch.
    pub force_n: f64,
    /// Diameter of the sphere, mm.
    pub diameter_mm: f64,
}

/// Touches of a module as time goes by. The path is the caller's, with an integer clock as its argument. A module
/// crosses to another thread with what touches it.
pub trait Touches: Send {
    /// Appends the touches at `now` to `out`.
    fn touches(&self, now: Nanos, out: &mut Vec<Press>);

    /// Friction at `now`: shear counts (x, y) for every normal count. Spheres that are pressed and not dragged have
    /// none.
    fn drag(&self, _now: Nanos) -> [f64; 2] {
        [0.0; 2]
    }
}

impl<F: Fn(Nanos, &mut Vec<Press>) + Send> Touches for F {
    fn touches(&self, now: Nanos, out: &mut Vec<Press>) {
        self(now, out);
    }
}

/// Constants of the silicone. None is published; all are calibrated to the figures named with them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Silicone {
    /// Normal counts per newton, summed over an endless skin (about 1190 were measured).
    pub counts_per_newton: f64,
    /// Spread (standard deviation) under a point load, mm. With `crosstalk` set so that the 19.45 mm
    /// sphere at 1 N puts 12 of 16 taxels above 12 to 20 counts (thesis: "up to 12").
    pub spread_mm: f64,
    /// Effective modulus of the contact, N/mm² (soft silicone; assumed).
    pub modulus_n_mm2: f64,
    /// Further spread beyond 1 N, mm² per newton: the peak bleeds into its neighbours (assumed).
    pub bleed_mm2_per_n: f64,
    /// Shear counts against normal counts one spread away from the touch (assumed).
    pub shear: f64,
    /// Share of the difference to each direct neighbour that leaks through the tape (assumed).
    pub crosstalk: f64,
    /// Time constant of the silicone, s (first order; assumed).
    pub lag_s: f64,
}

impl Default for Silicone {
    fn default() -> Self {
        Self {
            counts_per_newton: 1190.0,
            spread_mm: 2.75,
            modulus_n_mm2: 0.5,
            bleed_mm2_per_n: 1.0,
            shear: 0.25,
            crosstalk: 0.02,
            lag_s: 0.005,
        }
    }
}

/// One touch made ready: its Gaussian, evaluated taxel by taxel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dent {
    at: Point,
    peak: f64,
    inverse_variance: f64,
    shear_per_mm: f64,
}

impl Silicone {
    /// The response to a touch on a skin with one taxel per `area_mm2`; `None` when nothing presses
    /// or a number is not finite.
    pub(super) fn dent(&self, touch: &Press, area_mm2: f64) -> Option<Dent> {
        let (force, radius) = (touch.force_n, touch.diameter_mm / 2.0);
        let finite = force.is_finite()
            && radius.is_finite()
            && touch.at.x.is_finite()
            && touch.at.y.is_finite();
        if !finite || force <= 0.0 || radius < 0.0 {
            return None;
        }
        // Hertz, sphere on a half-space: a³ = 3 F R / (4 E*) (Johnson, Contact Mechanics, 4.22).
        // The sphere touches with no more than itself, and beyond 10 N nothing bleeds further.
        let contact = libm::cbrt(3.0 * force * radius / (4.0 * self.modulus_n_mm2)).min(radius);
        let variance = self.spread_mm * self.spread_mm
            + contact * contact / 5.0
            + self.bleed_mm2_per_n * (force.min(10.0) - 1.0).max(0.0);
        Some(Dent {
            at: touch.at,
            peak: self.counts_per_newton * force * area_mm2 / (std::f64::consts::TAU * variance),
            inverse_variance: 1.0 / variance,
            shear_per_mm: self.shear / libm::sqrt(variance),
        })
    }
}

impl Dent {
    /// Counts (x, y, z) added at a taxel; `drag` is what [`Touches::drag`] says.
    pub(super) fn at(&self, taxel: Point, drag: [f64; 2]) -> [f64; 3] {
        let dx = f64::from(taxel.x) - f64::from(self.at.x);
        let dy = f64::from(taxel.y) - f64::from(self.at.y);
        let z = self.peak * libm::exp(-0.5 * (dx * dx + dy * dy) * self.inverse_variance);
        let push = z * self.shear_per_mm;
        [push * dx + drag[0] * z, push * dy + drag[1] * z, z]
    }
}
