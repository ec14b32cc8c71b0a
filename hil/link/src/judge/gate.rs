//! The gate before a finger, which decides on the frames that are felt.

use std::fmt;

use palpate_core::units::{Duration, Instant};

use super::clock::Clock;
use super::rate::Bucket;

/// Head of every frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Head {
    /// Version of the messages.
    pub version: u32,
    /// The publisher's session: a number that no other start of a publisher has.
    pub session: u64,
    /// Number of the frame in its session.
    pub sequence: u64,
    /// Time at which the frame was sent, microseconds of the sender's clock.
    pub sent_us: u64,
    /// Time at which the skin was read, microseconds of the sender's clock.
    pub taken_us: u64,
    /// Digest of the skin's layout.
    pub layout: u64,
}

/// Limits that the gate judges frames by.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// Version of the messages.
    pub version: u32,
    /// Digest of the layout here.
    pub layout: u64,
    /// Largest age of a reading.
    pub deadline: Duration,
    /// Time without a felt frame after which another publisher may follow.
    pub lease: Duration,
    /// Most frames per second.
    pub per_second: u32,
    /// Most frames at once.
    pub at_once: u32,
}

impl Patience {
    /// Limits with the guard's deadline and the transport's lease.
    #[must_use]
    pub const fn new(version: u32, layout: u64) -> Self {
        Self {
            version,
            layout,
            deadline: Duration::from_millis(100),
            lease: Duration::from_millis(1000),
            per_second: 1000,
            at_once: 100,
        }
    }

    /// Limits for a skin of so many modules, each of which may come as a frame of its own.
    #[must_use]
    pub fn of_modules(version: u32, layout: u64, modules: usize) -> Self {
        let modules = u32::try_from(modules).unwrap_or(u32::MAX);
        let one = Self::new(version, layout);
        Self {
            per_second: one.per_second.max(modules.saturating_mul(250)),
            at_once: one.at_once.max(modules.saturating_mul(20)),
            ..one
        }
    }
}

fn may_be_old(age: &Duration, out: &mut fmt::Formatter<'_>) -> fmt::Result {
    let ms = age.as_micros().div_ceil(1000);
    write!(out, "the reading may be {ms} ms old")
}

macro_rules! refusals {
    ($($(#[$why:meta])* $kind:ident $(($with:ty))? = $count:ident),+ $(,)?) => {
        /// Reasons for which a frame is not felt.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
        pub enum Refusal { $($(#[$why])* $kind $(($with))?),+ }

        impl Refusal {
            /// Word of the refusal: the name of its count in a [`Tally`].
            #[must_use]
            pub const fn word(&self) -> &'static str {
                match self { $(Self::$kind { .. } => stringify!($count)),+ }
            }
        }

        /// Counts of frames by the gate's decision.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
        pub struct Tally {
            /// Frames that are felt.
            pub felt: u64,
            $(
                #[doc = concat!("Frames of [`Refusal::", stringify!($kind), "`].")]
                pub $count: u64,
            )+
            /// Sequence numbers that never came, of the sessions that were felt.
            pub lost: u64,
        }

        impl Tally {
            const fn add(&mut self, refusal: Refusal) {
                let count = match refusal { $(Refusal::$kind { .. } => &mut self.$count),+ };
                *count += 1;
            }
        }
    };
}

refusals! {
    /// Messages of another version.
    #[error(
        "expected messages of this program's version, found version {0}: run the same palpate-link on both machines"
    )]
    Version(u32) = version,
    /// Frames of a skin with another layout.
    #[error(
        "expected the layout of this scene, found digest {0:016x}: run the same scene on both machines"
    )]
    Layout(u64) = layout,
    /// Frames of another publisher than the one that is felt.
    #[error("publisher {0:016x} is refused: this finger feels another one")]
    Second(u64) = second,
    /// More frames per second than any skin has.
    #[error("more frames per second than any skin has")]
    Rate = rate,
    /// Frames that came before, or were overtaken.
    #[error("came before, or was overtaken")]
    Order = order,
    /// A reading that is newer than its frame.
    #[error("was read after it was sent")]
    Impossible = impossible,
    /// One of the clocks was set: the age of frames is unknown.
    #[error("a clock was set: the age of readings is not known")]
    Jumped = jumped,
    /// Publisher and wearer have not heard of each other yet, so nothing is known of its age.
    #[error("the publisher has not answered yet")]
    NoClock = no_clock,
    /// The reading may be older than the deadline.
    #[error(fmt = may_be_old)]
    Late(Duration) = late,
}

/// The publisher that is felt.
#[derive(Debug)]
struct Owner {
    session: u64,
    clock: Clock,
    bucket: Bucket,
    /// Sequence number and reading of the publisher's newest frame.
    newest: Option<(u64, u64)>,
    /// Time at which a frame of this publisher was last felt, or it became the owner.
    felt: Instant,
}

/// The gate of one finger. Its memory is fixed, and the cost of a frame does not depend on earlier ones.
#[derive(Debug)]
pub struct Gate {
    patience: Patience,
    owner: Option<Owner>,
    /// The time of the newest reading that was let through, on our clock.
    newest: Instant,
    tally: Tally,
}

impl Gate {
    /// A gate that has let nothing through.
    #[must_use]
    pub fn new(patience: Patience) -> Self {
        Self {
            patience,
            owner: None,
            newest: Instant::ZERO,
            tally: Tally::default(),
        }
    }

    /// Judges a frame that arrived at `now`; the time of its reading on our clock, never later than it was.
    ///
    /// # Errors
    /// Why it is not felt.
    pub fn judge(&mut self, head: &Head, now: Instant) -> Result<Instant, Refusal> {
        let judged = self.judged(head, now);
        match judged {
            Ok(at) => {
                self.newest = at;
                self.tally.felt += 1;
            }
            Err(refusal) => self.tally.add(refusal),
        }
        judged
    }

    fn judged(&mut self, head: &Head, now: Instant) -> Result<Instant, Refusal> {
        let patience = self.patience;
        if head.version != patience.version {
            return Err(Refusal::Version(head.version));
        }
        if head.layout != patience.layout {
            return Err(Refusal::Layout(head.layout));
        }
        let is_held = |o: &Owner| now.since(o.felt) <= patience.lease;
        let owner = match &mut self.owner {
            Some(owner) if owner.session == head.session => owner,
            Some(owner) if is_held(owner) => return Err(Refusal::Second(head.session)),
            _ => self.owner.insert(Owner {
                session: head.session,
                clock: Clock::default(),
                bucket: Bucket::new(patience.per_second, patience.at_once),
                newest: None,
                felt: now,
            }),
        };
        if !owner.bucket.take(now) {
            return Err(Refusal::Rate);
        }
        if head.taken_us > head.sent_us {
            return Err(Refusal::Impossible);
        }
        owner
            .clock
            .arrived(head.sent_us, now)
            .map_err(|_| Refusal::Jumped)?;
        if let Some((sequence, taken_us)) = owner.newest {
            // Modules of one skin may be read at one time.
            if head.sequence <= sequence || head.taken_us < taken_us {
                return Err(Refusal::Order);
            }
            // A number that no rate could have reached would shut out every true one.
            let passed_us = head.taken_us - taken_us;
            let reachable = (passed_us / 1_000_000 + 2).saturating_mul(patience.per_second.into());
            let step = head.sequence - sequence;
            if step > reachable {
                return Err(Refusal::Impossible);
            }
            self.tally.lost += step - 1;
        }
        owner.newest = Some((head.sequence, head.taken_us));
        let age = owner.clock.most_since(head.taken_us, now);
        let age = age.ok_or(Refusal::NoClock)?;
        if age >= patience.deadline {
            return Err(Refusal::Late(age));
        }
        let at = Instant::from_micros(now.as_micros().saturating_sub(age.as_micros()));
        if at < self.newest {
            return Err(Refusal::Order);
        }
        owner.felt = now;
        Ok(at)
    }

    /// Takes an echo: the publisher of this session had heard at `heard_us`, of its clock, our message of `said`.
    pub fn echoed(&mut self, session: u64, said: Instant, heard_us: u64, now: Instant) {
        if let Some(owner) = self.owner.as_mut().filter(|o| o.session == session) {
            // A clock that was set is a refusal of the next frame.
            let _ = owner.clock.echoed(said, heard_us, now);
        }
    }

    /// The session that is felt, as long as its lease lasts.
    #[must_use]
    pub fn feels(&self, now: Instant) -> Option<u64> {
        let owner = self.owner.as_ref()?;
        (now.since(owner.felt) <= self.patience.lease).then_some(owner.session)
    }

    /// The bounds of that publisher's clock: least and most of ours minus theirs, microseconds.
    #[must_use]
    pub fn offset(&self, now: Instant) -> Option<(i64, i64)> {
        self.owner.as_ref()?.clock.offset(now)
    }

    /// Likely delay of readings of that publisher after the time that [`Self::judge`] gives, which is the earliest that
    /// is possible: half of the uncertainty of its clock. It only extrapolates places; staleness ignores it.
    #[must_use]
    pub fn likely_later(&self, now: Instant) -> Duration {
        let (low, high) = self.offset(now).unwrap_or((0, 0));
        Duration::from_micros(high.abs_diff(low) / 2)
    }

    /// Counts of frames so far.
    #[must_use]
    pub const fn tally(&self) -> &Tally {
        &self.tally
    }
}

#[cfg(test)]
#[path = "gate_tests.rs"]
mod tests;
