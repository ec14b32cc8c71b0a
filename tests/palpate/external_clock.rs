//! Chips that count by a clock on EXTCLK in a run, and what becomes of it without that clock.

use std::collections::BTreeSet;

use palpate_core::units::{Instant, Ticks};
use palpate_files::{ExternalClock, load_bench};
use palpate_records::trace::{Event, event};
use palpate_records::verdict::Verdict;
use palpate_run::Outcome;

use super::faults::{healthy, outputs_are_off, try_on, try_with, widths_ns};

/// On a bench whose chips count by a clock of 25 MHz on EXTCLK.
fn clocked(faults: &str) -> Result<Outcome, String> {
    let mut bench = load_bench("emulated").unwrap();
    bench.value.drive.clock = Some(ExternalClock {
        hz: 25_000_000,
        tolerance_ppm: 100,
    });
    try_on(bench, "sphere-along", faults)
}

/// When anything was driven.
fn onsets(outcome: &Outcome) -> BTreeSet<Instant> {
    let driven = |event: &Event| match event {
        Event::Schedule(entry) if entry.width() > Ticks::ZERO => Some(entry.at),
        _ => None,
    };
    outcome.trace.events.iter().filter_map(driven).collect()
}

#[test]
fn a_missing_external_clock_moves_nothing_and_the_bus_says_nothing() {
    let fault = "[[faults]]\nat_s = 0.0\nkind = \"clock-stopped\"\nboard = 0";
    let outcome = clocked(fault).unwrap();
    assert!(widths_ns(&outcome).is_empty());
    assert!(outcome.failure.is_none() && outcome.summary.stimuli > 30);
    let refused = try_with("sphere-along", fault).unwrap_err();
    assert!(
        refused.contains("faults[0].kind") && refused.contains("drive.clock"),
        "{refused}"
    );
}

#[test]
fn an_external_clock_that_stops_in_mid_pulse_leaves_the_wire_on() {
    let clean = clocked("").unwrap();
    // The other spacing makes other widths, and a wire of one tick may have none; but every onset comes, at its time.
    assert_eq!(onsets(&clean), onsets(&healthy()));
    let high = |e: &Event| match e {
        Event::Edge(event::Edge {
            t_ns, high: true, ..
        }) if *t_ns > 1_500_000_000 => Some(*t_ns),
        _ => None,
    };
    let rose = clean.trace.events.iter().find_map(high).unwrap();
    let at = (rose / 1000 + 5) as f64 * 1e-6;
    let until = at + 0.03;
    let fault =
        format!("[[faults]]\nat_s = {at}\nuntil_s = {until}\nkind = \"clock-stopped\"\nboard = 0");
    let stopped = clocked(&fault).unwrap();
    // The chip takes writes, and none of them reaches an output before the clock is back.
    let longest = widths_ns(&stopped).into_iter().max().unwrap();
    assert!((30_000_000..30_300_000).contains(&longest), "{longest}");
    // A wire that is on for so long passes 400 C.
    assert_eq!(stopped.summary.conclusion.verdict, Verdict::BeyondTheModel);
    assert!(outputs_are_off(&stopped));
}
