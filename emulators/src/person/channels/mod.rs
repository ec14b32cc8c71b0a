//! A person's perception of moving wires: two channels of the fingertip, how far over threshold each is, and where.
//!
//! `docs/felt.md` has the law and where every number comes from. In short: the displacement u under each wire goes through
//! the filters of both channels (`filter.rs`). The Pacinian one adds up energy with a leak of 0.2 s, over all wires:
//! q' = (2 y^2 - q) / 0.2 s, L_P = 10 log10(max q / a0^2). Of NP I the strongest wire counts: L_N = 20 log10(max |y| / a_N).
//! A person may have NP II too, of which the strongest wire counts by the first filter: L_II = 20 log10(max |y| / a_II).
//! Something is felt where a level reaches 0 dB. `threshold.rs` has a0 by the area that moves.
//!
//! Between events u is a sum of exponentials, so both filters are exact at any time. The energy's integrals are taken by
//! Gauss's rule on pieces so short that nothing but rounding is left of its error.

mod filter;
mod gauss;
mod piece;
mod threshold;
mod train;
mod wire;

use crate::display::solver::stretch::Stretch;
pub(super) use filter::gains;
use gauss::Gauss;
use palpate_core::physics::ParameterError;
use palpate_core::vector::Vectors;
pub(super) use piece::LEAK_S;
use piece::Tables;
pub use threshold::{AreaThreshold, sine_threshold_um};
pub use train::Kick;
use wire::{Met, Shared, WireFilter};

/// Spacing of the times at which the largest energy is looked for, s.
const LOOK_S: f64 = 0.25e-3;
/// Looks whose bounds are held against what is known, together.
const CELL: usize = 8;
/// Factor by which values between nodes may exceed a bound that is taken from the nodes.
const NEARER: f64 = 1.0 + 1e-6;
/// Shortest vibration, s; a shorter stimulus is a tap.
const VIBRATION_S: f64 = 0.03;
/// The least level there is, dB: silence.
pub(super) const SILENCE_DB: f64 = -200.0;
/// Colder tissue than this feels less of vibration, degrees C, and by how much, dB/K.
const COLD: (f64, f64) = (30.0, 0.8);
/// Hotter tissue feels less too, degrees C, by so much, dB.
const HOT: (f64, f64) = (44.0, 7.0);

/// A person's parameters; `fixtures/persons` has values and where they come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Person {
    /// a0: amplitude of a long sine at 250 Hz that the Pacinian channel just feels under one wire, um.
    pub vibration_um: f64,
    /// a_N: peak of the filtered displacement that the channel NP I just feels, um.
    pub flutter_um: f64,
    /// a_II: peak of the Pacinian filter's displacement that the channel NP II just feels, um; `None`: a person without
    /// it, as for every headline.
    pub np2_um: Option<f64>,
    /// Exponents by which what is felt grows with the amplitude: Pacinian channel, NP I.
    pub growth: [f64; 2],
}

fn above(name: &'static str, value: f64) -> Result<(), ParameterError> {
    match value.is_finite() && value > 0.0 {
        true => Ok(()),
        false => Err(ParameterError { name }),
    }
}

impl Person {
    pub(super) fn check_thresholds(&self) -> Result<(), ParameterError> {
        above("vibration_um", self.vibration_um)?;
        above("flutter_um", self.flutter_um)?;
        above("np2_um", self.np2_um.unwrap_or(1.0))
    }
}

/// Levels of the channels over their thresholds, dB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// The Pacinian channel: vibration.
    pub vibration_db: f64,
    /// NP I: flutter and taps.
    pub flutter_db: f64,
    /// NP II: short vibration of small areas; silent for a person without it.
    pub np2_db: f64,
}

impl Levels {
    /// Levels while nothing moves.
    pub const SILENT: Self = Self {
        vibration_db: SILENCE_DB,
        flutter_db: SILENCE_DB,
        np2_db: SILENCE_DB,
    };

    /// The highest one.
    pub const fn db(&self) -> f64 {
        self.vibration_db.max(self.flutter_db).max(self.np2_db)
    }

    /// Tells whether anything is felt: a channel is at or over its threshold.
    pub const fn felt(&self) -> bool {
        self.db() >= 0.0
    }

    /// Felt intensity, 1 at threshold: the stronger channel and half the weaker (Hollins and Roy 1996), each grown by
    /// its power. NP II feels vibration as the Pacinian channel does: the stronger of them counts. It is 0 where nothing
    /// is felt; a channel below threshold adds nothing.
    pub fn intensity(&self, growth: [f64; 2]) -> f64 {
        let grown = |db: f64, exponent: f64| match db >= 0.0 {
            true => libm::pow(10.0, exponent * db / 20.0),
            false => 0.0,
        };
        let (p, n) = (
            grown(self.vibration_db.max(self.np2_db), growth[0]),
            grown(self.flutter_db, growth[1]),
        );
        p.max(n) + p.min(n) / 2.0
    }
}

/// Stimulus at the finger since an onset, whether it is felt or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Felt {
    /// Levels over the thresholds.
    pub levels: Levels,
    /// Place by the energy centroid, mm, in the display's plane.
    pub energy_mm: (f64, f64),
    /// Place by the amplitude centroid, mm, in the display's plane.
    pub amplitude_mm: (f64, f64),
    /// Filtered energy of all wires without a leak: the integral of the squared Pacinian output, um2 s.
    pub energy: f64,
    /// Largest displacement of the tissue under any wire, from its lowest place to its highest, um.
    pub skin_um: f64,
    /// Time from the first current to the last, s.
    pub seconds: f64,
}

impl Felt {
    /// Tells whether the stimulus feels like a tap: shorter than 30 ms.
    pub const fn tap(&self) -> bool {
        self.seconds < VIBRATION_S
    }
}

/// A person with wires on a finger.
#[derive(Clone, Debug)]
pub struct Perceiver {
    person: Person,
    places: Vec<(f64, f64)>,
    wires: Vec<WireFilter>,
    shared: Shared,
    /// Leaky energy of all wires when the account began, um2, and the largest since the onset.
    energy: f64,
    most: f64,
    /// Time since the onset when the account began; first and last time at which current flowed, s.
    since_s: f64,
    driven: Option<(f64, f64)>,
}

impl Perceiver {
    /// A person with wires at these places, mm, all at rest.
    ///
    /// # Errors
    /// A threshold that is not above 0 or an exponent that is no number, by name.
    pub fn new(person: Person, places: &[(f64, f64)]) -> Result<Self, ParameterError> {
        person.check_thresholds()?;
        let mut growths = person.growth.into_iter();
        growths.try_for_each(|n| above("growth", n))?;
        Ok(Self {
            person,
            places: places.to_vec(),
            wires: vec![WireFilter::default(); places.len()],
            shared: Shared {
                rule: Gauss::new(),
                tables: Tables::default(),
                vectors: Vectors::widest(),
            },
            energy: 0.0,
            most: 0.0,
            since_s: 0.0,
            driven: None,
        })
    }

    /// The person's parameters.
    pub const fn person(&self) -> &Person {
        &self.person
    }

    /// Lets a stretch of a wire pass; a wire that is not there is left
    /// alone. A stretch that is not finite does not move the tissue.
    pub fn pass(&mut self, wire: usize, stretch: &Stretch) {
        let Some(filter) = self.wires.get_mut(wire) else {
            return;
        };
        let from = self.since_s + filter.now_s;
        filter.pass(&mut self.shared, stretch);
        if stretch.driven {
            let to = self.since_s + filter.now_s;
            self.driven_during(from, to);
        }
    }

    /// Lifts the tissue at a wire at once, um.
    pub fn lift(&mut self, wire: usize, um: f64) {
        if let Some(filter) = self.wires.get_mut(wire) {
            filter.lift(um);
            let now = self.since_s + filter.now_s;
            self.driven_during(now, now);
        }
    }

    fn driven_during(&mut self, from: f64, to: f64) {
        let (first, last) = self.driven.unwrap_or((from, to));
        self.driven = Some((first.min(from), last.max(to)));
    }

    /// Sums up what passed. All wires are let come to the same time; one that lags behind rests.
    pub fn settle(&mut self) {
        let end = self.wires.iter().map(|w| w.now_s).fold(0.0, f64::max);
        for wire in &mut self.wires {
            let lag = end - wire.now_s;
            if lag > 1e-9 {
                wire.pass(&mut self.shared, &Stretch::rest(lag));
            }
        }
        self.most = self.most.max(self.largest(end));
        self.energy = self.leaked(end, self.wires.iter().map(|w| w.energy).sum());
        self.since_s += end;
        self.wires.iter_mut().for_each(WireFilter::settle);
    }

    /// The leaky energy of all wires when the account was last settled, um2.
    pub const fn energy(&self) -> f64 {
        self.energy
    }

    /// The leaky energy at `t` where so much had flowed in until then.
    fn leaked(&self, t: f64, inflow: f64) -> f64 {
        (self.energy + inflow) * libm::exp(-t / LEAK_S)
    }

    /// Time before `end` from which the leaky energy only falls: it is
    /// larger than the inflow that would hold it, and that falls itself.
    fn falls_from(&self, end: f64) -> Option<f64> {
        let from = self.wires.iter().map(WireFilter::fades_from);
        let from = from.fold(0.0, f64::max);
        let (mut outputs, mut inflow) = (0.0, 0.0);
        for wire in &self.wires {
            let (square, before) = wire.fading_at(from);
            outputs += square;
            inflow += before;
        }
        let falls = from < end && NEARER * 2.0 * outputs <= self.leaked(from, inflow);
        falls.then_some(from)
    }

    /// The largest leaky energy of all wires together until `end`: at both ends, and every 0.25 ms where bounds do not
    /// tell that it is less than what is known.
    fn largest(&self, end: f64) -> f64 {
        let all: f64 = self.wires.iter().map(|w| w.energy).sum();
        let mut most = self.energy.max(self.leaked(end, all));
        if all == 0.0 {
            return most;
        }
        let cell_s = CELL as f64 * LOOK_S;
        // The first cell of those in which it only falls has its largest.
        let cells = match self.falls_from(end) {
            Some(from) => libm::ceil(from / cell_s) as usize + 1,
            None => usize::MAX,
        };
        let cells = cells.min(libm::ceil(end / cell_s) as usize);
        let edge = |cell: usize| (cell as f64 * cell_s).min(end);
        let mut bounds = vec![(0.0, 0.0); cells];
        for wire in &self.wires {
            wire.add_bounds(edge, &mut bounds);
        }
        // What flowed in only grows: it lies between what it was before and after.
        let mut fallen = 1.0;
        for (cell, (low, high)) in bounds.iter_mut().enumerate() {
            let fallen_by = libm::exp(-edge(cell + 1) / LEAK_S);
            most = most.max((self.energy + *low) * fallen_by);
            *high = (self.energy + *high) * fallen;
            fallen = fallen_by;
        }
        for (cell, (_, upper)) in bounds.into_iter().enumerate() {
            // Where nothing moves both are 0, and no cell is looked at.
            if upper <= most {
                continue;
            }
            let times: [f64; CELL] =
                core::array::from_fn(|look| ((cell * CELL + look) as f64 * LOOK_S).min(end));
            let mut sums = [0.0; CELL];
            self.shared.vectors.run(
                #[inline(always)]
                || {
                    for wire in &self.wires {
                        wire.add_energies(&self.shared.rule, &times, &mut sums);
                    }
                },
            );
            let looks = times.iter().zip(sums).map(|(t, sum)| self.leaked(*t, sum));
            most = looks.fold(most, f64::max);
        }
        most
    }

    /// Stimulus since the last onset, with tissue at `skin_c` degrees C, summed up to now. `None` where no wire has
    /// moved since then.
    pub fn felt(&self, skin_c: f64) -> Option<Felt> {
        let (mut energy, mut amplitude) = (Mean::default(), Mean::default());
        let [mut strongest_p, mut strongest_n, mut skin_um] = [0.0_f64; 3];
        for (met, place) in self.met() {
            energy.add(met.energy, place);
            amplitude.add(met.peak_p, place);
            strongest_p = strongest_p.max(met.peak_p);
            strongest_n = strongest_n.max(met.peak_n);
            skin_um = skin_um.max(met.swing_um());
        }
        let loss = if skin_c < COLD.0 {
            COLD.1 * (COLD.0 - skin_c)
        } else if skin_c >= HOT.0 {
            HOT.1
        } else {
            0.0
        };
        let a0 = self.person.vibration_um;
        let decibels = |power: f64| (10.0 * libm::log10(power)).max(SILENCE_DB);
        let flutter = strongest_n / self.person.flutter_um;
        let np2 = self.person.np2_um.map_or(0.0, |um| strongest_p / um);
        (energy.weights > 0.0 && amplitude.weights > 0.0).then(|| Felt {
            levels: Levels {
                vibration_db: (decibels(self.most / (a0 * a0)) - loss).max(SILENCE_DB),
                flutter_db: decibels(flutter * flutter),
                np2_db: decibels(np2 * np2),
            },
            energy_mm: energy.place(),
            amplitude_mm: amplitude.place(),
            energy: energy.weights,
            skin_um,
            seconds: self.driven.map_or(0.0, |(first, last)| last - first),
        })
    }

    /// Every wire's part since the onset, and its place.
    fn met(&self) -> impl Iterator<Item = (Met, (f64, f64))> {
        let met = self.wires.iter().map(|w| w.met);
        met.zip(self.places.iter().copied())
    }

    /// An onset: what is met from now on is its. The leaky energy goes on.
    pub fn onset(&mut self) {
        self.wires.iter_mut().for_each(WireFilter::onset);
        self.most = self.energy;
        (self.since_s, self.driven) = (0.0, None);
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
mod tests;
