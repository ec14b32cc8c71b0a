//! Exact solution from edge to edge, without truncation error: modes, events, memory of hysteresis.

mod step;

use std::sync::Arc;

use super::WireDrive;
use super::lanes::dot;
use super::maxima::Maxima;
use super::modal::{Mode, ModeKey};
use super::propagators::Propagators;
use super::regimes::{REGIMES, Regimes};
use crate::display::finger::dose::Dose;
use crate::display::finger::{NODES, ThermalNetwork};
use crate::display::solver::branch::Heading;
use crate::display::solver::phase::Phase;
use crate::display::solver::record::{Energy, Peaks};
use crate::display::solver::strain::{Motion, Strain, Worn};
use crate::display::solver::stretch::Stretch;
use crate::time::Nanos;
use palpate_core::physics::{Bow, Line, ParameterError, TissueParameters, WireParameters};
#[cfg(test)]
use palpate_core::physics::{Curve, Law};
use palpate_core::vector::{Scalar, Vectors};
use step::{Advance, Glance};

/// The exact solver. A clone has a state of its own, and shares everything that follows from the wire alone.
#[derive(Clone, Debug)]
pub struct Exact {
    wire: Arc<WireParameters>,
    network: Arc<ThermalNetwork>,
    phase: Phase,
    heading: Heading,
    /// Regimes of all clones; `modes` are those that this clone has been in.
    regimes: Regimes,
    modes: Vec<Arc<Mode>>,
    mode: usize,
    oldest: usize,
    propagators: Propagators,
    z: [f64; NODES],
    /// Temperatures that `z` gives at the places that are looked at.
    watched: Watched,
    vectors: Vectors,
    now: Nanos,
    drive: WireDrive,
    /// Hottest the wire has been: since the start, and since a window was opened.
    hottest: (f64, f64),
    /// The tissue at 0.1 and 0.4 mm.
    shallow: Maxima,
    deep: Maxima,
    energy: Energy,
    /// Burn integrals of the tissue at 0.1 mm, where they are wanted.
    pub dose: Option<Dose>,
    /// The seat of a worn wire: with one, parting from the skin is an event.
    worn: Option<Worn>,
    /// Motion of the skin in the last stretch.
    motion: Motion,
    /// Stretches that a person's model reads, the oldest first; `None` without such a model.
    pub stretches: Option<Vec<Stretch>>,
}

/// Temperatures above the body's at the time computed up to, K.
#[derive(Clone, Copy, Debug, Default)]
struct Watched {
    wire: f64,
    /// The tissue at 0.1 mm.
    shallow: f64,
    /// The tissue at 0.4 mm.
    deep: f64,
}

/// Heat into the wire as a function of its temperature above the body's: `power + feedback u`.
struct Heat {
    power: f64,
    feedback: f64,
}

impl Exact {
    /// A wire and its tissue, all at rest at `start_c`, the wire's phases by its history.
    ///
    /// # Errors
    /// A parameter that cannot be computed with.
    pub fn new(
        wire: &WireParameters,
        tissue: &TissueParameters,
        start_c: f64,
    ) -> Result<Self, ParameterError> {
        Self::beside(None, wire, tissue, start_c)
    }

    /// [`Self::new`] beside a wire whose regimes are used again where both have the same network.
    ///
    /// # Errors
    /// A parameter that cannot be computed with.
    pub fn beside(
        other: Option<&Self>,
        wire: &WireParameters,
        tissue: &TissueParameters,
        start_c: f64,
    ) -> Result<Self, ParameterError> {
        if !start_c.is_finite() {
            return Err(ParameterError { name: "start_c" });
        }
        let network = ThermalNetwork::new(wire, tissue)?;
        let phase = Phase::new(wire, tissue, start_c)?;
        let same = other.filter(|other| *other.network == network);
        let regimes = same.map_or_else(Regimes::default, |same| same.regimes.clone());
        let resting = regimes.mode(
            &network,
            ModeKey {
                latent: 0.0,
                feedback: 0.0,
            },
        );
        let z = resting.project(&[start_c - network.body_c; NODES]);
        let mut solver = Self {
            wire: Arc::new(*wire),
            network: Arc::new(network),
            phase,
            heading: Heading::Up,
            regimes,
            modes: vec![resting],
            mode: 0,
            oldest: 1,
            propagators: Propagators::default(),
            z,
            watched: Watched::default(),
            vectors: Vectors::widest(),
            now: Nanos::ZERO,
            drive: WireDrive::Off,
            hottest: (start_c, start_c),
            shallow: Maxima::new(start_c),
            deep: Maxima::new(start_c),
            energy: Energy::default(),
            dose: None,
            worn: None,
            motion: Motion::default(),
            stretches: None,
        };
        solver.watch();
        solver.face();
        Ok(solver)
    }

    /// Puts the wire on the skin as it is now; from here on both part and meet by [`Bow`].
    ///
    /// # Errors
    /// A parameter that cannot be computed with.
    pub fn wear(&mut self, tissue: &TissueParameters) -> Result<(), ParameterError> {
        self.worn = Some(Worn {
            parting_m: Bow::new(&self.wire, tissue)?.parting_m,
            rest_m: self.phase.u_m(self.wire_c()),
        });
        self.motion = Motion::default();
        Ok(())
    }

    /// Temperatures of wire and tissue 0.1 mm deep at `at` (or now), degrees C, as [`Self::advance`] would find them.
    pub(crate) fn glance(&self, at: Nanos) -> [f64; 2] {
        let span = at.since(self.now);
        let body_c = self.network.body_c;
        let found = match span {
            Nanos::ZERO => Some([self.watched.wire, self.watched.shallow]),
            _ => self.vectors.dispatch(Glance(self, span)),
        };
        found.map_or_else(
            || {
                let mut ahead = self.ahead();
                ahead.advance(at);
                [ahead.wire_c(), ahead.tissue_c().0]
            },
            |found| found.map(|k| body_c + k),
        )
    }

    /// A light copy for a look ahead at temperatures: without books, and without caches that only save work.
    #[must_use]
    pub fn ahead(&self) -> Self {
        let (shallow_c, deep_c) = self.tissue_c();
        Self {
            wire: Arc::clone(&self.wire),
            network: Arc::clone(&self.network),
            phase: self.phase.clone(),
            regimes: self.regimes.clone(),
            modes: vec![Arc::clone(&self.modes[self.mode])],
            mode: 0,
            oldest: 1,
            propagators: Propagators::default(),
            shallow: Maxima::new(shallow_c),
            deep: Maxima::new(deep_c),
            dose: None,
            stretches: None,
            ..*self
        }
    }

    /// Clones the solver with its books.
    #[must_use]
    pub(crate) fn ahead_with_books(&self) -> Self {
        Self {
            shallow: self.shallow.clone(),
            deep: self.deep.clone(),
            dose: self.dose,
            ..self.ahead()
        }
    }

    /// Replaces the bow by one whose stress is the bias stress throughout, and whose skin moves by its gain at rest.
    #[cfg(test)]
    pub(crate) fn with_linear_bow(self, tissue: &TissueParameters, start_c: f64) -> Self {
        let bow = Bow::new(&self.wire, tissue).unwrap();
        let mut curve = Curve::new(&bow, &self.wire);
        curve.pieces.truncate(1);
        let piece = &mut curve.pieces[0];
        (piece.low, piece.high) = (f64::NEG_INFINITY, f64::INFINITY);
        (piece.from, piece.u_m, piece.u_per) = (0.0, 0.0, -bow.gain * self.wire.length_m);
        (piece.stress_pa, piece.stiffness_pa, piece.tight) = (0.0, 0.0, false);
        let law = Law::in_bow(&self.wire, curve, start_c).unwrap();
        let phase = Phase::by(law).unwrap();
        Self { phase, ..self }
    }

    /// Displacement of the bow from its sag, m.
    #[cfg(test)]
    pub(crate) fn bow_m(&self) -> f64 {
        self.phase.u_m(self.wire_c())
    }

    /// Clones the solver to step with these vectors.
    #[cfg(test)]
    pub(crate) fn with_vectors(&self, vectors: Vectors) -> Self {
        Self {
            vectors,
            ..self.clone()
        }
    }

    /// The time computed up to.
    pub const fn now(&self) -> Nanos {
        self.now
    }

    /// The drive of the wire.
    pub const fn driven(&self) -> WireDrive {
        self.drive
    }

    /// The wire's parameters.
    pub fn wire(&self) -> &WireParameters {
        &self.wire
    }

    /// The thermal network under the wire.
    pub fn network(&self) -> &ThermalNetwork {
        &self.network
    }

    /// The wire's temperature at the time computed up to, degrees C.
    pub fn wire_c(&self) -> f64 {
        self.network.body_c + self.watched.wire
    }

    /// Looks at the coordinates anew, after a change of them or of their meaning.
    fn watch(&mut self) {
        let mode = &self.modes[self.mode];
        self.watched = Watched {
            wire: dot(Scalar, &mode.gain, &self.z),
            shallow: dot(Scalar, &mode.shallow, &self.z),
            deep: dot(Scalar, &mode.deep, &self.z),
        };
    }

    /// Strain at the time computed up to.
    pub fn strain(&self) -> Strain {
        self.phase.strain(self.wire_c())
    }

    /// True if the bow has been past the tightest that the model knows.
    pub(crate) const fn was_tight(&self) -> bool {
        self.phase.was_tight()
    }

    /// Displacement of the skin from rest at the time computed up to, m, positive into it; 0 without [`Self::wear`].
    pub(crate) fn displacement_m(&self) -> f64 {
        self.motion.at(self.wire_c())
    }

    /// The tissue at 0.1 and 0.4 mm at the time computed up to, degrees C.
    pub fn tissue_c(&self) -> (f64, f64) {
        let base = self.network.body_c;
        (base + self.watched.shallow, base + self.watched.deep)
    }

    /// Maxima over continuous time since the start. Tissue that cannot have passed `floor` is not searched, now or later.
    pub fn peaks(&mut self, floor: &Peaks) -> Peaks {
        Peaks {
            wire_c: self.hottest.0,
            shallow_c: self.shallow.settle(floor.shallow_c).0,
            deep_c: self.deep.settle(floor.deep_c).0,
        }
    }

    /// The peaks as far as they are known without a search: no higher than the true ones.
    pub(crate) const fn peaks_floor(&self) -> Peaks {
        Peaks {
            wire_c: self.hottest.0,
            shallow_c: self.shallow.known_whole(),
            deep_c: self.deep.known_whole(),
        }
    }

    /// The known part of the window's maxima, without a search: no higher than the true ones.
    pub(crate) const fn window_floor(&self) -> Peaks {
        Peaks {
            wire_c: self.hottest.1,
            shallow_c: self.shallow.known(),
            deep_c: self.deep.known(),
        }
    }

    /// Maxima since the last call of this, or the start; begins a new window at the time computed up to. Tissue that
    /// cannot have passed `floor` is not searched, now or later.
    pub(crate) fn window_peaks(&mut self, floor: &Peaks) -> Peaks {
        let peaks = Peaks {
            wire_c: self.hottest.1,
            shallow_c: self.shallow.settle(floor.shallow_c).1,
            deep_c: self.deep.settle(floor.deep_c).1,
        };
        let (shallow_c, deep_c) = self.tissue_c();
        self.hottest.1 = self.wire_c();
        self.shallow.open(shallow_c);
        self.deep.open(deep_c);
        peaks
    }

    /// Energy delivered so far: between the terminals, and into the wire, J.
    pub const fn delivered(&self) -> (f64, f64) {
        (self.energy.electrical_j, self.energy.wire_j)
    }

    /// Destinations of the heat since the start.
    pub fn energy(&self) -> Energy {
        let nodes = self.nodes();
        let mut stored = 0.0;
        for (t, c) in nodes.iter().zip(&self.network.capacity) {
            stored += c * (t - self.network.body_c);
        }
        Energy {
            stored_j: stored,
            latent_j: self.phase.latent_j(self.wire_c()),
            ..self.energy
        }
    }

    /// Resistance between the terminals at the time computed up to, Ohm.
    pub fn resistance_ohm(&self) -> f64 {
        let (branch, series) = (Line::default(), 1.0 - self.wire.wire_share);
        self.resistance(self.wire_c(), &branch).0 + self.wire.resistance_ohm * series
    }

    /// Resistance of the wire alone now, Ohm, and its change with temperature within `branch`.
    fn resistance(&self, t: f64, branch: &Line) -> (f64, f64) {
        let w = &*self.wire;
        let nominal = w.resistance_ohm * w.wire_share;
        let mut relative = 1.0 + (w.austenite_ratio - 1.0) * (1.0 - self.phase.fraction(t));
        relative += w.resistance_per_kelvin * (t - w.reference_c);
        let per_kelvin = w.resistance_per_kelvin - (w.austenite_ratio - 1.0) * branch.martensite;
        (nominal * relative, nominal * per_kelvin)
    }

    /// Computes the motion of the skin from `t` on, where the wire is worn.
    fn touch(&mut self, t: f64) {
        if let Some(worn) = &self.worn {
            self.motion = self.phase.motion(worn, t);
        }
    }

    /// Heat into the wire from the drive alone.
    fn heat(&self, t: f64, branch: &Line) -> Heat {
        match self.drive {
            WireDrive::Off => Heat {
                power: 0.0,
                feedback: 0.0,
            },
            WireDrive::Power(watts) => Heat {
                power: watts * self.wire.wire_share,
                feedback: 0.0,
            },
            WireDrive::Current(amps) => {
                let (ohm, per_kelvin) = self.resistance(t, branch);
                let feedback = amps * amps * per_kelvin;
                Heat {
                    power: amps * amps * ohm - feedback * (t - self.network.body_c),
                    feedback,
                }
            }
        }
    }

    /// Heat that flows into the wire now from drive and surroundings, W: its sign is the heading.
    fn inflow(&self) -> f64 {
        let u = self.watched.wire;
        let shell = self.modes[self.mode].first_shell(&self.z);
        let t = self.wire_c();
        let heat = self.heat(t, &Line::default());
        let n = &*self.network;
        let out = (n.air + n.ends) * u + n.chain[0] * (u - shell);
        heat.power + heat.feedback * u + n.rest_inflow() - out
    }

    /// Turns to the direction in which the wire's temperature goes after an edge.
    fn face(&mut self) {
        let heading = if self.inflow() < 0.0 {
            Heading::Down
        } else {
            Heading::Up
        };
        if heading != self.heading {
            self.turn(heading);
        }
    }

    fn turn(&mut self, heading: Heading) {
        self.heading = heading;
        self.phase.commit(self.wire_c(), heading);
    }

    /// Enters the regime `key`, taking the state along.
    fn enter(&mut self, key: ModeKey) {
        if self.modes[self.mode].key == key {
            return;
        }
        let nodes = self.modes[self.mode].nodes(&self.z);
        let found = self.modes.iter().position(|m| m.key == key);
        self.mode = found.unwrap_or_else(|| {
            let mode = self.regimes.mode(&self.network, key);
            if self.modes.len() < REGIMES {
                self.modes.push(mode);
                return self.modes.len() - 1;
            }
            let place = self.oldest;
            self.oldest = if place + 1 < REGIMES { place + 1 } else { 1 };
            self.modes[place] = mode;
            self.propagators.forget(place);
            place
        });
        // The watched temperatures stay the same in the new regime.
        self.z = self.modes[self.mode].project(&nodes);
    }
}

impl Exact {
    /// Changes the drive at `at`; a time before the last one counts as that.
    pub fn drive(&mut self, at: Nanos, drive: WireDrive) {
        if drive == self.drive {
            return;
        }
        self.advance(at);
        self.drive = drive;
        self.face();
    }

    /// Computes up to `to`; does nothing if that is past.
    pub fn advance(&mut self, to: Nanos) {
        if to > self.now {
            let span = to.since(self.now);
            self.vectors.dispatch(Advance(self, span));
            self.now = to;
        }
    }

    /// Temperatures of wire and shells at the time computed up to, degrees C.
    pub fn nodes(&self) -> [f64; NODES] {
        self.modes[self.mode]
            .nodes(&self.z)
            .map(|u| u + self.network.body_c)
    }

    /// Martensite fraction at the time computed up to, in [0, 1].
    pub fn fraction(&self) -> f64 {
        self.phase.fraction(self.wire_c())
    }
}
