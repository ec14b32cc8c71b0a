//! The host's end of a driver unit's link: guarded updates in, datagrams out. It sends nothing itself and knows no
//! clock: its owner has the socket.
//!
//! An update takes effect a *delay* after its onset, which hides the jitter of the network. Every command carries all
//! stimuli that have yet to begin, so that a lost one costs nothing.

mod sync;

use super::{Actuators, DriverError, UnitFault};
use crate::codec::link::{
    Buffer, Command, Header, Hello, Key, Kind, MOST_PLANNED, Planned, Refusal, Request, Said,
    State, Status, Warmth,
};
use crate::guard::Guarded;
use crate::units::{Channel, Duration, Instant, Ticks};
use sync::{Exchange, Sync};

/// A command goes out this often at the least.
const HEARTBEAT: Duration = Duration::from_millis(10);
/// A host that has no session knocks this often.
const KNOCK: Duration = Duration::from_millis(20);
/// A unit that has not answered for this long has switched off by itself.
const SILENT: Duration = Duration::from_millis(150);
/// Silence after which the session is given up and begun anew.
const LOST: Duration = Duration::from_millis(300);
/// A line stays in the plan for this long after its onset at the least: the unit begins none later.
const KEPT: Duration = Duration::from_millis(10);
/// Commands whose sending times are remembered, to be found by an answer.
const REMEMBERED: usize = 64;

/// Settings of a host for its unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnitSettings {
    /// Time from an onset to its effect: more than the network's usual delay.
    pub delay: Duration,
    /// `true` where a stop of the unit is acknowledged without a person.
    pub resumes: bool,
}

/// Counts of the link's traffic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkCounts {
    /// Commands sent.
    pub sent: u64,
    /// Answers taken.
    pub answered: u64,
    /// Datagrams refused.
    pub refused: u64,
    /// Sessions begun.
    pub sessions: u64,
}

/// A session that a unit has answered.
#[derive(Clone, Copy, Debug)]
struct Open {
    unit: u64,
    hello: Hello,
    /// Sequence of the unit's newest datagram.
    heard: u64,
    /// Reception of that datagram.
    at: Instant,
}

/// The driver of a unit far away.
#[derive(Debug)]
pub struct UnitDriver {
    key: Key,
    settings: UnitSettings,
    /// This host's half of the session.
    host: u64,
    sequence: u64,
    open: Option<Open>,
    /// The unit's stops before this driver first met it: who started the program has seen to those.
    met: Option<u32>,
    status: Option<Status>,
    sync: Sync,
    plan: [Planned; MOST_PLANNED],
    count: usize,
    /// The plan was changed since the last command.
    fresh: bool,
    /// Request to go off, or off and stopped, until a command with this sequence or a later one was taken.
    off: Option<(Request, u64)>,
    /// Request to the unit's Peltier module.
    warmth: Option<Warmth>,
    sent: [(u64, Instant); REMEMBERED],
    last: Option<Instant>,
    counts: LinkCounts,
}

impl UnitDriver {
    /// A driver under a unit's key. `nonce` is a number that no driver with this key had before: 64 random bits.
    pub fn new(key: &[u8; 32], nonce: u64, settings: UnitSettings) -> Self {
        Self {
            key: Key::new(key),
            settings,
            host: nonce,
            sequence: 0,
            open: None,
            met: None,
            status: None,
            sync: Sync::default(),
            plan: [Planned::NONE; MOST_PLANNED],
            count: 0,
            fresh: false,
            off: None,
            warmth: None,
            sent: [(0, Instant::ZERO); REMEMBERED],
            last: None,
            counts: LinkCounts::default(),
        }
    }

    /// The unit's answer to the knock, once it has come.
    pub fn hello(&self) -> Option<&Hello> {
        self.open.as_ref().map(|open| &open.hello)
    }

    /// The unit's newest report.
    pub const fn status(&self) -> Option<&Status> {
        self.status.as_ref()
    }

    /// Age of the unit's newest report, by the unit's clock as it is known here.
    pub fn status_age(&self, now: Instant) -> Option<Duration> {
        let status = self.status.as_ref()?;
        self.sync
            .unit_time(now)
            .map(|there| there.since(status.now))
    }

    /// Counts of the link's traffic.
    pub const fn counts(&self) -> LinkCounts {
        self.counts
    }

    /// This host's half of the session.
    pub const fn session(&self) -> u64 {
        self.host
    }

    /// Confirms that the unit can be driven at `now`.
    ///
    /// # Errors
    /// [`UnitFault`]: the unit is silent, busy or stopped.
    pub fn ready(&self, now: Instant) -> Result<(), UnitFault> {
        let Some(open) = &self.open else {
            return Err(UnitFault::Silent);
        };
        let Some(status) = &self.status else {
            let busy = open.hello.busy;
            return Err(if busy {
                UnitFault::Busy
            } else {
                UnitFault::Silent
            });
        };
        if now.since(open.at) > SILENT {
            return Err(UnitFault::Silent);
        }
        match status.state {
            // A stop from before this host began ends with its first reading.
            State::Stopped(cause) if status.stops > self.acknowledged() => {
                Err(UnitFault::Stopped(cause))
            }
            _ => Ok(()),
        }
    }

    /// Latest time at which [`Self::datagram`] has one, if the plan stays as it is.
    pub fn next(&self) -> Instant {
        let every = if self.open.is_some() {
            HEARTBEAT
        } else {
            KNOCK
        };
        self.last.map_or(Instant::ZERO, |last| last + every)
    }

    /// The datagram that is due at `now`; `reading` is when the newest reading of the skin was received.
    pub fn datagram<'b>(
        &mut self,
        now: Instant,
        reading: Option<Instant>,
        buffer: &'b mut Buffer,
    ) -> Option<&'b [u8]> {
        let silent = |open: &Open| now.since(open.at) > LOST;
        if self.open.as_ref().is_some_and(silent) {
            self.give_up();
        }
        if now < self.next() && !self.fresh {
            return None;
        }
        self.last = Some(now);
        self.sequence += 1;
        let Some(open) = &self.open else {
            let knock = self.header(Kind::Knock, 0);
            return Some(self.key.seal(&knock, buffer, |_| 0));
        };
        let header = self.header(Kind::Command, open.unit);
        self.forget_over(now);
        self.fresh = false;
        self.counts.sent += 1;
        let slot = (self.sequence as usize) % REMEMBERED;
        self.sent[slot] = (self.sequence, now);
        let stops = self.acknowledged();
        let reading = reading.and_then(|at| self.sync.earliest(at));
        let request = match &mut self.off {
            None => Request::Play,
            Some((request, first)) => {
                *first = self.sequence.min(*first);
                *request
            }
        };
        let plan = match request {
            Request::Play => &self.plan[..self.count],
            _ => &[],
        };
        let said = Said {
            reading: reading.unwrap_or_default(),
            stops,
            request,
            warmth: self.warmth.filter(|_| request == Request::Play),
        };
        let write = |out: &mut [u8]| Command::write(out, &said, plan);
        Some(self.key.seal(&header, buffer, write))
    }

    const fn header(&self, kind: Kind, unit: u64) -> Header {
        Header {
            kind,
            host: self.host,
            unit,
            sequence: self.sequence,
        }
    }

    /// The stops of the unit that are over for this host. A session that it begins anew by itself must not end another
    /// host's stop.
    fn acknowledged(&self) -> u32 {
        if !self.settings.resumes {
            return self.met.unwrap_or(0);
        }
        let greeted = self.hello().map_or(0, |hello| hello.stops);
        self.status.map_or(greeted, |status| status.stops)
    }

    /// Sets the request to the unit's Peltier module from the next command on; nothing switches the module off.
    pub const fn warm(&mut self, warmth: Option<Warmth>) {
        self.warmth = warmth;
    }

    /// Asks the unit to switch everything off and to stay so until a host that begins after this acknowledges it. Goes into
    /// a unit that another host has as well.
    pub const fn stop(&mut self) {
        self.ask(Request::Stop);
    }

    const fn ask(&mut self, request: Request) {
        self.count = 0;
        self.fresh = true;
        self.off = Some((request, u64::MAX));
    }

    /// Tells whether the unit has yet to say that it took [`Self::stop`] or an all-off.
    pub const fn is_asking(&self) -> bool {
        self.off.is_some()
    }

    /// Ends the session and prepares another.
    pub fn give_up(&mut self) {
        (self.open, self.status) = (None, None);
        (self.sync, self.last) = (Sync::default(), None);
        self.host = self.host.wrapping_add(1);
        (self.sequence, self.count) = (0, 0);
        self.off = self.off.map(|(request, _)| (request, u64::MAX));
    }

    /// Drops stimuli that are over from the plan. Those that run stay, for an update may end them before their time.
    fn forget_over(&mut self, now: Instant) {
        let Some(now) = self.sync.unit_time(now) else {
            return;
        };
        let mut kept = 0;
        for index in 0..self.count {
            let planned = self.plan[index];
            if planned.until.max(planned.at + KEPT) > now {
                self.plan[kept] = planned;
                kept += 1;
            }
        }
        self.count = kept;
    }

    /// Takes a datagram that came at `now`.
    ///
    /// # Errors
    /// [`Refusal`] of a datagram that counts as none.
    pub fn hear(&mut self, now: Instant, datagram: &mut [u8]) -> Result<(), Refusal> {
        let heard = self.take(now, datagram);
        if heard.is_err() {
            self.counts.refused += 1;
        }
        heard
    }

    fn take(&mut self, now: Instant, datagram: &mut [u8]) -> Result<(), Refusal> {
        let header = Header::read(datagram)?;
        if header.host != self.host {
            return Err(Refusal::Stale);
        }
        match (header.kind, &mut self.open) {
            (Kind::Hello, None) => {
                let hello = Hello::read(self.key.open(datagram)?)?;
                self.met.get_or_insert(hello.stops);
                self.open = Some(Open {
                    unit: header.unit,
                    hello,
                    heard: header.sequence,
                    at: now,
                });
                // The first command opens the session.
                self.fresh = true;
                Ok(())
            }
            (Kind::Status, Some(open)) => {
                let newer = header.unit == open.unit && header.sequence > open.heard;
                if !newer {
                    return Err(Refusal::Stale);
                }
                let status = Status::read(self.key.open(datagram)?)?;
                (open.heard, open.at) = (header.sequence, now);
                self.answered(now, &status);
                Ok(())
            }
            (Kind::Hello | Kind::Status, _) => Err(Refusal::Stale),
            (Kind::Knock, _) => Err(Refusal::Kind(1)),
            (Kind::Command, _) => Err(Refusal::Kind(3)),
        }
    }

    fn answered(&mut self, now: Instant, status: &Status) {
        self.counts.answered += 1;
        self.counts.sessions += u64::from(self.status.is_none());
        let (sequence, sent) = self.sent[(status.echo as usize) % REMEMBERED];
        if sequence == status.echo {
            self.sync.add(Exchange {
                sent,
                taken: status.taken,
                answered: status.now,
                heard: now,
            });
        }
        if self.off.is_some_and(|(_, first)| status.echo >= first) {
            self.off = None;
        }
        self.status = Some(*status);
    }

    /// Puts a stimulus into the plan, in place of one of the same channel and time.
    fn put(&mut self, planned: Planned) -> Result<(), UnitFault> {
        let same = |p: &Planned| {
            (p.board, p.channel, p.at) == (planned.board, planned.channel, planned.at)
        };
        let place = self.plan[..self.count].iter().position(same);
        let place = place.unwrap_or(self.count);
        let slot = self.plan.get_mut(place).ok_or(UnitFault::Full)?;
        *slot = planned;
        self.count = self.count.max(place + 1);
        Ok(())
    }

    fn plan(&mut self, update: &Guarded) -> Result<(), UnitFault> {
        let open = self.open.as_ref().ok_or(UnitFault::Silent)?;
        let wires = open.hello.wires;
        let at = self.sync.unit_time(update.at() + self.settings.delay);
        let at = at.ok_or(UnitFault::NoTime)?;
        let board = update.board();
        let carried = wires.get(usize::from(board.0)).copied().unwrap_or(0);
        for (number, (setting, end)) in (0..).zip(update.channels().iter().zip(update.ends())) {
            let Some(setting) = setting else {
                continue;
            };
            let channel = Channel(number);
            if carried >> number & 1 == 0 {
                return Err(UnitFault::NoSuchOutput(board, channel));
            }
            let width = Ticks::new(setting.off.saturating_sub(setting.on));
            let until = at + end.since(update.at());
            let planned = Planned {
                board,
                channel,
                width,
                current: update.current(number).unwrap_or_default(),
                at,
                until,
            };
            // The unit ends each stimulus by itself: only what ends one before its time is told.
            let ends = |p: &Planned| p.board == board && p.channel == channel && p.until > at;
            if width > Ticks::ZERO || self.plan[..self.count].iter().any(ends) {
                self.put(planned)?;
            }
        }
        self.fresh = true;
        Ok(())
    }
}

impl Actuators for UnitDriver {
    type Error = DriverError;

    fn apply(&mut self, update: &Guarded) -> Result<(), DriverError> {
        self.plan(update).map_err(DriverError::Unit)
    }

    /// Asks the unit for an all-off. Its effect is known once the unit has answered; a unit that does not hear it
    /// switches off by itself.
    fn all_off(&mut self) -> Result<(), DriverError> {
        self.ask(Request::Off);
        match &self.open {
            Some(_) => Ok(()),
            None => Err(DriverError::Unit(UnitFault::Silent)),
        }
    }
}
