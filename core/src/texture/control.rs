//! Control parameters of the wires from a latent coordinate, (3.2),
//! in integers: nothing of the network's last digits is left.

use crate::units::Duration;

/// A latent coordinate that stands for a property of surfaces, as training found it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatentDriver {
    /// Index of the coordinate, from 0.
    pub coordinate: usize,
    /// `true` where the property falls as the coordinate grows.
    pub falls: bool,
    /// The low end z_lo of its range.
    pub low: f32,
    /// The high end z_hi.
    pub high: f32,
}

/// A control parameter at both ends of roughness; either may be the larger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span<T> {
    /// Value for the smoothest texture.
    pub smooth: T,
    /// Value for the roughest texture.
    pub rough: T,
}

/// Control parameters from z: c1, c2 and c3 of the thesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Control {
    /// Delay from one wire's mean to that of a wire one gap further along the stroke: a larger one is a slower surface.
    pub delta_mu: Duration,
    /// Spread sigma of (3.1).
    pub sigma: Duration,
    /// f_PWM, millihertz: periods in which wires may pulse at all.
    pub rate_mhz: u32,
}

impl LatentDriver {
    /// Amount of the property in a latent vector, 0 to 1: the coordinate's place in the range, clamped. A vector
    /// without that coordinate has nothing of it.
    fn share(&self, latent: &[f32]) -> f64 {
        let (low, high) = (f64::from(self.low), f64::from(self.high));
        let Some(&z) = latent.get(self.coordinate) else {
            return 0.0;
        };
        let part = (f64::from(z) - low) / (high - low);
        // Written so that a NaN is 0.
        let part = if part > 0.0 { part.min(1.0) } else { 0.0 };
        if self.falls { 1.0 - part } else { part }
    }

    /// Checks that the range is one: finite, its low end below its high end.
    fn check(&self) -> Result<(), ControlError> {
        let Self { low, high, .. } = *self;
        let fits = low.is_finite() && high.is_finite() && low < high;
        fits.then_some(()).ok_or(ControlError::Latent)
    }
}

/// The coordinates that drive wires.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drivers {
    /// Says how pulses are spaced and spread.
    pub roughness: LatentDriver,
    /// Says how slowly the surface slides; where none stands for friction, roughness says that too, as in the thesis.
    pub friction: Option<LatentDriver>,
    /// Says what is felt where a surface is met and left.
    pub hardness: Option<LatentDriver>,
}

impl From<LatentDriver> for Drivers {
    fn from(roughness: LatentDriver) -> Self {
        Self {
            roughness,
            friction: None,
            hardness: None,
        }
    }
}

/// (3.2) for all three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlMap {
    drivers: Drivers,
    delta_mu: Span<Duration>,
    sigma: Span<Duration>,
    rate_mhz: Span<u32>,
}

/// Reasons for which a map is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ControlError {
    /// The driving coordinate's range is empty, or not finite.
    #[error("a finite z_lo below z_hi")]
    Latent,
    /// A spread of zero.
    #[error("a spread above 0")]
    Sigma,
    /// A rate of zero.
    #[error("a rate above 0 Hz")]
    Rate,
}

impl ControlMap {
    /// A map over the drivers' ranges: sigma and the rate go with roughness, delta mu with friction.
    ///
    /// # Errors
    /// [`ControlError`] says what was expected.
    pub fn new(
        drivers: Drivers,
        delta_mu: Span<Duration>,
        sigma: Span<Duration>,
        rate_mhz: Span<u32>,
    ) -> Result<Self, ControlError> {
        drivers.roughness.check()?;
        let others = [drivers.friction, drivers.hardness];
        let mut others = others.iter().flatten();
        others.try_for_each(LatentDriver::check)?;
        if sigma.smooth.as_micros().min(sigma.rough.as_micros()) == 0 {
            return Err(ControlError::Sigma);
        }
        if rate_mhz.smooth.min(rate_mhz.rough) == 0 {
            return Err(ControlError::Rate);
        }
        Ok(Self {
            drivers,
            delta_mu,
            sigma,
            rate_mhz,
        })
    }

    /// Roughness of a latent vector, 0 to 1: its place in the driver's
    /// range, clamped. A vector without that coordinate is smooth.
    pub fn roughness(&self, latent: &[f32]) -> f64 {
        self.drivers.roughness.share(latent)
    }

    /// Hardness of a latent vector, 0 to 1, where a coordinate says so.
    pub fn hardness(&self, latent: &[f32]) -> Option<f64> {
        Some(self.drivers.hardness?.share(latent))
    }

    /// (3.2) with clamping.
    pub fn control(&self, latent: &[f32]) -> Control {
        let rough = self.roughness(latent);
        let slow = self.drivers.friction.map_or(rough, |f| f.share(latent));
        let between = |ends: Span<u64>, share: f64| {
            let (smooth, span) = (ends.smooth as f64, ends.rough as f64 - ends.smooth as f64);
            libm::rint(smooth + span * share) as u64 // never negative: both ends are not
        };
        let time = |ends: Span<Duration>, share| {
            let ends = Span {
                smooth: ends.smooth.as_micros(),
                rough: ends.rough.as_micros(),
            };
            Duration::from_micros(between(ends, share))
        };
        let rate = Span {
            smooth: u64::from(self.rate_mhz.smooth),
            rough: u64::from(self.rate_mhz.rough),
        };
        Control {
            delta_mu: time(self.delta_mu, slow),
            sigma: time(self.sigma, rough),
            rate_mhz: between(rate, rough) as u32,
        }
    }
}

#[cfg(test)]
#[path = "control_tests.rs"]
mod tests;
