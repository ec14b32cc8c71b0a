//! A host's command: the age of its reading, and every stimulus that has yet to begin.
//!
//! A command is a state, not a step: it replaces the plan before it. Any of them may be lost; the newest wins.

use super::bytes::{Reader, Writer};
use super::{MOST_PLANNED, Refusal};
use crate::units::{Board, Channel, Duration, Instant, Milliamps, Ticks};

/// Bytes of one stimulus.
const EACH: usize = 10;
/// Bits of a width in a stimulus; those above are its current.
const WIDTH_BITS: u32 = 12;
/// Largest value of either field, and so the most current, mA, that a link carries.
pub const MOST_CURRENT: u32 = (1 << WIDTH_BITS) - 1;

/// A stimulus in time to come, in the unit's time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Planned {
    /// The board, 0 ..= 15.
    pub board: Board,
    /// Channel of that board, 0 ..= 15.
    pub channel: Channel,
    /// Pulse width; zero ends the channel's stimulus.
    pub width: Ticks,
    /// Current that the amplifier is set to before the onset, 4095 mA
    /// at most; zero for an amplifier of one current, or for its most.
    pub current: Milliamps,
    /// Onset.
    pub at: Instant,
    /// End.
    pub until: Instant,
}

impl Planned {
    /// Empty entry that fills unused memory of a plan.
    pub const NONE: Self = Self {
        board: Board(0),
        channel: Channel(0),
        width: Ticks::ZERO,
        current: Milliamps(0),
        at: Instant::ZERO,
        until: Instant::ZERO,
    };
}

/// Request of a host beside its plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Request {
    /// No request beside the plan.
    #[default]
    Play = 0,
    /// Everything goes off now and the plan is empty.
    Off = 1,
    /// Everything goes off now, the plan is empty, and the unit stays off until the stop is acknowledged.
    Stop = 2,
}

impl Request {
    /// Byte on the wire.
    pub const fn number(self) -> u8 {
        self as u8
    }

    fn from_number(number: u8) -> Option<Self> {
        let mut all = [Self::Play, Self::Off, Self::Stop].into_iter();
        all.find(|r| r.number() == number)
    }
}

/// Request of a host to a Peltier module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Warmth {
    /// Wanted temperature of the module's face, millidegrees C.
    pub face_mc: u16,
    /// The warmest that the wires bear by the host's own guard, millidegrees C.
    pub ceiling_mc: u16,
}

/// Content of a command beside its plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Said {
    /// Reception of the newest reading in the unit's time, or somewhat earlier, never later; zero without a reading.
    pub reading: Instant,
    /// The unit's stops that the host has seen and takes for over.
    pub stops: u32,
    /// Request beside the plan.
    pub request: Request,
    /// Request to the Peltier module, if there is one; nothing switches the module off.
    pub warmth: Option<Warmth>,
}

/// A command as it was received: the stimuli stay bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command<'a> {
    /// Content of the command beside its plan.
    pub said: Said,
    base: Instant,
    entries: &'a [u8],
}

impl<'a> Command<'a> {
    /// Reads the body of a datagram.
    ///
    /// # Errors
    /// [`Refusal::Body`] for a length that does not fit, or an unknown request.
    pub fn read(body: &'a [u8]) -> Result<Self, Refusal> {
        Self::parse(body).ok_or(Refusal::Body)
    }

    fn parse(body: &'a [u8]) -> Option<Self> {
        let mut reader = Reader::new(body);
        let reading = Instant::from_micros(reader.u64()?);
        let base = Instant::from_micros(reader.u64()?);
        let stops = reader.u32()?;
        let request = Request::from_number(reader.u8()?)?;
        let count = usize::from(reader.u8()?);
        let (face_mc, ceiling_mc) = (reader.u16()?, reader.u16()?);
        let entries = reader.rest();
        let warmth = Warmth {
            face_mc,
            ceiling_mc,
        };
        let command = Self {
            said: Said {
                reading,
                stops,
                request,
                warmth: (face_mc > 0).then_some(warmth),
            },
            base,
            entries,
        };
        let fits = count <= MOST_PLANNED && entries.len() == count * EACH;
        fits.then_some(command)
    }

    /// The stimuli.
    pub fn planned(&self) -> impl Iterator<Item = Planned> + 'a {
        let base = self.base;
        let one = move |entry: &[u8; EACH]| {
            let mut reader = Reader::new(entry);
            let place = reader.u8()?;
            let pulse = reader.u24()?;
            let at = base + Duration::from_micros(reader.u24()?.into());
            Some(Planned {
                board: Board(place >> 4),
                channel: Channel(place & 15),
                width: Ticks::new((pulse & MOST_CURRENT) as u16),
                current: Milliamps(pulse >> WIDTH_BITS),
                at,
                until: at + Duration::from_micros(reader.u24()?.into()),
            })
        };
        self.entries.as_chunks::<EACH>().0.iter().filter_map(one)
    }

    /// Writes a command's body; returns its length. Stimuli beyond [`MOST_PLANNED`] are left out.
    pub fn write(out: &mut [u8], said: &Said, plan: &[Planned]) -> usize {
        let plan = plan.get(..MOST_PLANNED).unwrap_or(plan);
        let base = plan.iter().map(|p| p.at).min().unwrap_or_default();
        let warmth = said.warmth.unwrap_or(Warmth {
            face_mc: 0,
            ceiling_mc: 0,
        });
        let mut writer = Writer::new(out);
        writer.u64(said.reading.as_micros());
        writer.u64(base.as_micros());
        writer.u32(said.stops);
        writer.u8(said.request.number());
        writer.u8(plan.len() as u8); // at most 128
        writer.u16(warmth.face_mc);
        writer.u16(warmth.ceiling_mc);
        for planned in plan {
            let width = u32::from(planned.width.get()).min(MOST_CURRENT);
            let current = planned.current.0.min(MOST_CURRENT);
            writer.u8(planned.board.0 << 4 | planned.channel.0 & 15);
            writer.u24(u64::from(current << WIDTH_BITS | width));
            writer.u24(planned.at.since(base).as_micros());
            writer.u24(planned.until.since(planned.at).as_micros());
        }
        writer.length()
    }
}
