//! A shape-memory wire on a finger: current in, heat, phase, strain and skin temperature out.
//!
//! The wire is lazy. Edges and questions advance it; between them nothing is computed, and however
//! time is cut by questions the answers are the same to 1e-9 K.

pub mod phase;
pub mod record;
pub mod strain;

use crate::finger::dose::Dose;
use crate::solver::exact::Exact;
use crate::solver::{Drive, Solver};
use crate::time::Nanos;
use palpate_core::physics::{ParameterError, SkinParameters, WireParameters};
use record::{Burst, Energy, Peaks};
use strain::{Strain, sag_m};

/// A burst ends after this long without a pulse (`physics.md`).
pub const BURST_GAP: Nanos = Nanos::from_micros(20_000);

/// One wire and the skin under it.
#[derive(Clone, Debug)]
pub struct Wire {
    solver: Exact,
    pulse: Option<Pulse>,
    burst: Option<Burst>,
    ended: Option<Burst>,
}

/// The wire at a rising edge.
#[derive(Clone, Copy, Debug)]
struct Pulse {
    start: Nanos,
    wire_c: f64,
    strain: Strain,
    energy: (f64, f64),
}

impl Wire {
    /// A wire at rest, with skin and itself at `start_c` (33 is skin).
    ///
    /// # Errors
    /// A parameter that cannot be computed with, by name.
    pub fn new(
        wire: &WireParameters,
        skin: &SkinParameters,
        start_c: f64,
    ) -> Result<Self, ParameterError> {
        let solver = Exact::new(wire, skin, start_c)?;
        Ok(Self {
            solver,
            pulse: None,
            burst: None,
            ended: None,
        })
    }

    /// Also keeps the burn integrals at 0.1 mm from here on, at a few evaluations a step.
    #[must_use]
    pub fn with_dose(mut self) -> Self {
        self.solver.dose = Some(Dose::default());
        self
    }

    /// Sets the current from `at` on, A. Call it at every edge, in order; a time before the last
    /// one counts as that. Setting what already flows costs nothing. Not a number counts as off.
    pub fn set_current(&mut self, at: Nanos, amps: f64) {
        let flows = amps.is_finite() && amps != 0.0;
        self.set_drive(
            at,
            if flows {
                Drive::Current(amps)
            } else {
                Drive::Off
            },
        );
    }

    /// Sets the electrical power from `at` on, W; the wire's share of it heats the wire.
    pub fn set_power(&mut self, at: Nanos, watts: f64) {
        let flows = watts.is_finite() && watts > 0.0;
        self.set_drive(
            at,
            if flows {
                Drive::Power(watts)
            } else {
                Drive::Off
            },
        );
    }

    fn set_drive(&mut self, at: Nanos, drive: Drive) {
        let before = self.solver.driven();
        if drive == before {
            return;
        }
        self.advance(at);
        self.solver.drive(at, drive);
        if before == Drive::Off {
            self.rise();
        } else if drive == Drive::Off {
            self.fall();
        }
    }

    fn rise(&mut self) {
        let (wire_c, strain) = self.strain_now();
        self.pulse = Some(Pulse {
            start: self.now(),
            wire_c,
            strain,
            energy: self.solver.delivered(),
        });
    }

    fn fall(&mut self) {
        let Some(pulse) = self.pulse.take() else {
            return;
        };
        let (energy, now) = (self.solver.delivered(), self.now());
        let (hot, strain) = self.strain_now();
        if let Some(b) = self.burst
            && pulse.start.since(b.end) >= BURST_GAP
        {
            self.ended = Some(b);
            self.burst = None;
        }
        let b = self.burst.get_or_insert(Burst {
            start: pulse.start,
            end: pulse.start,
            pulses: 0,
            electrical_j: 0.0,
            wire_j: 0.0,
            hottest_c: hot,
            ripple_k: 0.0,
            ripple_max_k: 0.0,
            thermal_strain: 0.0,
            strain: 0.0,
        });
        b.end = now;
        b.pulses += 1;
        b.electrical_j += energy.0 - pulse.energy.0;
        b.wire_j += energy.1 - pulse.energy.1;
        b.hottest_c = b.hottest_c.max(hot);
        b.ripple_max_k = b.ripple_max_k.max(hot - pulse.wire_c);
        let part = 1.0 / f64::from(b.pulses);
        b.ripple_k += (hot - pulse.wire_c - b.ripple_k) * part;
        b.thermal_strain += (strain.thermal - pulse.strain.thermal - b.thermal_strain) * part;
        b.strain += ((strain.total() - pulse.strain.total()).abs() - b.strain) * part;
    }

    /// The wire's temperature, degrees C, and its strain.
    fn strain_now(&self) -> (f64, Strain) {
        let solver = &self.solver;
        let wire_c = solver.wire_c();
        let strain = Strain::of(solver.wire(), wire_c, solver.fraction_at(wire_c));
        (wire_c, strain)
    }

    /// Computes up to `to`; nothing if that is past. Questions do this themselves.
    pub fn advance(&mut self, to: Nanos) {
        self.solver.advance(to);
    }

    /// The time computed up to.
    pub const fn now(&self) -> Nanos {
        self.solver.now()
    }

    /// The wire's temperature at `at` (or now, if that is later), degrees C.
    pub fn temperature(&mut self, at: Nanos) -> f64 {
        self.advance(at);
        self.solver.wire_c()
    }

    /// Martensite fraction at `at`, in [0, 1].
    pub fn fraction(&mut self, at: Nanos) -> f64 {
        self.advance(at);
        self.solver.fraction()
    }

    /// Skin temperature 0.1 and 0.4 mm under the surface at `at`, degrees C.
    pub fn skin(&mut self, at: Nanos) -> (f64, f64) {
        self.advance(at);
        self.solver.skin_c()
    }

    /// Strain at `at`, by parts.
    pub fn strain(&mut self, at: Nanos) -> Strain {
        self.advance(at);
        self.strain_now().1
    }

    /// Sag at `at` between ends at which the wire is taut when all austenite and at rest, m.
    pub fn sag(&mut self, at: Nanos) -> f64 {
        self.advance(at);
        let w = self.solver.wire();
        let taut = Strain::of(w, w.mechanics.rest_c, 0.0).total();
        sag_m(
            w.length_m,
            (self.strain_now().1.total() - taut) * w.length_m,
        )
    }

    /// Maxima over continuous time from the start to `at`.
    pub fn peaks(&mut self, at: Nanos) -> Peaks {
        self.advance(at);
        self.solver.peaks()
    }

    /// Maxima over continuous time since the last call of this (or the start), up to `at`; starts anew.
    pub fn window_peaks(&mut self, at: Nanos) -> Peaks {
        self.advance(at);
        self.solver.window_peaks()
    }

    /// The energy ledger up to `at`.
    pub fn energy(&mut self, at: Nanos) -> Energy {
        self.advance(at);
        self.solver.energy()
    }

    /// The burn integrals at 0.1 mm up to `at`; `None` without [`Wire::with_dose`].
    pub fn dose(&mut self, at: Nanos) -> Option<Dose> {
        self.advance(at);
        self.solver.dose
    }

    /// The burst under way, or the last one if no other has begun. A pulse counts once it has ended.
    pub const fn burst(&self) -> Option<Burst> {
        self.burst
    }

    /// Takes a burst that is over at `at`: 20 ms without a pulse, or followed by another. One at a
    /// time; call it at least once a burst to miss none.
    pub fn take_burst(&mut self, at: Nanos) -> Option<Burst> {
        if let Some(b) = self.ended.take() {
            return Some(b);
        }
        let over = self.burst.is_some_and(|b| at.since(b.end) >= BURST_GAP);
        if over && self.pulse.is_none() {
            self.burst.take()
        } else {
            None
        }
    }

    /// The solver underneath, for what is not asked often.
    pub const fn solver(&self) -> &Exact {
        &self.solver
    }
}
