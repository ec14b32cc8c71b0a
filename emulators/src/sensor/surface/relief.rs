//! One drawn piece of a texture: a sum of ripples whose wavelengths follow the texture's spectrum.

use core::f64::consts::{FRAC_PI_2, TAU};

use palpate_core::random::RandomStream;

use super::vibration::Riding;
use super::{PAD_MM, SurfaceTexture};

/// Ripples that make a relief.
const RIPPLES: usize = 24;
/// Side of the patch whose asperities press on the skin as one, mm: one taxel's field.
pub(super) const PATCH_MM: f64 = 4.7;

/// One wave of the relief.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ripple {
    /// Wave numbers along and across the stroke, radians per mm.
    along: f64,
    /// See `along`.
    across: f64,
    /// Phase at the origin, radians.
    phase: f64,
    /// Height, mm.
    height_mm: f64,
}

/// A piece of surface with its own seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    ripples: Vec<Ripple>,
    /// Time constant of the silicone in front of the taxels, s.
    lag_s: f64,
}

impl Relief {
    /// Draws a piece of `texture`, felt through silicone with a time constant of `lag_s`.
    pub fn new(texture: &SurfaceTexture, lag_s: f64, stream: &mut RandomStream) -> Self {
        // Sines have a mean square of one half.
        let height_mm = texture.relief_mm * libm::sqrt(2.0 / RIPPLES as f64);
        let ripple = |_| {
            let octave = texture.octaves * (stream.uniform() - 0.5);
            let number = TAU / (texture.wavelength_mm * libm::exp2(octave)).max(1e-3);
            let direction = TAU * stream.uniform();
            Ripple {
                along: number * libm::cos(direction),
                across: number * libm::sin(direction),
                phase: TAU * stream.uniform(),
                height_mm,
            }
        };
        Self {
            ripples: (0..RIPPLES).map(ripple).collect(),
            lag_s,
        }
    }

    /// Height under a patch of the skin around (`along`, `across`), mm, at a sliding speed in mm/s: asperities
    /// smaller than the patch average out as the root of their number, and fast ones drown in the silicone.
    pub fn height(&self, along: f64, across: f64, speed: f64) -> f64 {
        let part = |r: &Ripple| {
            let angle = r.along * along + r.across * across + r.phase;
            r.height_mm * self.passed(r, speed, PATCH_MM) * libm::sin(angle)
        };
        self.ripples.iter().map(part).sum()
    }

    /// Slope along the stroke under the whole pad around (`along`, 0): what the relief adds to the coefficient of
    /// friction while the pad slides at `speed`, mm/s.
    pub fn slope(&self, along: f64, speed: f64) -> f64 {
        let part = |r: &Ripple| {
            let angle = r.along * along + r.phase;
            r.height_mm * r.along * self.passed(r, speed, PAD_MM) * libm::cos(angle)
        };
        self.ripples.iter().map(part).sum()
    }

    /// Acceleration along the stroke and towards the module, m/s2, of a body that rides on the whole pad at a travel in mm and
    /// a speed in mm/s: slopes turn its force in N, heights press by its stiffness in N/mm.
    pub(super) fn shakes(
        &self,
        riding: Riding,
        (travel, speed): (f64, f64),
        [force_n, stiffness]: [f64; 2],
    ) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for r in &self.ripples {
            let (angle, rate) = (r.along * travel + r.phase, r.along * speed);
            let height = r.height_mm * averaged(r, PAD_MM);
            sum[0] += riding.shaken(force_n * height * r.along, angle + FRAC_PI_2, rate);
            sum[1] += riding.shaken(stiffness * height, angle, rate);
        }
        sum
    }

    /// The share of a ripple that reaches the taxels under a field of `side_mm`.
    fn passed(&self, ripple: &Ripple, speed: f64, side_mm: f64) -> f64 {
        let turn = ripple.along * speed * self.lag_s;
        averaged(ripple, side_mm) / libm::sqrt(1.0 + turn * turn)
    }
}

/// The share of a ripple that a field of `side_mm` does not average out.
fn averaged(ripple: &Ripple, side_mm: f64) -> f64 {
    let number = libm::hypot(ripple.along, ripple.across);
    (TAU / number / side_mm).min(1.0)
}
