//! A unit's answer to each command.

use super::Refusal;
use super::bytes::{Reader, Writer};
use crate::guard::Cause;
use crate::peltier::PeltierReason;
use crate::units::Instant;

/// State of a unit: ready to drive, or stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// The unit does what it is commanded, as far as its guard lets it.
    Ready,
    /// The unit's guard is latched: off until the stop is acknowledged and its cause is gone.
    Stopped(Cause),
}

impl State {
    /// Byte on the wire.
    pub const fn number(self) -> u8 {
        match self {
            Self::Ready => 0,
            Self::Stopped(Cause::StaleInput) => 1,
            Self::Stopped(Cause::ActuatorError) => 2,
            Self::Stopped(Cause::SensorError) => 3,
            Self::Stopped(Cause::LateTick) => 4,
            Self::Stopped(Cause::End) => 5,
            Self::Stopped(Cause::Overrun) => 6,
            Self::Stopped(Cause::Rezero) => 7,
        }
    }

    pub(super) fn from_number(number: u8) -> Option<Self> {
        let stopped = Cause::ALL.into_iter().map(Self::Stopped);
        let mut all = core::iter::once(Self::Ready).chain(stopped);
        all.find(|s| s.number() == number)
    }
}

/// Number in place of a phase: the chip drives nothing, so its counter is held.
pub const HELD: u16 = u16::MAX;

/// Report of a unit on its Peltier module.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Face {
    /// The face, led by its thermistor's lag, millidegrees C; zero where no sensor tells it.
    pub face_mc: u16,
    /// The warmest that the face can be, millidegrees C; zero without a module.
    pub warmest_mc: u16,
    /// Temperature that the control aims at now, millidegrees C; zero without an aim.
    pub aim_mc: u16,
    /// The sink, millidegrees C; zero where no sensor tells it.
    pub sink_mc: u16,
    /// Current through the module, mA; positive cools the face.
    pub milliamps: i16,
    /// Reason for which the current is not the one that the control asked for.
    pub reason: Option<PeltierReason>,
}

/// A unit's report. Counters run since its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// The unit's clock as it answered.
    pub now: Instant,
    /// The sequence of the newest command that it took.
    pub echo: u64,
    /// Time at which the unit took that command.
    pub taken: Instant,
    /// Ready, or stopped by a cause.
    pub state: State,
    /// Stops of the unit so far.
    pub stops: u32,
    /// Stimuli begun.
    pub applied: u32,
    /// Begun stimuli that the unit's guard changed or refused.
    pub limited: u32,
    /// Reasons of the guard for those, a bit for each of [`Reason::ALL`](crate::schedule::Reason::ALL).
    pub reasons: u16,
    /// Stimuli left out: too late, with too old a reading, or while stopped.
    pub dropped: u32,
    /// The latest beginning of this session, microseconds after its time.
    pub late_us: u32,
    /// Datagrams refused.
    pub refused: u32,
    /// Skin 0.1 mm deep, the most predicted so far, millidegrees C; zero without thermal rows.
    pub skin_mc: u32,
    /// Progress of each board's chip through its PWM period, microseconds by the nominal clock, or [`HELD`].
    pub phase_us: [u16; 16],
    /// The unit's Peltier module.
    pub face: Face,
}

impl Status {
    /// Reads the body of a datagram.
    ///
    /// # Errors
    /// [`Refusal::Body`] for another length or an unknown state.
    pub fn read(body: &[u8]) -> Result<Self, Refusal> {
        Self::parse(body).ok_or(Refusal::Body)
    }

    fn parse(body: &[u8]) -> Option<Self> {
        let mut reader = Reader::new(body);
        let mut status = Self {
            now: Instant::from_micros(reader.u64()?),
            echo: reader.u64()?,
            taken: Instant::from_micros(reader.u64()?),
            state: State::from_number(reader.u8()?)?,
            stops: reader.u32()?,
            applied: reader.u32()?,
            limited: reader.u32()?,
            reasons: reader.u16()?,
            dropped: reader.u32()?,
            late_us: reader.u32()?,
            refused: reader.u32()?,
            skin_mc: reader.u32()?,
            phase_us: [HELD; 16],
            face: Face::default(),
        };
        for phase in &mut status.phase_us {
            *phase = reader.u16()?;
        }
        status.face = Face {
            face_mc: reader.u16()?,
            warmest_mc: reader.u16()?,
            aim_mc: reader.u16()?,
            sink_mc: reader.u16()?,
            milliamps: reader.u16()?.cast_signed(),
            reason: match reader.u8()? {
                0 => None,
                number => Some(*PeltierReason::ALL.get(usize::from(number) - 1)?),
            },
        };
        reader.is_done().then_some(status)
    }

    /// Writes the body; returns its length.
    pub fn write(&self, out: &mut [u8]) -> usize {
        let mut writer = Writer::new(out);
        writer.u64(self.now.as_micros());
        writer.u64(self.echo);
        writer.u64(self.taken.as_micros());
        writer.u8(self.state.number());
        writer.u32(self.stops);
        writer.u32(self.applied);
        writer.u32(self.limited);
        writer.u16(self.reasons);
        writer.u32(self.dropped);
        writer.u32(self.late_us);
        writer.u32(self.refused);
        writer.u32(self.skin_mc);
        self.phase_us.iter().for_each(|us| writer.u16(*us));
        let face = &self.face;
        for value in [face.face_mc, face.warmest_mc, face.aim_mc, face.sink_mc] {
            writer.u16(value);
        }
        writer.u16(face.milliamps.cast_unsigned());
        writer.u8(face.reason.map_or(0, |reason| 1 + reason.number()));
        writer.length()
    }
}
