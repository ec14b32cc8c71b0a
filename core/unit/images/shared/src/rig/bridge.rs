//! The image's end of the rig's Peltier module: its bridge and its thermistors.

use palpate_core::driver::Actuators;
use palpate_core::peltier::{GuardedCurrent, Reading};
use palpate_core::units::{Duration, Instant};

use super::{Kind, Outcome, Rig, Wires};

/// A bridge that is not reached: the rig is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the rig's bridge is gone")]
pub struct Gone;

/// The bridge of the rig's Peltier module, and its thermistors.
#[derive(Debug)]
pub struct Bridge<'r, W, C>(&'r Rig<W, C>);

impl<'r, W: Wires, C: Fn() -> u64> Bridge<'r, W, C> {
    /// Bridge of a rig, if it has one.
    pub fn new(rig: &'r Rig<W, C>) -> Option<Self> {
        let asked = rig.ask((Kind::Sensors, 0), &[], &mut [0; 4]);
        let has = asked.is_some_and(|(_, outcome, _)| outcome == Outcome::Done);
        has.then_some(Self(rig))
    }

    /// Lets the bridge give this current for this length.
    fn give(&self, milliamps: i32, length: Duration) -> Result<(), Gone> {
        let us = u32::try_from(length.as_micros()).unwrap_or(u32::MAX);
        let told = [&milliamps.to_le_bytes()[..], &us.to_le_bytes()];
        let asked = self.0.ask((Kind::Bridge, 0), &told, &mut []);
        asked.map(|_| ()).ok_or(Gone)
    }
}

impl<W: Wires, C: Fn() -> u64> Actuators<GuardedCurrent> for Bridge<'_, W, C> {
    type Error = Gone;

    fn apply(&mut self, update: &GuardedCurrent) -> Result<(), Gone> {
        self.give(update.milliamps(), update.until().since(update.at()))
    }

    fn all_off(&mut self) -> Result<(), Gone> {
        self.give(0, Duration::ZERO)
    }
}

impl<W: Wires, C: Fn() -> u64> palpate_unit::Module for Bridge<'_, W, C> {
    fn reading(&mut self, _: Instant) -> Reading {
        let mut codes = [0; 4];
        // Codes of a rig that is gone are as old as the start.
        let asked = self.0.ask((Kind::Sensors, 0), &[], &mut codes);
        let [a, b, c, d] = codes;
        Reading {
            at: Instant::from_micros(asked.map_or(0, |(ns, ..)| ns / 1000)),
            face: u16::from_le_bytes([a, b]),
            sink: u16::from_le_bytes([c, d]),
        }
    }
}
