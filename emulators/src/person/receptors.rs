//! Two receptor channels of a fingertip: how strong a train of pulses feels to each.
//!
//! A pulse lifts the tissue, which then sinks back: a step that dies away. Each channel takes the part of the pulses'
//! spectrum that it is tuned to, over its own threshold, and grows as a power of it (Stevens). Both together feel as
//! strong as the stronger and half the weaker (Hollins and Roy 1996). The Pacinian channel adds up over the tissue, the
//! other, of Meissner's corpuscles, does not (Gescheider, Bolanowski et al.).
//!
//! **Fitted and assumed**: the Pacinian threshold is set so that it agrees with the perceiver's fitted one; the other's
//! lies 20 dB above it, as for a contact of 5 mm; slopes, exponent and the tissue's relaxation are round numbers near the
//! published ones. This module has not been measured on tissue.

use core::f64::consts::TAU;

/// One channel's threshold, a straight line on either side of its best frequency (both axes logarithmic).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceptorChannel {
    /// The frequency that it hears best, Hz.
    pub best_hz: f64,
    /// Amplitude of a sine that is just felt there, um.
    pub threshold_um: f64,
    /// Power of the frequency by which the threshold rises on either side: 2 are 12 dB an octave.
    pub slope: f64,
}

impl ReceptorChannel {
    /// Amplitude of a sine at `hz` that is just felt, um.
    pub fn threshold(&self, hz: f64) -> f64 {
        let octaves = libm::fabs(libm::log2(hz / self.best_hz));
        self.threshold_um * libm::exp2(self.slope * octaves)
    }
}

/// One pulse as the tissue meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kick {
    /// When, seconds since the stimulus began.
    pub at_s: f64,
    /// By how much the tissue is lifted, um.
    pub um: f64,
}

/// What both channels make of a stimulus, in multiples of what is just felt; 0 below that.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Intensity {
    /// Of the Pacinian channel.
    pub pacinian: f64,
    /// Of the channel of Meissner's corpuscles.
    pub meissner: f64,
}

impl Intensity {
    /// How strong it feels: the stronger channel and half the weaker.
    pub fn felt(&self) -> f64 {
        let (strong, weak) = (
            self.pacinian.max(self.meissner),
            self.pacinian.min(self.meissner),
        );
        strong + weak / 2.0
    }
}

/// The person's channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receptors {
    /// Smooth vibration, best at 250 Hz.
    pub pacinian: ReceptorChannel,
    /// Flutter, best at 40 Hz.
    pub meissner: ReceptorChannel,
    /// Exponent of both growths.
    pub exponent: f64,
    /// Time in which the tissue sinks back to a part e, s: the wire's cooling.
    pub relaxation_s: f64,
}

/// Frequencies that are looked at, Hz.
const BAND: (f64, f64) = (5.0, 600.0);
/// How long the Pacinian channel adds up, s (Verrillo 1965): a stimulus is as strong as its strongest stretch.
const ADDS_UP_S: f64 = 0.2;
/// The train that thresholds are held against: rate in Hz and pulses, as long as that.
const REFERENCE: (f64, usize) = (196.89, 39);

impl Receptors {
    /// Channels of which the Pacinian one just feels a long train at f_PWM whose pulses lift the tissue by
    /// `threshold_um`: what the perceiver calls its threshold.
    pub fn fitted(threshold_um: f64) -> Self {
        let mut receptors = Self {
            pacinian: ReceptorChannel {
                best_hz: 250.0,
                threshold_um: 1.0,
                slope: 2.0,
            },
            meissner: ReceptorChannel {
                best_hz: 40.0,
                threshold_um: 1.0,
                slope: 1.0,
            },
            exponent: 0.9,
            relaxation_s: 0.025,
        };
        let (rate, count) = REFERENCE;
        let train: Vec<Kick> = (0..count)
            .map(|n| Kick {
                at_s: n as f64 / rate,
                um: threshold_um,
            })
            .collect();
        let [heard, _] = receptors.drives(&train, count as f64 / rate);
        receptors.pacinian.threshold_um = heard;
        receptors.meissner.threshold_um = 10.0 * heard;
        receptors
    }

    /// Amplitude of the sine that would drive each channel as much, over its threshold: Pacinian, Meissner.
    fn drives(&self, kicks: &[Kick], seconds: f64) -> [f64; 2] {
        // Fine enough for the lines of a train that lasts as long.
        let step = 1.0 / (4.0 * seconds.max(0.02));
        let count = ((BAND.1 - BAND.0) / step) as usize;
        let phasor = |hz: f64, kick: &Kick| {
            let angle = TAU * hz * kick.at_s;
            (libm::cos(angle), -libm::sin(angle))
        };
        let mut turns: Vec<_> = kicks
            .iter()
            .map(|k| (k.um, phasor(BAND.0, k), phasor(step, k)))
            .collect();
        let mut sums = [0.0; 2];
        for n in 0..count {
            let hz = BAND.0 + n as f64 * step;
            let (mut re, mut im) = (0.0, 0.0);
            for (um, now, by) in &mut turns {
                re += *um * now.0;
                im += *um * now.1;
                *now = (now.0 * by.0 - now.1 * by.1, now.0 * by.1 + now.1 * by.0);
            }
            let (rate, turn) = (1.0 / self.relaxation_s, TAU * hz);
            let power = (re * re + im * im) / (rate * rate + turn * turn);
            for (sum, channel) in sums.iter_mut().zip([self.pacinian, self.meissner]) {
                let threshold = channel.threshold(hz);
                *sum += power / (threshold * threshold);
            }
        }
        // A sine of amplitude A has a mean square of A^2/2, and both signs of its frequency half of that.
        sums.map(|sum| libm::sqrt(4.0 * step * sum / seconds))
    }

    /// What a stimulus of `seconds` feels like where it is strongest, wire by wire.
    pub fn intensity(&self, wires: &[Vec<Kick>], seconds: f64) -> Intensity {
        let length = seconds.min(ADDS_UP_S);
        let steps = ((seconds - length) / (length / 2.0)) as usize;
        let stretch = |n: usize| {
            let from = n as f64 * length / 2.0;
            let inside = |k: &&Kick| k.at_s >= from && k.at_s < from + length;
            let of_wire = |kicks: &Vec<Kick>| kicks.iter().filter(inside).copied().collect();
            let wires: Vec<Vec<Kick>> = wires.iter().map(of_wire).collect();
            self.stretch(&wires, length)
        };
        (0..=steps)
            .map(stretch)
            .max_by(|a, b| a.felt().total_cmp(&b.felt()))
            .unwrap_or_default()
    }

    fn stretch(&self, wires: &[Vec<Kick>], seconds: f64) -> Intensity {
        let (mut pacinian, mut meissner) = (0.0, 0.0_f64);
        for kicks in wires.iter().filter(|kicks| !kicks.is_empty()) {
            let [p, m] = self.drives(kicks, seconds);
            pacinian += p * p;
            meissner = meissner.max(m);
        }
        let grown = |drive: f64| match drive {
            felt if felt >= 1.0 => libm::pow(felt, self.exponent),
            _ => 0.0,
        };
        Intensity {
            pacinian: grown(libm::sqrt(pacinian)),
            meissner: grown(meissner),
        }
    }
}

#[cfg(test)]
#[path = "receptors_tests.rs"]
mod tests;
