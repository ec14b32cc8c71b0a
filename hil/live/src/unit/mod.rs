//! A driver unit as a process: `palpate-unit` on this computer's clock, over UDP, with emulated boards or those of a Linux
//! I2C adapter. One thread, a turn each millisecond and for each datagram.

mod boards;
mod record;

use std::net::SocketAddr;

use embedded_hal::digital::OutputPin;
use embedded_hal::i2c::I2c;
use palpate_buses::datagrams::Datagrams as Socket;
use palpate_buses::served::wait::{monotonic_ns, wait};
use palpate_buses::signals::Signals;
use palpate_buses::sys::forbid_core_dumps;
use palpate_core::codec::link::{Buffer, Kind};
use palpate_core::contact::Levels;
use palpate_core::guard::{Cause, Guard};
use palpate_core::units::Instant;
use palpate_files::{BenchKind, Real, Setup};
use palpate_run::{Failure, build, plan};
use palpate_unit::{Datagrams, Module, Settings, SettingsError, Unit};
use std::os::fd::AsFd;

use crate::link::key;
use crate::real::{Heat, refuse_slow, take_priority};
use crate::telling::{Teller, Telling};
use boards::{Boards, Emulated, Guarded};
pub use record::Record;
use record::Told;

/// Longest time between two turns, nanoseconds.
const TURN_NS: u64 = 1_000_000;
/// Shortest time between two reports of refused datagrams.
const REFUSED_NS: u64 = 1_000_000_000;

/// Address, key and output of a unit that serves.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Address to listen at; port 0 takes a free one.
    pub listen: SocketAddr,
    /// The key that its host has too.
    pub key: [u8; 32],
    /// Form of the words on standard output.
    pub telling: Telling,
}

/// The link, and the addresses at its other end.
struct Link {
    socket: Socket,
    /// Sender of the newest datagram.
    newest: SocketAddr,
    /// Receiver of the newest status: the host.
    host: SocketAddr,
}

impl Datagrams for Link {
    type Peer = SocketAddr;

    fn receive(&mut self, buffer: &mut Buffer) -> Option<(usize, SocketAddr)> {
        let received = self.socket.receive(buffer)?;
        self.newest = received.1;
        Some(received)
    }

    fn send(&mut self, datagram: &[u8], to: SocketAddr) {
        if Kind::stated_in(datagram) == Some(Kind::Status) {
            self.host = to;
        }
        self.socket.send(datagram, to);
    }
}

/// Serves until a signal comes; everything is off then.
///
/// # Errors
/// [`Failure::Input`] for a bench that no unit can have, [`Failure::Device`] for an address or adapter that is not to be
/// had, or boards that are not known to be off at the end.
pub fn serve(setup: &Setup, options: &Options) -> Result<(), Failure> {
    let bench = &setup.bench.value;
    let projector = build(setup, 1, Levels::Off)?;
    let addresses = plan::boards(bench);
    let boot = u64::from_le_bytes(key::random()?);
    let settings = Settings {
        key: &options.key,
        boot,
        wires: projector.display().wires(),
        addresses: &addresses,
        limits: *projector.guard().limits(),
        plant: *projector.guard().plant(),
        // A processor that runs Linux bears them.
        worn: projector.guard().worn(),
        converters: plan::converters(bench),
    };
    let cannot = |e| Failure::Input(format!("bench `{}`: {e}", bench.name));
    let device = |what: String| move |e: std::io::Error| Failure::Device(format!("{what}: {e}"));
    // A core dump would let an abort in the middle of a burst be noticed late.
    let _ = forbid_core_dumps();
    let signals = Signals::catch().map_err(device("signals".into()))?;
    let listening = device(options.listen.to_string());
    let socket = Socket::listen(options.listen).map_err(&listening)?;
    let here = socket.here().map_err(&listening)?;
    let mut teller = Teller::new(options.telling)?;
    let epoch_ns = monotonic_ns();
    let served = |source, i2c| Told::Serving {
        t_ns: monotonic_ns(),
        address: here,
        source,
        i2c,
        bench: &bench.name,
        boards: &addresses,
        wires: settings.wires.len(),
    };
    let process = Process {
        signals,
        link: Link {
            socket,
            newest: here,
            host: here,
        },
        epoch_ns,
        seen: Seen::default(),
        record: Record::default(),
    };
    match (&bench.real, bench.kind) {
        (Some(real), BenchKind::Real) => {
            if bench.heat.is_some() {
                return Err(Failure::Input(format!(
                    "bench `{}`: expected no [heat] with real boards: this program drives no bridge. A unit with a firmware image does (docs/unit.md)",
                    bench.name
                )));
            }
            refuse_slow_bus(real, &settings).map_err(cannot)??;
            let mut own = setup.clone();
            let heat = Heat::of_boards(&mut own)?;
            let (mut boards, found) = Guarded::open(bench, real, heat)?;
            if real.realtime != Some(false) {
                let taken = take_priority();
                taken.or_else(|refused| match real.realtime {
                    Some(true) => Err(refused),
                    _ => Ok(()),
                })?;
            }
            found
                .lines()
                .for_each(|line| crate::output::note(&format!("{line}; switched off")));
            let Some((line, pin)) = boards.lines() else {
                return Ok(()); // held once
            };
            let mut unit = Unit::new(&settings, line, pin).map_err(cannot)?;
            if let Some(memory) = &own.memory {
                let remembered = unit.remember(memory, shown(monotonic_ns()));
                remembered.map_err(|e| Failure::Guard(format!("heat of earlier runs: {e}")))?;
            }
            let i2c = real.i2c.first().map(|path| path.display().to_string());
            teller.tell(&served("real", i2c.as_deref()))?;
            process.run(unit, boards, teller, "real")
        }
        _ => {
            let boards = Emulated::new(setup, epoch_ns)?;
            let unit = Unit::warming(&settings, boards.lines(), boards.module());
            let unit = unit.map_err(cannot)?;
            teller.tell(&served("emulated", None))?;
            process.run(unit, boards, teller, "emulated")
        }
    }
}

/// Errors of [`refuse_slow`] by the unit's own guard.
fn refuse_slow_bus(
    real: &Real,
    settings: &Settings<'_>,
) -> Result<Result<(), Failure>, SettingsError> {
    let guard = Guard::last_word(settings.limits, settings.plant, settings.wires, None);
    guard
        .map_err(SettingsError::Plant)
        .map(|guard| refuse_slow(real, &guard))
}

/// State that was told last.
#[derive(Default)]
struct Seen {
    host: Option<SocketAddr>,
    sessions: u32,
    stops: u32,
    stopped: Option<Cause>,
    refused: u32,
    refused_ns: u64,
}

/// A unit's process between two turns.
struct Process {
    signals: Signals,
    link: Link,
    /// CLOCK_MONOTONIC at its start.
    epoch_ns: u64,
    seen: Seen,
    record: Record,
}

/// The unit's clock: CLOCK_MONOTONIC itself, so that times of hosts and emulators can be compared with it.
const fn shown(t_ns: u64) -> Instant {
    Instant::from_micros(t_ns / 1000)
}

impl Process {
    /// Runs turns until a signal or a failure. The outputs go off whatever ended it.
    fn run<I: I2c, P: OutputPin, T: Module, B: Boards>(
        mut self,
        mut unit: Unit<I, P, T>,
        mut boards: B,
        mut teller: Teller,
        source: &'static str,
    ) -> Result<(), Failure> {
        let held = boards.ledger().map_or(Ok(()), |heat| {
            heat.begin(&[(shown(monotonic_ns()), unit.guard())])
        });
        if let Err(refused) = held {
            // Nothing is on yet: the good-bye cannot fail in a way that matters more than this.
            let _ = boards.finish(true);
            return Err(refused);
        }
        unit.start(shown(monotonic_ns()));
        let turned = self.turns(&mut unit, &mut boards, &mut teller);
        self.record.counts(unit.counts());
        let mut took = unit.end(shown(monotonic_ns()));
        // Without a guardian nobody else would switch off.
        while !took && !boards.is_guarded() {
            let again_ns = monotonic_ns() + TURN_NS;
            // A wait that fails must not end the tries.
            let _ = wait(&[], again_ns);
            took = unit.end(shown(monotonic_ns()));
        }
        let t_ns = monotonic_ns();
        let last = boards.advance(t_ns.saturating_sub(self.epoch_ns), &mut teller);
        let off = boards.finish(took);
        let booked = boards.ledger().map_or(Ok(()), |heat| {
            heat.end(&[(shown(t_ns), unit.guard())], off == Ok(true))
        });
        self.record.source = source;
        self.record.served_s = t_ns.saturating_sub(self.epoch_ns) as f64 / 1e9;
        self.record.off = off == Ok(true);
        self.record.emulated = boards.flowed();
        let told = teller.finish(&Told::Record(&self.record));
        turned.and(last).and(booked)?;
        match off {
            Ok(true) => told,
            Ok(false) => Err(Failure::Device(
                "not every output is known to be off".into(),
            )),
            Err(cause) => Err(Failure::Device(format!(
                "not every output is known to be off: {cause}"
            ))),
        }
    }

    fn turns<I: I2c, P: OutputPin, T: Module, B: Boards>(
        &mut self,
        unit: &mut Unit<I, P, T>,
        boards: &mut B,
        teller: &mut Teller,
    ) -> Result<(), Failure> {
        let mut due_ns = monotonic_ns();
        while self.signals.caught().is_none() {
            let t_ns = monotonic_ns();
            let late_us = t_ns.saturating_sub(due_ns) / 1000;
            self.record.latest_turn_us = self.record.latest_turn_us.max(late_us);
            boards.advance(t_ns.saturating_sub(self.epoch_ns), teller)?;
            if let Some(heat) = boards.ledger() {
                heat.beat(0, shown(t_ns), unit.guard())?;
            }
            unit.turn(shown(t_ns), &mut self.link);
            self.tell(t_ns, unit, teller)?;
            teller.flush()?;
            let next_ns = unit.next().as_micros().saturating_mul(1000);
            due_ns = next_ns.clamp(t_ns, t_ns + TURN_NS);
            let ready = wait(&[self.link.socket.as_fd()], due_ns)
                .map_err(|e| Failure::Device(format!("waiting: {e}")))?;
            if ready.contains(&true) {
                due_ns = monotonic_ns();
            }
        }
        Ok(())
    }

    /// Tells the news since the last call.
    fn tell<I: I2c, P: OutputPin, T: Module>(
        &mut self,
        t_ns: u64,
        unit: &Unit<I, P, T>,
        teller: &mut Teller,
    ) -> Result<(), Failure> {
        let (counts, seen) = (unit.counts(), &mut self.seen);
        if counts.sessions != seen.sessions {
            (seen.sessions, seen.host) = (counts.sessions, Some(self.link.host));
            teller.tell(&Told::Host {
                t_ns,
                address: self.link.host,
                session: counts.sessions,
            })?;
        }
        if let Some(address) = seen.host.filter(|_| !unit.is_kept(shown(t_ns))) {
            seen.host = None;
            teller.tell(&Told::HostGone { t_ns, address })?;
        }
        let stopped = unit.guard().latched();
        if stopped != seen.stopped || counts.stops != seen.stops {
            (seen.stopped, seen.stops) = (stopped, counts.stops);
            teller.tell(&match stopped {
                Some(cause) => Told::Stopped {
                    t_ns,
                    cause: cause.word(),
                },
                None => Told::DrivesAgain { t_ns },
            })?;
        }
        let refused = counts.refused.wrapping_sub(seen.refused);
        if refused > 0 && t_ns >= seen.refused_ns + REFUSED_NS {
            (seen.refused, seen.refused_ns) = (counts.refused, t_ns);
            teller.tell(&Told::Refused {
                t_ns,
                count: refused,
                address: self.link.newest,
            })?;
        }
        Ok(())
    }
}
