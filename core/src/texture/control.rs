//! From a latent coordinate to what drives the wires, (3.2), in integers: nothing of the network's last digits is left.

use core::fmt;

use crate::units::Duration;

/// The latent coordinate that stands for roughness, as training found it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughnessDriver {
    /// Which coordinate, from 0.
    pub coordinate: usize,
    /// Whether roughness falls where it grows.
    pub falls: bool,
    /// The low end z_lo of its range.
    pub low: f32,
    /// The high end z_hi.
    pub high: f32,
}

/// A control parameter at both ends of roughness; either may be the larger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span<T> {
    /// For the smoothest texture.
    pub smooth: T,
    /// For the roughest.
    pub rough: T,
}

/// What z becomes: c1, c2 and c3 of the thesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Control {
    /// From one wire's mean to that of a wire one gap further along the stroke: a larger one is a slower surface.
    pub delta_mu: Duration,
    /// Spread sigma of (3.1).
    pub sigma: Duration,
    /// f_PWM, millihertz: periods in which wires may pulse at all.
    pub rate_mhz: u32,
}

/// (3.2) for all three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlMap {
    driver: RoughnessDriver,
    delta_mu: Span<Duration>,
    sigma: Span<Duration>,
    rate_mhz: Span<u32>,
}

/// Why a map is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlError {
    /// The driving coordinate's range is empty, or not finite.
    Latent,
    /// A spread of zero.
    Sigma,
    /// A rate of zero.
    Rate,
}

impl fmt::Display for ControlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Latent => "a finite z_lo below z_hi",
            Self::Sigma => "a spread above 0",
            Self::Rate => "a rate above 0 Hz",
        })
    }
}

impl core::error::Error for ControlError {}

impl ControlMap {
    /// A map over a driver's range.
    ///
    /// # Errors
    /// [`ControlError`] says what was expected.
    pub fn new(
        driver: RoughnessDriver,
        delta_mu: Span<Duration>,
        sigma: Span<Duration>,
        rate_mhz: Span<u32>,
    ) -> Result<Self, ControlError> {
        let RoughnessDriver { low, high, .. } = driver;
        if !(low.is_finite() && high.is_finite() && low < high) {
            return Err(ControlError::Latent);
        }
        if sigma.smooth.as_micros().min(sigma.rough.as_micros()) == 0 {
            return Err(ControlError::Sigma);
        }
        if rate_mhz.smooth.min(rate_mhz.rough) == 0 {
            return Err(ControlError::Rate);
        }
        Ok(Self {
            driver,
            delta_mu,
            sigma,
            rate_mhz,
        })
    }

    /// How rough a latent vector is, 0 to 1: its place in the driver's range, clamped. A vector without that
    /// coordinate is smooth.
    pub fn roughness(&self, latent: &[f32]) -> f64 {
        let RoughnessDriver {
            coordinate,
            falls,
            low,
            high,
        } = self.driver;
        let (low, high) = (f64::from(low), f64::from(high));
        let Some(&z) = latent.get(coordinate) else {
            return 0.0;
        };
        let part = (f64::from(z) - low) / (high - low);
        // Written so that a NaN is 0.
        let part = if part > 0.0 { part.min(1.0) } else { 0.0 };
        if falls { 1.0 - part } else { part }
    }

    /// (3.2) with clamping.
    pub fn control(&self, latent: &[f32]) -> Control {
        let rough = self.roughness(latent);
        let between = |ends: Span<u64>| {
            let (smooth, span) = (ends.smooth as f64, ends.rough as f64 - ends.smooth as f64);
            libm::rint(smooth + span * rough) as u64 // never negative: both ends are not
        };
        let time = |ends: Span<Duration>| {
            Duration::from_micros(between(Span {
                smooth: ends.smooth.as_micros(),
                rough: ends.rough.as_micros(),
            }))
        };
        let rate = Span {
            smooth: u64::from(self.rate_mhz.smooth),
            rough: u64::from(self.rate_mhz.rough),
        };
        Control {
            delta_mu: time(self.delta_mu),
            sigma: time(self.sigma),
            rate_mhz: between(rate) as u32,
        }
    }
}

#[cfg(test)]
#[path = "control_tests.rs"]
mod tests;
