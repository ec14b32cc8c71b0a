//! A driver unit over UDP, driven by its host in real time.

use std::net::SocketAddr;
use std::time::Duration as Patience;

use palpate_buses::datagrams::{Datagrams, address, is_closed};
use palpate_buses::hardware::Hardware;
use palpate_buses::pacer::RunClock;
use palpate_core::codec::link::{
    Buffer, Header, Hello, Key, MOST, Refusal, State, Status, VERSION,
};
use palpate_core::driver::{
    Actuators, Driver, DriverError, Traffic, UnitDriver, UnitFault, UnitSettings,
};
use palpate_core::guard::Guarded;
use palpate_core::units::{Board, Duration, Instant};
use palpate_files::{Bench, Loaded};
use palpate_records::trace::Event;
use palpate_run::Failure;
use palpate_run::unit::UnitReport;

use super::key;

/// Longest wait for a unit's answer, and for another host to be gone.
const PATIENCE: Duration = Duration::from_millis(2000);
/// Longest wait for a unit's word that everything is off.
const OFF: Duration = Duration::from_millis(500);
/// Longest wait for a computer's word that a port is closed.
const CLOSED: Patience = Patience::from_millis(300);
/// Time between two looks at the socket.
const LOOK: Duration = Duration::from_micros(500);

/// Address of a unit, and the key that is shared with it.
#[derive(Clone)]
pub struct UnitPlace {
    /// Name of the unit as the user gave it.
    pub name: String,
    /// Address of datagrams to the unit.
    pub at: SocketAddr,
    /// The key.
    pub key: [u8; 32],
}

impl UnitPlace {
    /// The unit of a bench; `None` for a bench without one that is there.
    ///
    /// # Errors
    /// [`Failure::Input`] for an address or key file that is none.
    pub fn find(bench: &Loaded<Bench>) -> Result<Option<Self>, Failure> {
        let (Some(name), Some(path)) = (bench.value.unit_address(), bench.unit_key()) else {
            return Ok(None);
        };
        let at = address(name).map_err(|expected| {
            let expected = expected.trim_start_matches("expected ");
            Failure::File(bench.source.bad("unit.address", expected))
        })?;
        Ok(Some(Self {
            name: name.into(),
            at,
            key: key::read(&path)?,
        }))
    }

    /// Hardware whose lock and stops concern runs on this unit.
    pub fn hardware(&self) -> Hardware {
        Hardware::unit(&self.name, &self.key)
    }
}

/// A unit over UDP.
pub struct RemoteUnit {
    place: UnitPlace,
    key: Key,
    clock: RunClock,
    socket: Datagrams,
    driver: UnitDriver,
    reading: Option<Instant>,
    state: State,
    boards: u8,
    /// First status in this run: the unit's counters run since its own start.
    before: Option<Status>,
    /// The newest status of any session.
    newest: Option<Status>,
    /// Address that the unit answers from beside its own.
    other: Option<SocketAddr>,
    /// Version of the link that another program there speaks.
    version: Option<u8>,
}

impl RemoteUnit {
    /// The host's end for a unit; nothing is sent yet. `delay_ms` is from an onset to its effect.
    ///
    /// # Errors
    /// [`Failure::Device`] where the system gives no socket.
    pub fn open(place: &UnitPlace, delay_ms: u32, clock: RunClock) -> Result<Self, Failure> {
        let socket = Datagrams::towards(place.at);
        let nonce = u64::from_le_bytes(key::random()?);
        let settings = UnitSettings {
            delay: Duration::from_micros(u64::from(delay_ms) * 1000),
            // A person wears it: a stop is a person's to end.
            resumes: false,
        };
        Ok(Self {
            key: Key::new(&place.key),
            socket: socket.map_err(|e| Failure::Device(format!("unit {}: {e}", place.name)))?,
            driver: UnitDriver::new(&place.key, nonce, settings),
            clock,
            reading: None,
            state: State::Ready,
            boards: 0,
            before: None,
            newest: None,
            other: None,
            version: None,
            place: place.clone(),
        })
    }

    /// Begins a session.
    ///
    /// # Errors
    /// [`Failure::Device`] with why there is none.
    pub fn connect(&mut self) -> Result<Hello, Failure> {
        let ready = |unit: &Self, now| unit.driver.ready(now).is_ok();
        self.until(PATIENCE, ready)
            .then(|| self.driver.hello().copied())
            .flatten()
            .ok_or_else(|| self.refused())
    }

    /// Switches everything off for good: until a host that begins after this. Another host does not keep it from that.
    /// Whether it had stopped before.
    ///
    /// # Errors
    /// [`Failure::Device`] where it does not say that it did.
    pub fn stop(&mut self) -> Result<Option<Status>, Failure> {
        self.driver.stop();
        match self.until(PATIENCE, |unit, _| !unit.driver.is_asking()) {
            true => Ok(self.driver.status().copied()),
            false => Err(self.refused()),
        }
    }

    /// Asks who is there and begins no session. Returns the answer, the round trip of the shortest exchange, and the
    /// time of that answer by the clock here.
    ///
    /// # Errors
    /// [`Failure::Device`] where nothing answers under this key.
    pub fn ask(&mut self, times: usize) -> Result<(Hello, Duration, Instant), Failure> {
        let mut best: Option<(Hello, Duration, Instant)> = None;
        for _ in 0..times {
            self.driver.give_up();
            let sent = self.clock.now();
            self.send();
            let wait = sent + PATIENCE;
            while self.driver.hello().is_none() && self.clock.now() < wait {
                self.clock.sleep_until(self.clock.now() + LOOK);
                self.hear(&mut Vec::new());
                if self.driver.hello().is_none() {
                    self.send();
                }
            }
            let heard = self.clock.now();
            let Some(hello) = self.driver.hello().copied() else {
                return Err(self.refused());
            };
            let trip = heard.since(sent);
            if best.is_none_or(|(_, shortest, _)| trip < shortest) {
                let half = Duration::from_micros(trip.as_micros() / 2);
                best = Some((hello, trip, sent + half));
            }
        }
        self.strange().map_or(Ok(()), Err)?;
        best.ok_or_else(|| self.refused())
    }

    /// Exchanges datagrams until `done`. Returns whether it was so in time.
    fn until(&mut self, patience: Duration, done: impl Fn(&Self, Instant) -> bool) -> bool {
        let end = self.clock.now() + patience;
        loop {
            self.hear(&mut Vec::new());
            self.send();
            let now = self.clock.now();
            if self.other.is_some() || done(self, now) {
                return self.other.is_none();
            }
            if now >= end {
                return false;
            }
            self.clock.sleep_until(now + LOOK);
        }
    }

    /// Failure for a session that did not begin.
    fn refused(&self) -> Failure {
        if let Some(strange) = self.strange() {
            return strange;
        }
        let (name, at) = (&self.place.name, self.place.at);
        let seconds = PATIENCE.as_micros() / 1_000_000;
        let why = match self.driver.ready(self.clock.now()) {
            Err(UnitFault::Busy) => format!(
                "another host drives it; end that one (`hil off --unit {name} --key FILE` does), then start again"
            ),
            Err(UnitFault::Silent) | Ok(()) => {
                // The datagram is plain: sealing it needs a nonce of a session, and there is none.
                match is_closed(at, b"?", CLOSED) {
                    true => format!(
                        "expected a unit at {at}, nothing listens there: start it, or name its address"
                    ),
                    false => format!(
                        "expected an answer under this key within {seconds} s, found none: check its power, the network, the address {at}, and that both have the same key (`hil unit` says what it refuses)"
                    ),
                }
            }
            Err(fault) => return Failure::Device(format!("{name}: {fault}")),
        };
        Failure::Device(format!("unit {name}: {why}"))
    }

    /// Failure for a unit that answers from another address or speaks another version; `None` for a good one.
    fn strange(&self) -> Option<Failure> {
        let (name, at) = (&self.place.name, self.place.at);
        let why = match (self.other, self.version) {
            (Some(other), _) => format!(
                "expected answers from {at} alone, found some from {other}: name the address that it answers from, and give each unit a key of its own"
            ),
            (None, Some(found)) if self.driver.hello().is_none() => format!(
                "expected version {VERSION} of the link, found {found}: bring host and unit to the same version"
            ),
            _ => return None,
        };
        Some(Failure::Device(format!("unit {name}: {why}")))
    }

    /// Checks for causes that end a run on the unit at once.
    ///
    /// # Errors
    /// [`Failure::Guard`] for a stop by its own guard, [`Failure::Device`] for answers from another address.
    pub fn check(&self, now: Instant) -> Result<(), Failure> {
        self.strange().map_or(Ok(()), Err)?;
        match self.driver.ready(now) {
            Err(UnitFault::Stopped(cause)) => Err(Failure::Guard(format!(
                "unit {}: stopped by its own guard, {}; outputs are off and stay off",
                self.place.name,
                cause.word()
            ))),
            _ => Ok(()),
        }
    }

    /// The host's end of its link.
    pub const fn driver(&mut self) -> &mut UnitDriver {
        &mut self.driver
    }

    /// Address and key of the unit.
    pub const fn place(&self) -> &UnitPlace {
        &self.place
    }

    /// Sets the time of the newest reading, which every command carries from now on.
    pub fn tell(&mut self, reading: Option<Instant>) {
        self.reading = reading.or(self.reading);
        self.send();
    }

    fn send(&mut self) {
        let mut buffer = [0; MOST];
        let now = self.clock.now();
        if let Some(datagram) = self.driver.datagram(now, self.reading, &mut buffer) {
            self.socket.send(datagram, self.place.at);
        }
    }

    /// Takes the datagrams that have come, and notes a unit that stops or goes on.
    pub fn hear(&mut self, events: &mut Vec<Event>) {
        let mut buffer: Buffer = [0; MOST];
        while let Some((length, from)) = self.socket.receive(&mut buffer) {
            let now = self.clock.now();
            let datagram = &mut buffer[..length];
            let header = Header::read(datagram);
            if from != self.place.at {
                let ours = header.is_ok_and(|h| h.host == self.driver.session());
                if ours && self.key.open(datagram).is_ok() {
                    self.other = Some(from);
                }
                continue;
            }
            if let Err(Refusal::Version(found)) = header {
                self.version = Some(found);
            }
            // Refused datagrams are counted.
            let _ = self.driver.hear(now, datagram);
        }
        let Some(status) = self.driver.status() else {
            return;
        };
        self.before.get_or_insert(*status);
        self.newest = Some(*status);
        if let Some(hello) = self.driver.hello() {
            let carried = hello.wires.iter().rposition(|bits| *bits != 0);
            self.boards = carried.map_or(0, |last| last as u8 + 1);
        }
        if status.state != self.state {
            self.state = status.state;
            let text = match status.state {
                State::Ready => "unit: drives".to_owned(),
                State::Stopped(cause) => format!("unit: stopped, {}", cause.word()),
            };
            events.push(Event::note(self.clock.now(), text));
        }
    }

    /// Switches everything off, and waits until the unit has confirmed it.
    ///
    /// # Errors
    /// The state that is known instead, in words.
    pub fn end(&mut self) -> Result<(), String> {
        match self.until(OFF, |unit, _| !unit.driver.is_asking()) {
            true => Ok(()),
            false => Err(format!(
                "unit {}: it did not say that its outputs are off; it switches off by itself 100 ms after the newest reading",
                self.place.name
            )),
        }
    }

    /// Report of the unit in this run; `None` before its first status.
    pub fn report(&self) -> Option<UnitReport> {
        let (before, newest) = (self.before?, self.newest?);
        let link = self.driver.counts();
        // A unit that began anew counts from zero.
        let since = |now: u32, then: u32| now.checked_sub(then).unwrap_or(now);
        Some(UnitReport {
            begun: since(newest.applied, before.applied),
            limited: since(newest.limited, before.limited),
            dropped: since(newest.dropped, before.dropped),
            late_us: newest.late_us,
            stops: since(newest.stops, before.stops),
            refused: since(newest.refused, before.refused),
            commands: link.sent,
            answers: link.answered,
            lost: link.sent.saturating_sub(link.answered),
            sessions: link.sessions,
        })
    }
}

impl Actuators for RemoteUnit {
    type Error = DriverError;

    fn apply(&mut self, update: &Guarded) -> Result<(), DriverError> {
        self.driver.apply(update)
    }

    fn all_off(&mut self) -> Result<(), DriverError> {
        let told = self.driver.all_off();
        self.send();
        told
    }
}

impl Driver for RemoteUnit {
    fn start(&mut self, now: Instant) -> Result<Instant, DriverError> {
        self.send();
        let ready = self.driver.ready(now).map(|()| now);
        ready.map_err(DriverError::Unit)
    }

    fn verify(&mut self) -> Result<(), DriverError> {
        let ready = self.driver.ready(self.clock.now());
        ready.map_err(DriverError::Unit)
    }

    fn retries(&self) -> u64 {
        0
    }

    fn traffic(&self) -> Traffic {
        Traffic::default()
    }

    fn boards(&self) -> Vec<Board> {
        (0..self.boards).map(Board).collect()
    }
}
