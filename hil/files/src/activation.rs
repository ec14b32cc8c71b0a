//! Activation files: the control parameters on the wires that a texture's roughness becomes, (3.1) and (3.2).

use palpate_core::projector::{Firmness, Taps};
use palpate_core::texture::{Activation, ControlError, ControlMap, Drivers, Span};
use palpate_core::units::Duration;
use serde::Deserialize;

use super::error::FileError;
use super::settings::bounds;
use super::source::Source;

/// A control parameter at both ends of roughness.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Both {
    /// Value for the smoothest texture.
    pub smooth: f64,
    /// Value for the roughest texture.
    pub rough: f64,
}

/// A figure of taps at both ends of hardness.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BothFirm {
    /// Value for the softest surface.
    pub soft: f64,
    /// Value for the hardest surface.
    pub hard: f64,
}

/// Taps that are felt where a surface is met and left.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TapFile {
    /// Pulses per second, Hz; rates above the carrier's are felt no faster.
    pub rate_hz: BothFirm,
    /// Strength of the first pulse, a share of the strongest that the guard allows.
    pub strength: BothFirm,
    /// Time in which the strength falls to 1/e, ms.
    pub decay_ms: f64,
}

/// Constants of (3.1) and limits of (3.2).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ActivationFile {
    /// Name, in lower case with hyphens.
    pub name: String,
    /// The activation, in a sentence.
    pub description: String,
    /// The values that are neither published nor measured.
    pub assumed: Option<String>,
    /// Offset alpha, a probability per PWM period.
    pub alpha: f64,
    /// Gain beta; alpha + beta < 1.
    pub beta: f64,
    /// The interval T of a stroke, ms.
    pub interval_ms: f64,
    /// The mean mu of the first wire, ms.
    pub lead_ms: f64,
    /// Time from one wire's mean to the next one's, ms.
    pub delta_mu_ms: Both,
    /// Spread sigma, ms.
    pub sigma_ms: Both,
    /// f_PWM, Hz.
    pub rate_hz: Both,
    /// f_PWM within the bursts of a moving contact, Hz.
    pub burst_rate_hz: Both,
    /// Taps of hardness, where a surface is met and left; left out: hardness is not shown.
    pub tap: Option<TapFile>,
}

impl ActivationFile {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let file: Self = source.read()?;
        source.heading(&file.name, &file.description)?;
        bounds!(source, "", file;
            alpha: 0.0..=1.0;
            beta: 0.0..=1.0;
            interval_ms: 1.0..=1e5, "ms";
            lead_ms: 0.0..=1e5, "ms";
            delta_mu_ms.smooth: 0.0..=1e4, "ms";
            delta_mu_ms.rough: 0.0..=1e4, "ms";
            sigma_ms.smooth: 0.1..=1e4, "ms";
            sigma_ms.rough: 0.1..=1e4, "ms";
            rate_hz.smooth: 0.1..=1500.0, "Hz";
            rate_hz.rough: 0.1..=1500.0, "Hz";
            // Pulses further apart than 20 ms are bursts of their own.
            burst_rate_hz.smooth: 55.0..=1500.0, "Hz";
            burst_rate_hz.rough: 55.0..=1500.0, "Hz")?;
        if let Some(tap) = &file.tap {
            bounds!(source, "tap", tap;
                rate_hz.soft: 1.0..=1500.0, "Hz";
                strength.soft: 0.0..=1.0;
                rate_hz.hard: 1.0..=1500.0, "Hz";
                strength.hard: 0.0..=1.0;
                decay_ms: 0.1..=1e3, "ms")?;
        }
        let [lead, interval] = [file.lead_ms, file.interval_ms].map(millis);
        Activation::new(file.alpha, file.beta, lead, interval)
            .map_err(|e| source.bad("beta", e.to_string()))?;
        Ok(file)
    }

    /// Activation of (3.1) with these constants; none only for a file that was not read by [`Self::read`].
    pub fn activation(&self) -> Option<Activation> {
        let [lead, interval] = [self.lead_ms, self.interval_ms].map(millis);
        Activation::new(self.alpha, self.beta, lead, interval).ok()
    }

    /// Taps that carry hardness, if the activation has them.
    pub fn taps(&self) -> Option<Taps> {
        let tap = self.tap?;
        let rate = |hz: f64| (hz * 1e3).round() as u32;
        Some(Taps {
            rate_mhz: Firmness {
                soft: rate(tap.rate_hz.soft),
                hard: rate(tap.rate_hz.hard),
            },
            strength: Firmness {
                soft: tap.strength.soft as f32,
                hard: tap.strength.hard as f32,
            },
            decay: millis(tap.decay_ms),
        })
    }

    /// Control map of (3.2) with these limits, for a model's driving coordinates.
    ///
    /// # Errors
    /// A driver without a range.
    pub fn map(&self, drivers: Drivers) -> Result<ControlMap, ControlError> {
        self.with_rate(drivers, self.rate_hz)
    }

    /// The map for the bursts of a moving contact.
    ///
    /// # Errors
    /// A driver without a range.
    pub fn burst_map(&self, drivers: Drivers) -> Result<ControlMap, ControlError> {
        self.with_rate(drivers, self.burst_rate_hz)
    }

    fn with_rate(&self, drivers: Drivers, rate_hz: Both) -> Result<ControlMap, ControlError> {
        let time = |both: Both| Span {
            smooth: millis(both.smooth),
            rough: millis(both.rough),
        };
        let rate = |hz: f64| (hz * 1e3).round() as u32;
        let rates = Span {
            smooth: rate(rate_hz.smooth),
            rough: rate(rate_hz.rough),
        };
        ControlMap::new(drivers, time(self.delta_mu_ms), time(self.sigma_ms), rates)
    }
}

fn millis(ms: f64) -> Duration {
    Duration::from_micros((ms * 1e3).round() as u64)
}
