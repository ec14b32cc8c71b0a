//! `palpate-link display`: renders frames of a finger on a bench's outputs, emulated ones or those of `hil run`.

use std::sync::Arc;
use std::sync::mpsc::sync_channel;

use palpate_buses::pacer::RunClock;
use palpate_buses::signals::Signals;
use palpate_core::projector::Projector;
use palpate_files::Setup;
use palpate_live::host;
use palpate_live::link::UnitPlace;
use palpate_live::output::note;
use palpate_live::real::{self, Heat, Watched};
use palpate_live::views::Wanted;
use palpate_run::wires::EmulatedDisplay;
use palpate_run::{Failure, Policy, build, pass};

use super::feeling::{Feeling, Finger};
use super::heard::{Heard, Waiting};
use super::inbox::Inbox;
use super::shrunk::{Rest, levels};
use crate::cli::DisplayArgs;
use crate::net::{self, Mode};

/// Messages that wait for the loop at most: more than a turn of any skin.
const MOST_WAITING: usize = 512;
/// Lines for people that wait at most.
const MOST_SAID: usize = 64;

/// Runs it.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn run(args: &DisplayArgs) -> Result<(), Failure> {
    let setup = args.setup()?;
    let bench = &setup.bench.value;
    if !setup.fingers.is_empty() {
        return Err(Failure::Input(format!(
            "bench `{}`: expected one display; a wearer of several fingers runs one `palpate-link display` per finger",
            bench.name
        )));
    }
    if !bench.is_hardware() {
        let wanted = Wanted {
            quiet: args.quiet,
            ..Wanted::default()
        };
        let (setup, _) = host::passed(&setup, args.on.seed, wanted)?;
        return feel(args, (&setup, false), Some(false), |setup, projector, _| {
            let display = EmulatedDisplay::new(setup, projector, args.on.seed)?;
            Ok((display, Policy::emulated(setup.bench.value.unit.is_some())))
        });
    }
    // Before anything is opened, and before a relay is waited for.
    real::refuse_stopped(&setup)?;
    real::dies_at_once();
    let realtime = bench.real.as_ref().and_then(|real| real.realtime);
    // The skin is elsewhere, so cold wires are passed while it is untouched. Until then the loop plans for passed ones.
    let mut setup = real::known(&setup)?;
    let is_cold = pass::is_due(&setup) && pass::lasts(&setup);
    if is_cold {
        pass::set_passed(&mut setup);
    }
    match UnitPlace::find(&setup.bench)? {
        None => {
            let (setup, heat) = Heat::alone(&setup)?;
            feel(
                args,
                (&setup, is_cold),
                realtime,
                |setup, projector, clock| {
                    let outputs = real::open_outputs(setup, heat, projector, clock)?;
                    Ok((outputs, Policy::REAL))
                },
            )
        }
        Some(place) => {
            let (setup, notes) = real::met(&setup, &place)?;
            if !args.quiet {
                notes.iter().for_each(|text| note(text));
            }
            let (setup, heat) = Heat::alone(&setup)?;
            feel(args, (&setup, is_cold), realtime, |setup, _, clock| {
                Ok((real::open_unit(setup, heat, &place, clock)?, Policy::REAL))
            })
        }
    }
}

/// Feels on a setup whose wires may be cold: meets the publisher, opens the outputs last, and feels on a thread of its own.
fn feel<D: Watched + Send>(
    args: &DisplayArgs,
    (setup, is_cold): (&Setup, bool),
    realtime: Option<bool>,
    outputs: impl FnOnce(&Setup, &Projector, RunClock) -> Result<(D, Policy), Failure>,
) -> Result<(), Failure> {
    let signals = Signals::catch().map_err(|e| Failure::Device(e.to_string()))?;
    let net = net::open(&args.at.at(), Mode::Peer, &signals)?;
    let wearer = net.wearer(&args.wearer)?;
    let again = args.at.is_twice(args.twice);
    let again = again.then(|| net::open_beside(&args.at.at())).flatten();
    let seed = args.on.seed;
    let levels = levels(setup, seed)?;
    let projector = build(setup, seed, levels.clone())?;
    let clock = RunClock::start();
    let waiting: Waiting = Arc::new(Inbox::new(MOST_WAITING));
    let rest = Rest {
        setup: Arc::new(setup.clone()),
        seed,
        levels,
    };
    let heard = Heard::begin((&net, again), (args, &wearer), (clock, rest), &waiting)?;
    let finger = Finger {
        args,
        wearer: &wearer,
        setup,
        net: &net,
        realtime,
        is_cold,
    };
    let (says, said) = sync_channel(MOST_SAID);
    let outputs = |projector: &Projector| outputs(setup, projector, clock);
    let feeling = Feeling::new(finger, projector, outputs, (clock, waiting), says)?;
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new()
            .name("loop".into())
            .spawn_scoped(scope, || feeling.until(&signals, &heard));
        let thread = thread.map_err(|e| Failure::Device(format!("the loop's thread: {e}")))?;
        said.iter().for_each(|text| note(&text));
        thread.join().map_err(|_| real::panicked())?
    })
}
