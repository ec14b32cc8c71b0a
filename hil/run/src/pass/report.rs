//! Report of a hot pass.

use palpate_core::guard::Memory;
use palpate_core::projector::Projector;
use palpate_core::schedule::{Entry, Reason};
use palpate_core::units::Instant;
use serde::Serialize;

use super::heated::{KEPT, pulses};
use super::plan::Planned;
use crate::Outcome;

/// State of the wires at the end of a run that was a pass.
#[derive(Clone, Debug)]
pub struct PassEnd {
    /// Wires of the display.
    pub wires: usize,
    /// Wires that the guard let have every pulse.
    pub passed: usize,
    /// The first wire that the guard refused, with its word for the reason.
    pub refused: Option<(u16, &'static str)>,
    /// Most martensite that the model has left in any wire; `None` on hardware.
    pub martensite: Option<f64>,
    /// Heat and dose under the display.
    pub memory: Memory,
}

impl PassEnd {
    /// The end of a loop's pass at this time; `None` for a loop that made none.
    #[must_use]
    pub fn find(projector: &Projector, end: Instant, martensite: Option<f64>) -> Option<Self> {
        let passing = projector.passing()?;
        let refused = passing.refused().map(|(wire, entry)| {
            let reason = entry.reason.map_or("shortened", Reason::word);
            (*wire, reason)
        });
        Some(Self {
            wires: projector.display().wires().len(),
            passed: passing.passed(),
            refused,
            martensite,
            memory: projector.guard().memory(end),
        })
    }
}

/// A share to a ten-thousandth.
fn part(share: f64) -> f64 {
    (share * 1e4).round() * 1e-4
}

/// A burst of a hot pass.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassBurst {
    /// Start, s, negative: before the scene's t = 0, which is the end of the pass.
    pub at_s: f64,
    /// The board's number.
    pub board: u8,
    /// Channel of the board.
    pub channel: u8,
    /// Pulses that the guard passed.
    pub pulses: u64,
    /// The guard's reason for another pulse than was planned; null for none.
    pub reason: Option<&'static str>,
}

/// A hot pass before a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassReport {
    /// State in which the run's wires begin: `assumed passed`, or `cold` after a pass that failed.
    pub state: &'static str,
    /// `true` where the guard let every wire have its pulses, and the model of an emulated wire has passed.
    #[serde(skip)]
    pub has_passed: bool,
    /// Wires of the bench that are driven.
    pub wires: usize,
    /// Wires that the guard let have every pulse.
    pub passed: usize,
    /// The guard's refusal, or what the model has left; null for a pass that was whole.
    pub why: Option<String>,
    /// Length of the pass, s.
    pub length_s: f64,
    /// Bursts of each wire.
    pub bursts: u8,
    /// Pulses of each burst.
    pub pulses: u64,
    /// Nominal width of a pulse, us.
    pub pulse_us: f64,
    /// Energy that the guard books for a wire, mJ.
    pub wire_mj: f64,
    /// Most martensite that a modelled wire has at the end of the pass: what stress has brought back; null on hardware.
    pub martensite: Option<f64>,
    /// Martensite that the plan leaves in the corner of the least heat; null where the model has no such wire.
    pub martensite_at_worst: Option<f64>,
    /// Hottest skin, degrees C; null on hardware.
    pub hottest_skin_c: Option<f64>,
    /// Every burst.
    pub schedule: Vec<PassBurst>,
}

impl PassReport {
    pub(super) fn new(planned: &Planned, outcome: &Outcome) -> Self {
        let each: Vec<&PassEnd> = match outcome.displays.is_empty() {
            true => outcome.pass.iter().collect(),
            false => {
                let displays = outcome.displays.iter();
                displays.filter_map(|d| d.outcome.pass.as_ref()).collect()
            }
        };
        let [wires, passed] = [|p: &&PassEnd| p.wires, |p: &&PassEnd| p.passed]
            .map(|of| each.iter().map(of).sum::<usize>());
        let left = each.iter().filter_map(|p| p.martensite);
        let martensite = left.reduce(f64::max);
        let why = match each.iter().find_map(|p| p.refused) {
            Some((wire, reason)) => Some(format!("the guard refused wire {wire}: {reason}")),
            None if passed < wires || wires == 0 => {
                Some("contacts or a stop left no time for it".to_owned())
            }
            None if outcome.trace.ledger.tight => {
                Some("the bow was pulled past what the model knows".to_owned())
            }
            None => martensite
                .filter(|left| *left >= KEPT)
                .map(|left| format!("the modelled wire keeps {:.0} % martensite", left * 100.0)),
        };
        let (pass, prescale) = (&planned.pass, planned.prescale);
        let end_us = outcome.trace.ledger.length_us;
        let burst = |entry: &Entry| PassBurst {
            at_s: (entry.at.as_micros() as f64 - end_us as f64) * 1e-6,
            board: entry.board.0,
            channel: entry.channel.0,
            pulses: entry.pulses(prescale.period_ns()),
            reason: entry.reason.map(Reason::word),
        };
        Self {
            state: if why.is_none() {
                "assumed passed"
            } else {
                "cold"
            },
            has_passed: why.is_none(),
            wires,
            passed,
            why,
            length_s: end_us as f64 * 1e-6,
            bursts: pass.bursts,
            pulses: pulses(pass, prescale),
            pulse_us: f64::from(pass.width.get()) * prescale.tick_ns() as f64 * 1e-3,
            wire_mj: planned.burst_nj as f64 * f64::from(pass.bursts) * 1e-6,
            martensite: martensite.map(part),
            martensite_at_worst: planned.left_at_worst.map(part),
            hottest_skin_c: outcome.summary.hottest_skin_c,
            schedule: outcome.trace.each::<Entry>().map(burst).collect(),
        }
    }

    /// The pass in a sentence.
    #[must_use]
    pub fn line(&self) -> String {
        let bursts = match self.bursts {
            1 => String::new(),
            n => format!("{n} bursts of "),
        };
        let skin = self.hottest_skin_c;
        let skin = skin.map_or_else(String::new, |c| format!(", skin at {c:.1} C at most"));
        let what = format!(
            "{bursts}{} pulses of {:.0} us for each of {} wires, one after the other in {:.1} s before t = 0{skin}",
            self.pulses, self.pulse_us, self.wires, self.length_s
        );
        match &self.why {
            None => format!("{what}; the wires are assumed passed"),
            Some(why) => format!("{what}; NOT PASSED: {why}. The wires count as cold"),
        }
    }
}
