//! Part of full level that the limits leave: arithmetic, before anything is driven.
//!
//! A contact asks most of the limits where it is on one wire, which then has all of its power.

use crate::guard::Guard;
use crate::units::{Instant, Ticks};

use super::reserve::{PART, Reserve, SESSION};
use super::{RenderSettings, bearable};

/// Parts of full amplitude that a contact on one wire can have; 1 for all of it, more for room to spare.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Borne {
    /// Part in one burst, from rest.
    pub once: f32,
    /// Part for ten minutes, moving over all wires evenly.
    pub moving: f32,
    /// Part for ten minutes, at rest.
    pub resting: f32,
}

impl RenderSettings {
    /// Part of full level that this many wires of a fingertip bear behind a guard at rest.
    pub fn borne(&self, guard: &Guard, wires: usize) -> Borne {
        let wire_uw = guard.sustained_uw(SESSION) as f32 * PART;
        let tip_uw = guard.limits().fingertip_60s_uw as f32;
        let soa_ms = self.pattern.timing().soa.as_micros() as f32 * 1e-3;
        let rested = Reserve::new(guard.sustained_uw(SESSION));
        let part = |rests: bool, uw: f32| {
            let pulses = self.pattern.pulses(self.style.taps(rests, &self.pattern));
            let length = self.pattern.lasts(pulses);
            let most = bearable(guard, &rested, 0, (Instant::ZERO, length), 1.0);
            let tick_nj = guard.energy_nj(Ticks::new(1000), length) as f32 * 1e-3;
            let even = uw * soa_ms / tick_nj;
            let fewer = f32::from(pulses) / f32::from(self.pattern.pulses(false));
            self.response.amplitude(most.min(even)) * libm::sqrtf(fewer) / self.full
        };
        Borne {
            once: part(false, f32::INFINITY).max(part(true, f32::INFINITY)),
            moving: part(false, tip_uw.min(wire_uw * wires as f32)),
            resting: part(true, wire_uw),
        }
    }
}
