//! Alignment of a capture to a run: the signal of each output, each board's period, and the start of the capture.

use std::collections::BTreeMap;

use super::edges::{Capture, Signal};
use super::plan::{Output, Plan};
use palpate_core::statistics::quantile;
use palpate_run::Failure;

/// Names of signals and the outputs they were clipped to; empty: by their names (`..b0_ch3`), else the n-th
/// signal is the n-th output of the schedule.
pub type Pins = [(String, Output)];

/// `..b0_ch3..` in a name.
fn output_in(name: &str) -> Option<Output> {
    let (_, rest) = name.rsplit_once('b')?;
    let (board, channel) = rest.split_once("_ch")?;
    let digits: String = channel.chars().take_while(char::is_ascii_digit).collect();
    Some((board.parse().ok()?, digits.parse().ok()?))
}

/// The bus that a signal belongs to, and its bit: `pwm[3]`.
fn bit_of(name: &str) -> Option<(&str, usize)> {
    let (bus, bit) = name.strip_suffix(']')?.rsplit_once('[')?;
    Some((bus, bit.parse().ok()?))
}

/// Returns true if all signals are bits of one bus: then their numbers count, and not their order in the file.
fn is_bus(signals: &[Signal]) -> bool {
    let mut buses = signals.iter().map(|s| bit_of(&s.name).map(|(bus, _)| bus));
    match buses.next() {
        Some(Some(first)) => buses.all(|bus| bus == Some(first)),
        _ => false,
    }
}

/// Pulses of a signal: rise and width, nanoseconds.
pub(super) type Pulses = Vec<(f64, f64)>;

/// Observation of an output: its pulses, and the times between which its level is unknown, nanoseconds.
pub(super) type Watched = (Pulses, Vec<(f64, f64)>);

/// Finds the signal of every output.
pub(super) fn assign(
    capture: &Capture,
    outputs: &[Output],
    pins: &Pins,
    nominal: f64,
) -> Result<BTreeMap<Output, Watched>, Failure> {
    for (name, output) in pins {
        if !capture.signals.iter().any(|s| s.is_called(name)) {
            let names: Vec<_> = capture.signals.iter().map(|s| s.name.as_str()).collect();
            return Err(Failure::Input(format!(
                "--pin {name}={}:{}: expected a signal of the capture ({})",
                output.0,
                output.1,
                names.join(", ")
            )));
        }
    }
    let bus = is_bus(&capture.signals);
    let by_name = capture.signals.iter().any(|s| output_in(&s.name).is_some());
    let mut assigned = BTreeMap::new();
    for (n, signal) in capture.signals.iter().enumerate() {
        let output = match (pins, by_name) {
            ([], true) => output_in(&signal.name),
            ([], false) => {
                let bit = bit_of(&signal.name).filter(|_| bus).map(|(_, bit)| bit);
                outputs.get(bit.unwrap_or(n)).copied()
            }
            (pins, _) => pins.iter().find(|p| signal.is_called(&p.0)).map(|p| p.1),
        };
        if let Some(output) = output {
            let pulses = signal.pulses(capture.end_ns, (1.25 * nominal) as u64);
            let pulses = pulses.iter().map(|p| (p.0 as f64, p.1 as f64));
            let unseen = signal.unseen.iter().chain(&capture.unrecorded);
            let unseen = unseen
                .map(|(from, to)| (*from as f64, *to as f64))
                .collect();
            if assigned
                .insert(output, (pulses.collect(), unseen))
                .is_some()
            {
                return Err(Failure::Input(format!(
                    "the comparison of a capture: expected one signal for board {} channel {}, found two; `--pin NAME=BOARD:CHANNEL` says which",
                    output.0, output.1
                )));
            }
        }
    }
    Ok(assigned)
}

/// The true period of a board: the mean distance of neighbouring pulses of one train.
pub(super) fn period(pulses: &[&Pulses], nominal: f64) -> Option<f64> {
    let mut distances: Vec<f64> = Vec::new();
    for pulses in pulses {
        let near = pulses.windows(2).map(|p| p[1].0 - p[0].0);
        distances.extend(near.filter(|d| (0.8..1.25).contains(&(d / nominal))));
    }
    distances.sort_unstable_by(f64::total_cmp);
    let median = quantile(&distances, 0.5)?.above;
    let close = distances
        .iter()
        .filter(|d| (*d / median - 1.0).abs() < 0.01);
    let (sum, count) = close.fold((0.0, 0.0), |(s, n), d| (s + d, n + 1.0));
    Some(sum / count)
}

/// Finds the time of the capture's start on the schedule's clock: the one that puts most trains on bursts of their
/// width, since bursts come on a grid and a short capture fits many places of it. A train begins up to a period after
/// its burst, so the earliest of all is taken to begin with it.
pub(super) fn offset(
    trains: &BTreeMap<Output, Pulses>,
    plan: &Plan,
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
pub(super) fn starts(pulses: &Pulses, period: f64, mut last: f64) -> Pulses {
    let mut found = Vec::new();
    for &(rise, width) in pulses {
        if rise - last > 1.5 * period {
            found.push((rise, width));
        }
        last = rise;
    }
    found
}

/// Delay of a board's earliest train after its place in the schedule, nanoseconds. Trains are as in [`offset`], already
/// on the run's clock but for this delay.
pub(super) fn latency(
    trains: &BTreeMap<Output, Pulses>,
    plan: &Plan,
    board: u8,
    offset: f64,
    period: f64,
) -> f64 {
    let mut least = f64::INFINITY;
    for (output, starts) in trains.iter().filter(|(output, _)| output.0 == board) {
        for burst in plan.get(output).into_iter().flatten() {
            let near = starts.partition_point(|s| s.0 + offset < burst.from_ns - 1.0);
            if let Some((rise, _)) = starts.get(near) {
                let lag = rise + offset - burst.from_ns;
                if lag <= 1.5 * period {
                    least = least.min(lag - burst.on * period / 4096.0);
                }
            }
        }
    }
    if least.is_finite() { least } else { 0.0 }
}
