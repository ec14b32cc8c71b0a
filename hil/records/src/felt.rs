//! The felt path in figures: how far it is from the contact, where it breaks, where it jumps, how even its
//! energy is; always by both perceivers.

use crate::fixed::distance2_um;
use crate::measure::{Errors, Sum};
use crate::trace::{Event, FeltAt, PlaceUm, Trace};

/// A perceiver: its name, and which of the two places is its.
type Perceiver = (&'static str, fn(&FeltAt) -> PlaceUm);

/// The two.
const PERCEIVERS: [Perceiver; 2] = [
    ("energy centroid", |felt| felt.energy),
    ("amplitude centroid", |felt| felt.amplitude),
];

/// A felt path by one perceiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeltScore {
    /// Whose.
    pub perceiver: &'static str,
    /// Felt place against the mapped contact, display space, over the onsets with the contact inside the
    /// display. At a break the contact counts as felt where it was felt last. `None` where nothing was felt.
    pub errors: Option<Errors>,
    /// Onsets with the contact inside the display and no wire above threshold.
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

/// The felt path of a run by both perceivers, the energy centroid first.
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
    PERCEIVERS.map(|perceiver| score(onsets, perceiver, step, soa_us))
}

fn score(onsets: &[FeltOnset], (name, place): Perceiver, step_um: u64, soa_us: u64) -> FeltScore {
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

/// Least and most energy of the onsets with a contact inside the display, in thousandths of one wire's at
/// full drive; `None` where there was none.
pub fn energy_permille(trace: &Trace) -> Option<(u32, u32)> {
    let inside = |event: &Event| match event {
        Event::Felt {
            inside: true,
            energy_permille,
            ..
        } => Some(*energy_permille),
        _ => None,
    };
    let energies = || trace.events.iter().filter_map(inside);
    Some((energies().min()?, energies().max()?))
}

/// Thousandths of an energy in decibels.
pub fn decibels(permille: u32) -> f64 {
    10.0 * (f64::from(permille.max(1)) / 1000.0).log10()
}

#[cfg(test)]
#[path = "felt_tests.rs"]
mod tests;
