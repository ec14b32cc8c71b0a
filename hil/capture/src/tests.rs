//! Captures of emulated pins, whole and spoilt: what was done to them is what is measured.

use std::fmt::Write;

use palpate_core::units::{Clock, Instant};
use palpate_records::trace::{Event, Trace};
use palpate_records::vcd::write_vcd;

use super::*;
use palpate_files::{Overrides, Setup};
use palpate_records::verdict::Verdict;
use palpate_run::Failure;
use palpate_run::{Input, run};

fn trace() -> Trace {
    // Bursts of seven pulses, so gentle that no limit is met.
    let mut overrides = Overrides::default();
    overrides.scene("the test", "illusion.model", "balanced");
    overrides.bench("the test", "drive.current_ma", 850);
    let setup = Setup::load("sphere-circle", "emulated").unwrap();
    let setup = setup.with(&overrides).unwrap();
    run(&setup, &Input::Scene, 1).unwrap().trace
}

/// The pins as a VCD reader sees them.
fn capture(trace: &Trace) -> Capture {
    let mut out = Vec::new();
    write_vcd(trace, &mut out).unwrap();
    dump::read("a.vcd", out.as_slice()).unwrap()
}

/// Starts a capture later, on a clock with its own zero.
fn shifted(mut capture: Capture, by_ns: u64) -> Capture {
    for signal in &mut capture.signals {
        signal.edges.retain(|e| e.0 >= by_ns);
        signal.edges.iter_mut().for_each(|e| e.0 -= by_ns);
        if signal.edges.first().is_some_and(|e| !e.1) {
            signal.edges.remove(0);
        }
    }
    capture.end_ns -= by_ns;
    capture
}

fn bad(comparison: &Comparison) -> Vec<String> {
    let bad = comparison.measurements.iter().filter(|m| !m.good());
    bad.map(|m| format!("{} = {:?}", m.name, m.value)).collect()
}

/// Drops or changes pulses of a signal in the middle of the capture.
fn spoil(
    capture: &mut Capture,
    signal: usize,
    change: impl Fn(usize, u64, u64) -> Option<(u64, u64)>,
) {
    let end = capture.end_ns;
    let signal = &mut capture.signals[signal];
    let pulses = signal.pulses(end, 6_000_000);
    signal.edges.clear();
    for (n, (rise, width)) in pulses.into_iter().enumerate() {
        if let Some((rise, width)) = change(n, rise, width) {
            signal.edges.push((rise, true));
            signal.edges.push((rise + width, false));
        }
    }
}

#[test]
fn pins_as_scheduled_are_good_wherever_the_capture_begins() {
    let trace = trace();
    for begin in [0, 1_234_567_890] {
        let seen = shifted(capture(&trace), begin);
        let found = compare(&trace, &seen, &[], None).unwrap();
        assert_eq!(bad(&found), [""; 0]);
        assert!(
            found.coverage.bursts_seen > 100 && found.pulses > 1000,
            "{found:?}"
        );
        // Within a period: the chip's own clock decides when a burst begins.
        let error = found.offset_s.unwrap() - begin as f64 * 1e-9;
        assert!(error.abs() < 0.006, "{error}");
        let hz = &found.measurements[0];
        assert!((hz.value.unwrap() - 196.888).abs() < 0.01, "{hz:?}");
    }
}

#[test]
fn a_short_capture_finds_its_place() {
    let trace = trace();
    for n in 0..20 {
        let begin = 900_000_000 + n * 417_000_000;
        let mut seen = shifted(capture(&trace), begin);
        seen.end_ns = 200_000_000;
        let end = seen.end_ns;
        for signal in &mut seen.signals {
            signal.edges.retain(|e| e.0 < end);
        }
        let found = compare(&trace, &seen, &[], None).unwrap();
        assert_eq!(bad(&found), [""; 0], "from {begin} ns");
        let error = found.offset_s.unwrap() - begin as f64 * 1e-9;
        assert!(error.abs() < 0.006, "from {begin} ns: {error}");
    }
}

#[test]
fn what_was_spoilt_is_what_is_measured() {
    let trace = trace();
    let whole = capture(&trace);
    let busy = (0..8)
        .max_by_key(|s| whole.signals[*s].edges.len())
        .unwrap();
    type Change = fn(usize, u64, u64) -> Option<(u64, u64)>;
    let cases: [(&str, Change); 4] = [
        ("pulse width off by", |n, t, w| {
            Some((t, if n == 40 { w + 20_000 } else { w }))
        }),
        ("phase off by", |n, t, w| {
            Some((if n % 7 == 3 { t + 30_000 } else { t }, w))
        }),
        ("blank periods", |n, t, w| (n % 50 != 3).then_some((t, w))),
        ("missing pulses", |n, t, w| {
            (!(30..40).contains(&n)).then_some((t, w))
        }),
    ];
    for (expected, change) in cases {
        let mut seen = whole.clone();
        spoil(&mut seen, busy, change);
        let found = bad(&compare(&trace, &seen, &[], None).unwrap());
        let channel = format!("channel {}", trace.header.wires[busy].channel);
        assert!(
            found
                .iter()
                .any(|f| f.starts_with(expected) && f.contains(&channel)),
            "{expected}: {found:?}"
        );
        assert!(
            found.iter().all(|f| f.contains(&channel)),
            "{expected}: {found:?}"
        );
    }
    // A pulse where nothing is scheduled.
    let mut seen = whole.clone();
    seen.signals[busy].edges.insert(0, (1_000, true));
    seen.signals[busy].edges.insert(1, (125_000, false));
    let found = bad(&compare(&trace, &seen, &[], None).unwrap());
    assert!(
        matches!(found.as_slice(), [one] if one.starts_with("stray pulses")),
        "{found:?}"
    );
    // Another oscillator: 26 MHz is within what chips do, 30 MHz is not.
    for (mhz, good) in [(26, true), (30, false)] {
        let mut seen = whole.clone();
        for edge in seen.signals.iter_mut().flat_map(|s| &mut s.edges) {
            edge.0 = edge.0 * 25 / mhz;
        }
        let found = compare(&trace, &seen, &[], None).unwrap();
        assert_eq!(found.measurements[0].good(), good, "{mhz} MHz");
    }
}

#[test]
fn an_external_clock_is_held_to_its_own_tolerance() {
    let mut trace = trace();
    let seen = capture(&trace);
    let clock = Clock::external(25_000_000, 100).unwrap();
    trace.header.pre_scale = trace.header.pre_scale.with_clock(clock);
    for (ppm, good) in [(0, true), (90, true), (120, false), (40_000, false)] {
        let mut off = seen.clone();
        let edges = off.signals.iter_mut().flat_map(|s| &mut s.edges);
        edges.for_each(|edge| edge.0 += edge.0 * ppm / 1_000_000);
        let found = compare(&trace, &off, &[], None).unwrap();
        assert_eq!(found.measurements[0].good(), good, "{ppm} ppm slow");
    }
}

#[test]
fn exports_of_sigrok_and_saleae_read_like_the_vcd() {
    let trace = trace();
    let whole = shifted(capture(&trace), 900_000_000);
    let until = 300_000_000;
    // Levels of all signals at times that only grow.
    let rows = |times: &mut dyn Iterator<Item = u64>, text: &mut String, stamped: bool| {
        let mut next = vec![0; whole.signals.len()];
        for t in times {
            if stamped {
                write!(text, "{}.{:09},", t / 1_000_000_000, t % 1_000_000_000).unwrap();
            }
            for (n, signal) in whole.signals.iter().enumerate() {
                while signal.edges.get(next[n]).is_some_and(|e| e.0 <= t) {
                    next[n] += 1;
                }
                let high = next[n] > 0 && signal.edges[next[n] - 1].1;
                write!(text, "{}{}", if n > 0 { "," } else { "" }, u8::from(high)).unwrap();
            }
            text.push('\n');
        }
    };
    let names: Vec<_> = (0..8).map(|n| format!("D{n}")).collect();
    let mut sigrok = format!(
        "; CSV generated by libsigrok\n; Channels (8/8): {}\n; Samplerate: 2 MHz\nlogic,logic,logic,logic,logic,logic,logic,logic\n",
        names.join(", ")
    );
    rows(&mut (0..until).step_by(500), &mut sigrok, false);
    let mut saleae = format!("Time [s],{}\n", names.join(","));
    let mut times: Vec<u64> = whole
        .signals
        .iter()
        .flat_map(|s| s.edges.iter().map(|e| e.0))
        .collect();
    times.push(0);
    times.sort_unstable();
    times.dedup();
    rows(
        &mut times.into_iter().filter(|t| *t < until),
        &mut saleae,
        true,
    );
    for (name, text, resolution) in [("sigrok", &sigrok, 500), ("saleae", &saleae, 1000)] {
        let seen = csv::read("a.csv", text.as_bytes()).unwrap();
        assert_eq!(seen.signals[3].name, "D3", "{name}");
        assert!(
            seen.resolution_ns <= resolution,
            "{name}: {}",
            seen.resolution_ns
        );
        let found = compare(&trace, &seen, &[], None).unwrap();
        assert_eq!(bad(&found), [""; 0], "{name}");
        assert_eq!(found.notes, [""; 0], "{name}");
        assert!(
            found.coverage.bursts_seen > 5,
            "{name}: {}",
            found.coverage.bursts_seen
        );
    }
}

#[test]
fn damaged_captures_give_what_came_before_and_name_the_line() {
    let trace = trace();
    let mut text = Vec::new();
    write_vcd(&trace, &mut text).unwrap();
    let lines = text.len() / 2
        + text[text.len() / 2..]
            .iter()
            .position(|b| *b == b'\n')
            .unwrap();
    let mut torn = text[..lines].to_vec();
    torn.extend(b"\n#12z\n");
    let seen = dump::read("a.vcd", &torn[..]).unwrap();
    assert!(
        seen.notes[0].starts_with("a.vcd:") && seen.notes[0].contains("were read"),
        "{:?}",
        seen.notes
    );
    assert!(seen.end_ns > 1_000_000_000);
    let seen = csv::read("a.csv", &b"Time [s],D0\n0.0,0\n0.1,1\n0.2,x\n"[..]).unwrap();
    assert!(seen.notes[0].starts_with("a.csv:4:"), "{:?}", seen.notes);
    assert_eq!(seen.signals[0].edges.len(), 2);
    for (text, line) in [("D0,D1\n0,1\n", 1), ("Time [s],D0\n0.0,5\n", 2), (",\n", 1)] {
        let told = csv::read("a.csv", text.as_bytes()).unwrap_err();
        assert_eq!(told.line, Some(line), "{told}");
    }
    assert!(dump::read("a.vcd", &b"hello"[..]).is_err());
}

/// Edges as Saleae's Logic writes them, up to a time.
fn edges_as_csv(whole: &Capture, until_ns: u64) -> String {
    let mut times: Vec<u64> = (whole.signals.iter())
        .flat_map(|s| s.edges.iter().map(|e| e.0))
        .chain([0])
        .filter(|t| *t < until_ns)
        .collect();
    times.sort_unstable();
    times.dedup();
    let mut text = String::from("Time [s]");
    for signal in &whole.signals {
        write!(text, ",{}", signal.name).unwrap();
    }
    for t in times {
        write!(text, "\n{}.{:09}", t / 1_000_000_000, t % 1_000_000_000).unwrap();
        for signal in &whole.signals {
            let before = signal.edges.partition_point(|e| e.0 <= t);
            let high = before > 0 && signal.edges[before - 1].1;
            write!(text, ",{}", u8::from(high)).unwrap();
        }
    }
    text
}

#[test]
fn captures_that_end_too_early_are_incomplete_unless_a_window_is_filled() {
    let trace = trace();
    let mut vcd = Vec::new();
    write_vcd(&trace, &mut vcd).unwrap();
    let half = dump::read("a.vcd", &vcd[..vcd.len() / 2]).unwrap();
    let whole = capture(&trace);
    let csv = |until| csv::read("a.csv", edges_as_csv(&whole, until).as_bytes()).unwrap();
    let all = compare(&trace, &csv(u64::MAX), &[], None).unwrap();
    assert_eq!(all.conclusion.verdict, Verdict::Ok, "{:?}", all.conclusion);
    for seen in [half, csv(1_200_000_000)] {
        let found = compare(&trace, &seen, &[], None).unwrap();
        let (said, coverage) = (found.conclusion.line(), &found.coverage);
        assert!(said.starts_with("INCOMPLETE: "), "{said}");
        assert!(coverage.bursts_seen > 0 && coverage.bursts_seen < coverage.bursts_planned);
        assert!(coverage.seconds_seen < coverage.seconds_planned - 1.0);
        // The window that it names is one that it fills.
        let (_, named) = said.split_once("--window ").unwrap();
        let (window, _) = named.split_once('`').unwrap();
        let (from, to) = window.split_once("..").unwrap();
        let window = (from.parse().unwrap(), to.parse().unwrap());
        let found = compare(&trace, &seen, &[], Some(window)).unwrap();
        assert_eq!(
            found.conclusion.verdict,
            Verdict::Ok,
            "{:?}",
            found.conclusion
        );
        let wider = Some((window.0, window.1 + 0.03));
        let found = compare(&trace, &seen, &[], wider).unwrap();
        assert_eq!(found.conclusion.verdict, Verdict::Incomplete);
    }
    let idle = compare(&trace, &whole, &[], Some((0.0, 0.5))).unwrap();
    assert_eq!(
        idle.conclusion.verdict,
        Verdict::Incomplete,
        "{:?}",
        idle.conclusion
    );
}

#[test]
fn silence_and_outputs_that_stay_high_are_findings() {
    let trace = trace();
    let whole = capture(&trace);
    let mut silent = whole.clone();
    silent.signals.iter_mut().for_each(|s| s.edges.clear());
    let found = compare(&trace, &silent, &[], None).unwrap();
    assert!(
        found.conclusion.line().starts_with("FAILED: no edges"),
        "{:?}",
        found.conclusion
    );
    silent.end_ns = 500_000_000;
    let found = compare(&trace, &silent, &[], None).unwrap();
    assert_eq!(found.conclusion.verdict, Verdict::Incomplete);
    // Behind the last burst an output rises and stays high.
    let mut stuck = whole.clone();
    let end = whole.end_ns;
    let signal = stuck
        .signals
        .iter_mut()
        .find(|s| !s.edges.is_empty())
        .unwrap();
    let after = signal.edges.last().unwrap().0 + 100_000_000;
    signal.edges.push((after, true));
    stuck.end_ns = end.max(after + 50_000_000);
    let found = compare(&trace, &stuck, &[], None).unwrap();
    assert_eq!(found.conclusion.verdict, Verdict::Failed);
    assert!(
        bad(&found)[0].starts_with("stray pulses"),
        "{:?}",
        bad(&found)
    );
}

#[test]
fn pins_are_said_or_guessed_and_wrong_ones_refused() {
    let trace = trace();
    let mut seen = capture(&trace);
    seen.signals
        .iter_mut()
        .enumerate()
        .for_each(|(n, s)| s.name = format!("D{n}"));
    assert_eq!(bad(&compare(&trace, &seen, &[], None).unwrap()), [""; 0]);
    let swapped = [("D0".to_owned(), (0, 1)), ("D1".to_owned(), (0, 0))];
    assert!(!bad(&compare(&trace, &seen, &swapped, None).unwrap()).is_empty());
    let nowhere = compare(&trace, &seen, &[("D9".to_owned(), (0, 1))], None).unwrap_err();
    assert!(
        matches!(nowhere, Failure::Input(told) if told.contains("D9=0:1") && told.contains("D7"))
    );
    let twice = [("D0".to_owned(), (0, 1)), ("D1".to_owned(), (0, 1))];
    let told = compare(&trace, &seen, &twice, None).unwrap_err();
    assert!(
        told.to_string()
            .contains("one signal for board 0 channel 1")
    );
}

/// The schedule alone decides: a trace without edges is enough.
#[test]
fn a_schedule_without_pins_is_enough() {
    let mut trace = trace();
    let seen = capture(&trace);
    trace.events.retain(|e| !matches!(e, Event::Edge(_)));
    trace.ledger.length_us = Instant::ZERO.as_micros();
    assert_eq!(bad(&compare(&trace, &seen, &[], None).unwrap()), [""; 0]);
}

/// The pins as a dump of text, with some of it changed.
fn text_of(trace: &Trace) -> String {
    let mut out = Vec::new();
    write_vcd(trace, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

#[test]
fn what_was_not_recorded_is_not_low() {
    let trace = trace();
    let text = text_of(&trace);
    let at = |from: u64| {
        let stamp = |line: &&str| {
            line.strip_prefix('#')
                .is_some_and(|t| t.parse().unwrap_or(0) >= from)
        };
        let line = text.lines().find(stamp).unwrap();
        text.find(&format!("{line}\n")).unwrap()
    };
    let (off, on) = (at(1_500_000_000), at(2_500_000_000));
    let codes = text
        .lines()
        .filter_map(|l| l.strip_prefix("$var wire 1 ")?.split(' ').next());
    let all = |level: char| {
        codes
            .clone()
            .map(|code| format!("{level}{code}\n"))
            .collect::<String>()
    };
    let gap = format!(
        "$dumpoff\n{}$end\n#2499999999\n$dumpon\n{}$end\n",
        all('x'),
        all('0')
    );
    let spoilt = [&text[..off], &gap, &text[on..]].concat();
    let seen = dump::read("a.vcd", spoilt.as_bytes()).unwrap();
    assert_eq!(seen.unrecorded.len(), 1);
    let found = compare(&trace, &seen, &[], None).unwrap();
    assert_eq!(
        found.conclusion.verdict,
        Verdict::Incomplete,
        "{:?}",
        found.conclusion
    );
    assert!(found.coverage.seconds_seen < found.coverage.seconds_planned - 0.8);
    for window in [(0.7, 1.4), (2.7, 4.0), (1.0, 3.0)] {
        let found = compare(&trace, &seen, &[], Some(window)).unwrap();
        let verdict = found.conclusion.verdict;
        assert_ne!(
            verdict,
            Verdict::Failed,
            "{window:?}: {:?}",
            found.conclusion
        );
    }
}

#[test]
fn bits_of_a_bus_are_outputs_by_their_numbers() {
    let trace = trace();
    let mut seen = capture(&trace);
    let last = seen.signals.len() - 1;
    for (n, signal) in seen.signals.iter_mut().enumerate() {
        signal.name = format!("pwm[{n}]");
    }
    seen.signals.reverse();
    assert_eq!(bad(&compare(&trace, &seen, &[], None).unwrap()), [""; 0]);
    let pins: Vec<_> = (0..=last)
        .map(|n| {
            (
                format!("pwm[{n}]"),
                (trace.header.wires[n].board, trace.header.wires[n].channel),
            )
        })
        .collect();
    assert_eq!(bad(&compare(&trace, &seen, &pins, None).unwrap()), [""; 0]);
}

#[test]
fn times_of_a_table_have_their_unit_in_any_writing() {
    for (heading, ns) in [
        ("Time (us)", 1000),
        ("time_us", 1000),
        ("Time[ms]", 1_000_000),
        ("time_ns", 1),
        ("Time [s]", 1_000_000_000),
        ("Time", 1_000_000_000),
        ("Milliseconds", 1_000_000),
    ] {
        let text = format!("{heading},D0\n0,0\n1,1\n2,0\n");
        let seen = csv::read("a.csv", text.as_bytes()).unwrap();
        assert_eq!(
            seen.signals[0].edges,
            [(0, false), (ns, true), (2 * ns, false)],
            "{heading}"
        );
    }
}
