//! Pulses against the schedule.

use std::collections::BTreeMap;

use palpate_records::trace::Trace;
use serde::Serialize;

use super::align::{Pins, Pulses, assign, latency, offset, period, starts};
use super::coverage::{Coverage, driven};
use super::edges::Capture;
use super::plan::{Output, Plan, Span, bursts};
use super::tally::{Clock, Grids, Tally, tally};
use palpate_records::verdict::{Conclusion, Verdict};
use palpate_run::Failure;

/// Slowest and fastest oscillators seen of the chip, over the nominal 25 MHz.
const OSCILLATOR: (f64, f64) = (23.0 / 25.0, 27.4 / 25.0);

/// Range of a chip's clock over its nominal frequency: the stated
/// tolerance of a clock on EXTCLK, else every oscillator seen.
fn range(clock: palpate_core::units::Clock) -> (f64, f64) {
    clock.tolerance_ppm().map_or(OSCILLATOR, |ppm| {
        let part = f64::from(ppm) * 1e-6;
        (1.0 - part, 1.0 + part)
    })
}

/// One measured value with its limits.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measurement {
    /// Measured quantity and its place.
    pub name: String,
    /// Value; null where there was nothing to measure.
    pub value: Option<f64>,
    /// Unit; empty for a count.
    pub unit: &'static str,
    /// Smallest good value.
    pub low: f64,
    /// Largest good value.
    pub high: f64,
}

impl Measurement {
    fn new(name: String, value: Option<f64>, unit: &'static str, low: f64, high: f64) -> Self {
        Self {
            name,
            value,
            unit,
            low,
            high,
        }
    }

    /// Tells whether the value lies within its limits; a value that could not be measured does not.
    pub fn good(&self) -> bool {
        self.value
            .is_some_and(|v| (self.low..=self.high).contains(&v))
    }
}

/// Result of a comparison of a capture with a schedule.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The verdict and its reasons.
    #[serde(flatten)]
    pub conclusion: Conclusion,
    /// Coverage of the plan by the capture.
    pub coverage: Coverage,
    /// Time of the run at the start of the capture, seconds; none where nothing tells.
    pub offset_s: Option<f64>,
    /// Pulses seen.
    pub pulses: usize,
    /// The measurements.
    pub measurements: Vec<Measurement>,
    /// Questions that the capture cannot answer, and damages of its file.
    pub notes: Vec<String>,
}

/// The signals of a capture as outputs of a schedule.
struct Seen<'a> {
    capture: &'a Capture,
    pulses: BTreeMap<Output, Pulses>,
    /// Times between which each output's level is unknown, nanoseconds.
    unseen: BTreeMap<Output, Vec<(f64, f64)>>,
    /// PRE_SCALE's period, nanoseconds.
    nominal: f64,
    /// Slowest and fastest clock of the chips, over the nominal one.
    clock: (f64, f64),
    /// The true period of each board, where its pulses tell.
    periods: BTreeMap<u8, Option<f64>>,
}

impl<'a> Seen<'a> {
    fn new(trace: &Trace, plan: &Plan, capture: &'a Capture, pins: &Pins) -> Result<Self, Failure> {
        let outputs: Vec<Output> = match trace.header.wires.as_slice() {
            [] => plan.keys().copied().collect(),
            wires => wires.iter().map(|w| (w.board, w.channel)).collect(),
        };
        let nominal = trace.header.pre_scale.period_ns() as f64;
        let (mut pulses, mut unseen) = (BTreeMap::new(), BTreeMap::new());
        for (output, (seen, not)) in assign(capture, &outputs, pins, nominal)? {
            pulses.insert(output, seen);
            unseen.insert(output, not);
        }
        let mut boards: BTreeMap<u8, Vec<&Pulses>> = BTreeMap::new();
        for (output, pulses) in &pulses {
            boards.entry(output.0).or_default().push(pulses);
        }
        let of_board = |(board, pulses): (u8, Vec<&Pulses>)| (board, period(&pulses, nominal));
        let periods = boards.into_iter().map(of_board).collect();
        Ok(Self {
            capture,
            pulses,
            unseen,
            nominal,
            clock: range(trace.header.pre_scale.clock()),
            periods,
        })
    }

    fn period(&self, output: &Output) -> f64 {
        let known = self.periods.get(&output.0).copied().flatten();
        known.unwrap_or(self.nominal)
    }

    fn resolution(&self) -> f64 {
        self.capture.resolution_ns as f64
    }

    /// The trains that begin a period and a half after `last`, by their first pulses.
    fn trains(&self, last: f64) -> BTreeMap<Output, Pulses> {
        let first = |(output, pulses): (&Output, &Pulses)| {
            (*output, starts(pulses, self.period(output), last))
        };
        self.pulses.iter().map(first).collect()
    }

    /// Holds every output against the plan. Returns the tallies, and the time of the run at the capture's start,
    /// nanoseconds, if the pulses tell.
    fn tallies(&self, plan: &Plan, window: Span) -> (BTreeMap<Output, Tally>, Option<f64>) {
        let place = |trains: &BTreeMap<Output, Pulses>| {
            let period_of = |output: &Output| self.period(output);
            offset(trains, plan, self.nominal, &period_of, self.resolution())
        };
        // A train that the capture cuts has no start to go by; but a capture may be triggered by its only train.
        let mut trains = self.trains(0.0);
        let mut found = place(&trains);
        if found.is_none() {
            trains = self.trains(f64::NEG_INFINITY);
            found = place(&trains);
        }
        let Some(start) = found else {
            let none = |output: &Output| (*output, Tally::default());
            return (self.pulses.keys().map(none).collect(), None);
        };
        let mut grids = Grids::new();
        let mut tallies = BTreeMap::new();
        for (output, pulses) in &self.pulses {
            let period = self.period(output);
            let late = latency(&trains, plan, output.0, start, period);
            let clock = Clock {
                offset: start - late,
                length: self.capture.end_ns as f64,
                period,
                resolution: self.resolution(),
            };
            let unseen = self.unseen.get(output).map_or(&[][..], Vec::as_slice);
            let seen = (pulses, unseen);
            let found = tally(plan, *output, seen, clock, window, &mut grids);
            tallies.insert(*output, found);
        }
        (tallies, Some(start))
    }

    /// Every measurement with its limits.
    fn measurements(&self, tallies: &BTreeMap<Output, Tally>) -> Vec<Measurement> {
        let mut measurements = Vec::new();
        let hz = 1e9 / self.nominal;
        // A clock may be stated better than the analyser's samples tell its period.
        let sampled = 2.0 * self.resolution() / self.nominal;
        for (board, period) in &self.periods {
            measurements.push(Measurement::new(
                format!("PWM frequency, board {board}"),
                period.map(|p| 1e9 / p),
                "Hz",
                hz * (self.clock.0 - sampled),
                hz * (self.clock.1 + sampled),
            ));
        }
        for (output, tally) in tallies {
            let tick_us = self.period(output) / 4096.0 / 1e3;
            let most = tick_us + 2.0 * self.resolution() / 1e3;
            let at = format!("board {} channel {}", output.0, output.1);
            let measured = |name: &str, value, unit, most| {
                Measurement::new(format!("{name}, {at}"), value, unit, 0.0, most)
            };
            if tally.seen > 0 {
                measurements.push(measured("pulse width off by", tally.width_us, "us", most));
                measurements.push(measured("phase off by", tally.phase_us, "us", most));
            }
            for (name, count) in [
                ("blank periods", tally.blank),
                ("missing pulses", tally.missing),
                ("stray pulses", tally.stray),
            ] {
                measurements.push(measured(name, Some(count as f64), "", 0.0));
            }
        }
        measurements
    }
}

/// Holds a capture against the schedule of a run, or against a window of it: seconds of the run, from and to.
///
/// # Errors
/// [`Failure::Input`] for a pin that is not there, or two signals on one.
pub fn compare(
    trace: &Trace,
    capture: &Capture,
    pins: &Pins,
    window: Option<(f64, f64)>,
) -> Result<Comparison, Failure> {
    let plan = bursts(trace);
    let (from_s, to_s) = window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let window = Span {
        from_ns: from_s * 1e9,
        to_ns: to_s * 1e9,
    };
    let seen = Seen::new(trace, &plan, capture, pins)?;
    let (tallies, start) = seen.tallies(&plan, window);
    let all_pulses = seen.pulses.values().map(Vec::len).sum();
    let mut conclusion = Conclusion::default();
    let mut coverage = Coverage::default();
    let length = capture.end_ns as f64;
    match driven(&plan, window) {
        None => conclusion.add(
            Verdict::Incomplete,
            "the schedule drives nothing there, so there is nothing that a capture can show",
        ),
        Some(driven) => {
            let taken = start.map(|start| Span {
                from_ns: start,
                to_ns: start + length,
            });
            coverage = Coverage::new(&plan, &tallies, driven, taken);
            if let Some(start) = start {
                let unrecorded = capture.unrecorded.iter().map(|(from, to)| Span {
                    from_ns: start + *from as f64,
                    to_ns: start + *to as f64,
                });
                let lost: f64 = unrecorded.map(|span| driven.overlap_s(&span)).sum();
                coverage.seconds_seen = (coverage.seconds_seen - lost).max(0.0);
            }
            coverage.conclude(&plan, &tallies, &mut conclusion);
            if start.is_none() {
                conclusion.add(
                    no_edges(length, driven),
                    format!(
                        "no edges: no pulse in {:.3} s of the capture on any of {} outputs that the schedule drives",
                        length * 1e-9,
                        coverage.channels_planned
                    ),
                );
            }
        }
    }
    let measurements = match start {
        Some(_) => seen.measurements(&tallies),
        None => Vec::new(),
    };
    judge(&measurements, &mut conclusion);
    let mut notes = capture.notes.clone();
    let shortest = tallies.values().filter_map(|t| t.shortest_ns);
    let shortest = shortest.fold(f64::INFINITY, f64::min);
    if shortest < 2.0 * seen.resolution() {
        notes.push(format!(
            "the shortest pulse lasts {:.2} us, a sample of the capture {:.2} us: pulses are overlooked below two samples",
            shortest / 1e3,
            seen.resolution() / 1e3
        ));
    }
    Ok(Comparison {
        conclusion,
        coverage,
        offset_s: start.map(|ns| ns * 1e-9),
        pulses: all_pulses,
        measurements,
        notes,
    })
}

/// A silent capture as long as what was driven says that nothing was; a shorter one may have been taken elsewhere.
fn no_edges(length_ns: f64, driven: Span) -> Verdict {
    if length_ns >= driven.to_ns - driven.from_ns {
        Verdict::Failed
    } else {
        Verdict::Incomplete
    }
}

/// Adds what was measured outside its limits, and what could not be measured.
fn judge(measurements: &[Measurement], conclusion: &mut Conclusion) {
    let (unknown, outside): (Vec<&Measurement>, Vec<&Measurement>) = (measurements.iter())
        .filter(|m| !m.good())
        .partition(|m| m.value.is_none());
    if let [first, ..] = outside.as_slice() {
        let why = format!(
            "{} of {} measurements outside their limits, first of all {}",
            outside.len(),
            measurements.len(),
            first.name
        );
        conclusion.add(Verdict::Failed, why);
    }
    if let [first, ..] = unknown.as_slice() {
        let why = format!("too few pulses to measure: {}", first.name);
        conclusion.add(Verdict::Incomplete, why);
    }
}
