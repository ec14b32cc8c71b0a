//! A fast accelerometer on the finger that strokes: it sees what the taxels' rate and silicone keep from them.
//!
//! The module is a mass that rides on the spring of silicone and surface. Every ripple of the relief shakes it along and
//! across that spring, an impact and a slip let it ring: decaying sines, as contact transients are modelled (Okamura,
//! Cutkosky and Dennerlein 2001). Ripples are taken at their steady state for the speed of the moment.

use palpate_core::random::RandomStream;

/// Samples per second.
pub const ACCELEROMETER_HZ: u32 = 3000;
/// Milli-g per count, noise, counts, and the most that is told: a cheap MEMS part (ADXL345: 3.9 mg, 16 g; its noise at such a
/// rate from 0.75 counts at 100 Hz by the root of the bandwidth).
const COUNT_MG: f64 = 3.9;
const NOISE_COUNTS: f64 = 4.1;
const RANGE_COUNTS: f64 = 4095.0;
/// Mass that moves with the face of the module: the face itself and the tip of a finger, kg (assumed).
const MASS_KG: f64 = 0.02;
/// Damping of that mass, as a share of critical damping (assumed).
const DAMPING: f64 = 0.25;
/// Milli-g per m/s2.
const MG: f64 = 1000.0 / 9.806_65;

/// The mass on its spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Riding {
    /// Angular frequency of the undamped mass, rad/s.
    own: f64,
}

impl Riding {
    /// The mass on a spring of this stiffness.
    pub(super) fn on(stiffness_n_per_mm: f64) -> Self {
        let own = libm::sqrt(1000.0 * stiffness_n_per_mm.max(1e-3) / MASS_KG);
        Self { own }
    }

    /// Acceleration, m/s2, under a force of `newtons` sin(`angle`) between mass and surface, whose angle turns by `rate` rad/s:
    /// hardly any below its own frequency, the force over the mass above it.
    pub(super) fn shaken(&self, newtons: f64, angle: f64, rate: f64) -> f64 {
        let r = rate / self.own;
        let (spring, damper) = (1.0 - r * r, 2.0 * DAMPING * r);
        let gain = r * r / libm::hypot(spring, damper).max(1e-9);
        let late = libm::atan2(damper, spring);
        -newtons / MASS_KG * gain * libm::sin(angle - late)
    }

    /// Acceleration, m/s2, of the ringing mass `since` seconds after it met its spring at `mm_s` mm/s.
    pub(super) fn met(&self, mm_s: f64, since: f64) -> f64 {
        self.rings(since) * 1e-3 * mm_s * self.own
    }

    /// Acceleration, m/s2, of the ringing mass `since` seconds after a force of `newtons` let go.
    pub(super) fn let_go(&self, newtons: f64, since: f64) -> f64 {
        self.rings(since) * newtons / MASS_KG
    }

    fn rings(&self, since: f64) -> f64 {
        if since < 0.0 {
            return 0.0;
        }
        let turns = self.own * libm::sqrt(1.0 - DAMPING * DAMPING) * since;
        libm::exp(-DAMPING * self.own * since) * libm::sin(turns)
    }
}

/// Output of the accelerometer, counts of 3.9 mg, for an acceleration in m/s2.
pub(super) fn told(acceleration: [f64; 3], noise: &mut RandomStream) -> [i16; 3] {
    acceleration.map(|a| {
        let counts = a * MG / COUNT_MG + NOISE_COUNTS * noise.normal();
        libm::round(counts.clamp(-RANGE_COUNTS - 1.0, RANGE_COUNTS)) as i16
    })
}

/// Counts as milli-g.
pub fn milli_g(counts: i16) -> f64 {
    COUNT_MG * f64::from(counts)
}

#[cfg(test)]
#[path = "vibration_tests.rs"]
mod tests;
