//! The phases of a wire, by the knowledge of it: plays in parallel, or phases that exclude one another in a bow.
//!
//! [`Plays`] go with [`Worn`], the linear bow. Once every wire has a history both can go, and [`Phase`] becomes
//! [`Exclusive`].

use std::sync::Arc;

use palpate_core::physics::{Law, ParameterError, Phases, TissueParameters, WireParameters};

use super::branch::{Branch, Heading};
use super::plays::Plays;
use super::strain::{Motion, Strain, Worn};

/// The phases of one wire.
#[derive(Clone, Debug)]
pub enum Phase {
    /// Plays in parallel: a wire without a history.
    Parallel(Plays),
    /// Phases that exclude one another: a wire with a history.
    Exclusive(Box<Exclusive>),
}

/// Phases that exclude one another, in a bow that saturates.
#[derive(Clone, Debug)]
pub struct Exclusive {
    law: Arc<Law>,
    phases: Phases,
    /// True once the bow has been past the tightest that the model knows.
    tight: bool,
}

impl Phase {
    /// Makes the phases of a wire on a finger at rest at `start_c`: by its history, or else as after heating from far below.
    ///
    /// # Errors
    /// A parameter that cannot be computed with.
    pub fn new(
        wire: &WireParameters,
        tissue: &TissueParameters,
        start_c: f64,
    ) -> Result<Self, ParameterError> {
        match wire.history {
            None => Plays::new(wire, start_c).map(Self::Parallel),
            Some(_) => {
                let law = Law::new(wire, tissue, start_c)?;
                Exclusive::new(law).map(|e| Self::Exclusive(Box::new(e)))
            }
        }
    }

    /// Martensite fraction at `t` degrees C, reached without a turn since the last event; in [0, 1].
    pub fn fraction(&self, t: f64) -> f64 {
        match self {
            Self::Parallel(plays) => plays.fraction(t),
            Self::Exclusive(e) => e.phases.fractions(t)[0],
        }
    }

    /// Latent heat that the wire holds at `t`, reached without a turn since the last event, J: none where all of it is martensite.
    pub fn latent_j(&self, t: f64) -> f64 {
        match self {
            Self::Parallel(plays) => plays.latent_j(t),
            Self::Exclusive(e) => e.phases.latent_j(&e.law, t),
        }
    }

    /// Strain at `t`, reached without a turn since the last event.
    pub fn strain(&self, t: f64) -> Strain {
        match self {
            Self::Parallel(plays) => plays.strain(t),
            Self::Exclusive(e) => e.strain(t),
        }
    }

    /// The straight piece that leads on from `t`.
    pub fn branch(&self, t: f64, heading: Heading) -> Branch {
        match self {
            Self::Parallel(plays) => plays.branch(t, heading),
            Self::Exclusive(e) => e.branch(),
        }
    }

    /// Motion of the skin from `t` on under a wire that is worn, and the temperatures between which it holds.
    pub fn motion(
        &self,
        worn: &Worn,
        t: f64,
        branch: &Branch,
        heading: Heading,
    ) -> (Motion, (f64, f64)) {
        match self {
            Self::Parallel(plays) => {
                let rises = heading == Heading::Up;
                worn.motion(t, plays.strain(t).total(), branch.strain, rises)
            }
            // Where skin and wire part the bow has a knot.
            Self::Exclusive(e) => (e.motion(worn, t), (f64::NEG_INFINITY, f64::INFINITY)),
        }
    }

    /// Displacement of the bow from its sag at `t`, m; a wire without a history has its sag at rest.
    pub fn u_m(&self, t: f64) -> f64 {
        match self {
            Self::Parallel(_) => 0.0,
            Self::Exclusive(e) => e.phases.u_m(&e.law, t),
        }
    }

    /// Takes a turn of the temperature or a threshold passed at `t`.
    pub fn commit(&mut self, t: f64, heading: Heading) {
        match self {
            Self::Parallel(plays) => plays.commit(t),
            Self::Exclusive(e) => e.commit(t, heading),
        }
    }

    /// True once the bow has been past nine tenths of its sag.
    pub const fn was_tight(&self) -> bool {
        match self {
            Self::Parallel(_) => false,
            Self::Exclusive(e) => e.tight,
        }
    }
}

impl Exclusive {
    /// A wire at rest.
    ///
    /// # Errors
    /// A rest that cannot be.
    pub(crate) fn new(law: Law) -> Result<Self, ParameterError> {
        let phases = Phases::rest(&law)?;
        Ok(Self {
            law: Arc::new(law),
            phases,
            tight: false,
        })
    }

    fn strain(&self, t: f64) -> Strain {
        let (law, thermal) = (&*self.law, self.phases.thermal_strain(&self.law, t));
        Strain {
            elastic: law.elastic(self.phases.stress_pa(law, t)),
            phase: self.phases.strain_at(t) + law.rest_strain() - thermal,
            thermal,
        }
    }

    fn branch(&self) -> Branch {
        let line = self.phases.line_on();
        Branch {
            slope: line.martensite,
            latent: line.latent,
            strain: line.strain,
            low: line.low,
            high: line.high,
            one_way: line.one_way,
        }
    }

    fn motion(&self, worn: &Worn, t: f64) -> Motion {
        let (at_m, m_per_k) = match self.phases.is_apart(&self.law) {
            true => (worn.parting_m - worn.rest_m, 0.0),
            false => (
                self.phases.u_m(&self.law, t) - worn.rest_m,
                self.phases.line_on().u_m,
            ),
        };
        Motion {
            at_m,
            m_per_k,
            from_c: t,
        }
    }

    fn commit(&mut self, t: f64, heading: Heading) {
        self.phases.commit(&self.law, t, heading == Heading::Up);
        self.tight |= self.phases.is_tight(&self.law);
    }
}
