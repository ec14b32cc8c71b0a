//! Cases that are computed: a wire on a finger, and the edges of the power that heats it.

use palpate_core::physics::{Alloy, Mechanics, ParameterError, TissueParameters, WireParameters};
use palpate_core::units::Prescale;
use palpate_emulators::display::finger::NODES;
use palpate_emulators::display::wire::Wire;
use palpate_emulators::time::Nanos;

/// Duty of the published full drive, ticks of 4096.
const TICKS: u64 = 100;
/// Electrical power during a pulse of the published full drive: 0.18 W over the period, W.
pub const PULSE_W: f64 = 0.18 * 4096.0 / TICKS as f64;

/// Node temperatures, degrees C.
pub type Nodes = [f64; NODES];

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
    /// Name of the case in the table.
    pub name: &'static str,
    /// The wire.
    pub wire: WireParameters,
    /// The finger.
    pub skin: TissueParameters,
    /// Times at which the electrical power changes, and what it is from then on, W.
    pub edges: Vec<(Nanos, f64)>,
    /// End of the case.
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
            wire: WIRE,
            skin: TissueParameters::DEFAULT,
            edges: Bursts::round_robin(end).edges(),
            end,
        }
    }

    /// A second of holding a wire half transformed: from 60 ms on every pulse transforms it and every pause back, past
    /// two kinks of the heat capacity in between.
    ///
    /// # Errors
    /// A parameter that cannot be computed with.
    pub fn phase_cycling() -> Result<Self, ParameterError> {
        Self::held(ms(1000))
    }

    /// Holds a wire half transformed for so long.
    ///
    /// # Errors
    /// A parameter that cannot be computed with.
    pub fn held(end: Nanos) -> Result<Self, ParameterError> {
        let skin = TissueParameters::DEFAULT;
        let wire = WireParameters {
            alloy: NARROW,
            ..WIRE
        };
        Ok(Self {
            name: "phase-cycling",
            edges: hold(&wire, &skin, end)?,
            wire,
            skin,
            end,
        })
    }
}

/// Duties that heat a wire held in [`NARROW`]'s band further and let it cool, ticks of 4096.
const HOLD_TICKS: [u64; 2] = [100, 40];

/// A pulse every period: a long one while more than half is martensite, a short one otherwise.
fn hold(
    wire: &WireParameters,
    skin: &TissueParameters,
    end: Nanos,
) -> Result<Vec<(Nanos, f64)>, ParameterError> {
    let mut held = Wire::new(wire, skin, START_C)?;
    let period = pwm().0;
    let (mut edges, mut t) = (Vec::new(), Nanos::ZERO);
    while t < end {
        let ticks = HOLD_TICKS[usize::from(held.fraction(t) <= 0.5)];
        for edge in [(t, PULSE_W), (t + Nanos(period.0 / 4096 * ticks), 0.0)] {
            held.set_power(edge.0, edge.1);
            edges.push(edge);
        }
        t = t + period;
    }
    Ok(edges)
}

/// The final module's wire at its vendor's stress, without strains: nothing changes its stress, and only heat is compared.
pub const WIRE: WireParameters = WireParameters {
    alloy: Alloy {
        austenite_start_c: 68.0,
        austenite_finish_c: 78.0,
        martensite_start_c: 52.0,
        martensite_finish_c: 42.0,
        reference_stress_pa: 172e6,
        ..Alloy::LOW
    },
    mechanics: Mechanics {
        transformation_strain: 0.0,
        expansion_austenite: 0.0,
        expansion_martensite: 0.0,
        ..Mechanics::DEFAULT
    },
    bias_stress_pa: 172e6,
    r_phase: None,
    ..WireParameters::FINAL
};

/// Austenite 90 to 91 C, martensite 89.5 to 88.5 C: no wire that is sold. Ripple crosses it both ways at every pulse, and
/// the latent heat keeps the temperature there.
const NARROW: Alloy = Alloy {
    austenite_start_c: 90.0,
    austenite_finish_c: 91.0,
    martensite_start_c: 89.5,
    martensite_finish_c: 88.5,
    reference_stress_pa: 172e6,
    ..Alloy::LOW
};
