//! The felt path in figures: how far over threshold it is, how far from the contact by both centroids, where it breaks and
//! jumps, how even its energy is.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::fixed::distance2_um;
use crate::measure::{Errors, Sum};
use crate::trace::{Event, FeltAt, Header, PlaceUm, Trace, event};

/// A centroid: its name, and which of the two places is its.
type Centroid = (&'static str, fn(&FeltAt) -> PlaceUm);

/// Both centroids, each with its name and its place in a stimulus.
const CENTROIDS: [Centroid; 2] = [
    ("energy centroid", |felt| felt.energy),
    ("amplitude centroid", |felt| felt.amplitude),
];

/// A level where no wire moved, thousandths of a decibel.
const SILENCE_MDB: i32 = -200_000;

/// Felt level and error of a bench over all draws of what is not measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FeltBand {
    /// Level over the person's threshold at 5, 50 and 95 %, dB.
    pub level_db: [f64; 3],
    /// Share of draws whose person feels half of the onsets or more.
    pub felt: f64,
    /// Error of the felt place over all onsets at 5, 50 and 95 %, RMSE, mm.
    pub error_mm: [f64; 3],
    /// Number of draws.
    pub draws: usize,
    /// Effective sample size of their weights.
    pub effective: f64,
    /// Seed of the draws.
    pub seed: u64,
    /// Scene that every draw played.
    pub scene: String,
    /// True if the law planned with each draw's own wire.
    pub identified: bool,
    /// Evidence by which draws were weighed.
    pub evidence: Vec<String>,
}

/// A felt path by one centroid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeltScore {
    /// Name of the centroid.
    pub perceiver: &'static str,
    /// Place against the mapped contact, display space, over the onsets with the contact inside the display. The place is
    /// that of the wires' motion, whether the level reaches the threshold or not. `None` where no wire moved.
    pub errors: Option<Errors>,
    /// Errors over all onsets, with the contact inside the display or not.
    pub everywhere: Option<Errors>,
    /// Onsets with the contact inside the display and a level below 0 dB.
    pub breaks: u64,
    /// Onsets felt, after another that was, at which the place went further than the contact by a step that can be felt.
    pub jumps: u64,
}

/// The felt path of a run by both centroids, the energy's first.
pub fn felt_scores(trace: &Trace) -> [FeltScore; 2] {
    FeltPath::from_trace(trace).scores()
}

/// A felt path that is scored onset by onset, in the order of time.
#[derive(Debug)]
pub struct FeltPath {
    step_um: u64,
    soa_us: u64,
    by: [Followed; 2],
    /// Number of onsets by level, thousandths of a decibel.
    levels: BTreeMap<i32, u64>,
    /// Number of onsets by displacement of the skin, thousandths of a micrometre.
    skins: BTreeMap<i32, u64>,
    taps: u64,
    /// Least and most: requested, applied, felt.
    energies: Option<[Range; 3]>,
}

/// Score of one centroid so far.
#[derive(Debug, Default)]
struct Followed {
    sum: Sum,
    everywhere: Sum,
    breaks: u64,
    jumps: u64,
    /// The newest onset that was felt: when, where, and where the contact was.
    before: Option<(u64, PlaceUm, PlaceUm)>,
}

impl FeltPath {
    /// An empty path on a run's display.
    pub fn new(header: &Header) -> Self {
        let wires: Vec<PlaceUm> = header.wires.iter().map(|w| w.place).collect();
        Self::on(&wires, header.soa_us)
    }

    /// An empty path on a display with wires at these places, whose onsets are `soa_us` microseconds apart.
    pub fn on(wires: &[PlaceUm], soa_us: u64) -> Self {
        Self {
            step_um: felt_step_um(wires),
            soa_us,
            by: Default::default(),
            levels: BTreeMap::new(),
            skins: BTreeMap::new(),
            taps: 0,
            energies: None,
        }
    }

    fn from_trace(trace: &Trace) -> Self {
        let mut path = Self::new(&trace.header);
        trace.events.iter().for_each(|event| path.add(event));
        path
    }

    /// Adds an event; only onsets that were to be felt count.
    pub fn add(&mut self, event: &Event) {
        let Event::Felt(felt) = event else {
            return;
        };
        let event::Felt {
            inside,
            met,
            energy,
            ..
        } = *felt;
        if inside {
            let level = self.levels.entry(met.map_or(SILENCE_MDB, |m| m.level_mdb));
            *level.or_insert(0) += 1;
            *self.skins.entry(met.map_or(0, |m| m.skin_nm)).or_insert(0) += 1;
            self.taps += u64::from(met.is_some_and(|m| m.tap));
            let all = [energy.requested, energy.applied, energy.felt];
            let ranges = self.energies.get_or_insert([(u32::MAX, 0); 3]);
            for ((least, most), value) in ranges.iter_mut().zip(all) {
                (*least, *most) = (value.min(*least), value.max(*most));
            }
        }
        for (followed, (_, place)) in self.by.iter_mut().zip(CENTROIDS) {
            followed.add(felt, place, (self.step_um, self.soa_us));
        }
    }

    /// Scores by both centroids, the energy's first.
    pub fn scores(&self) -> [FeltScore; 2] {
        let [energy, amplitude] = &self.by;
        let [(first, _), (second, _)] = CENTROIDS;
        [energy.score(first), amplitude.score(second)]
    }

    /// Level of the onsets so far; `None` where no contact was inside the display.
    pub fn level(&self) -> Option<FeltLevel> {
        Some(FeltLevel {
            median_mdb: ranked(&self.levels, 50)?,
            p5_mdb: ranked(&self.levels, 5)?,
            skin_median_nm: ranked(&self.skins, 50)?,
            skin_most_nm: ranked(&self.skins, 100)?,
            taps: self.taps,
        })
    }

    /// Least and most energy of the onsets so far: requested, applied and felt, as in [`energies`].
    pub fn energies(&self) -> Option<[(&'static str, Range); 3]> {
        let [requested, applied, felt] = self.energies?;
        Some([
            ("requested", requested),
            ("applied", applied),
            ("felt", felt),
        ])
    }
}

/// Value that so many hundredths of all lie below; `None` of none.
fn ranked(counts: &BTreeMap<i32, u64>, hundredths: u64) -> Option<i32> {
    let count: u64 = counts.values().sum();
    let place = hundredths * count.checked_sub(1)? / 100;
    let mut below = 0;
    let value = counts.iter().find(|(_, n)| {
        below += **n;
        below > place
    });
    value.map(|(value, _)| *value)
}

impl Followed {
    fn add(&mut self, onset: &event::Felt, place: fn(&FeltAt) -> PlaceUm, (step, soa): (u64, u64)) {
        let target = onset.target;
        if let Some(met) = &onset.met {
            let squared = distance2_um(place(met), target);
            self.everywhere.add(squared);
            if onset.inside {
                self.sum.add(squared);
            }
        }
        let felt = onset.met.filter(FeltAt::is_felt);
        let felt = felt.as_ref().map(place);
        self.breaks += u64::from(onset.inside && felt.is_none());
        let next_onset = |t: u64| onset.t_us.saturating_sub(t) <= soa;
        if let (Some((_, from, aim)), Some(felt)) = (self.before.filter(|b| next_onset(b.0)), felt)
        {
            let moved = distance2_um(felt, from).isqrt();
            let meant = distance2_um(target, aim).isqrt();
            self.jumps += u64::from(moved >= meant.saturating_add(step));
        }
        self.before = felt.map(|felt| (onset.t_us, felt, target));
    }

    fn score(&self, perceiver: &'static str) -> FeltScore {
        FeltScore {
            perceiver,
            errors: self.sum.errors(),
            everywhere: self.everywhere.errors(),
            breaks: self.breaks,
            jumps: self.jumps,
        }
    }
}

/// The smallest step that is felt as motion: a fifth of the smallest gap between wires, micrometres.
fn felt_step_um(wires: &[PlaceUm]) -> u64 {
    let pairs = wires.iter().enumerate().flat_map(|(i, a)| {
        let others = wires.iter().take(i);
        others.map(|b| distance2_um(*a, *b))
    });
    pairs.min().map_or(u64::MAX, |gap2| gap2.isqrt() / 5)
}

/// Levels over threshold of the onsets with a contact inside the display, thousandths of a decibel, and the skin's
/// displacement there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeltLevel {
    /// Half of the onsets were weaker.
    pub median_mdb: i32,
    /// One in twenty onsets was weaker.
    pub p5_mdb: i32,
    /// Half of the onsets moved the skin less, thousandths of a micrometre.
    pub skin_median_nm: i32,
    /// No onset moved the skin more, thousandths of a micrometre.
    pub skin_most_nm: i32,
    /// Onsets that were so short that they feel like taps.
    pub taps: u64,
}

/// The level of a run; `None` where no contact was inside the display.
pub fn felt_level(trace: &Trace) -> Option<FeltLevel> {
    FeltPath::from_trace(trace).level()
}

/// Least and most of an energy.
pub type Range = (u32, u32);

/// Least and most energy of the onsets with a contact inside the display, in thousandths of one wire's at full drive:
/// requested, applied, felt. `None` where there was none.
pub fn energies(trace: &Trace) -> Option<[(&'static str, Range); 3]> {
    FeltPath::from_trace(trace).energies()
}

/// Thousandths of an energy in decibels.
pub fn decibels(permille: u32) -> f64 {
    10.0 * (f64::from(permille.max(1)) / 1000.0).log10()
}

#[cfg(test)]
#[path = "felt_tests.rs"]
mod tests;
