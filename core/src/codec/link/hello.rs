//! A unit's answer to a knock: the hardware that it drives, and the limits of its guard.

use super::bytes::{Reader, Writer};
use super::{Refusal, State};
use crate::guard::{CurrentControl, Limits, Plant};
use crate::units::{Clock, Duration, Instant, Milliamps, Prescale};

/// The flag of a unit that another host drives.
pub const BUSY: u8 = 1;
/// The flag of a unit whose guard has the thermal rows.
pub const HEAT: u8 = 2;
/// The flag of a unit that has a Peltier module.
pub const WARMTH: u8 = 4;
/// Number in the tolerance field that stands for the chips' own oscillator.
pub const INTERNAL: u32 = u32::MAX;

/// A unit's answer to a knock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hello {
    /// The unit's clock as it answered.
    pub now: Instant,
    /// `true` where another host drives the unit.
    pub busy: bool,
    /// `true` where the unit's guard has the thermal rows.
    pub heat: bool,
    /// `true` where the unit has a Peltier module.
    pub warmth: bool,
    /// Ready, or stopped by a cause.
    pub state: State,
    /// The stops so far; a host that takes over acknowledges them.
    pub stops: u32,
    /// Boards and wires as the unit's guard knows them.
    pub plant: Plant,
    /// The limits that were burnt in.
    pub limits: Limits,
    /// Channels that carry a wire, a bit each, by board.
    pub wires: [u16; 16],
    /// Amplifiers whose current is set; `None` for those that have one of their own.
    pub current: Option<CurrentControl>,
}

impl Hello {
    /// Reads the body of a datagram.
    ///
    /// # Errors
    /// [`Refusal::Body`] for another length, or a clock or divider that no chip takes.
    pub fn read(body: &[u8]) -> Result<Self, Refusal> {
        Self::parse(body).ok_or(Refusal::Body)
    }

    fn parse(body: &[u8]) -> Option<Self> {
        let mut reader = Reader::new(body);
        let now = Instant::from_micros(reader.u64()?);
        let flags = reader.u8()?;
        let state = State::from_number(reader.u8()?)?;
        let stops = reader.u32()?;
        let pre = reader.u8()?;
        let hz = reader.u32()?;
        let clock = match reader.u32()? {
            INTERNAL => Clock::INTERNAL,
            ppm => Clock::external(hz, ppm)?,
        };
        let plant = Plant {
            prescale: Prescale::new(pre).with_clock(clock),
            wire_milliohm: reader.u32()?,
            peak: Milliamps(reader.u32()?),
            bus: Duration::from_micros(reader.u32()?.into()),
        };
        let mut rows = [0; 15];
        for row in &mut rows {
            *row = reader.u64()?;
        }
        let limits = Limits::from_rows(rows);
        let mut wires = [0; 16];
        for board in &mut wires {
            *board = reader.u16()?;
        }
        let current = CurrentControl {
            full_scale: Milliamps(reader.u32()?),
            gain_ppm: reader.u32()?,
            offset: Milliamps(reader.u32()?),
        };
        let fits = limits.rows() == rows && flags <= BUSY | HEAT | WARMTH;
        (reader.is_done() && fits).then_some(Self {
            now,
            busy: flags & BUSY != 0,
            heat: flags & HEAT != 0,
            warmth: flags & WARMTH != 0,
            state,
            stops,
            plant,
            limits,
            wires,
            current: (current.full_scale > Milliamps(0)).then_some(current),
        })
    }

    /// Writes the body; returns its length.
    pub fn write(&self, out: &mut [u8]) -> usize {
        let mut writer = Writer::new(out);
        writer.u64(self.now.as_micros());
        let flags = [(self.busy, BUSY), (self.heat, HEAT), (self.warmth, WARMTH)];
        writer.u8(flags.iter().map(|(is, bit)| u8::from(*is) * bit).sum());
        writer.u8(self.state.number());
        writer.u32(self.stops);
        let (plant, limits) = (&self.plant, &self.limits);
        let clock = plant.prescale.clock();
        writer.u8(plant.prescale.get());
        writer.u32(clock.hz());
        writer.u32(clock.tolerance_ppm().unwrap_or(INTERNAL));
        writer.u32(plant.wire_milliohm);
        writer.u32(plant.peak.0);
        writer.u32(u32::try_from(plant.bus.as_micros()).unwrap_or(u32::MAX));
        limits.rows().iter().for_each(|row| writer.u64(*row));
        self.wires.iter().for_each(|board| writer.u16(*board));
        let current = self.current.unwrap_or_default();
        writer.u32(current.full_scale.0);
        writer.u32(current.gain_ppm);
        writer.u32(current.offset.0);
        writer.length()
    }
}
