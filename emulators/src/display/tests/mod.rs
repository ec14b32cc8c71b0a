//! The thermal model against computed values, against itself and against other methods.

mod exclusive;
mod felt;
mod others;
mod properties;
mod reference;
mod rest;
mod table;
mod worn;

use crate::display::solver::exact::Exact;
use crate::display::wire::Wire;
use crate::time::Nanos;
use palpate_core::physics::{Mechanics, TissueParameters, WireParameters};

/// One PWM period at 196.89 Hz: 4096 ticks of 31 / 25 MHz.
pub const PERIOD: Nanos = Nanos(4096 * 1240);
/// 100 ticks.
pub const PULSE: Nanos = Nanos(100 * 1240);
/// Electrical power during a pulse, W.
pub const PULSE_W: f64 = 0.18 * 4096.0 / 100.0;

/// The final module's wire with a two-way strain of 1 % and a small part without hysteresis.
pub const fn trained() -> WireParameters {
    WireParameters {
        reversible: 0.02,
        mechanics: Mechanics {
            transformation_strain: 0.01,
            ..Mechanics::DEFAULT
        },
        ..WireParameters::FINAL
    }
}

/// A wire under the stress of its vendor's temperatures, whatever its length.
pub fn at_constant_stress(wire: &WireParameters, tissue: &TissueParameters) -> Wire {
    let solver = Exact::new(wire, tissue, 33.0).unwrap();
    Wire::on(solver.with_linear_bow(tissue, 33.0))
}

/// Edges of bursts of `burst` at the start of every `cycle`; each burst is a new train at 196.89 Hz.
pub fn edges(burst: Nanos, cycle: Nanos, end: Nanos) -> Vec<(Nanos, f64)> {
    let mut out = Vec::new();
    let mut start = Nanos::ZERO;
    while start < end {
        let mut t = start;
        while t < start + burst && t < end {
            out.push((t, PULSE_W));
            out.push((t + PULSE, 0.0));
            t = t + PERIOD;
        }
        start = start + cycle;
    }
    out
}

/// Applies edges.
pub fn play(wire: &mut Wire, edges: &[(Nanos, f64)]) {
    for &(t, watts) in edges {
        wire.set_power(t, watts);
    }
}
