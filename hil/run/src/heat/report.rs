//! Report of a Peltier module, and the account of its turns, by the host or by a driver unit.

use palpate_core::peltier::PeltierReason;
use palpate_core::units::{Duration, Instant};
use palpate_records::trace::{Event, event};
use serde::Serialize;

use crate::recorder::milli_c;

/// Time between two records of the module.
const RECORD: Duration = Duration::from_millis(100);

/// Temperatures, turns and stops of a Peltier module in a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[allow(missing_docs)] // the keys say what they are, with their units
pub struct HeatReport {
    pub coldest_face_c: f64,
    pub warmest_face_c: f64,
    pub warmest_sink_c: f64,
    pub fastest_ramp_k_s: f64,
    /// Root mean square of the face's distance from its aim, over all turns that drove it; null for none.
    pub error_k: Option<f64>,
    pub energy_j: f64,
    /// Turns of the regulator, a hundred a second.
    pub turns: u64,
    /// Turns in which the guard let less current flow than was requested.
    pub held_back: u64,
    /// Times that a sensor switched the module off.
    pub stops: u32,
    /// `true` where the thermostat cut the module.
    pub thermostat: bool,
}

impl HeatReport {
    /// Words of the report, in a line.
    #[must_use]
    pub fn words(&self) -> String {
        let error = self
            .error_k
            .map_or("-".to_owned(), |k| format!("{k:.2} K RMSE"));
        let cut = match self.thermostat {
            true => ", CUT by its thermostat",
            false => "",
        };
        format!(
            "face {:.1} to {:.1} C, {error} from what it aims at, {:.1} K/s at most; sink {:.1} C at most; {:.1} J; {} of {} turns held back, {} stops{cut}",
            self.coldest_face_c,
            self.warmest_face_c,
            self.fastest_ramp_k_s,
            self.warmest_sink_c,
            self.energy_j,
            self.held_back,
            self.turns,
            self.stops
        )
    }
}

/// State of a module after a turn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub face_c: f64,
    pub sink_c: f64,
    pub milliamps: i32,
    /// Temperature that the module aims at; `None` where it is off.
    pub aim_c: Option<f64>,
    /// Reason for which the current is not the one that its control asked for.
    pub reason: Option<PeltierReason>,
}

/// Account of a module's turns so far.
#[derive(Debug, Default)]
pub(super) struct Account {
    /// Sum of squared distances from the aim, K2, and turns that had an aim.
    missed: (f64, u64),
    turns: u64,
    held_back: u64,
    stops: u32,
    /// `true` once the module had an aim: one that is off from the start is no news.
    driven: bool,
    /// Reason for which the module was last noted as off.
    told: Option<PeltierReason>,
    recorded: Option<Instant>,
}

impl Account {
    /// Takes a turn in: counts it, notes once that the module goes off or on again, and records it now and then.
    pub(super) fn take(&mut self, now: Instant, seen: &Seen, events: &mut Vec<Event>) {
        let t_us = now.as_micros();
        self.turns += 1;
        if let Some(aim_c) = seen.aim_c {
            let error = seen.face_c - aim_c;
            self.missed = (self.missed.0 + error * error, self.missed.1 + 1);
            self.held_back += u64::from(seen.reason.is_some());
            self.driven = true;
        }
        let off = seen.reason.filter(|_| seen.aim_c.is_none());
        if self.driven && off != self.told {
            let text = match off {
                Some(reason) => format!("Peltier module off: {}", reason.word()),
                None => "Peltier module on again".to_owned(),
            };
            events.push(Event::note(now, text));
            self.stops += u32::from(matches!(off, Some(PeltierReason::Sensor(_))));
            self.told = off;
        }
        if self.recorded.is_none_or(|at| now >= at + RECORD) {
            self.recorded = Some(now);
            events.push(Event::Face(event::Face {
                t_us,
                face_mc: milli_c(seen.face_c).unwrap_or(i32::MAX),
                aim_mc: seen.aim_c.and_then(milli_c),
                sink_mc: milli_c(seen.sink_c).unwrap_or(i32::MAX),
                milliamps: seen.milliamps,
            }));
        }
    }

    /// Turns so far.
    pub(super) const fn turns(&self) -> u64 {
        self.turns
    }

    /// Puts the counts into a report.
    pub(super) fn fill(&self, report: &mut HeatReport) {
        let (sum, count) = self.missed;
        report.error_k = (count > 0).then(|| (sum / count as f64).sqrt());
        report.turns = self.turns;
        report.held_back = self.held_back;
        report.stops = self.stops;
    }
}
