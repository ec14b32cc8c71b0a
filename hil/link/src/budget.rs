//! The latency budget: the parts of the time between a touch of the robot and the wearer's sensation.

use std::collections::BTreeMap;

use palpate_core::projector::Projector;
use palpate_core::statistics::quantile;
use palpate_core::units::Instant;
use palpate_files::Setup;
use palpate_records::report::SummaryRow;
use palpate_records::trace::Event;
use palpate_run::Failure;
use palpate_run::plan::{Reaction, reaction};
use serde::Serialize;

use crate::judge::Head;

/// Values of one kind that are kept at most: a quarter of an hour at 100 Hz.
pub(crate) const MOST: usize = 100_000;
/// Outputs whose edge is awaited at most: more than any bench has.
const MOST_AWAITED: usize = 1024;

/// Median, 99 % and largest of some times, milliseconds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Spread {
    /// Half of the times are below.
    pub median: f64,
    /// 99 % of the times are below.
    pub p99: f64,
    /// Largest of the times.
    pub max: f64,
}

/// Times that are gathered, microseconds.
#[derive(Debug, Default)]
pub(crate) struct Samples(Vec<u64>);

impl Samples {
    /// Keeps a sample while there is room.
    pub(crate) fn keep(&mut self, one: u64) {
        if self.0.len() < MOST {
            self.0.push(one);
        }
    }

    /// The spread of all samples, which are taken out.
    pub(crate) fn spread(&mut self) -> Option<Spread> {
        let mut micros = std::mem::take(&mut self.0);
        micros.sort_unstable();
        let at = |share| quantile(&micros, share).map(|at| at.below as f64 * 1e-3);
        Some(Spread {
            median: at(0.5)?,
            p99: at(0.99)?,
            max: at(1.0)?,
        })
    }
}

impl Spread {
    fn always(seconds: f64) -> Self {
        let ms = seconds * 1e3;
        Self {
            median: ms,
            p99: ms,
            max: ms,
        }
    }
}

/// Parts of the latency, each after the one before it.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Budget {
    /// Time on the robot from the end of a reading until it was sent.
    pub sensor_ms: Option<Spread>,
    /// Time from sending to arrival, at most: an answer of the robot proves the bound.
    pub network_ms: Option<Spread>,
    /// Time from the newest reading's arrival to the onset that it gave: the wait for the grid of onsets.
    pub projection_ms: Option<Spread>,
    /// Time from the onset to the first rising edge of its output: transfers to the chip, its phase.
    pub unit_ms: Option<Spread>,
    /// Time from the first current until the tissue has moved half of its way: the model of the bench's wire.
    pub wire_ms: Option<Spread>,
    /// Time from then until the level reaches the threshold: the model of the bench's person.
    pub skin_ms: Option<Spread>,
}

impl Budget {
    /// The parts with their names.
    #[must_use]
    pub const fn parts(&self) -> [(&'static str, Option<Spread>); 6] {
        [
            ("sensor", self.sensor_ms),
            ("network", self.network_ms),
            ("projection", self.projection_ms),
            ("unit", self.unit_ms),
            ("wire", self.wire_ms),
            ("skin", self.skin_ms),
        ]
    }

    /// Words of the budget, in a line.
    #[must_use]
    pub fn line(&self) -> String {
        let part = |(name, spread): &(&str, Option<Spread>)| match spread {
            Some(s) => format!("{name} {:.1}", s.median),
            None => format!("{name} -"),
        };
        let parts: Vec<String> = self.parts().iter().map(part).collect();
        let sum: f64 = self
            .parts()
            .iter()
            .filter_map(|(_, s)| Some(s.as_ref()?.median))
            .sum();
        format!(
            "latency, medians, ms: {}; together {sum:.1}",
            parts.join(", ")
        )
    }

    /// Rows for the summary of a report.
    #[must_use]
    pub fn rows(&self) -> Vec<SummaryRow> {
        let row = |(name, spread): &(&str, Option<Spread>)| SummaryRow {
            name: format!("latency, {name}: median, 99 %"),
            value: match spread {
                Some(s) => format!("{:.2}, {:.2}", s.median, s.p99),
                None => "-".into(),
            },
            unit: "ms".into(),
            ..SummaryRow::default()
        };
        self.parts().iter().map(row).collect()
    }
}

/// Measures the parts of a [`Budget`] while a finger feels.
#[derive(Debug)]
pub struct Stopwatch {
    reaction: Reaction,
    sensor: Samples,
    network: Samples,
    projection: Samples,
    unit: Samples,
    /// Arrival of the newest reading that is felt.
    arrived: Option<Instant>,
    /// Onsets of outputs that have not risen yet, by board and channel, microseconds.
    awaited: BTreeMap<(u8, u8), u64>,
}

impl Stopwatch {
    /// A stopwatch for a bench's wire and person.
    ///
    /// # Errors
    /// [`Failure::Input`] for a wire or person that cannot be.
    pub fn new(setup: &Setup, projector: &Projector) -> Result<Self, Failure> {
        Ok(Self {
            reaction: reaction(setup, projector)?,
            sensor: Samples::default(),
            network: Samples::default(),
            projection: Samples::default(),
            unit: Samples::default(),
            arrived: None,
            awaited: BTreeMap::new(),
        })
    }

    /// Takes a felt frame that arrived at `now`; its reading may have been as early as `read`.
    pub fn arrived(&mut self, head: &Head, read: Instant, now: Instant) {
        let waited = head.sent_us.saturating_sub(head.taken_us);
        self.sensor.keep(waited);
        let age = now.since(read).as_micros();
        self.network.keep(age.saturating_sub(waited));
        self.arrived = Some(now);
    }

    /// Looks at an event.
    pub fn see(&mut self, event: &Event) {
        match event {
            Event::Schedule(entry) if entry.width().get() > 0 => {
                if let Some(arrived) = self.arrived {
                    let waited = entry.at.since(arrived).as_micros();
                    self.projection.keep(waited);
                }
                if self.awaited.len() < MOST_AWAITED {
                    let output = (entry.board.0, entry.channel.0);
                    self.awaited.insert(output, entry.at.as_micros());
                }
            }
            Event::Edge(edge) if edge.high => {
                if let Some(onset) = self.awaited.remove(&(edge.board, edge.channel)) {
                    self.unit.keep((edge.t_ns / 1000).saturating_sub(onset));
                }
            }
            _ => {}
        }
    }

    /// Budget of the times so far.
    pub fn finish(&mut self) -> Budget {
        let Reaction { moved_s, felt_s } = self.reaction;
        Budget {
            sensor_ms: self.sensor.spread(),
            network_ms: self.network.spread(),
            projection_ms: self.projection.spread(),
            unit_ms: self.unit.spread(),
            wire_ms: Some(Spread::always(moved_s)),
            skin_ms: felt_s.map(|felt_s| Spread::always((felt_s - moved_s).max(0.0))),
        }
    }
}
