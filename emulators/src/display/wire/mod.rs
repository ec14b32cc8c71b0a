//! A shape-memory wire on a finger: current in, heat, phase, strain and tissue temperature out.
//!
//! The wire is lazy. Edges and questions advance it; between them nothing is computed, and however
//! time is cut by questions the answers are the same to 1e-9 K.

mod burst;

use crate::display::finger::dose::Dose;
use crate::display::solver::WireDrive;
use crate::display::solver::exact::Exact;
use crate::display::solver::record::{Energy, Peaks};
use crate::display::solver::strain::Strain;
use crate::display::solver::stretch::Stretch;
use crate::time::Nanos;
use burst::WireBurst;
use palpate_core::physics::{ParameterError, TissueParameters, WireParameters};

/// Pause without a pulse after which a burst has ended.
pub const BURST_GAP: Nanos = Nanos::from_micros(20_000);

/// One wire and the tissue under it.
///
/// ```
/// use palpate_core::physics::{TissueParameters, WireParameters};
/// use palpate_emulators::display::wire::Wire;
/// use palpate_emulators::time::Nanos;
///
/// let mut wire = Wire::new(&WireParameters::FINAL, &TissueParameters::DEFAULT, 33.0)?; // degrees C
/// wire.set_current(Nanos::ZERO, 1.97); // A
/// wire.set_current(Nanos(124_000), 0.0);
///
/// let hottest = wire.peaks(Nanos::from_micros(100_000));
/// assert!(hottest.wire_c > 40.0 && hottest.shallow_c > 33.1);
/// # Ok::<(), palpate_core::physics::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Wire {
    solver: Exact,
    pulse: Option<Pulse>,
    burst: Option<WireBurst>,
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
    /// A wire at rest, with tissue and itself at `start_c` (33 is tissue).
    ///
    /// # Errors
    /// A parameter that cannot be computed with, by name.
    pub fn new(
        wire: &WireParameters,
        tissue: &TissueParameters,
        start_c: f64,
    ) -> Result<Self, ParameterError> {
        Self::beside(None, wire, tissue, start_c)
    }

    /// [`Self::new`] beside a wire on the same finger, of the same alloy or another: equal work is done once for both.
    ///
    /// # Errors
    /// A parameter that cannot be computed with, by name.
    pub fn beside(
        other: Option<&Self>,
        wire: &WireParameters,
        tissue: &TissueParameters,
        start_c: f64,
    ) -> Result<Self, ParameterError> {
        let other = other.map(|other| &other.solver);
        let solver = Exact::beside(other, wire, tissue, start_c)?;
        Ok(Self {
            solver,
            pulse: None,
            burst: None,
        })
    }

    /// Keeps the burn integrals at 0.1 mm too from here on, at a few evaluations a step.
    #[must_use]
    pub fn with_dose(mut self) -> Self {
        self.solver.dose = Some(Dose::default());
        self
    }

    /// Keeps every stretch from here on for a person's model, until they are taken. A wire moves tissue once it is
    /// [`Wire::worn`].
    pub fn keep_stretches(&mut self) {
        self.solver.stretches = Some(Vec::new());
    }

    /// Computes up to `at` and takes the stretches since the last time, the oldest first.
    pub fn take_stretches(&mut self, at: Nanos, mut take: impl FnMut(&Stretch)) {
        self.advance(at);
        if let Some(stretches) = &mut self.solver.stretches {
            stretches.drain(..).for_each(|s| take(&s));
        }
    }

    /// Sets the current from `at` on, A. The caller sets every edge, in order; a time before the last one counts as
    /// that. Setting the present current again costs nothing. Not a number counts as off.
    pub fn set_current(&mut self, at: Nanos, amps: f64) {
        let flows = amps.is_finite() && amps != 0.0;
        self.set_drive(
            at,
            if flows {
                WireDrive::Current(amps)
            } else {
                WireDrive::Off
            },
        );
    }

    /// Sets the electrical power from `at` on, W; the wire's share of it heats the wire.
    pub fn set_power(&mut self, at: Nanos, watts: f64) {
        let flows = watts.is_finite() && watts > 0.0;
        self.set_drive(
            at,
            if flows {
                WireDrive::Power(watts)
            } else {
                WireDrive::Off
            },
        );
    }

    /// Puts the wire on the skin as it is now, so that the wire moves it.
    ///
    /// # Errors
    /// A parameter that cannot be computed with, by name.
    pub fn worn(mut self, tissue: &TissueParameters) -> Result<Self, ParameterError> {
        self.solver.wear(tissue)?;
        Ok(self)
    }

    /// Displacement of the skin from rest at `at`, m, positive into it; 0 without [`Wire::worn`].
    pub fn displacement_m(&mut self, at: Nanos) -> f64 {
        self.advance(at);
        self.solver.displacement_m()
    }

    fn set_drive(&mut self, at: Nanos, drive: WireDrive) {
        let before = self.solver.driven();
        if drive == before {
            return;
        }
        self.advance(at);
        self.solver.drive(at, drive);
        if before == WireDrive::Off {
            self.rise();
        } else if drive == WireDrive::Off {
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
            self.burst = None;
        }
        let b = self.burst.get_or_insert(WireBurst {
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
        (solver.wire_c(), solver.strain())
    }

    /// Computes up to `to`; a time in the past changes nothing. Questions do this themselves.
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

    /// Temperatures of wire and tissue 0.1 mm deep at `at` (or now), degrees C, without advancing. The solver steps
    /// from look to look, so a look of its own would change the last digits of later ones.
    pub(crate) fn glance(&self, at: Nanos) -> [f64; 2] {
        self.solver.glance(at)
    }

    /// A light copy that gives the temperatures that this wire would.
    #[must_use]
    pub fn ahead(&self) -> Self {
        Self::on(self.solver.ahead())
    }

    /// Clones the wire to answer for peaks, energy and dose too. Bursts and stretches stay behind.
    #[must_use]
    pub(crate) fn ahead_with_books(&self) -> Self {
        Self::on(self.solver.ahead_with_books())
    }

    /// A wire on this solver, without bursts or pulses.
    pub(crate) const fn on(solver: Exact) -> Self {
        Self {
            solver,
            pulse: None,
            burst: None,
        }
    }

    /// Martensite fraction at `at`, in [0, 1].
    pub fn fraction(&mut self, at: Nanos) -> f64 {
        self.advance(at);
        self.solver.fraction()
    }

    /// Tissue temperature 0.1 and 0.4 mm under the surface at `at`, degrees C.
    pub fn tissue(&mut self, at: Nanos) -> (f64, f64) {
        self.advance(at);
        self.solver.tissue_c()
    }

    /// True if the bow has been past the tightest that the model knows until `at`.
    pub fn was_tight(&mut self, at: Nanos) -> bool {
        self.advance(at);
        self.solver.was_tight()
    }

    /// Resistance between the terminals at `at`, Ohm.
    pub fn resistance_ohm(&mut self, at: Nanos) -> f64 {
        self.advance(at);
        self.solver.resistance_ohm()
    }

    /// Strain at `at`, by parts.
    pub fn strain(&mut self, at: Nanos) -> Strain {
        self.advance(at);
        self.strain_now().1
    }

    /// Maxima over continuous time from the start to `at`.
    pub fn peaks(&mut self, at: Nanos) -> Peaks {
        self.peaks_above(at, &Peaks::NONE)
    }

    /// The peaks where only the warmest of several wires counts: tissue that cannot have passed `floor` is not
    /// searched, now or later.
    pub(crate) fn peaks_above(&mut self, at: Nanos, floor: &Peaks) -> Peaks {
        self.advance(at);
        self.solver.peaks(floor)
    }

    /// Lower bound of [`Self::window_peaks`], without a search.
    pub(crate) fn window_floor(&mut self, at: Nanos) -> Peaks {
        self.advance(at);
        self.solver.window_floor()
    }

    /// Maxima over continuous time since the last call of this (or the start), up to `at`; starts anew. Only the
    /// warmest of several wires counts: tissue that cannot have passed `floor` is not searched, and [`Self::peaks`]
    /// may miss its maximum.
    pub(crate) fn window_peaks(&mut self, at: Nanos, floor: &Peaks) -> Peaks {
        self.advance(at);
        self.solver.window_peaks(floor)
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
    pub const fn burst(&self) -> Option<WireBurst> {
        self.burst
    }

    /// The solver underneath, for rare questions.
    pub const fn solver(&self) -> &Exact {
        &self.solver
    }
}
