//! Pulses from control parameters: the Gaussian activation (3.1) as a probability per PWM period, and its two draws.
//!
//! A stroke takes the interval T and begins again. The carrier's frequency stays: all channels of a PCA9685 share one,
//! and changing it means sleep, 500 us and a restart, with tick lengths that the guard does not know. f_PWM is made of
//! skipped periods instead, evenly spread, which also goes below the chip's 24 Hz.

use alloc::boxed::Box;
use alloc::format;

use crate::random::RandomStream;
use crate::render::Density;
use crate::units::{Duration, Instant, Point, Prescale};

use super::control::Control;

/// One, in the integers that probabilities are compared in.
const ONE: u32 = 1 << 24;

/// Method by which pulses are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Draw {
    /// Each period by itself, seeded: the thesis's.
    #[default]
    Bernoulli,
    /// Error diffusion: the same density, never more than one pulse from it.
    Diffusion,
}

/// The constants of (3.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Activation {
    alpha: f64,
    beta: f64,
    lead: Duration,
    interval: Duration,
}

/// Reasons for which constants are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ActivationError {
    /// alpha and beta are not probabilities with a sum below 1.
    #[error("alpha and beta from 0 on, with a sum below 1")]
    Sum,
    /// The interval is zero.
    #[error("an interval above 0")]
    Interval,
}

impl Activation {
    /// Offset alpha, gain beta, the mean mu of the first wire, and the interval T.
    ///
    /// # Errors
    /// [`ActivationError`] says what was expected.
    pub fn new(
        alpha: f64,
        beta: f64,
        lead: Duration,
        interval: Duration,
    ) -> Result<Self, ActivationError> {
        if !(alpha >= 0.0 && beta >= 0.0 && alpha + beta < 1.0) {
            return Err(ActivationError::Sum);
        }
        if interval.as_micros() == 0 {
            return Err(ActivationError::Interval);
        }
        Ok(Self {
            alpha,
            beta,
            lead,
            interval,
        })
    }

    /// A_n(t) of (3.1) at a time within the interval, for a wire `gaps` gaps along the stroke.
    pub fn probability(&self, within: Duration, gaps: f32, control: &Control) -> f64 {
        let mu =
            self.lead.as_micros() as f64 + f64::from(gaps) * control.delta_mu.as_micros() as f64;
        let sigma = control.sigma.as_micros() as f64;
        let far = (within.as_micros() as f64 - mu) / sigma;
        self.alpha + self.beta * libm::exp(-0.5 * far * far)
    }
}

/// The square root of 2 pi: the area under a Gaussian of height and spread 1.
const GAUSSIAN: f64 = 2.506_628_274_631;

/// Places of wires along the longer side of their array, in gaps of `gap` mm from the first.
pub fn along(places: &[Point], gap: f32) -> Box<[f32]> {
    let span = |of: fn(&Point) -> f32| {
        let (low, high) = places
            .iter()
            .map(of)
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| {
                (l.min(v), h.max(v))
            });
        (low, high - low)
    };
    let (left, width) = span(|p| p.x);
    let (bottom, height) = span(|p| p.y);
    let of = |p: &Point| {
        if width >= height {
            p.x - left
        } else {
            p.y - bottom
        }
    };
    places.iter().map(|p| of(p) / gap).collect()
}

/// One wire's draw.
#[derive(Clone, Debug)]
struct Wire {
    gaps: f32,
    random: RandomStream,
    owed: u32,
}

/// Pulses of every wire, period by period.
#[derive(Clone, Debug)]
pub struct Pulses {
    activation: Activation,
    draw: Draw,
    period_ns: u64,
    wires: Box<[Wire]>,
    fired: Box<[bool]>,
    periods: u64,
    /// Parts of a period of f_PWM that have passed since the last one, in 1e-12.
    phase: u64,
}

impl Pulses {
    /// Pulses for wires at these places along the stroke, in gaps. Wire n draws from `texture wire n` under `seed`.
    pub fn new(
        activation: Activation,
        draw: Draw,
        carrier: Prescale,
        gaps: &[f32],
        seed: u64,
    ) -> Self {
        let wire = |(n, &gaps): (usize, &f32)| Wire {
            gaps,
            random: RandomStream::new(seed, &format!("texture wire {n}")),
            owed: ONE / 2,
        };
        Self {
            activation,
            draw,
            period_ns: carrier.period_ns(),
            wires: gaps.iter().enumerate().map(wire).collect(),
            fired: alloc::vec![false; gaps.len()].into(),
            periods: 0,
            phase: 0,
        }
    }

    /// Start of the next period.
    pub const fn at(&self) -> Instant {
        Instant::from_micros(self.periods * self.period_ns / 1000)
    }

    /// Expected pulses, with every mean of (3.1) well within the interval.
    pub fn density(&self, control: &Control) -> Density {
        let Activation {
            alpha,
            beta,
            interval,
            ..
        } = self.activation;
        let [sigma_s, interval_s] = [control.sigma, interval].map(Duration::as_secs_f64);
        let carrier_hz = 1e9 / self.period_ns as f64;
        let rate_hz = (f64::from(control.rate_mhz) * 1e-3).min(carrier_hz);
        let pass = rate_hz * beta * (GAUSSIAN * sigma_s).min(interval_s);
        let each_hz = rate_hz * alpha + pass / interval_s;
        Density {
            pass: pass as f32,
            all_hz: (self.wires.len() as f64 * each_hz) as f32,
        }
    }

    /// Begins a stroke anew. The random streams go on.
    pub fn restart(&mut self) {
        (self.periods, self.phase) = (0, 0);
        self.wires.iter_mut().for_each(|wire| wire.owed = ONE / 2);
    }

    /// The next period: which wires pulse in it.
    pub fn next(&mut self, control: &Control) -> &[bool] {
        const WHOLE: u64 = 1_000_000_000_000; // 1e12: nanoseconds times millihertz
        let at = self.at().as_micros();
        self.periods += 1;
        self.phase += u64::from(control.rate_mhz) * self.period_ns;
        if self.phase < WHOLE {
            self.fired.fill(false);
            return &self.fired;
        }
        // A rate above the carrier's is the carrier's: nothing is owed.
        self.phase = (self.phase - WHOLE).min(WHOLE - 1);
        let within = Duration::from_micros(at % self.activation.interval.as_micros());
        for (wire, fired) in self.wires.iter_mut().zip(&mut self.fired) {
            let probability = self.activation.probability(within, wire.gaps, control);
            let part = (probability * f64::from(ONE)) as u32; // below ONE
            *fired = match self.draw {
                Draw::Bernoulli => ((wire.random.next_u64() >> 40) as u32) < part,
                Draw::Diffusion => {
                    wire.owed += part;
                    let due = wire.owed >= ONE;
                    wire.owed -= if due { ONE } else { 0 };
                    due
                }
            };
        }
        &self.fired
    }
}

#[cfg(test)]
#[path = "pulses_tests.rs"]
mod tests;
