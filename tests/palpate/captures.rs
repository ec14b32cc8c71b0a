//! Captures of emulated pins with something taken out, wherever the plan drives: never a good verdict.

use std::sync::OnceLock;

use palpate_capture::{Capture, Comparison, Signal, compare};
use palpate_files::Setup;
use palpate_records::trace::{Event, Trace, event};
use palpate_records::verdict::Verdict;
use palpate_run::{Input, run};
use proptest::prelude::*;

/// Scenes with bursts of many periods, and with bursts of one.
const SCENES: [&str; 2] = ["sphere-circle", "sphere-along-wood"];
/// A period of the run's boards, ns.
fn period(trace: &Trace) -> u64 {
    trace.header.pre_scale.period_ns()
}

fn trace(scene: usize) -> &'static Trace {
    static TRACES: [OnceLock<Trace>; 2] = [OnceLock::new(), OnceLock::new()];
    TRACES[scene].get_or_init(|| {
        let setup = Setup::load(SCENES[scene], "emulated").unwrap();
        run(&setup, &Input::Scene, 1).unwrap().trace
    })
}

/// The pins of a run, from its start to its end.
fn capture(trace: &Trace) -> Capture {
    let signal = |w: &palpate_records::trace::WireInfo| {
        let name = format!("b{}_ch{}", w.board, w.channel);
        Signal::new(name, edges(trace, w.board, w.channel))
    };
    Capture {
        signals: trace.header.wires.iter().map(signal).collect(),
        resolution_ns: 1,
        end_ns: trace.ledger.length_us * 1000,
        ..Capture::default()
    }
}

fn edges(trace: &Trace, of_board: u8, of_channel: u8) -> Vec<(u64, bool)> {
    let edge = |event: &Event| match *event {
        Event::Edge(event::Edge {
            t_ns,
            board,
            channel,
            high,
        }) if (board, channel) == (of_board, of_channel) => Some((t_ns, high)),
        _ => None,
    };
    trace.events.iter().filter_map(edge).collect()
}

/// Signal, begin and end of every burst, nanoseconds.
fn bursts(trace: &Trace) -> Vec<(usize, u64, u64)> {
    let burst = |event: &Event| match event {
        Event::Schedule(e) if e.width().get() > 0 => {
            let drives = |w: &palpate_records::trace::WireInfo| {
                (w.board, w.channel) == (e.board.0, e.channel.0)
            };
            let signal = trace.header.wires.iter().position(drives)?;
            Some((signal, e.at.as_micros() * 1000, e.until.as_micros() * 1000))
        }
        _ => None,
    };
    trace.events.iter().filter_map(burst).collect()
}

/// What is done to a capture.
#[derive(Clone, Copy, Debug)]
enum Damage {
    /// A burst of one channel is not there.
    Burst,
    /// A signal is not in the file.
    Channel,
    /// A signal has no edge.
    Flat,
    /// All signals are low for a time.
    Silence,
    /// A time is not in the file, and what follows comes earlier.
    Splice,
    /// Lines of the file are not there: levels stay as they were.
    Lines,
    /// The file begins here.
    Begins,
    /// The file ends here.
    Ends,
}

const DAMAGES: [Damage; 8] = [
    Damage::Burst,
    Damage::Channel,
    Damage::Flat,
    Damage::Silence,
    Damage::Splice,
    Damage::Lines,
    Damage::Begins,
    Damage::Ends,
];

/// A level as it was at a time.
fn level(edges: &[(u64, bool)], at: u64) -> bool {
    let before = edges.partition_point(|e| e.0 < at);
    before > 0 && edges[before - 1].1
}

/// Edges without repetitions.
fn put(edges: &mut Vec<(u64, bool)>, at: u64, high: bool) {
    if edges.last().map_or(high, |e| e.1 != high) {
        edges.push((at, high));
    }
}

/// Takes the time from `from` to `to` out of a signal.
fn take_out(signal: &mut Signal, damage: Damage, from: u64, to: u64) {
    let old = std::mem::take(&mut signal.edges);
    let new = &mut signal.edges;
    for &(at, high) in old.iter().filter(|e| e.0 < from) {
        put(new, at, high);
    }
    let resumes = level(&old, to);
    match damage {
        Damage::Burst | Damage::Silence => {
            put(new, from, false);
            put(new, to, resumes);
        }
        Damage::Splice => put(new, from, resumes),
        _ => {}
    }
    let shift = match damage {
        Damage::Splice => to - from,
        _ => 0,
    };
    for &(at, high) in old.iter().filter(|e| e.0 >= to) {
        put(new, at - shift, high);
    }
}

/// A stretch of at least a period, from a place within a burst where a whole period is still to come.
fn stretch(period: u64, burst: (usize, u64, u64), place: f64, length: f64) -> (u64, u64) {
    let (_, from, to) = burst;
    let room = (to - from).saturating_sub(period * 3 / 2);
    let begin = from + (room as f64 * place) as u64;
    // The first period begins with the bus's delay behind the burst.
    let least = if room == 0 {
        period + 1_000_000
    } else {
        period
    };
    (begin, begin + least + (length.powi(3) * 2e9) as u64)
}

fn damaged(trace: &Trace, damage: Damage, pick: f64, place: f64, length: f64) -> Capture {
    let mut seen = capture(trace);
    let bursts = bursts(trace);
    let burst = bursts[(bursts.len() as f64 * pick) as usize];
    let (from, to) = stretch(period(trace), burst, place, length);
    match damage {
        Damage::Burst => {
            take_out(
                &mut seen.signals[burst.0],
                damage,
                burst.1,
                burst.2 + period(trace),
            );
        }
        Damage::Channel => drop(seen.signals.remove(burst.0)),
        Damage::Flat => seen.signals[burst.0].edges.clear(),
        Damage::Silence | Damage::Lines => {
            (seen.signals.iter_mut()).for_each(|s| take_out(s, damage, from, to));
        }
        Damage::Splice => {
            (seen.signals.iter_mut()).for_each(|s| take_out(s, damage, from, to));
            seen.end_ns = seen.end_ns.saturating_sub(to - from).max(from);
        }
        Damage::Begins => {
            let begin = from + period(trace);
            for signal in &mut seen.signals {
                take_out(signal, Damage::Splice, 0, begin);
            }
            seen.end_ns -= begin;
        }
        Damage::Ends => {
            seen.signals
                .iter_mut()
                .for_each(|s| s.edges.retain(|e| e.0 < from));
            seen.end_ns = from;
        }
    }
    seen
}

fn verdict(trace: &Trace, seen: &Capture, window: Option<(f64, f64)>) -> Comparison {
    compare(trace, seen, &[], window).unwrap()
}

#[test]
fn whole_captures_are_good() {
    for scene in 0..SCENES.len() {
        let trace = trace(scene);
        let found = verdict(trace, &capture(trace), None);
        assert_eq!(
            found.conclusion.verdict,
            Verdict::Ok,
            "{:?}",
            found.conclusion
        );
        let coverage = found.coverage;
        assert_eq!(coverage.bursts_seen, bursts(trace).len());
        assert_eq!(coverage.bursts_seen, coverage.bursts_planned);
        assert!((coverage.seconds_seen - coverage.seconds_planned).abs() < 1e-9);
        // A file of edges ends with the last of them.
        let mut seen = capture(trace);
        let last = seen.signals.iter().filter_map(|s| s.edges.last());
        seen.end_ns = last.map(|e| e.0).max().unwrap();
        let found = verdict(trace, &seen, None);
        assert_eq!(
            found.conclusion.verdict,
            Verdict::Ok,
            "{:?}",
            found.conclusion
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn a_capture_that_lacks_something_is_never_good(
        scene in 0..SCENES.len(),
        damage in prop::sample::select(&DAMAGES[..]),
        pick in 0.0..1.0,
        place in 0.0..1.0,
        length in 0.0..1.0,
    ) {
        let trace = trace(scene);
        let seen = damaged(trace, damage, pick, place, length);
        let found = verdict(trace, &seen, None);
        prop_assert_ne!(found.conclusion.verdict, Verdict::Ok, "{:?}", found.coverage);
        prop_assert!(!found.conclusion.why.is_empty());
    }

    /// What lies outside the window may be gone; what lies within may not.
    #[test]
    fn a_window_is_filled_or_not(
        damage in prop::sample::select(&[Damage::Silence, Damage::Lines, Damage::Ends][..]),
        pick in 0.2..0.8,
        place in 0.0..1.0,
        length in 0.0..0.5,
    ) {
        let trace = trace(0);
        let seen = damaged(trace, damage, pick, place, length);
        let bursts = bursts(trace);
        let burst = bursts[(bursts.len() as f64 * pick) as usize];
        let from = burst.1;
        // Between two bursts, before the one that was harmed.
        let before = (0.0, (from as f64 - 5e6) * 1e-9);
        let found = verdict(trace, &seen, Some(before));
        prop_assert_eq!(found.conclusion.verdict, Verdict::Ok, "{:?}", found.conclusion);
        let across = (before.0, (burst.2 as f64) * 1e-9);
        let found = verdict(trace, &seen, Some(across));
        prop_assert_ne!(found.conclusion.verdict, Verdict::Ok, "{:?}", found.coverage);
    }
}
