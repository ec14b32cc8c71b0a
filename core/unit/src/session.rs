//! Sessions: one host at a time may command, after an exchange that no recording can repeat.
//!
//! A host knocks with a number it never used before. The unit answers with one of its own, its *challenge*, sealed for
//! that host. A command under both numbers proves that the host has the key now. With it the session begins, and the
//! next challenge is another.

use palpate_core::codec::link::{Header, Kind, Refusal, Request};
use palpate_core::units::{Duration, Instant};

/// A host that was heard within this time keeps its session: another's commands wait, except to switch off.
pub(crate) const KEEP: Duration = Duration::from_millis(500);

/// The running session.
#[derive(Clone, Copy, Debug)]
struct Live {
    host: u64,
    unit: u64,
    /// Sequence of the newest command.
    sequence: u64,
    heard: Instant,
    /// `true` where the session keeps the unit from other hosts.
    kept: bool,
}

/// The sessions of a unit.
#[derive(Debug)]
pub(crate) struct Sessions {
    challenge: u64,
    live: Option<Live>,
    /// Counts the datagrams that the unit sends: with the challenge no two datagrams have the same numbers.
    sent: u64,
}

impl Sessions {
    /// Sessions with a first challenge that no start before had.
    pub(crate) const fn new(challenge: u64) -> Self {
        // Zero stands for "no session yet" in a knock.
        let challenge = if challenge == 0 { 1 } else { challenge };
        Self {
            challenge,
            live: None,
            sent: 0,
        }
    }

    /// Tells whether a host has the unit.
    pub(crate) fn is_kept(&self, now: Instant) -> bool {
        self.live
            .is_some_and(|live| live.kept && now.since(live.heard) < KEEP)
    }

    /// Tells whether a datagram with this header may be of use, before its seal is looked at.
    ///
    /// # Errors
    /// [`Refusal::Kind`] and [`Refusal::Stale`].
    pub(crate) fn expects(&self, header: &Header) -> Result<(), Refusal> {
        match header.kind {
            Kind::Knock if header.unit == 0 => Ok(()),
            Kind::Knock => Err(Refusal::Stale),
            Kind::Command if self.is_challenge(header) || self.is_newer(header) => Ok(()),
            Kind::Command => Err(Refusal::Stale),
            Kind::Hello => Err(Refusal::Kind(2)),
            Kind::Status => Err(Refusal::Kind(4)),
        }
    }

    const fn is_challenge(&self, header: &Header) -> bool {
        header.unit == self.challenge
    }

    fn is_newer(&self, header: &Header) -> bool {
        self.live.is_some_and(|live| {
            (header.host, header.unit) == (live.host, live.unit) && header.sequence > live.sequence
        })
    }

    /// Takes an opened command's header over; returns whether a session began with it.
    ///
    /// # Errors
    /// [`Refusal::Stale`] where another host has the unit and this one does not ask to switch off.
    pub(crate) fn take(
        &mut self,
        now: Instant,
        header: &Header,
        request: Request,
    ) -> Result<bool, Refusal> {
        let begins = self.is_challenge(header);
        if begins && self.is_kept(now) && request == Request::Play {
            return Err(Refusal::Stale);
        }
        if begins {
            self.challenge = match self.challenge.wrapping_add(1) {
                0 => 1,
                next => next,
            };
        }
        self.live = Some(Live {
            host: header.host,
            unit: header.unit,
            sequence: header.sequence,
            heard: now,
            kept: true,
        });
        Ok(begins)
    }

    /// Releases the unit, whose host is done with it: any host may
    /// have it from now on. Commands sent before stay refused.
    pub(crate) const fn release(&mut self) {
        if let Some(live) = &mut self.live {
            live.kept = false;
        }
    }

    /// The header of an answer to a knock.
    pub(crate) const fn hello(&mut self, knock: &Header) -> Header {
        self.sent += 1;
        Header {
            kind: Kind::Hello,
            host: knock.host,
            unit: self.challenge,
            sequence: self.sent,
        }
    }

    /// The header of a report, and the sequence of the command that it answers; `None` without a session.
    pub(crate) fn status(&mut self) -> Option<(Header, u64)> {
        let live = self.live?;
        self.sent += 1;
        let header = Header {
            kind: Kind::Status,
            host: live.host,
            unit: live.unit,
            sequence: self.sent,
        };
        Some((header, live.sequence))
    }
}
