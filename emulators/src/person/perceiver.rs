//! A stand-in for the person: which wires are felt, how strongly, and where the phantom is.
//!
//! What is felt of a wire is the change of its length with every pulse. The model gives that change
//! (thermal strain; plain play shows no phase cycling at 200 Hz); how much of it arrives at the tissue
//! as displacement is one fitted gain, and is labelled so.

use crate::display::wire::burst::WireBurst;
use palpate_core::physics::WireParameters;

/// Which centroid is felt. The literature disagrees; every score is given for both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Centroid {
    /// Weights are squared amplitudes (Israr and Poupyrev).
    Energy,
    /// Weights are amplitudes.
    Amplitude,
}

impl Centroid {
    /// Its name in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Energy => "energy centroid",
            Self::Amplitude => "amplitude centroid",
        }
    }
}

/// The person's parameters; `fixtures/perceivers` has their values and where they come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerceiverParameters {
    /// Displacement of the tissue per change of the wire's length, 1. **Fitted.**
    pub fitted_gain: f64,
    /// Smallest displacement felt near 200 Hz by a contact of this size, um. **Fitted.**
    pub threshold_um: f64,
    /// Expansion that turns ripple into strain when only energy is known, 1/K (austenite).
    pub expansion: f64,
    /// Pulses after which a burst is felt as strongly as it will be.
    pub full_pulses: u32,
}

/// A wire as the person meets it: where it is and how much it moves the tissue.
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
    /// Where by the energy centroid, mm, in the display's plane.
    pub energy_mm: (f64, f64),
    /// Where by the amplitude centroid.
    pub amplitude_mm: (f64, f64),
    /// How strong: root of the summed squares, um.
    pub amplitude_um: f64,
    /// Wires above threshold.
    pub wires: usize,
}

impl Felt {
    /// Where by one of the two centroids, mm.
    pub const fn place(&self, centroid: Centroid) -> (f64, f64) {
        match centroid {
            Centroid::Energy => self.energy_mm,
            Centroid::Amplitude => self.amplitude_mm,
        }
    }
}

/// The person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perceiver {
    /// Gain and threshold.
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
    pub fn amplitude_of_burst(&self, wire: &WireParameters, burst: &WireBurst) -> f64 {
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
        let (mut energy, mut amplitude) = (Mean::default(), Mean::default());
        let mut count = 0;
        for w in wires.iter().filter(|w| self.detects(w.amplitude_um)) {
            energy.add(w.amplitude_um * w.amplitude_um, w.position_mm);
            amplitude.add(w.amplitude_um, w.position_mm);
            count += 1;
        }
        (energy.weights > 0.0).then(|| Felt {
            energy_mm: energy.place(),
            amplitude_mm: amplitude.place(),
            amplitude_um: libm::sqrt(energy.weights),
            wires: count,
        })
    }
}

/// A weighted mean of places.
#[derive(Default)]
struct Mean {
    weights: f64,
    x: f64,
    y: f64,
}

impl Mean {
    fn add(&mut self, weight: f64, (x, y): (f64, f64)) {
        self.weights += weight;
        self.x += weight * x;
        self.y += weight * y;
    }

    fn place(&self) -> (f64, f64) {
        (self.x / self.weights, self.y / self.weights)
    }
}

#[cfg(test)]
#[path = "perceiver_tests.rs"]
mod tests;
