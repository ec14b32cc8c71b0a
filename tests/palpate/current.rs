//! Currents that are set, through whole runs: what records say, what reaches the wires, and what a broken converter ends.

use palpate_core::units::Milliamps;
use palpate_files::load_bench;
use palpate_records::trace::Event;
use palpate_run::Outcome;

use super::faults::{outputs_are_off, try_on};

fn sphere(more: &str) -> Outcome {
    try_on(load_bench("set-current").unwrap(), "sphere-along", more).unwrap()
}

fn currents(outcome: &Outcome) -> Vec<Option<Milliamps>> {
    let events = outcome.trace.events.iter();
    let current = |event: &Event| match event {
        Event::Schedule(entry) => Some(entry.current),
        _ => None,
    };
    events.filter_map(current).collect()
}

#[test]
fn a_run_sets_currents_and_its_records_say_them() {
    let outcome = sphere("");
    let currents = currents(&outcome);
    assert!(!currents.is_empty());
    assert!(currents.iter().all(Option::is_some));
    let mut text = Vec::new();
    palpate_records::schedule::write_schedule(&outcome.trace, &mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    let set = text
        .lines()
        .skip(1)
        .filter(|l| l.contains("\"current_ma\""));
    assert_eq!(set.count(), currents.len());
    let wires = |_: &str| outcome.trace.header.wires.clone();
    let again = palpate_records::schedule::read_schedule(&text, wires).unwrap();
    let read = |event: &Event| match event {
        Event::Schedule(entry) => Some(entry.current),
        _ => None,
    };
    let read: Vec<_> = again.events.iter().filter_map(read).collect();
    assert_eq!(read, currents);
    assert!(outputs_are_off(&outcome));
}

#[test]
fn a_weak_level_has_less_current_and_no_narrower_pulse() {
    let outcome = sphere("");
    let entries = outcome.trace.events.iter().filter_map(|event| match event {
        Event::Schedule(entry) => Some(*entry),
        _ => None,
    });
    let entries: Vec<_> = entries.collect();
    let tick_ns = outcome.trace.header.pre_scale.tick_ns() as f64;
    let narrowest = (50e3 / tick_ns).round() as u16;
    let asked = entries.iter().map(|e| e.requested.get()).min();
    assert!(asked >= Some(narrowest), "{asked:?}, {narrowest}");
    let weaker = entries.iter().filter(|e| e.current < Some(Milliamps(1970)));
    let weaker = weaker.count();
    assert!(weaker > 0 && weaker < entries.len(), "{weaker}");
}
