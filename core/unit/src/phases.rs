//! Phase of each chip in its PWM period. A chip's counter is held while all of its channels are off, and starts from
//! zero with the first that goes on (PCA9685 data sheet 7.3.3).

use palpate_core::codec::link::HELD;
use palpate_core::guard::Guarded;
use palpate_core::units::{Instant, Prescale};

/// Channels that are on, a bit each, and start of the counter, by board.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Phases([(u16, Instant); 16]);

impl Phases {
    /// Takes an update that was written at `now`.
    pub(crate) fn apply(&mut self, now: Instant, update: &Guarded) {
        let Some((on, started)) = self.0.get_mut(usize::from(update.board().0)) else {
            return;
        };
        let was = *on;
        for (channel, setting) in update.channels().iter().enumerate() {
            match setting {
                Some(setting) if setting.off > setting.on => *on |= 1 << channel,
                Some(_) => *on &= !(1 << channel),
                None => {}
            }
        }
        if was == 0 && *on != 0 {
            *started = now;
        }
    }

    /// Takes that every channel of every board is off.
    pub(crate) fn all_off(&mut self) {
        *self = Self::default();
    }

    /// Phase of each board in its period, microseconds by the nominal clock; [`HELD`] for a board that drives nothing.
    pub(crate) fn at(&self, now: Instant, prescale: Prescale) -> [u16; 16] {
        let period_ns = prescale.period_ns().max(1);
        self.0.map(|(on, started)| match on {
            0 => HELD,
            _ => {
                let ns = now.since(started).as_micros().saturating_mul(1000);
                u16::try_from(ns % period_ns / 1000).unwrap_or(HELD - 1)
            }
        })
    }
}
