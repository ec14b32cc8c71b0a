//! `palpate-link relay`: a place where ends find each other or speak through; they are held to the access list.

use std::time::Duration;

use palpate_buses::pacer::RunClock;
use palpate_buses::signals::Signals;
use palpate_core::units::Instant;
use palpate_live::output::note;
use palpate_run::Failure;

use crate::cli::{RelayArgs, after};
use crate::net::{self, Mode};

/// Time between two looks for a signal.
const LOOK: Duration = Duration::from_millis(50);

/// Waits for a signal, `seconds` at most.
pub(super) fn wait(signals: &Signals, seconds: Option<f64>) {
    let clock = RunClock::start();
    let end = seconds.map_or(Instant::FAR_FUTURE, after);
    let step = palpate_core::units::Duration::from_micros(LOOK.as_micros() as u64);
    while signals.caught().is_none() && clock.now() < end {
        clock.sleep_until((clock.now() + step).min(end));
    }
}

/// Runs it.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn run(args: &RelayArgs) -> Result<(), Failure> {
    let signals = Signals::catch().map_err(|e| Failure::Device(e.to_string()))?;
    let net = net::open(&args.at.at(), Mode::Router, &signals)?;
    let name = net.name.clone().unwrap_or_else(|| "relay".into());
    let _answers = net.answer_who_may_publish(&name)?;
    note("relay: ends with --connect find each other here, those with --relay speak through it");
    wait(&signals, args.seconds);
    Ok(())
}
