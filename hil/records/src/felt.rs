//! The felt path in figures: how far over threshold it is, how far from the contact by both centroids, where it breaks and
//! jumps, how even its energy is.

use crate::fixed::distance2_um;
use crate::measure::{Errors, Sum};
use crate::trace::{EnergyPermille, Event, FeltAt, PlaceUm, Trace};

/// A centroid: its name, and which of the two places is its.
type Centroid = (&'static str, fn(&FeltAt) -> PlaceUm);

/// Both.
const CENTROIDS: [Centroid; 2] = [
    ("energy centroid", |felt| felt.energy),
    ("amplitude centroid", |felt| felt.amplitude),
];

/// A level where no wire moved, thousandths of a decibel.
const SILENCE_MDB: i32 = -200_000;

/// A felt path by one centroid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeltScore {
    /// Which.
    pub perceiver: &'static str,
    /// Felt place against the mapped contact, display space, over the onsets with the contact inside the
    /// display. At a break the contact counts as felt where it was felt last. `None` where nothing was felt.
    pub errors: Option<Errors>,
    /// Onsets with the contact inside the display and a level below 0 dB.
    pub breaks: u64,
    /// Onsets at which the felt place went further than the contact by a step that can be felt.
    pub jumps: u64,
}

/// One onset with one contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeltOnset {
    /// The onset.
    pub t_us: u64,
    /// Where the contact was, on the display.
    pub target: PlaceUm,
    /// Whether that is inside the display.
    pub inside: bool,
    /// Where it was felt, if it was.
    pub felt: Option<FeltAt>,
}

/// The felt path of a run by both centroids, the energy's first.
pub fn felt_scores(trace: &Trace) -> [FeltScore; 2] {
    let onset = |event: &Event| match *event {
        Event::Felt {
            t_us,
            target,
            inside,
            felt,
            ..
        } => Some(FeltOnset {
            t_us,
            target,
            inside,
            felt,
        }),
        _ => None,
    };
    let onsets: Vec<FeltOnset> = trace.events.iter().filter_map(onset).collect();
    let wires: Vec<PlaceUm> = trace.header.wires.iter().map(|w| w.place).collect();
    scores(&onsets, &wires, trace.header.soa_us)
}

/// The felt path of these onsets, one SOA apart where the contact stays, on a display with these wires.
pub fn scores(onsets: &[FeltOnset], wires: &[PlaceUm], soa_us: u64) -> [FeltScore; 2] {
    let step = felt_step_um(wires);
    CENTROIDS.map(|centroid| score(onsets, centroid, step, soa_us))
}

fn score(onsets: &[FeltOnset], (name, place): Centroid, step_um: u64, soa_us: u64) -> FeltScore {
    let mut sum = Sum::default();
    let (mut breaks, mut jumps) = (0, 0);
    let mut before: Option<(u64, PlaceUm, PlaceUm)> = None;
    let mut last: Option<PlaceUm> = None;
    for onset in onsets {
        let (target, felt) = (onset.target, onset.felt.as_ref().map(place));
        breaks += u64::from(onset.inside && felt.is_none());
        if let (true, Some(held)) = (onset.inside, felt.or(last)) {
            sum.add(distance2_um(held, target));
        }
        last = felt.or(last);
        let next_onset = |t: u64| onset.t_us.saturating_sub(t) <= soa_us;
        if let (Some((_, from, aim)), Some(felt)) = (before.filter(|b| next_onset(b.0)), felt) {
            let moved = distance2_um(felt, from).isqrt();
            let meant = distance2_um(target, aim).isqrt();
            jumps += u64::from(moved >= meant.saturating_add(step_um));
        }
        before = felt.map(|felt| (onset.t_us, felt, target));
    }
    FeltScore {
        perceiver: name,
        errors: sum.errors(),
        breaks,
        jumps,
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

/// How far over threshold the onsets with a contact inside the display were, thousandths of a decibel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeltLevel {
    /// Half of the onsets were weaker.
    pub median_mdb: i32,
    /// One in twenty was.
    pub p5_mdb: i32,
    /// Onsets that were so short that they feel like taps.
    pub taps: u64,
}

/// The level of a run; `None` where no contact was inside the display.
pub fn felt_level(trace: &Trace) -> Option<FeltLevel> {
    let mut levels = Vec::new();
    let mut taps = 0;
    for event in &trace.events {
        if let Event::Felt {
            inside: true,
            level_mdb,
            tap,
            ..
        } = event
        {
            levels.push(level_mdb.unwrap_or(SILENCE_MDB));
            taps += u64::from(*tap && level_mdb.is_some());
        }
    }
    levels.sort_unstable();
    let at = |hundredths: usize| levels.get(hundredths * levels.len().checked_sub(1)? / 100);
    Some(FeltLevel {
        median_mdb: *at(50)?,
        p5_mdb: *at(5)?,
        taps,
    })
}

/// Least and most of an energy.
pub type Range = (u32, u32);

/// Least and most energy of the onsets with a contact inside the display, in thousandths of one wire's at full drive:
/// requested, applied, felt. `None` where there was none.
pub fn energies(trace: &Trace) -> Option<[(&'static str, Range); 3]> {
    let inside = |event: &Event| match event {
        Event::Felt {
            inside: true,
            energy,
            ..
        } => Some(*energy),
        _ => None,
    };
    let all: Vec<EnergyPermille> = trace.events.iter().filter_map(inside).collect();
    let range = |of: fn(&EnergyPermille) -> u32| {
        Some((all.iter().map(of).min()?, all.iter().map(of).max()?))
    };
    Some([
        ("requested", range(|e| e.requested)?),
        ("applied", range(|e| e.applied)?),
        ("felt", range(|e| e.felt)?),
    ])
}

/// Thousandths of an energy in decibels.
pub fn decibels(permille: u32) -> f64 {
    10.0 * (f64::from(permille.max(1)) / 1000.0).log10()
}

#[cfg(test)]
#[path = "felt_tests.rs"]
mod tests;
