//! A stand-in for the person: which wires are felt, how strongly, and where the phantom is.
//!
//! What is felt of a wire is the change of its length with every pulse. The model gives that change
//! (thermal strain; plain play shows no phase cycling at 200 Hz); how much of it arrives at the skin
//! as displacement is one fitted gain, and is labelled so.

use crate::wire::record::Burst;
use palpate_core::physics::WireParameters;

/// Which centroid is felt. The literature disagrees; report both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Centroid {
    /// Weights are squared amplitudes (Israr and Poupyrev).
    #[default]
    Energy,
    /// Weights are amplitudes.
    Amplitude,
}

/// The person's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerceiverParameters {
    /// Displacement of the skin per change of the wire's length, 1. **Fitted**: full drive of the final
    /// module changes the length by 0.46 um a pulse and shall give the 10 um that were measured on
    /// the first prototype; not measured on this one.
    pub fitted_gain: f64,
    /// Smallest displacement felt near 200 Hz by a contact of this size, um. Assumed: a tenth of full
    /// drive, so that a wire with an activation under 0.10 is not felt.
    pub threshold_um: f64,
    /// Expansion that turns ripple into strain when only energy is known, 1/K (austenite).
    pub expansion: f64,
    /// Pulses after which a burst is felt as strongly as it will be. Assumed: 7, a burst of 35 ms.
    pub full_pulses: u32,
    /// Which centroid is felt.
    pub centroid: Centroid,
}

impl Default for PerceiverParameters {
    fn default() -> Self {
        Self {
            fitted_gain: 21.6,
            threshold_um: 1.0,
            expansion: 11e-6,
            full_pulses: 7,
            centroid: Centroid::Energy,
        }
    }
}

/// A wire as the person meets it: where it is and how much it moves the skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vibration {
    /// Where the wire is, mm, in the display's plane.
    pub position_mm: (f64, f64),
    /// Felt displacement, um, as [`Perceiver`] computes it.
    pub amplitude_um: f64,
}

/// What is felt at one instant or of one stimulus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Felt {
    /// Where, mm, in the display's plane.
    pub position_mm: (f64, f64),
    /// How strong: root of the summed squares, um.
    pub amplitude_um: f64,
    /// Wires above threshold.
    pub wires: usize,
}

/// The person.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Perceiver {
    /// Gain, threshold and centroid.
    pub parameters: PerceiverParameters,
}

impl Perceiver {
    /// With these parameters.
    pub const fn new(parameters: PerceiverParameters) -> Self {
        Self { parameters }
    }

    /// Felt displacement of a wire that got `pulses` pulses of `pulse_j` joule each into itself (the
    /// wire's share, not the electrical energy), um.
    pub fn amplitude_of_pulses(&self, wire: &WireParameters, pulse_j: f64, pulses: u32) -> f64 {
        let ripple = pulse_j / wire.heat_capacity();
        self.amplitude(ripple * self.parameters.expansion, wire.length_m, pulses)
    }

    /// Felt displacement of a burst that the model has computed, from its thermal strain, um.
    pub fn amplitude_of_burst(&self, wire: &WireParameters, burst: &Burst) -> f64 {
        // The phase sets which expansion holds; the fit was made with one, so the ripple counts.
        self.amplitude(
            burst.ripple_k * self.parameters.expansion,
            wire.length_m,
            burst.pulses,
        )
    }

    fn amplitude(&self, strain: f64, length_m: f64, pulses: u32) -> f64 {
        let p = &self.parameters;
        let part = f64::from(pulses.min(p.full_pulses)) / f64::from(p.full_pulses.max(1));
        let um = p.fitted_gain * strain * length_m * 1e6 * libm::sqrt(part);
        if um.is_finite() { um.max(0.0) } else { 0.0 }
    }

    /// Whether a wire is felt at all.
    pub fn detects(&self, amplitude_um: f64) -> bool {
        amplitude_um >= self.parameters.threshold_um
    }

    /// Where the wires together are felt; `None` where no wire is above threshold: the phantom breaks.
    pub fn feel(&self, wires: &[Vibration]) -> Option<Felt> {
        let (mut x, mut y, mut weights, mut squares, mut count) = (0.0, 0.0, 0.0, 0.0, 0);
        for w in wires.iter().filter(|w| self.detects(w.amplitude_um)) {
            let square = w.amplitude_um * w.amplitude_um;
            let weight = match self.parameters.centroid {
                Centroid::Energy => square,
                Centroid::Amplitude => w.amplitude_um,
            };
            x += weight * w.position_mm.0;
            y += weight * w.position_mm.1;
            weights += weight;
            squares += square;
            count += 1;
        }
        (weights > 0.0).then(|| Felt {
            position_mm: (x / weights, y / weights),
            amplitude_um: libm::sqrt(squares),
            wires: count,
        })
    }
}
