//! `hil off`: everything off, from any state, and what it saw.

use std::time::Duration;

use palpate_buses::guardian::{Latch, Sweeper, Watch};
use palpate_buses::lock::BusLock;
use palpate_buses::oe::OeLine;

use crate::cli::OffArgs;
use crate::link::{RemoteUnit, UnitPlace};
use crate::output::{note, print};
use crate::real::watch;
use palpate_buses::pacer::RunClock;
use palpate_core::codec::link::State;
use palpate_run::Failure;

use super::devices::{bench, unit_of};

/// How long a run that holds the bus may take to end, and boards to answer.
const PATIENCE: Duration = Duration::from_secs(5);

/// What one transfer may take.
const TRANSFER: Duration = Duration::from_secs(1);

/// Switches everything off, ends a run that is driving, and shows or clears a latched stop.
///
/// # Errors
/// [`Failure::Input`] for a bench that is not real, [`Failure::Device`] when not everything is off.
pub fn off(args: &OffArgs) -> Result<(), Failure> {
    if let Some(place) = unit_of(args.bench.as_deref(), &args.unit)? {
        return off_unit(&place, args.unlatch);
    }
    let bench = bench(args.bench.as_deref(), &[], &args.i2c)?;
    let Some(real) = &bench.value.real else {
        return Err(Failure::Input(format!(
            "bench `{}` is emulated: nothing of it drives anything while no program runs it",
            bench.value.name
        )));
    };
    let mut watch = watch(&bench.value, real);
    // No loop waits here: an answer counts more than its time.
    watch.transfer = watch.transfer.max(TRANSFER);
    let mut lines = Vec::new();
    // Before the lock: a run beside us keeps the line cut until it notices that its guardian ends.
    let oe = watch
        .oe
        .as_ref()
        .map(|(chip, line)| OeLine::cut(chip, *line));
    if let Some(Err(reason)) = &oe {
        note(reason);
    }
    let result = sweep(&watch, &mut lines);
    for path in watch.buses.iter().map(|bus| &bus.path) {
        let latch = Latch::of(path);
        let Some(held) = latch.read() else {
            continue;
        };
        lines.push(format!(
            "{}: stopped earlier: {}",
            path.display(),
            held.cause
        ));
        if !args.unlatch {
            lines.push(format!(
                "{}: stays latched; `hil off --unlatch` clears it",
                path.display()
            ));
        } else if result.is_ok() {
            latch.clear().map_err(|error| Failure::Write {
                path: path.display().to_string(),
                error,
            })?;
            lines.push(format!("{}: the stop is cleared", path.display()));
        }
    }
    print(|out| lines.iter().try_for_each(|line| writeln!(out, "{line}")))?;
    result
}

/// The same of a driver unit: it switches off and stops, and only a host that begins after this goes on.
fn off_unit(place: &UnitPlace, unlatch: bool) -> Result<(), Failure> {
    let name = &place.name;
    let stopped = RemoteUnit::open(place, 0, RunClock::start())?.stop();
    let mut lines = Vec::new();
    if let Ok(status) = &stopped {
        lines.push(match status.map(|s| s.state) {
            Some(State::Stopped(cause)) => {
                format!("unit {name}: everything is off; stopped: {}", cause.word())
            }
            _ => format!("unit {name}: everything is off"),
        });
        lines.push(format!(
            "unit {name}: no host that runs goes on; `hil run` begins anew"
        ));
    }
    let latch = place.latch();
    if let Some(held) = latch.read() {
        lines.push(format!("unit {name}: stopped earlier: {}", held.cause));
        if !unlatch {
            lines.push(format!(
                "unit {name}: stays latched; `hil off --unlatch` clears it"
            ));
        } else if stopped.is_ok() {
            latch.clear().map_err(|error| Failure::Write {
                path: name.clone(),
                error,
            })?;
            lines.push(format!("unit {name}: the stop is cleared"));
        }
    }
    print(|out| lines.iter().try_for_each(|line| writeln!(out, "{line}")))?;
    stopped.map(drop)
}

/// Takes the buses over and switches everything off.
fn sweep(watch: &Watch, lines: &mut Vec<String>) -> Result<(), Failure> {
    let mut sweeper =
        Sweeper::open(&watch.buses, watch.transfer).map_err(|e| Failure::Device(e.to_string()))?;
    let found = sweeper.look();
    // At once, even while another program has the bus; then again when none has.
    let first = sweeper.off();
    let mut locks = Vec::new();
    for path in watch.buses.iter().map(|bus| &bus.path) {
        match BusLock::take_over(path, PATIENCE) {
            Ok((lock, ended)) => {
                lines.extend(ended.map(|who| format!("{}: ended {who}", path.display())));
                locks.push(lock);
            }
            Err(error) => lines.push(error.to_string()),
        }
    }
    lines.extend(found.iter().map(ToString::to_string));
    let off = sweeper.off_within(PATIENCE).map_err(|second| {
        let reason = first.err().unwrap_or(second);
        Failure::Device(format!("not everything is known to be off: {reason}"))
    });
    if off.is_ok() && locks.len() == watch.buses.len() {
        lines.push("everything is off, and read back".into());
    }
    off
}
