//! `hil off`: everything off, from any state, and what it saw.

use std::time::Duration;

use palpate_buses::guardian::{Latch, Sweeper, Watch};
use palpate_buses::hardware::Hardware;
use palpate_buses::lock::{BusLock, LockError, ask_off};
use palpate_buses::oe::OeLine;

use crate::cli::OffArgs;
use palpate_buses::pacer::RunClock;
use palpate_core::codec::link::State;
use palpate_files::{Bench, Loaded, unnumbered};
use palpate_live::link::{RemoteUnit, UnitPlace};
use palpate_live::output::{note, print};
use palpate_live::real::{forget, watch};
use palpate_run::Failure;

use super::devices::{adapters_alone, bench, bench_of};

/// Time that boards have to answer, and a run that holds the bus to end.
const PATIENCE: Duration = Duration::from_secs(5);

/// Time that all adapters have to answer before the run that holds them is asked to end; one that hangs has longer.
const FIRST: Duration = Duration::from_millis(300);

/// Time between two looks whether a bus is free.
const LOOK: palpate_core::units::Duration = palpate_core::units::Duration::from_millis(2);

/// Switches everything off, ends a run that is driving, and shows or clears a latched stop.
///
/// # Errors
/// [`Failure::Input`] for a bench that is not real, [`Failure::Device`] when not everything is off.
pub fn off(args: &OffArgs) -> Result<(), Failure> {
    let of_unit = bench_of(args.bench.as_deref(), &args.unit)?;
    if let Some(place) = UnitPlace::find(&of_unit)? {
        off_unit(&place, args.unlatch)?;
        return forget_heat(args, &place.name, &of_unit);
    }
    let bench = match args.bench.as_deref() {
        Some(name) => bench(Some(name), &[], &[])?,
        None => adapters_alone(&args.i2c)?,
    };
    let Some(real) = &bench.value.real else {
        return Err(Failure::Input(format!(
            "bench `{}` is emulated: nothing of it drives anything while no program runs it",
            bench.value.name
        )));
    };
    let watch = watch(&bench.value, real);
    let mut lines = Vec::new();
    // Before the lock: a run beside us keeps the line cut until it notices that its guardian ends.
    let oe = watch
        .oe
        .as_ref()
        .map(|(chip, line)| OeLine::cut(chip, *line));
    if let Some(Err(reason)) = &oe {
        note(reason);
    }
    let Swept {
        hardware,
        locks,
        off,
    } = sweep(&watch, &mut lines);
    for hardware in &hardware {
        let lock = locks.iter().find(|lock| lock.hardware().is(hardware));
        tell_stop(hardware, lock, args.unlatch, off.is_ok(), &mut lines)?;
    }
    print(|out| {
        lines
            .iter()
            .try_for_each(|line| writeln!(out, "{}", unnumbered(line)))
    })?;
    off?;
    forget_heat(args, &bench.value.name, &bench)
}

/// Says which stop is kept of hardware, and clears it under its lock where that is wanted and everything `is_off`.
fn tell_stop(
    hardware: &Hardware,
    lock: Option<&BusLock>,
    unlatch: bool,
    is_off: bool,
    lines: &mut Vec<String>,
) -> Result<(), Failure> {
    let latch = Latch::new(hardware);
    // What a dead run left armed is a stop too; while one lives it is not.
    let held = lock.map_or_else(|| latch.read(), |lock| latch.read_locked(lock));
    let Some(held) = held else {
        return Ok(());
    };
    lines.push(format!("{hardware}: stopped earlier: {}", held.cause));
    match lock.filter(|_| is_off) {
        _ if !unlatch => lines.push(format!(
            "{hardware}: stays latched; `hil off --unlatch` clears it"
        )),
        Some(lock) => {
            latch
                .clear(lock)
                .map_err(Failure::written(hardware.to_string()))?;
            lines.push(format!("{hardware}: the stop is cleared"));
        }
        None => {}
    }
    Ok(())
}

/// Forgets heat and dose of what is off, where its name was typed.
fn forget_heat(args: &OffArgs, name: &str, bench: &Loaded<Bench>) -> Result<(), Failure> {
    let Some(typed) = &args.forget_heat else {
        return Ok(());
    };
    if !args.i2c.is_empty() {
        return Err(Failure::Input(
            "--forget-heat: expected --bench or --unit with it, found --i2c: an adapter alone has no name to type".into(),
        ));
    }
    if typed != name {
        return Err(Failure::Input(format!(
            "--forget-heat: expected `{name}`, the name of what was switched off, found `{typed}`; nothing is forgotten"
        )));
    }
    let said = match forget(bench, &args.wearer)? {
        true => "heat and dose are forgotten",
        false => "no heat and no dose was kept",
    };
    print(|out| writeln!(out, "{name}: {said}"))
}

/// [`off`] of a driver unit: it switches off and stops, and only a host that begins after this goes on.
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
    let hardware = place.hardware();
    // A run of this computer ends when its unit has stopped, and keeps that stop.
    let lock = match &stopped {
        Ok(_) => {
            let (mut locks, held) = take_over(std::slice::from_ref(&hardware), &mut lines);
            lines.extend(held);
            locks.pop()
        }
        Err(_) => BusLock::take(&hardware).ok(),
    };
    let is_off = stopped.is_ok();
    tell_stop(&hardware, lock.as_ref(), unlatch, is_off, &mut lines)?;
    print(|out| {
        lines
            .iter()
            .try_for_each(|line| writeln!(out, "{}", unnumbered(line)))
    })?;
    stopped.map(drop)
}

/// Result of switching adapters off.
struct Swept {
    /// Adapters that are there.
    hardware: Vec<Hardware>,
    /// The locks of those that nobody else holds any more.
    locks: Vec<BusLock>,
    /// `Ok` where everything is known to be off, and nobody is left to switch on again.
    off: Result<(), Failure>,
}

/// Switches everything off that answers, ends the runs that hold the buses, and switches off again.
fn sweep(watch: &Watch, lines: &mut Vec<String>) -> Swept {
    let (mut sweeper, missing) = Sweeper::open_some(&watch.buses);
    // At once, side by side, before anything is looked at or anybody is asked.
    let (found, _) = sweeper.off(FIRST);
    lines.extend(found.iter().map(ToString::to_string));
    let (mut hardware, mut unknown) = (Vec::new(), Vec::new());
    for bus in &watch.buses {
        match Hardware::adapter(&bus.path) {
            Ok(known) => hardware.push(known),
            Err(error) => unknown.push(error),
        }
    }
    let (locks, mut wrong) = take_over(&hardware, lines);
    // The error of naming a missing adapter says nothing more than that it is missing.
    unknown.retain(|error| !missing.iter().any(|missing| missing.path == error.path));
    wrong.extend(unknown.iter().map(ToString::to_string));
    wrong.extend(missing.iter().map(ToString::to_string));
    // Once more where nobody else is left to switch on, or for as long as a slow adapter may take.
    let (_, not_off) = sweeper.off(PATIENCE);
    wrong.extend(not_off);
    let off = match wrong.is_empty() {
        true => {
            lines.push("everything is off, and read back".into());
            Ok(())
        }
        false => Err(Failure::Device(format!(
            "not everything is known to be off: {}",
            wrong.join("; ")
        ))),
    };
    Swept {
        hardware,
        locks,
        off,
    }
}

/// Takes the locks of all hardware; whoever holds one is asked through it to switch off and end. Returns the locks, and
/// errors for those still held.
fn take_over(all: &[Hardware], lines: &mut Vec<String>) -> (Vec<BusLock>, Vec<String>) {
    let (clock, mut wrong) = (RunClock::start(), Vec::new());
    let mut locks: Vec<BusLock> = Vec::new();
    for hardware in all {
        // By another name it has been taken over already.
        if locks.iter().any(|lock| lock.hardware().is(hardware)) {
            continue;
        }
        let mut asked = None;
        loop {
            let error = match BusLock::take(hardware) {
                Ok(lock) => {
                    let ended = asked.map(|who| format!("{hardware}: ended {who}"));
                    lines.extend(ended);
                    locks.push(lock);
                    break;
                }
                Err(error) => error,
            };
            let is_held = matches!(error, LockError::Held { .. });
            let late = clock.now().as_micros() > PATIENCE.as_micros() as u64;
            if !is_held || late {
                wrong.push(match is_held {
                    true => format!("{error}; it has not ended, and may switch on again: end it, then type this again"),
                    false => error.to_string(),
                });
                break;
            }
            if asked.is_none() {
                asked = Some(error.holder());
                if let Err(error) = ask_off(hardware) {
                    wrong.push(error.to_string());
                }
            }
            clock.sleep_until(clock.now() + LOOK);
        }
    }
    (locks, wrong)
}
