//! What a host says: how old its reading is, and every stimulus that has yet to begin.
//!
//! A command is a state, not a step: it replaces the plan before it. So any of them may be lost, and the newest wins.

use super::bytes::{Reader, Writer};
use super::{MOST_PLANNED, Refusal};
use crate::units::{Board, Channel, Duration, Instant, Ticks};

/// Bytes of one stimulus.
const EACH: usize = 9;

/// A stimulus in time to come, in the unit's time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Planned {
    /// The board, 0 ..= 15.
    pub board: Board,
    /// Its channel, 0 ..= 15.
    pub channel: Channel,
    /// Pulse width; none ends what the channel does.
    pub width: Ticks,
    /// Onset.
    pub at: Instant,
    /// End.
    pub until: Instant,
}

impl Planned {
    /// None: what fills memory that is not used.
    pub const NONE: Self = Self {
        board: Board(0),
        channel: Channel(0),
        width: Ticks::ZERO,
        at: Instant::ZERO,
        until: Instant::ZERO,
    };
}

/// What is done beside the plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Request {
    /// Nothing.
    #[default]
    Play,
    /// Everything goes off now and the plan is empty.
    Off,
    /// The same, and it stays off until the stop is acknowledged.
    Stop,
}

impl Request {
    /// Its byte.
    pub const fn number(self) -> u8 {
        match self {
            Self::Play => 0,
            Self::Off => 1,
            Self::Stop => 2,
        }
    }

    fn from_number(number: u8) -> Option<Self> {
        let mut all = [Self::Play, Self::Off, Self::Stop].into_iter();
        all.find(|r| r.number() == number)
    }
}

/// A command as it was received: the stimuli stay bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command<'a> {
    /// When the newest reading was received, in the unit's time: no later than that. Zero without a reading.
    pub reading: Instant,
    /// The unit's stops that the host has seen and takes for over.
    pub stops: u32,
    /// What else.
    pub request: Request,
    base: Instant,
    entries: &'a [u8],
}

impl<'a> Command<'a> {
    /// A body's meaning.
    ///
    /// # Errors
    /// [`Refusal::Body`] for a length that does not fit, an unknown flag, or a width over a period.
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
        let entries = reader.rest();
        let command = Self {
            reading,
            stops,
            request,
            base,
            entries,
        };
        let fits = count <= MOST_PLANNED && entries.len() == count * EACH;
        let sound = fits && command.widths().all(|w| w <= Ticks::PER_PERIOD);
        sound.then_some(command)
    }

    fn widths(&self) -> impl Iterator<Item = u16> + 'a {
        let each = self.entries.as_chunks::<EACH>().0.iter();
        each.map(|e| u16::from_le_bytes([e[1], e[2]]))
    }

    /// The stimuli.
    pub fn planned(&self) -> impl Iterator<Item = Planned> + 'a {
        let base = self.base;
        let one = move |entry: &[u8; EACH]| {
            let mut reader = Reader::new(entry);
            let place = reader.u8()?;
            let width = Ticks::new(reader.u16()?);
            let at = base + Duration::from_micros(reader.u24()?.into());
            Some(Planned {
                board: Board(place >> 4),
                channel: Channel(place & 15),
                width,
                at,
                until: at + Duration::from_micros(reader.u24()?.into()),
            })
        };
        self.entries.as_chunks::<EACH>().0.iter().filter_map(one)
    }

    /// Writes a command's body; its length. Stimuli beyond [`MOST_PLANNED`] are left out.
    pub fn write(
        out: &mut [u8],
        reading: Instant,
        (stops, request): (u32, Request),
        plan: &[Planned],
    ) -> usize {
        let plan = plan.get(..MOST_PLANNED).unwrap_or(plan);
        let base = plan.iter().map(|p| p.at).min().unwrap_or_default();
        let mut writer = Writer::new(out);
        writer.u64(reading.as_micros());
        writer.u64(base.as_micros());
        writer.u32(stops);
        writer.u8(request.number());
        writer.u8(plan.len() as u8); // at most 128
        for planned in plan {
            writer.u8(planned.board.0 << 4 | planned.channel.0 & 15);
            writer.u16(planned.width.get());
            writer.u24(planned.at.since(base).as_micros());
            writer.u24(planned.until.since(planned.at).as_micros());
        }
        writer.length()
    }
}
