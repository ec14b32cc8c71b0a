//! Health of a bench after a trial, so that the next one begins on a bench that works.

use std::collections::BTreeMap;
use std::time::Duration;

use palpate_buses::guardian::{Latch, Sweeper};
use palpate_buses::hardware::Hardware;
use palpate_records::trace::event;

use palpate_files::{Bench, Overload, Scene, unnumbered};
use palpate_live::real::watch;
use palpate_run::Outcome;

/// Time that an adapter has to read its boards.
const PATIENCE: Duration = Duration::from_secs(1);

/// Complaints about an emulated bench: outputs that stayed on; errors and ill taxels that no fault explains.
pub fn after_emulated(scene: &Scene, outcome: &Outcome) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut pins: BTreeMap<(u8, u8), bool> = BTreeMap::new();
    for edge in outcome.trace.each::<event::Edge>() {
        pins.insert((edge.board, edge.channel), edge.high);
    }
    for ((board, channel), _) in pins.iter().filter(|(_, high)| **high) {
        wrong.push(format!("output {board}:{channel} is still on"));
    }
    let disturbed = !scene.faults.is_empty() || scene.boards.overload == Some(Overload::Overwrite);
    if disturbed {
        return wrong;
    }
    wrong.extend(taxels(outcome));
    for bus in &outcome.summary.buses {
        let errors: u64 = bus.errors.iter().sum();
        if errors > 0 {
            wrong.push(format!("bus {}: {errors} error frames", bus.bus));
        }
        if bus.overflows > 0 {
            wrong.push(format!(
                "bus {}: {} frames not taken in time",
                bus.bus, bus.overflows
            ));
        }
    }
    wrong
}

fn taxels(outcome: &Outcome) -> Vec<String> {
    let t = &outcome.summary.taxels;
    let kinds = [
        (t.dead, "dead"),
        (t.frozen, "frozen"),
        (t.saturated, "saturated"),
        (t.jumping, "jumping"),
    ];
    let some = kinds.into_iter().filter(|(n, _)| *n > 0);
    some.map(|(n, word)| format!("{n} taxels {word}")).collect()
}

/// Complaints about a real bench: a latched stop, a board that does not answer or drives, lost frames, ill taxels.
pub fn after_real(bench: &Bench, outcome: &Outcome) -> Vec<String> {
    let Some(real) = &bench.real else {
        return vec!["it is not real".to_owned()];
    };
    let mut wrong = Vec::new();
    let watch = watch(bench, real);
    // One that is not there is complained of below.
    let adapters = watch.buses.iter();
    for hardware in adapters.filter_map(|bus| Hardware::adapter(&bus.path).ok()) {
        if let Some(held) = Latch::new(&hardware).read() {
            wrong.push(format!("{hardware}: stopped: {}", held.cause));
        }
    }
    match Sweeper::open(&watch.buses) {
        Ok(mut sweeper) => {
            let found = sweeper.look(PATIENCE);
            let bad = found.iter().filter(|b| b.was_driving() || b.seen.is_err());
            wrong.extend(bad.map(|board| unnumbered(&board.to_string())));
        }
        Err(error) => wrong.push(unnumbered(&error.to_string())),
    }
    for can in &outcome.summary.can {
        if can.lost + can.overruns + can.bus_off > 0 {
            wrong.push(format!(
                "{}: {} frames lost, {} overruns, bus-off {} times",
                can.interface, can.lost, can.overruns, can.bus_off
            ));
        }
    }
    wrong.extend(taxels(outcome));
    wrong
}

#[cfg(test)]
#[path = "health_tests.rs"]
mod tests;
