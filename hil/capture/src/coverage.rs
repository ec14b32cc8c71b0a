//! Coverage of a plan by a capture.

use std::collections::BTreeMap;

use serde::Serialize;

use super::plan::{Output, Plan, Span};
use super::tally::Tally;
use palpate_records::verdict::{Conclusion, Verdict};

/// Coverage of the plan within the window.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Coverage {
    /// The window, seconds of the run: as given, else from the first burst to the end of the last.
    pub window_s: [f64; 2],
    /// Bursts of the schedule that touch the window.
    pub bursts_planned: usize,
    /// Planned bursts that the capture has whole.
    pub bursts_seen: usize,
    /// Outputs with such bursts.
    pub channels_planned: usize,
    /// Planned outputs that a signal of the capture stands for.
    pub channels_seen: usize,
    /// Time from the first planned burst to the end of the last, seconds.
    pub seconds_planned: f64,
    /// Part of that time within the capture, seconds.
    pub seconds_seen: f64,
}

/// The stretch from the first burst that a window touches to the end of the last.
pub(super) fn driven(plan: &Plan, window: Span) -> Option<Span> {
    let bursts = plan.values().flatten();
    let touched = bursts.filter(|b| window.touches(b.from_ns, b.to_ns));
    touched.fold(None, |all: Option<Span>, b| {
        let all = all.unwrap_or(Span {
            from_ns: b.from_ns,
            to_ns: b.to_ns,
        });
        Some(Span {
            from_ns: all.from_ns.min(b.from_ns),
            to_ns: all.to_ns.max(b.to_ns),
        })
    })
}

impl Coverage {
    /// Counts the coverage. `capture` is when it was taken, on the run's clock; `None` if nothing tells.
    pub(super) fn new(
        plan: &Plan,
        tallies: &BTreeMap<Output, Tally>,
        driven: Span,
        capture: Option<Span>,
    ) -> Self {
        let mut coverage = Self {
            window_s: [driven.from_ns * 1e-9, driven.to_ns * 1e-9],
            seconds_planned: (driven.to_ns - driven.from_ns) * 1e-9,
            ..Self::default()
        };
        for (output, bursts) in plan {
            let touched = bursts.iter().filter(|b| driven.touches(b.from_ns, b.to_ns));
            let planned = touched.count();
            coverage.bursts_planned += planned;
            coverage.channels_planned += usize::from(planned > 0);
            if let Some(tally) = tallies.get(output) {
                coverage.bursts_seen += tally.seen;
                coverage.channels_seen += usize::from(planned > 0);
            }
        }
        if let Some(mut capture) = capture {
            // A capture of edges alone ends with the last of them, before the burst does.
            let whole = tallies.values().flat_map(|t| &t.trains).filter(|t| t.1);
            capture.to_ns = whole.fold(capture.to_ns, |end, t| end.max(t.0.to_ns));
            coverage.seconds_seen = driven.overlap_s(&capture);
        }
        coverage
    }

    /// Adds the parts of the plan that are not there to the reasons.
    pub(super) fn conclude(
        &self,
        plan: &Plan,
        tallies: &BTreeMap<Output, Tally>,
        into: &mut Conclusion,
    ) {
        let absent: Vec<String> = (plan.keys().filter(|o| !tallies.contains_key(*o)))
            .map(|o| format!("{}:{}", o.0, o.1))
            .collect();
        if self.channels_seen < self.channels_planned {
            let why = format!(
                "no signal stands for {} of {} planned channels ({}); `--pin NAME=BOARD:CHANNEL` says which is which",
                self.channels_planned - self.channels_seen,
                self.channels_planned,
                absent.join(", ")
            );
            into.add(Verdict::Incomplete, why);
        }
        let mut trains: Vec<&(Span, bool)> = tallies.values().flat_map(|t| &t.trains).collect();
        trains.sort_by(|a, b| a.0.from_ns.total_cmp(&b.0.from_ns));
        let Some(unseen) = trains.iter().find(|t| !t.1) else {
            return;
        };
        let mut why = format!(
            "{} of {} planned bursts were seen whole; the first that was not is that of {} s",
            self.bursts_seen,
            self.bursts_planned,
            unseen.0.from_ns / 1e9
        );
        // The first stretch that is all there.
        if let Some(begin) = trains.iter().find(|t| t.1).map(|t| t.0.from_ns) {
            let later = trains.iter().filter(|t| t.0.from_ns > begin);
            let cut = later.clone().find(|t| !t.1).map(|t| t.0.from_ns);
            let seen = trains.iter().filter(|t| t.1);
            let last = seen.map(|t| t.0.to_ns).fold(begin, f64::max);
            why += &format!(
                "; `--window {}..{}` asks for no more than the capture has",
                begin / 1e9,
                cut.unwrap_or(last) / 1e9
            );
        }
        into.add(Verdict::Incomplete, why);
    }
}
