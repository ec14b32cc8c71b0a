//! What is computed: a wire on a finger, and the edges of the power that heats it.

use palpate_core::physics::{Alloy, SkinParameters, WireParameters};
use palpate_core::units::Prescale;
use palpate_emulators::time::Nanos;

/// Duty of the published full drive, ticks of 4096.
const TICKS: u64 = 100;
/// Electrical power during a pulse of the published full drive: 0.18 W over the period, W.
pub const PULSE_W: f64 = 0.18 * 4096.0 / TICKS as f64;

/// Milliseconds.
pub const fn ms(n: u64) -> Nanos {
    Nanos(n * 1_000_000)
}

/// One PWM period at 196.89 Hz, and one pulse.
pub fn pwm() -> (Nanos, Nanos) {
    let period = Prescale::new(30).period_ns();
    (Nanos(period), Nanos(period / 4096 * TICKS))
}

/// Bursts of `burst` at the start of every `cycle` until `end`; each is a new train of pulses.
#[derive(Clone, Copy, Debug)]
pub struct Bursts {
    /// Length of one.
    pub burst: Nanos,
    /// From the start of one to the start of the next.
    pub cycle: Nanos,
    /// No pulse begins after this.
    pub end: Nanos,
}

impl Bursts {
    /// One wire of eight in turn: 35 of every 468 ms.
    pub const fn round_robin(end: Nanos) -> Self {
        Self {
            burst: ms(35),
            cycle: ms(468),
            end,
        }
    }

    /// A contact that rests on one wire: 35 of every 58.5 ms.
    pub const fn dwelling(end: Nanos) -> Self {
        Self {
            burst: ms(35),
            cycle: Nanos(58_500_000),
            end,
        }
    }

    /// Times at which the power changes, and what it is from then on, W.
    pub fn edges(&self) -> Vec<(Nanos, f64)> {
        let (period, pulse) = pwm();
        let mut out = Vec::new();
        let mut start = Nanos::ZERO;
        while start < self.end {
            let mut t = start;
            while t < start + self.burst && t < self.end {
                out.push((t, PULSE_W));
                out.push((t + pulse, 0.0));
                t = t + period;
            }
            start = start + self.cycle;
        }
        out
    }
}

/// A case that all methods compute.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its name in the table.
    pub name: &'static str,
    /// The wire.
    pub wire: WireParameters,
    /// The finger.
    pub skin: SkinParameters,
    /// Times at which the electrical power changes, and what it is from then on, W.
    pub edges: Vec<(Nanos, f64)>,
    /// How long it is.
    pub end: Nanos,
}

/// Temperature of everything at the start, degrees C.
pub const START_C: f64 = 33.0;

impl Case {
    /// Ten seconds of round-robin on the final module's wire: it transforms in every burst.
    pub fn round_robin() -> Self {
        let end = ms(10_000);
        Self {
            name: "round-robin",
            wire: WireParameters::FINAL,
            skin: SkinParameters::DEFAULT,
            edges: Bursts::round_robin(end).edges(),
            end,
        }
    }

    /// A second of dwelling on an invented alloy of 5 K hysteresis where the ripple is: every pulse transforms
    /// it both ways.
    pub fn phase_cycling() -> Self {
        let end = ms(1000);
        Self {
            name: "phase-cycling",
            wire: WireParameters {
                alloy: NARROW,
                ..WireParameters::FINAL
            },
            skin: SkinParameters::DEFAULT,
            edges: Bursts::dwelling(end).edges(),
            end,
        }
    }
}

/// Austenite 56 to 60 C, martensite 55 to 51 C: no wire that is sold, the worst there is for a solver.
pub const NARROW: Alloy = Alloy {
    austenite_start_c: 56.0,
    austenite_finish_c: 60.0,
    martensite_start_c: 55.0,
    martensite_finish_c: 51.0,
    ..Alloy::LOW
};
