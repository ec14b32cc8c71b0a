//! Times that a wire and a person take to answer the first pulse: the last two parts of the way from a touch to its
//! sensation.

use palpate_core::projector::Projector;
use palpate_emulators::display::solver::stretch::Stretch;
use palpate_emulators::person::channels::Perceiver;
use palpate_emulators::time::Nanos;
use palpate_files::Setup;

use super::{emulated_person, felt_wire};
use crate::failure::Failure;

/// Bursts before the one that counts: wire and tissue have got warm.
const BEFORE: u64 = 8;
/// Resolution of the times, s.
const STEP_S: f64 = 0.1e-3;

/// Times from the first current of a burst at full drive, alone on one wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reaction {
    /// Time until the tissue has moved half as far as that burst moves it at most, s.
    pub moved_s: f64,
    /// Time until the person's level reaches 0 dB, s; `None` where that burst is not felt.
    pub felt_s: Option<f64>,
}

/// Splits a stretch into pieces of at most [`STEP_S`] with the same motion.
fn pieces(whole: &Stretch) -> Vec<Stretch> {
    let count = libm::ceil(whole.seconds / STEP_S).max(1.0);
    let seconds = whole.seconds / count;
    let mut all = Vec::new();
    for piece in 0..count as u64 {
        let from = piece as f64 * seconds;
        let mut one = *whole;
        one.seconds = seconds;
        for (slope, rate) in one.slopes.iter_mut().zip(whole.rates) {
            *slope *= libm::exp(-rate * from);
        }
        all.push(one);
    }
    all
}

/// Movement of the tissue in a stretch, um.
fn moves(stretch: &Stretch) -> f64 {
    let by_rate = stretch.slopes.iter().zip(stretch.rates);
    let kelvins = by_rate.map(|(slope, rate)| match rate * stretch.seconds {
        small if small.abs() < 1e-12 => slope * stretch.seconds,
        exponent => -slope * libm::expm1(-exponent) / rate,
    });
    stretch.um_per_k * kelvins.sum::<f64>()
}

/// The answer of a setup's wire and emulated person, at the width and for as long as the loop drives at most.
///
/// # Errors
/// [`Failure::Input`] for a wire or person that cannot be.
pub fn reaction(setup: &Setup, projector: &Projector) -> Result<Reaction, Failure> {
    let bench = &setup.bench.value;
    let mut perceiver = Perceiver::new(emulated_person(setup), &[(0.0, 0.0)])
        .map_err(|e| Failure::Input(format!("bench `{}`: {e}", bench.name)))?;
    let mut wire = felt_wire(setup)?;
    let (prescale, timing) = (projector.guard().prescale(), projector.timing());
    let wide = Nanos(u64::from(projector.width(1.0).get()) * prescale.tick_ns());
    let pulses = timing.duration.as_micros() * 1000 / prescale.period_ns();
    let mut burst = |n: u64| {
        let start = Nanos::from_micros(n * timing.soa.as_micros());
        for pulse in 0..pulses.max(1) {
            let at = start + Nanos(pulse * prescale.period_ns());
            wire.set_current(at, bench.drive.current_ma * 1e-3);
            wire.set_current(at + wide, 0.0);
        }
        let end = Nanos::from_micros((n + 1) * timing.soa.as_micros());
        let mut all = Vec::new();
        wire.take_stretches(end, |stretch| all.extend(pieces(stretch)));
        all
    };
    // The person has felt none of these: their echo is no answer to the next.
    for n in 0..BEFORE {
        burst(n);
    }
    let (mut at_s, mut um, mut felt_s) = (0.0, 0.0, None);
    let mut path = Vec::new();
    for piece in burst(BEFORE) {
        at_s += piece.seconds;
        um += moves(&piece);
        path.push((at_s, um));
        if felt_s.is_none() {
            perceiver.pass(0, &piece);
            perceiver.settle();
            let felt = perceiver.felt(bench.tissue.rest_c);
            felt_s = felt.filter(|f| f.levels.felt()).map(|_| at_s);
        }
    }
    let half = path
        .iter()
        .fold(0.0_f64, |most, (_, um)| most.max(um.abs()))
        / 2.0;
    let moved = path.iter().find(|(_, um)| um.abs() >= half);
    Ok(Reaction {
        moved_s: moved.map_or(0.0, |(at_s, _)| *at_s),
        felt_s,
    })
}

#[cfg(test)]
#[path = "reaction_tests.rs"]
mod tests;
