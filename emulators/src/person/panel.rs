//! A **simulated** panel of people who rate textures, 1 to 6, as in the thesis's two studies (figures 3.4 and 3.6).
//!
//! No person has rated anything here. The model, all of it assumed:
//!
//! - Everybody was shown the ends of each scale beforehand (as in the studies): a rating is a place between them.
//! - Under the bare finger a surface is felt as its physics say, by published functions ([`bare_finger`]).
//! - On the display, roughness is coarseness: how far apart a wire's pulses are. Friction is slowness: how long what is
//!   felt takes from wire to wire, which the thesis calls a mere surrogate. Both are heard as logarithms, with an error
//!   of a Weber fraction, and only where the pulses are felt at all ([`crate::person::channels`]). Hardness is not there to be
//!   felt: the panel does not rate it, as in the thesis.
//! - A display's roughness and friction colour each other.
//! - Each person has a bias of their own in each dimension and a slip from trial to trial: small within a person, large
//!   between them. The bias is largest for friction, after the thesis; ratings end at 1 and 6, so their spread need not be.

use palpate_core::random::RandomStream;
use palpate_core::statistics::mean;

use crate::person::channels::Kick;
use crate::sensor::surface::{self, SurfaceTexture};

palpate_core::listed! {
    /// Dimension that is rated.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Dimension: name {
        /// Very soft to very hard.
        Hardness = "hardness",
        /// Very smooth to very rough.
        Roughness = "roughness",
        /// Very slippery to very sticky.
        Friction = "friction",
    }
}

impl Dimension {
    /// Standard deviation of people's biases, rating points.
    const fn bias(self) -> f64 {
        match self {
            Self::Hardness => 0.4,
            Self::Roughness => 0.7,
            Self::Friction => 0.9,
        }
    }
}

/// People of a panel, and how often each is shown a texture.
pub const SUBJECTS: u32 = 4;
/// Number of times that each texture is shown to each person.
pub const REPEATS: u32 = 3;
/// Trials of one texture.
pub const TRIALS: u32 = SUBJECTS * REPEATS;

/// Standard deviation of one person's ratings from trial to trial, points: mostly within one rating.
const SLIP: f64 = 0.4;
/// Weber fraction of coarseness and slowness.
const WEBER: f64 = 0.2;
/// The share of the other dimension in what is rated on a display.
const HALO: f64 = 0.25;

/// Pressure of a fingerpad on a surface, N/mm2: 1 N on 1 cm2. Assumed.
const PRESSURE_N_PER_MM2: f64 = 0.01;
/// Plane-strain modulus of a fingerpad, N/mm2. Assumed: Young's modulus of 0.05 over three quarters.
const SKIN_N_PER_MM2: f64 = 0.067;
/// Exponent by which roughness grows with the number of gaps under the finger. Assumed: published is that it grows, and that it
/// weighs less than the depth.
const GAPS: f64 = 0.5;

/// Roughness of a surface under a bare finger, any unit, by root mean square relief and wavelength in mm. Two components make up the skin's
/// deformation (Drewing 2016): the depth to which skin goes in between two elements, which grows with their distance until it
/// touches the ground, and the number of gaps under the finger, which falls with it. So roughness grows with the wavelength
/// of a high relief and falls with that of a low one.
///
/// An elastic half-space touches the ground of a sine of amplitude a where the pressure is at least pi E* a / lambda
/// (Johnson 1985); at a smaller one skin goes in as much less.
pub fn felt_roughness(relief_mm: f64, wavelength_mm: f64) -> f64 {
    let slope =
        PRESSURE_N_PER_MM2 / (core::f64::consts::SQRT_2 * core::f64::consts::PI * SKIN_N_PER_MM2);
    let depth_mm = relief_mm.min(slope * wavelength_mm);
    depth_mm * libm::pow(wavelength_mm, -GAPS)
}

/// Ratings by a bare finger of a surface whose friction is
/// against that finger: hardness, roughness and friction, 1 to 6.
///
/// - Hardness grows with a power of stiffness (Harper and Stevens 1964), roughness with one of what the skin is deformed
///   ([`felt_roughness`]). Of such continua people rate categories nearly by logarithms (Stevens and Galanter 1957), in
///   which a power is a factor: between the ends of a scale it cancels.
/// - On a line from slippery to sticky people place surfaces by their coefficient of friction (Smith and Scott 1996).
///
/// The ends that were shown are assumed: those of the emulated materials.
pub fn bare_finger(of: &SurfaceTexture) -> [f64; 3] {
    let share = |value: f64, (low, high): (f64, f64)| (value - low) / (high - low);
    let by_ratio = |value: f64, (low, high): (f64, f64)| {
        share(libm::log(value), (libm::log(low), libm::log(high)))
    };
    let (relief, wavelength) = (surface::RELIEF_MM, surface::WAVELENGTH_MM);
    // Coarse waves are the roughest of the highest relief and the smoothest of the lowest.
    let smoothest = felt_roughness(relief.0, wavelength.1);
    let roughest = felt_roughness(relief.1, wavelength.1);
    let shares = [
        by_ratio(of.stiffness_n_per_mm, surface::STIFFNESS_N_PER_MM),
        by_ratio(
            felt_roughness(of.relief_mm, of.wavelength_mm),
            (smoothest, roughest),
        ),
        share(of.friction, surface::FRICTION),
    ];
    shares.map(|share| 1.0 + 5.0 * share.clamp(0.0, 1.0))
}

/// Sensation of a stimulus of the display, before anybody rates it: logarithms of coarseness and slowness; `None` where
/// nothing was felt, or no motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensation {
    /// Logarithm of the seconds from pulse to pulse on a wire.
    pub coarseness: Option<f64>,
    /// Logarithm of the seconds from wire to wire.
    pub slowness: Option<f64>,
}

/// The ends of the scales, as they were shown beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleEnds {
    /// Sensation that is rated 1.
    pub smooth: Sensation,
    /// Sensation that is rated 6.
    pub rough: Sensation,
}

/// A panel; the same seed, the same people.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Panel {
    seed: u64,
}

impl Panel {
    /// The people of a seed.
    pub const fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// Bias of a person.
    fn bias(self, subject: u32, dimension: Dimension) -> f64 {
        let name = format!("subject {subject} {}", dimension.name());
        dimension.bias() * RandomStream::new(self.seed, &name).normal()
    }

    fn rating(self, trial: u32, dimension: Dimension, felt: f64, stream: &mut RandomStream) -> u8 {
        let rated = felt + self.bias(trial % SUBJECTS, dimension) + SLIP * stream.normal();
        libm::round(rated).clamp(1.0, 6.0) as u8
    }

    /// A trial with the bare finger: hardness, roughness, friction of a surface that is [felt](bare_finger) so.
    pub fn bare(self, texture: &str, trial: u32, felt: [f64; 3]) -> [u8; 3] {
        let mut stream = RandomStream::new(self.seed, &format!("bare {texture} {trial}"));
        let mut rate = |(d, felt): (Dimension, f64)| self.rating(trial, d, felt, &mut stream);
        let [h, r, f] = Dimension::ALL;
        [rate((h, felt[0])), rate((r, felt[1])), rate((f, felt[2]))]
    }

    /// A trial on the display: roughness and friction.
    pub fn display(self, texture: &str, trial: u32, felt: Sensation, ends: &ScaleEnds) -> [u8; 2] {
        let mut stream = RandomStream::new(self.seed, &format!("display {texture} {trial}"));
        let mut place = |felt: Option<f64>, low: Option<f64>, high: Option<f64>| {
            let heard = felt.map(|log| log + WEBER * stream.normal());
            match (heard, low, high) {
                (Some(at), Some(low), Some(high)) if high > low => {
                    (1.0 + 5.0 * (at - low) / (high - low)).clamp(1.0, 6.0)
                }
                // What cannot be felt, or is the same at both ends, is rated in the middle.
                _ => 3.5,
            }
        };
        let (smooth, rough) = (ends.smooth, ends.rough);
        let coarseness = place(felt.coarseness, smooth.coarseness, rough.coarseness);
        let slow = place(felt.slowness, smooth.slowness, rough.slowness);
        let coloured = |own: f64, other: f64| own + HALO * (other - own);
        [
            self.rating(
                trial,
                Dimension::Roughness,
                coloured(coarseness, slow),
                &mut stream,
            ),
            self.rating(
                trial,
                Dimension::Friction,
                coloured(slow, coarseness),
                &mut stream,
            ),
        ]
    }
}

/// Pulses of a wire further apart than this are felt apart, s.
const APART_S: f64 = 0.1;

/// Time between pulses on a wire, s: the geometric mean over all wires, while one pulse follows another.
pub fn apart_s(wires: &[Vec<Kick>]) -> Option<f64> {
    let gaps = wires.iter().flat_map(|kicks| kicks.windows(2));
    let gaps = gaps.map(|two| two[1].at_s - two[0].at_s);
    let logs = gaps
        .filter(|gap| *gap > 0.0 && *gap < APART_S)
        .map(libm::log);
    mean(logs).map(libm::exp)
}

/// Spacing of the envelopes that motion is read from, s.
const GRID_S: f64 = 0.005;
/// Time constant over which pulses of a wire become one, s.
const SMOOTH_S: f64 = 0.03;
/// The longest way from wire to wire that is one motion, s.
const LONGEST_S: f64 = 0.3;

/// Time that a sensation takes from one position to the next, s: the delay at which neighbours' pulses agree best.
/// Positions are in the order of the stroke, each with its pulses; `None` where there is no such delay.
pub fn step_s(positions: &[Vec<Kick>], seconds: f64) -> Option<f64> {
    let count = (seconds / GRID_S) as usize;
    let envelope = |kicks: &Vec<Kick>| -> Vec<f64> {
        let value = |n: usize| {
            let each = |k: &Kick| {
                let far = (n as f64 * GRID_S - k.at_s) / SMOOTH_S;
                k.um * libm::exp(-0.5 * far * far)
            };
            kicks.iter().map(each).sum::<f64>()
        };
        let mut all: Vec<f64> = (0..count).map(value).collect();
        let mean = mean(all.iter().copied()).unwrap_or(0.0);
        all.iter_mut().for_each(|v| *v -= mean);
        all
    };
    let envelopes: Vec<Vec<f64>> = positions.iter().map(envelope).collect();
    let agreement = |lag: usize| -> f64 {
        let pair = |two: &[Vec<f64>]| -> f64 {
            let late = two[1].iter().skip(lag);
            let products = two[0].iter().zip(late).map(|(a, b)| a * b);
            products.sum::<f64>() / (count - lag) as f64
        };
        envelopes.windows(2).map(pair).sum()
    };
    let longest = ((LONGEST_S / GRID_S) as usize).min(count.saturating_sub(1));
    let (lag, best) = (0..=longest)
        .map(|lag| (lag, agreement(lag)))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    (best > 0.0 && lag > 0).then_some(lag as f64 * GRID_S)
}

#[cfg(test)]
#[path = "panel_tests.rs"]
mod tests;
