//! Pulses of which only the energy is known: steps of the tissue that sink back.

use super::Perceiver;
use crate::display::solver::stretch::Stretch;

/// Time in which lifted tissue sinks back to a part e, s: a wire's cooling on skin. Assumed.
const SINK_S: f64 = 0.025;

/// One pulse as the tissue meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kick {
    /// Time of the pulse, seconds since the stimulus began.
    pub at_s: f64,
    /// Lift of the tissue, um.
    pub um: f64,
}

impl Perceiver {
    /// Lets `seconds` pass in which a wire gives these kicks, in the order of time; tissue lifted before goes on sinking.
    pub fn kicks(&mut self, wire: usize, kicks: &[Kick], seconds: f64) {
        let mut now = 0.0;
        for kick in kicks {
            let at = kick.at_s.clamp(now, seconds.max(now));
            self.sink(wire, at - now);
            now = at;
            self.lift(wire, kick.um);
        }
        self.sink(wire, seconds - now);
    }

    fn sink(&mut self, wire: usize, seconds: f64) {
        let um = self.wires.get(wire).map_or(0.0, |filter| filter.lifted_um);
        self.pass(wire, &Stretch::sinking(seconds, um, 1.0 / SINK_S));
        if let Some(filter) = self.wires.get_mut(wire) {
            filter.lifted_um *= libm::exp(-seconds / SINK_S);
        }
    }
}
