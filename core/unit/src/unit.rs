//! The unit itself: one turn after the other.

use embedded_hal::digital::OutputPin;
use embedded_hal::i2c::I2c;
use palpate_core::codec::link::{
    Buffer, Command, Face, Header, Hello, Key, Kind, MOST, Planned, Refusal, Request, State, Status,
};
use palpate_core::driver::{Actuators, Pca9685Bank, Traffic};
use palpate_core::guard::{Cause, Guard, Guarded, Memory, MemoryError};
use palpate_core::peltier::Regulator;
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Duration, Instant, Milliamps, Ticks};

use crate::counts::Counts;
use crate::phases::Phases;
use crate::schedule::Schedule;
use crate::session::Sessions;
use crate::settings::{Settings, SettingsError};
use crate::warmth::{Module, NoModule, Warm};

/// A turn takes no more datagrams than this, and opens one: the rest waits, so that a flood delays no end of a pulse.
const MOST_AT_ONCE: usize = 8;
/// A stimulus that is later than this is left out: about a PWM period, so that a hand does not feel two at once.
const LATEST: Duration = Duration::from_millis(6);
/// A lost bus is tried again this often.
const RETRY: Duration = Duration::from_millis(20);
/// Registers are read back this often, where nothing is driven.
const VERIFY: Duration = Duration::from_millis(250);
/// Registers are read back this often, where something always is driven.
const VERIFY_AT_LAST: Duration = Duration::from_millis(1000);

/// Transport of datagrams to the unit and from it. Neither call waits.
pub trait Datagrams {
    /// Sender of a datagram.
    type Peer: Copy;

    /// Puts the oldest datagram that waits into `buffer`; returns its length and its sender, or `None`.
    fn receive(&mut self, buffer: &mut Buffer) -> Option<(usize, Self::Peer)>;

    /// Sends a datagram. One that cannot be sent is lost, as any datagram may be.
    fn send(&mut self, datagram: &[u8], to: Self::Peer);
}

/// A driver unit over a bus, the pin that cuts all outputs while it is high, and a Peltier module where it has one.
#[derive(Debug)]
pub struct Unit<I, P, T = NoModule> {
    key: Key,
    sessions: Sessions,
    schedule: Schedule,
    guard: Guard,
    boards: u8,
    bank: Pca9685Bank<I>,
    cut: P,
    warm: Option<Warm<T>>,
    counts: Counts,
    phases: Phases,
    /// Time at which a lost bus is tried again; `None` while the bus is whole.
    lost: Option<Instant>,
    /// Time before which nothing begins: the oscillators start.
    ready: Instant,
    verified: Instant,
    /// Time at which the newest command was taken.
    taken: Instant,
}

impl<I: I2c, P: OutputPin> Unit<I, P> {
    /// A unit that has not begun. All that it will ever allocate, it allocates here.
    ///
    /// # Errors
    /// [`SettingsError`] for settings that no unit can have.
    pub fn new(settings: &Settings<'_>, bus: I, cut: P) -> Result<Self, SettingsError> {
        Self::warming(settings, (bus, cut), None)
    }
}

impl<I: I2c, P: OutputPin, T: Module> Unit<I, P, T> {
    /// Builds a unit with a Peltier module under the fingertip, if there is one. It has not begun.
    ///
    /// # Errors
    /// [`SettingsError`] for settings that no unit can have.
    pub fn warming(
        settings: &Settings<'_>,
        (bus, cut): (I, P),
        module: Option<(T, Regulator)>,
    ) -> Result<Self, SettingsError> {
        settings.check()?;
        let (limits, plant) = (settings.limits, settings.plant);
        let mut guard = Guard::last_word(limits, plant, settings.wires, settings.worn)
            .map_err(SettingsError::Plant)?;
        let mut bank = Pca9685Bank::new(bus, settings.addresses, settings.plant.prescale);
        if let Some(converters) = &settings.converters {
            let control = converters.control;
            guard = guard.with_current(control).map_err(SettingsError::Plant)?;
            bank = bank.with_converters(converters.addresses, control.full_scale);
        }
        Ok(Self {
            key: Key::new(settings.key),
            sessions: Sessions::new(settings.boot),
            schedule: Schedule::new(settings.wires),
            guard,
            boards: settings.addresses.len() as u8, // at most 16
            bank,
            cut,
            warm: module.map(|(module, regulator)| Warm::new(module, regulator)),
            counts: Counts::default(),
            phases: Phases::default(),
            lost: None,
            ready: Instant::ZERO,
            verified: Instant::ZERO,
            taken: Instant::ZERO,
        })
    }

    /// Switches everything off first, whatever was before; then sets the boards up. A bus that does not answer is tried
    /// again by the turns to come.
    pub fn start(&mut self, now: Instant) {
        // A reset lets a bridge go on: it may hold its last current for a tenth of a second.
        if let Some(warm) = &mut self.warm {
            warm.off();
        }
        self.bring_up(now);
    }

    fn bring_up(&mut self, now: Instant) {
        match self.bank.start(now) {
            Ok(ready) => {
                (self.lost, self.ready) = (None, ready);
                self.known_off(now);
                self.set_cut(false);
            }
            Err(_) => {
                self.set_cut(true);
                self.lost = Some(now + RETRY);
            }
        }
    }

    /// Sets the pin that cuts all outputs. Returns whether the pin took it: one that is not wired does not.
    fn set_cut(&mut self, cut: bool) -> bool {
        let set = match cut {
            true => self.cut.set_high(),
            false => self.cut.set_low(),
        };
        set.is_ok()
    }

    /// The guard, to look at.
    pub const fn guard(&self) -> &Guard {
        &self.guard
    }

    /// Goes on from heat and dose that outlived another unit on
    /// the same wires, as of `now`. It belongs before the start.
    ///
    /// # Errors
    /// Figures that no guard can have written.
    pub fn remember(&mut self, memory: &Memory, now: Instant) -> Result<(), MemoryError> {
        self.guard.remember(memory, now)
    }

    /// Counters of the unit.
    pub const fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Tells whether a host has the unit.
    pub fn is_kept(&self, now: Instant) -> bool {
        self.sessions.is_kept(now)
    }

    /// Switches everything off, before the unit's program ends. Returns whether every board took it.
    pub fn end(&mut self, now: Instant) -> bool {
        self.stop(now, Cause::End);
        self.lost.is_none()
    }

    /// Traffic of updates on the unit's bus.
    pub const fn traffic(&self) -> Traffic {
        self.bank.traffic()
    }

    /// Time at which the next turn is due at the latest; a datagram may come before.
    pub fn next(&self) -> Instant {
        let warm = self.warm.as_ref().map(|warm| warm.next(&self.guard));
        if let Some(retry) = self.lost {
            return warm.map_or(retry, |at| at.min(retry));
        }
        let begin = self.schedule.next().map(|at| at.max(self.ready));
        let times = [begin, self.guard.next_expiry(), self.guard.deadline()];
        let verify = self.verified + VERIFY_AT_LAST;
        let times = times.into_iter().chain([warm]).flatten();
        times.fold(verify, Instant::min)
    }

    /// Does what is due at `now`: looks at the watchdog, takes datagrams, ends and begins stimuli, answers. Never waits
    /// for anything but the bus.
    pub fn turn<D: Datagrams>(&mut self, now: Instant, link: &mut D) {
        if let Some(cause) = self.guard.watch(now) {
            self.stop(now, cause);
        }
        let asker = self.receive(now, link);
        if self.lost.is_some_and(|retry| now >= retry) {
            self.bring_up(now);
        }
        if let Some(warm) = &mut self.warm {
            warm.turn(now, &mut self.guard);
        }
        self.begin(now);
        self.expire(now);
        self.verify(now);
        if let Some(peer) = asker {
            self.report(now, link, peer);
        }
    }

    /// Takes the datagrams that wait; returns the sender of the newest command.
    fn receive<D: Datagrams>(&mut self, now: Instant, link: &mut D) -> Option<D::Peer> {
        let mut buffer = [0; MOST];
        let mut asker = None;
        for _ in 0..MOST_AT_ONCE {
            let Some((length, peer)) = link.receive(&mut buffer) else {
                break;
            };
            let datagram = &mut buffer[..length.min(MOST)];
            let header = match self.expected(datagram) {
                Ok(header) => header,
                Err(_) => {
                    self.counts.refused = self.counts.refused.saturating_add(1);
                    if let Some(answer) = Header::other_version(datagram) {
                        link.send(&answer, peer);
                    }
                    continue;
                }
            };
            match self.open(now, &header, datagram) {
                Ok(Some(knock)) => self.greet(now, &knock, link, peer),
                Ok(None) => asker = Some(peer),
                Err(_) => self.counts.refused = self.counts.refused.saturating_add(1),
            }
            // A seal takes a small processor milliseconds: what is due now does not wait for a second one.
            break;
        }
        asker
    }

    /// The header of a datagram that may be of use, before its seal is looked at.
    fn expected(&self, datagram: &[u8]) -> Result<Header, Refusal> {
        let header = Header::read(datagram)?;
        self.sessions.expects(&header)?;
        Ok(header)
    }

    /// Opens a datagram and does what it says; returns a knock's header.
    fn open(
        &mut self,
        now: Instant,
        header: &Header,
        datagram: &mut [u8],
    ) -> Result<Option<Header>, Refusal> {
        let body = self.key.open(datagram)?;
        if header.kind == Kind::Knock {
            return body
                .is_empty()
                .then_some(Some(*header))
                .ok_or(Refusal::Body);
        }
        let command = Command::read(body)?;
        let begins = self.sessions.take(now, header, command.said.request)?;
        if begins {
            // What another session drove is not this host's.
            self.all_off(now);
            self.counts.sessions = self.counts.sessions.saturating_add(1);
            self.counts.late_us = 0;
        }
        self.taken = now;
        self.obey(now, &command);
        Ok(None)
    }

    fn obey(&mut self, now: Instant, command: &Command<'_>) {
        let said = &command.said;
        // A reading from the future would keep outputs on beyond their time.
        if said.reading > Instant::ZERO {
            self.guard.hear(said.reading.min(now));
        }
        if let Some(warm) = &mut self.warm {
            warm.want(said.warmth);
        }
        match said.request {
            Request::Play => {}
            Request::Off => return self.all_off(now),
            Request::Stop => {
                self.stop(now, Cause::End);
                return self.sessions.release();
            }
        }
        let whole = self.lost.is_none() && said.stops == self.counts.stops;
        if self.guard.latched().is_some() && whole {
            // Refused while its cause lasts; the next command tries again.
            let _ = self.guard.reset(now);
        }
        if self.guard.latched().is_some() {
            self.schedule.clear();
            return;
        }
        let left_out = self.schedule.replace(now, command.planned());
        self.counts.dropped = self.counts.dropped.saturating_add(left_out);
    }

    /// Answers a knock.
    fn greet<D: Datagrams>(&mut self, now: Instant, knock: &Header, link: &mut D, to: D::Peer) {
        let hello = Hello {
            now,
            busy: self.sessions.is_kept(now),
            heat: self.guard.has_heat(),
            warmth: self.warm.is_some(),
            state: self.state(),
            stops: self.counts.stops,
            plant: *self.guard.plant(),
            limits: *self.guard.limits(),
            wires: self.schedule.wires().bits(),
            current: self.guard.current_control().copied(),
        };
        let header = self.sessions.hello(knock);
        let mut buffer = [0; MOST];
        link.send(
            self.key.seal(&header, &mut buffer, |out| hello.write(out)),
            to,
        );
    }

    fn state(&self) -> State {
        self.guard.latched().map_or(State::Ready, State::Stopped)
    }

    /// Answers the newest command.
    fn report<D: Datagrams>(&mut self, now: Instant, link: &mut D, to: D::Peer) {
        let Some((header, echo)) = self.sessions.status() else {
            return;
        };
        let counts = &self.counts;
        let skin_c = self.guard.has_heat().then(|| self.guard.predicted().peak_c);
        let status = Status {
            now,
            echo,
            taken: self.taken,
            state: self.state(),
            stops: counts.stops,
            applied: counts.applied,
            limited: counts.limited,
            reasons: counts.reasons,
            dropped: counts.dropped,
            late_us: counts.late_us,
            refused: counts.refused,
            skin_mc: skin_c.map_or(0, |c| (c * 1e3) as u32),
            phase_us: self.phases.at(now, self.guard.plant().prescale),
            face: self.warm.as_ref().map_or_else(Face::default, Warm::face),
        };
        let mut buffer = [0; MOST];
        link.send(
            self.key.seal(&header, &mut buffer, |out| status.write(out)),
            to,
        );
    }

    /// Begins what is due.
    fn begin(&mut self, now: Instant) {
        let mut due = [(0, Planned::NONE); 16];
        while let Some((board, at, count)) = self.begins(now, &mut due) {
            let late = now.since(at);
            let over = |planned: &Planned| planned.width > Ticks::ZERO && planned.until <= now;
            if late > LATEST || self.guard.is_stale(now) || self.guard.latched().is_some() {
                self.counts.dropped = self.counts.dropped.saturating_add(count as u32);
                continue;
            }
            // What the amplifiers give where a command states no current.
            let own = self.guard.current_control();
            let own = own.map_or(self.guard.plant().peak, |control| control.full_scale);
            let mut stimuli = [Stimulus {
                wire: 0,
                width: Ticks::ZERO,
                peak: own,
                at: now,
                until: now,
            }; 16];
            let mut used = 0;
            for (wire, planned) in due[..count].iter().filter(|(_, p)| !over(p)) {
                stimuli[used].wire = *wire;
                stimuli[used].width = planned.width;
                if planned.current > Milliamps(0) {
                    stimuli[used].peak = planned.current;
                }
                stimuli[used].until = planned.until;
                used += 1;
            }
            let late_us = u32::try_from(late.as_micros()).unwrap_or(u32::MAX);
            self.counts.late_us = self.counts.late_us.max(late_us);
            let counts = &mut self.counts;
            let judged = |entry| counts.judged(&entry);
            let update = self.guard.change(now, board, &stimuli[..used], judged);
            self.apply(now, &update);
        }
    }

    fn begins(
        &mut self,
        now: Instant,
        due: &mut [(u16, Planned); 16],
    ) -> Option<(Board, Instant, usize)> {
        let able = self.lost.is_none() && now >= self.ready;
        able.then(|| self.schedule.due(now, due)).flatten()
    }

    /// Ends what is over.
    fn expire(&mut self, now: Instant) {
        if self.guard.next_expiry().is_some_and(|end| end <= now) {
            for board in 0..self.boards {
                let update = self.guard.expire(now, Board(board));
                self.apply(now, &update);
            }
        }
    }

    fn apply(&mut self, now: Instant, update: &Guarded) {
        if !update.changes() {
            return;
        }
        match self.bank.apply(update) {
            Ok(()) => {
                self.guard.confirm(update, now);
                self.phases.apply(now, update);
                if self.guard.overran() {
                    self.stop(now, Cause::Overrun);
                }
            }
            Err(_) => self.lose(now),
        }
    }

    /// Reads registers back when that is due: a chip that fell back to reset values answers, and sleeps.
    fn verify(&mut self, now: Instant) {
        let since = now.since(self.verified);
        let quiet = self.guard.next_expiry().is_none();
        if self.lost.is_some() || since < VERIFY || !(quiet || since >= VERIFY_AT_LAST) {
            return;
        }
        self.verified = now;
        if self.bank.verify().is_err() {
            self.lose(now);
        }
    }

    /// The bus failed, or a chip: cut, off, and tried again.
    fn lose(&mut self, now: Instant) {
        self.set_cut(true);
        self.stop(now, Cause::ActuatorError);
        self.lost = Some(now + RETRY);
    }

    /// Switches everything off, and keeps it off until the host has acknowledged it.
    fn stop(&mut self, now: Instant, cause: Cause) {
        if let Some(warm) = &mut self.warm {
            warm.off();
        }
        self.latch(cause);
        self.all_off(now);
    }

    fn latch(&mut self, cause: Cause) {
        if self.guard.latched().is_none() {
            self.counts.stops = self.counts.stops.saturating_add(1);
        }
        self.guard.latch(cause);
    }

    /// Switches everything off now, with nothing planned.
    fn all_off(&mut self, now: Instant) {
        self.schedule.clear();
        self.guard.ask_off(now);
        self.phases.all_off();
        let is_off = self.lost.is_none() && self.bank.all_off().is_ok();
        if !is_off && self.lost.is_none() {
            self.latch(Cause::ActuatorError);
            self.lost = Some(now + RETRY);
        }
        if is_off || self.set_cut(true) {
            self.known_off(now);
        }
    }

    fn known_off(&mut self, now: Instant) {
        self.guard.all_off(now);
        if self.guard.overran() {
            self.latch(Cause::Overrun);
        }
    }
}
