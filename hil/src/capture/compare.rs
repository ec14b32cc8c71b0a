//! Pulses against the schedule.

use std::collections::BTreeMap;

use palpate_records::trace::{Event, Trace};
use serde::Serialize;

use super::edges::Capture;
use palpate_run::Failure;

/// Slowest and fastest oscillators seen of the chip, over the nominal 25 MHz.
const OSCILLATOR: (f64, f64) = (23.0 / 25.0, 27.4 / 25.0);

/// Board and channel.
type Output = (u8, u8);

/// Names of signals and the outputs they were clipped to; empty: by their names (`..b0_ch3`), else the n-th
/// signal is the n-th output of the schedule.
pub type Pins = [(String, Output)];

/// One measured value with its limits.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measurement {
    /// What was measured, and where.
    pub name: String,
    /// How much; null where there was nothing to measure.
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

    /// Whether it lies within its limits; what could not be measured does not.
    pub fn good(&self) -> bool {
        self.value
            .is_some_and(|v| (self.low..=self.high).contains(&v))
    }
}

/// What a capture came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Time of the run at the start of the capture, seconds.
    pub offset_s: f64,
    /// Bursts of the schedule that lie within the capture.
    pub bursts: usize,
    /// Pulses seen.
    pub pulses: usize,
    /// The measurements.
    pub measurements: Vec<Measurement>,
    /// What the capture cannot tell, and what is wrong with its file.
    pub notes: Vec<String>,
}

/// A channel's pulse train, as scheduled.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Burst {
    from_ns: f64,
    to_ns: f64,
    on: f64,
    width: f64,
}

/// The bursts of every output.
fn bursts(trace: &Trace) -> BTreeMap<Output, Vec<Burst>> {
    let mut found: BTreeMap<Output, Vec<Burst>> = BTreeMap::new();
    let mut open: BTreeMap<Output, Burst> = BTreeMap::new();
    let mut close = |open: &mut BTreeMap<Output, Burst>, output: Output, at: f64| {
        if let Some(mut burst) = open.remove(&output) {
            burst.to_ns = burst.to_ns.min(at);
            found.entry(output).or_default().push(burst);
        }
    };
    for event in &trace.events {
        let at = event.t_ns() as f64;
        match event {
            Event::Schedule(entry) => {
                let output = (entry.board.0, entry.channel.0);
                close(&mut open, output, at);
                if entry.width().get() > 0 {
                    let burst = Burst {
                        from_ns: at,
                        to_ns: entry.until.as_micros() as f64 * 1e3,
                        on: f64::from(entry.on),
                        width: f64::from(entry.width().get()),
                    };
                    open.insert(output, burst);
                }
            }
            Event::AllOff { board, .. } => {
                let outputs: Vec<Output> = open.keys().copied().filter(|o| o.0 == *board).collect();
                outputs.into_iter().for_each(|o| close(&mut open, o, at));
            }
            _ => {}
        }
    }
    found
}

/// `..b0_ch3..` in a name.
fn output_in(name: &str) -> Option<Output> {
    let (_, rest) = name.rsplit_once('b')?;
    let (board, channel) = rest.split_once("_ch")?;
    let digits: String = channel.chars().take_while(char::is_ascii_digit).collect();
    Some((board.parse().ok()?, digits.parse().ok()?))
}

/// Pulses of a signal: rise and width, nanoseconds.
type Pulses = Vec<(f64, f64)>;

/// Finds the signal of every output.
fn assign(
    capture: &Capture,
    outputs: &[Output],
    pins: &Pins,
) -> Result<BTreeMap<Output, Pulses>, Failure> {
    for (name, output) in pins {
        if !capture.signals.iter().any(|s| s.name == *name) {
            let names: Vec<_> = capture.signals.iter().map(|s| s.name.as_str()).collect();
            return Err(Failure::Input(format!(
                "--pin {name}={}:{}: expected a signal of the capture ({})",
                output.0,
                output.1,
                names.join(", ")
            )));
        }
    }
    let by_name = capture.signals.iter().any(|s| output_in(&s.name).is_some());
    let mut assigned = BTreeMap::new();
    for (n, signal) in capture.signals.iter().enumerate() {
        let output = match (pins, by_name) {
            ([], true) => output_in(&signal.name),
            ([], false) => outputs.get(n).copied(),
            (pins, _) => pins.iter().find(|p| p.0 == signal.name).map(|p| p.1),
        };
        if let Some(output) = output {
            let pulses = signal.pulses();
            let pulses = pulses.iter().map(|p| (p.0 as f64, p.1 as f64));
            assigned.insert(output, pulses.collect());
        }
    }
    Ok(assigned)
}

/// The true period of a board: the mean distance of neighbouring pulses of one train.
fn period(pulses: &[&Pulses], nominal: f64) -> Option<f64> {
    let mut distances: Vec<f64> = Vec::new();
    for pulses in pulses {
        let near = pulses.windows(2).map(|p| p[1].0 - p[0].0);
        distances.extend(near.filter(|d| (0.8..1.25).contains(&(d / nominal))));
    }
    distances.sort_by(f64::total_cmp);
    let median = *distances.get(distances.len() / 2)?;
    let close = distances
        .iter()
        .filter(|d| (*d / median - 1.0).abs() < 0.01);
    let (sum, count) = close.fold((0.0, 0.0), |(s, n), d| (s + d, n + 1.0));
    Some(sum / count)
}

/// The time of the capture's start on the schedule's clock: the one that puts most trains on bursts of their
/// width, since bursts come on a grid and a short capture fits many places of it. A train begins up to a period
/// after its burst, so the earliest of all is taken to begin with it.
fn offset(
    trains: &BTreeMap<Output, Pulses>,
    plan: &BTreeMap<Output, Vec<Burst>>,
    period: f64,
    period_of: &impl Fn(&Output) -> f64,
    resolution: f64,
) -> Option<f64> {
    let late = 1.5 * period;
    let first = trains
        .iter()
        .filter_map(|(o, starts)| Some((o, starts.first()?.0)));
    // The output whose trains tell most apart.
    let (output, start) = first.min_by_key(|(o, _)| plan.get(*o).map_or(usize::MAX, Vec::len))?;
    let mut best: Option<(usize, f64)> = None;
    for candidate in plan.get(output)?.iter().map(|b| b.from_ns - start) {
        let mut hits = 0;
        for (output, starts) in trains {
            let Some(bursts) = plan.get(output) else {
                continue;
            };
            let tick = period_of(output) / 4096.0;
            for (start, width) in starts {
                let at = start + candidate;
                let next = bursts.partition_point(|b| b.from_ns <= at + late);
                let burst = next.checked_sub(1).map(|i| &bursts[i]);
                if let Some(burst) = burst.filter(|b| (at - b.from_ns).abs() <= late) {
                    let same = (width - burst.width * tick).abs() <= 0.6 * tick + resolution;
                    hits += 1 + 2 * usize::from(same);
                }
            }
        }
        if best.is_none_or(|(most, _)| hits > most) {
            best = Some((hits, candidate));
        }
    }
    let (_, candidate) = best?;
    let mut earliest = f64::INFINITY;
    for (output, starts) in trains {
        for burst in plan.get(output).into_iter().flatten() {
            let near = starts.partition_point(|s| s.0 + candidate < burst.from_ns - late);
            if let Some((start, _)) = starts.get(near) {
                let lag = start + candidate - burst.from_ns;
                if lag.abs() <= late {
                    earliest = earliest.min(lag);
                }
            }
        }
    }
    Some(candidate - if earliest.is_finite() { earliest } else { 0.0 })
}

/// First pulses of trains: those with more than a period and a half of silence before them, that is after `last`,
/// the time of the last pulse before all these.
fn starts(pulses: &Pulses, period: f64, mut last: f64) -> Pulses {
    let mut found = Vec::new();
    for &(rise, width) in pulses {
        if rise - last > 1.5 * period {
            found.push((rise, width));
        }
        last = rise;
    }
    found
}

/// What one output's pulses came to.
#[derive(Debug, Default)]
struct Tally {
    /// Bursts that lie within the capture.
    bursts: usize,
    width_us: Option<f64>,
    phase_us: Option<f64>,
    blank: u64,
    missing: u64,
    stray: u64,
}

fn raise(worst: &mut Option<f64>, value: f64) {
    *worst = Some(worst.map_or(value, |w| w.max(value)));
}

/// Holds a capture against the schedule of a run.
///
/// # Errors
/// [`Failure::Input`] for a schedule or a capture without pulses, a pin that is not there, or pulses that fit
/// the schedule nowhere.
pub fn compare(trace: &Trace, capture: &Capture, pins: &Pins) -> Result<Comparison, Failure> {
    let input = |what: &str| Failure::Input(format!("the comparison of a capture: {what}"));
    let plan = bursts(trace);
    let outputs: Vec<Output> = match trace.header.wires.as_slice() {
        [] => plan.keys().copied().collect(),
        wires => wires.iter().map(|w| (w.board, w.channel)).collect(),
    };
    let seen = assign(capture, &outputs, pins)?;
    let nominal = trace.header.pre_scale.period_ns() as f64;
    let mut boards: BTreeMap<u8, Vec<&Pulses>> = BTreeMap::new();
    for (output, pulses) in &seen {
        boards.entry(output.0).or_default().push(pulses);
    }
    let periods: BTreeMap<u8, Option<f64>> = boards
        .iter()
        .map(|(board, pulses)| (*board, period(pulses, nominal)))
        .collect();
    let period_of = |output: &Output| periods.get(&output.0).copied().flatten().unwrap_or(nominal);
    let trains = |last: f64| -> BTreeMap<Output, Pulses> {
        let starts = |(output, pulses): (&Output, &Pulses)| {
            (*output, starts(pulses, period_of(output), last))
        };
        seen.iter().map(starts).collect()
    };
    let resolution = capture.resolution_ns as f64;
    // A train that the capture cuts has no start to go by; but a capture may be triggered by its only train.
    let found = offset(&trains(0.0), &plan, nominal, &period_of, resolution);
    let found = found.or_else(|| {
        offset(
            &trains(f64::NEG_INFINITY),
            &plan,
            nominal,
            &period_of,
            resolution,
        )
    });
    let offset = found.ok_or_else(|| {
        input("expected pulses on an output that the schedule drives, found none; `--pin NAME=BOARD:CHANNEL` says which signal is which")
    })?;

    let mut tallies: BTreeMap<Output, Tally> = BTreeMap::new();
    // The first pulse's distance from its place in the period, for each board and burst.
    let mut grids: BTreeMap<(u8, u64), f64> = BTreeMap::new();
    let mut shortest = f64::INFINITY;
    for (output, pulses) in &seen {
        let (period, tally) = (period_of(output), tallies.entry(*output).or_default());
        let tick = period / 4096.0;
        let empty = Vec::new();
        let planned = plan.get(output).unwrap_or(&empty);
        let mut rest = pulses.iter().map(|p| (p.0 + offset, p.1)).peekable();
        let end = capture.end_ns as f64 + offset;
        for (index, burst) in planned.iter().enumerate() {
            while rest.next_if(|p| p.0 < burst.from_ns - resolution).is_some() {
                tally.stray += 1;
            }
            let next = planned.get(index + 1).map_or(f64::INFINITY, |b| b.from_ns);
            let until = (burst.to_ns + 1.25 * period).min(next);
            let mut train: Pulses = Vec::new();
            while let Some(pulse) = rest.next_if(|p| p.0 < until) {
                train.push(pulse);
            }
            if burst.from_ns < offset || until > end {
                continue; // only partly seen
            }
            tally.bursts += 1;
            shortest = shortest.min(burst.width * tick);
            for (n, (rise, width)) in train.iter().enumerate() {
                let follows = |b: &&Burst| n == 0 && b.to_ns >= burst.from_ns;
                let before = index.checked_sub(1).map(|i| &planned[i]).filter(follows);
                let off = |b: &Burst| (width - b.width * tick).abs() / 1e3;
                let deviation = before.map_or(f64::INFINITY, off).min(off(burst));
                raise(&mut tally.width_us, deviation);
                let place = rise - burst.on * tick;
                let grid = *grids
                    .entry((output.0, burst.from_ns as u64))
                    .or_insert(place);
                let turns = (place - grid) / period;
                let phase = (turns - turns.round()) * period;
                if before.is_none() {
                    raise(&mut tally.phase_us, phase.abs() / 1e3);
                }
            }
            let gaps = train.windows(2).map(|p| (p[1].0 - p[0].0) / period);
            let blank: f64 = gaps.map(|g| (g.round() - 1.0).max(0.0)).sum();
            let least = ((burst.to_ns - burst.from_ns) / period - 1e-3)
                .floor()
                .max(0.0);
            tally.blank += blank as u64;
            tally.missing += (least - train.len() as f64).max(blank) as u64;
        }
        tally.stray += rest.count() as u64;
    }

    let mut measurements = Vec::new();
    for (board, period) in &periods {
        let hz = 1e9 / nominal;
        measurements.push(Measurement::new(
            format!("PWM frequency, board {board}"),
            period.map(|p| 1e9 / p),
            "Hz",
            hz * OSCILLATOR.0,
            hz * OSCILLATOR.1,
        ));
    }
    for (output, tally) in &tallies {
        let tick_us = period_of(output) / 4096.0 / 1e3;
        let most = tick_us + 2.0 * resolution / 1e3;
        let at = format!("board {} channel {}", output.0, output.1);
        if tally.bursts > 0 {
            for (name, value) in [
                ("pulse width off by", tally.width_us),
                ("phase off by", tally.phase_us),
            ] {
                measurements.push(Measurement::new(
                    format!("{name}, {at}"),
                    value,
                    "us",
                    0.0,
                    most,
                ));
            }
        }
        for (name, count) in [
            ("blank periods", tally.blank),
            ("missing pulses", tally.missing),
            ("stray pulses", tally.stray),
        ] {
            let value = Some(count as f64);
            measurements.push(Measurement::new(
                format!("{name}, {at}"),
                value,
                "",
                0.0,
                0.0,
            ));
        }
    }
    let mut notes = capture.notes.clone();
    if shortest < 2.0 * resolution {
        notes.push(format!(
            "the shortest pulse lasts {:.2} us, a sample of the capture {:.2} us: pulses are overlooked below two samples",
            shortest / 1e3,
            resolution / 1e3
        ));
    }
    Ok(Comparison {
        offset_s: offset * 1e-9,
        bursts: tallies.values().map(|t| t.bursts).sum(),
        pulses: seen.values().map(Vec::len).sum(),
        measurements,
        notes,
    })
}
