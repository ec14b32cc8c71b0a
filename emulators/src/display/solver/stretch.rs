//! Stretches of a wire that a person's model reads: in each, everything is a sum of exponentials.

use super::modal::ModeKey;
use crate::display::finger::NODES;

/// A stretch of constant drive in one regime, from event to event or shorter.
///
/// The tissue's displacement is affine in the wire's temperature there, and continuous from stretch to stretch. Its
/// slope is therefore enough: the offset is that of the stretch before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Length, s.
    pub seconds: f64,
    /// True while current flows.
    pub driven: bool,
    /// Displacement of the tissue per kelvin of the wire, um/K; 0 of a wire that is not worn.
    pub um_per_k: f64,
    /// The regime, which gives the rates.
    pub regime: ModeKey,
    /// Decay rates, 1/s.
    pub rates: [f64; NODES],
    /// Slope of the wire's temperature by rate, at the start, K/s.
    pub slopes: [f64; NODES],
}

impl Stretch {
    /// A stretch of `seconds` in which nothing moves the tissue.
    pub const fn rest(seconds: f64) -> Self {
        Self::sinking(seconds, 0.0, 0.0)
    }

    /// A stretch of `seconds` without a wire, in which tissue that was lifted by `um` sinks back at `rate`, 1/s.
    pub const fn sinking(seconds: f64, um: f64, rate: f64) -> Self {
        let (mut rates, mut slopes) = ([0.0; NODES], [0.0; NODES]);
        (rates[0], slopes[0]) = (rate, -um * rate);
        Self {
            seconds,
            driven: false,
            um_per_k: 1.0,
            regime: ModeKey {
                latent: -1.0,
                feedback: rate,
            },
            rates,
            slopes,
        }
    }
}
