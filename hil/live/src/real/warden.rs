//! The actuators' end of a finger on a real bench, and the parts that all fingers of the bench share while they run:
//! one guardian, and the line that cuts all outputs.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use palpate_buses::guardian::{Guardian, Lost};
use palpate_buses::i2c::SharedLine;
use palpate_buses::pacer::RunClock;
use palpate_buses::pulse::{Pulse, Round};
use palpate_core::driver::{Banks, Driver, DriverError, HapticFault, Haptics};
use palpate_core::projector::Projector;
use palpate_core::units::{Board, Instant};
use palpate_files::{Bench, BenchHaptics, Loaded, Real, Setup};
use palpate_run::display_end::{DisplayEnd, OutputEnable};
use palpate_run::place::Place;
use palpate_run::{Failure, plan};

use crate::lock::held;

use super::bench::{guarded, real_of, refuse_latched, watch};
use super::clocked::{Clocked, OnLines};
use super::ends::{Watched, lost};
use super::heat::Heat;

/// The guardian of a bench. It hears of fingers only together: one that hangs ends in everything off.
struct Warden {
    guardian: Mutex<Guardian>,
    round: Arc<Round>,
    /// `true` while the guardian waits for heartbeats.
    is_awake: AtomicBool,
    /// Fingers that have their bus, a bit each: OE is released when all have it.
    ready: Mutex<u32>,
    all: u32,
    has_oe: bool,
    parting: Mutex<Parting>,
    heat: Arc<Heat>,
}

/// Words of fingers that have ended.
#[derive(Default)]
struct Parting {
    /// Fingers that have ended, a bit each.
    ended: u32,
    /// Reasons why wires may still be on.
    left: Vec<String>,
    /// Causes that stay latched until a person has looked.
    stopped: Vec<String>,
}

impl Warden {
    fn pulse(&self) -> Pulse {
        held(&self.guardian).pulse()
    }

    /// Takes a finger's turn. From the first one on the guardian waits for heartbeats.
    fn beat(&self, finger: usize, now: Instant) -> Result<(), Lost> {
        let is_due = self.round.turned(Round::bit(finger));
        match is_due || !self.is_awake.swap(true, Ordering::Relaxed) {
            true => held(&self.guardian).beat(now),
            false => Ok(()),
        }
    }

    /// Tells whether the guardian is gone: then nobody would switch off outputs that are left on.
    fn is_gone(&self) -> bool {
        held(&self.guardian).is_gone()
    }

    /// Has the guardian switch everything off now: the program itself is wrong.
    fn give_up(&self, cause: &str) {
        held(&self.guardian).hand_over(cause);
    }

    /// Takes a finger's end, `off` or not; the others go on. With the last one the run is over: the guardian switches
    /// off outputs that are left on, and stops stay latched.
    fn part(&self, own: &Vote, off: Result<(), String>, failed: bool) -> Result<(), String> {
        let mut parting = held(&self.parting);
        self.round.ended(own.finger);
        parting.ended |= Round::bit(own.finger);
        parting
            .left
            .extend(off.as_ref().err().map(|cause| own.named(cause)));
        if parting.ended != self.all {
            return off;
        }
        let mut guardian = held(&self.guardian);
        if !parting.left.is_empty() {
            guardian.hand_over(&parting.left.join("; "));
            return off;
        }
        let stopped = match parting.stopped.is_empty() {
            true => Ok(()),
            false => guardian.stop(&parting.stopped.join("; ")),
        };
        let ended = stopped.map_err(|lost| lost.to_string());
        let ended = ended.and_then(|()| guardian.end());
        match failed && own.name.is_none() {
            // The first failure is the one to tell. A failure of one of several fingers tells nothing of the others'
            // outputs.
            true => ended.or(Ok(())),
            false => ended,
        }
    }
}

/// A finger's part in the bench's shared outputs.
struct Vote {
    warden: Arc<Warden>,
    finger: usize,
    /// Name of the finger's display; none for the only display of a bench.
    name: Option<String>,
}

impl Vote {
    /// A cause, with the name of its finger.
    fn named(&self, cause: &str) -> String {
        let name = self.name.as_ref();
        name.map_or_else(|| cause.to_owned(), |name| format!("{name}: {cause}"))
    }

    /// Latches the finger's stop now: the run may yet die before its end. A stop would end the other fingers too: with
    /// several it comes when all are off.
    fn stop(&self, cause: &str) {
        let named = self.named(cause);
        let guardian = held(&self.warden.guardian);
        // A guardian that is gone ends the run at the next heartbeat.
        let _ = match &self.name {
            None => guardian.stop(&named),
            Some(_) => guardian.latch(&named),
        };
        drop(guardian);
        if self.name.is_some() {
            held(&self.warden.parting).stopped.push(named);
        }
    }
}

impl OutputEnable for Vote {
    /// Takes note that the finger has its bus, or has lost it: a channel that could not be switched off must not drive
    /// on. The line is the guardian's, so that it can cut it when this process is gone.
    fn set_enabled(&self, _now: Instant, enabled: bool) {
        let mut ready = held(&self.warden.ready);
        match enabled {
            true => *ready |= Round::bit(self.finger),
            false => *ready &= !Round::bit(self.finger),
        }
        // A guardian that is gone ends the run at the next heartbeat.
        let _ = held(&self.warden.guardian).set_outputs(*ready == self.warden.all);
    }

    fn cuts(&self) -> bool {
        self.warden.has_oe
    }

    fn words(&self) -> &'static str {
        match self.warden.has_oe {
            true => "outputs off by the OE line",
            false => {
                "no OE line is wired, so boards drive what they were last told until the bus answers"
            }
        }
    }
}

/// A finger whose boards are to be opened.
#[derive(Clone, Copy)]
pub(super) struct Wired<'a> {
    pub(super) place: &'a Place,
    /// The setup that it has alone.
    pub(super) setup: &'a Setup,
    pub(super) projector: &'a Projector,
}

/// A bus of a finger, and the addresses of its boards there.
type OwnLine = (SharedLine, Vec<u8>);

/// Boards of wires on these buses.
pub(super) fn banks(finger: &Wired<'_>, lines: Vec<OwnLine>) -> Result<Banks<SharedLine>, Failure> {
    let (place, bench) = (finger.place, &finger.setup.bench.value);
    let (lines, boards): (Vec<SharedLine>, Vec<Vec<u8>>) = lines.into_iter().unzip();
    let lines = lines.into_iter().zip(boards.iter().map(|own| &**own));
    let banks = Banks::new(lines, finger.projector.guard().prescale());
    let banks = plan::with_converters(bench, banks);
    Ok(match place.alone {
        true => banks,
        false => banks.sharing(&place.channels),
    })
}

/// Drivers of motors on the only bus of a bench.
///
/// # Errors
/// [`Failure::Input`] for motors that no driver can have.
pub(super) fn haptics(
    motors: &BenchHaptics,
    lines: Vec<OwnLine>,
) -> Result<Haptics<SharedLine>, Failure> {
    let line = lines.into_iter().next().map(|(line, _)| line);
    let line = line.ok_or_else(|| Failure::Input("real.i2c: expected an adapter".into()))?;
    let haptics = Haptics::new(line, &plan::motors::channels(motors));
    haptics.map_err(|error| Failure::Input(error.to_string()))
}

/// Command that clears a stop of a bench.
fn way_out(bench: &Loaded<Bench>, real: &Real) -> String {
    let place = match bench.value.haptics {
        // An adapter alone does not say where its motors are.
        Some(_) => format!(" --bench {}", bench.source.label()),
        None => {
            let adapters = real.i2c.iter();
            let adapters = adapters.map(|path| format!(" --i2c {}", path.display()));
            adapters.collect()
        }
    };
    format!("hil off --unlatch{place}")
}

/// The actuators' end of a finger on buses of this computer: boards of wires, or drivers of motors.
pub struct Live<D = Banks<SharedLine>> {
    driver: Clocked<D>,
    vote: Vote,
    /// Command that clears a stop.
    way_out: String,
    /// Outputs that the guardian found driving before it switched everything off, where this is the only display.
    found: String,
}

impl<D: OnLines> Live<D> {
    /// Opens the adapters of a bench for the loops of its fingers, guardian last: from then on it can switch off. Heat
    /// is booked with `heat`, and `make` makes the driver of each finger on its buses. Returns an end for each, and the boards
    /// that the guardian found driving, a line each.
    pub(super) fn open(
        setup: &Setup,
        heat: Heat,
        fingers: &[Wired<'_>],
        clock: RunClock,
        make: impl Fn(&Wired<'_>, Vec<OwnLine>) -> Result<D, Failure>,
    ) -> Result<(Vec<Self>, String), Failure> {
        let real = real_of(setup)?;
        // Displays that the scene does not drive are the guardian's as well.
        let watch = watch(&setup.bench.value, real);
        refuse_latched(&watch)?;
        let (lines, guardian, found) = guarded(&watch)?;
        let warden = Arc::new(Warden {
            guardian: Mutex::new(guardian),
            round: Arc::new(Round::new(fingers.len())),
            is_awake: AtomicBool::new(false),
            ready: Mutex::new(0),
            all: (0..fingers.len()).fold(0, |all, finger| all | Round::bit(finger)),
            has_oe: real.oe.is_some(),
            parting: Mutex::default(),
            heat: Arc::new(heat),
        });
        let mut shares: Vec<Vec<OwnLine>> = fingers.iter().map(|_| vec![]).collect();
        for (bus, line) in lines.into_iter().enumerate() {
            let own = fingers
                .iter()
                .map(|finger| plan::buses(&finger.setup.bench.value));
            let own = own.map(|buses| buses.into_iter().nth(bus).unwrap_or_default());
            let on = own.enumerate().filter(|(_, boards)| !boards.is_empty());
            let on: Vec<(usize, Vec<u8>)> = on.collect();
            let numbers: Vec<usize> = on.iter().map(|(finger, _)| *finger).collect();
            let ends = SharedLine::share(line, warden.pulse(), &warden.round, &numbers);
            for ((finger, boards), end) in on.into_iter().zip(ends) {
                shares[finger].push((end, boards));
            }
        }
        let mut ends = Vec::new();
        for (number, (finger, lines)) in fingers.iter().zip(shares).enumerate() {
            let place = finger.place;
            ends.push(Self {
                driver: Clocked::new(make(finger, lines)?, clock),
                vote: Vote {
                    warden: Arc::clone(&warden),
                    finger: number,
                    name: place.name.clone(),
                },
                way_out: way_out(&setup.bench, real),
                found: match place.name {
                    None => found.clone(),
                    Some(_) => String::new(),
                },
            });
        }
        Ok((ends, found))
    }
}

impl<D: OnLines> DisplayEnd for Live<D> {
    type Update = D::Update;

    fn parts(&mut self) -> (&mut dyn Driver<D::Update>, &dyn OutputEnable) {
        (&mut self.driver, &self.vote)
    }

    /// Explains an error with the errno that the adapter gave.
    fn explain(&self, error: &DriverError) -> String {
        let fault = |board| self.driver.line(board).and_then(SharedLine::last_fault);
        match error {
            DriverError::Bus(board, _) => {
                fault(*board).map_or_else(|| error.to_string(), ToString::to_string)
            }
            // The address is that of all drivers: the actuator tells which.
            DriverError::Haptic(HapticFault::Bus(..)) => {
                let cause = fault(Board(0)).map_or_else(String::new, |own| format!(" ({own})"));
                format!("{error}{cause}")
            }
            _ => error.to_string(),
        }
    }

    fn keep_stopped(&mut self, cause: &str) -> Failure {
        self.vote.stop(cause);
        let whose = if self.vote.name.is_some() { "its " } else { "" };
        Failure::Guard(format!(
            "{cause}; {whose}outputs are off and stay off. Look at the bench, then clear the stop: {}",
            self.way_out
        ))
    }
}

/// The guardian watches over a finger among those of the bench.
impl<D: OnLines> Watched for Live<D> {
    fn found(&self) -> &str {
        &self.found
    }

    fn wait(&self) {
        if let Some(line) = self.driver.line(Board(0)) {
            line.wait();
        }
    }

    fn beat(&mut self, now: Instant) -> Result<(), Failure> {
        self.vote.warden.beat(self.vote.finger, now).map_err(lost)
    }

    fn ledger(&self) -> Option<(&Arc<Heat>, usize)> {
        Some((&self.vote.warden.heat, self.vote.finger))
    }

    fn is_guarded(&self) -> bool {
        !self.vote.warden.is_gone()
    }

    fn abandon(&mut self, cause: &str) {
        self.vote.warden.give_up(cause);
    }

    fn part(&mut self, off: Result<(), String>, failed: bool) -> Result<(), String> {
        self.vote.warden.part(&self.vote, off, failed)
    }
}

/// Has the guardian switch everything off after a panic of the loop. The guardian of the only finger is dropped with
/// it, and acts.
impl<D> Drop for Live<D> {
    fn drop(&mut self) {
        if std::thread::panicking() && self.vote.name.is_some() {
            self.vote.warden.give_up("a loop panicked");
        }
    }
}
