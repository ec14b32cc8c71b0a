//! The phases of a wire, which exclude one another, and the skin under its bow, which saturates.

use std::sync::Arc;

use palpate_core::physics::{Law, Line, ParameterError, Phases, TissueParameters, WireParameters};

use super::branch::Heading;
use super::strain::{Motion, Strain, Worn};

/// The phases of one wire in its bow. Copies share the law.
#[derive(Clone, Debug)]
pub struct Phase {
    law: Arc<Law>,
    phases: Phases,
    /// True once the bow has been past the tightest that the model knows.
    tight: bool,
}

impl Phase {
    /// Makes the phases of a wire on a finger, by its history at rest at `start_c` degrees C.
    ///
    /// # Errors
    /// A parameter that cannot be computed with, or a rest that cannot be.
    pub fn new(
        wire: &WireParameters,
        tissue: &TissueParameters,
        start_c: f64,
    ) -> Result<Self, ParameterError> {
        Self::by(Law::new(wire, tissue, start_c)?)
    }

    /// Makes the phases of a wire at rest by its law.
    ///
    /// # Errors
    /// A rest that cannot be.
    pub(crate) fn by(law: Law) -> Result<Self, ParameterError> {
        let phases = Phases::rest(&law)?;
        Ok(Self {
            law: Arc::new(law),
            phases,
            tight: false,
        })
    }

    /// Martensite fraction at `t` degrees C, reached without a turn since the last event; in [0, 1].
    pub fn fraction(&self, t: f64) -> f64 {
        self.phases.fractions(t)[0]
    }

    /// Latent heat that the wire holds at `t`, reached without a turn since the last event, J: none where all of it is martensite.
    pub fn latent_j(&self, t: f64) -> f64 {
        self.phases.latent_j(&self.law, t)
    }

    /// Strain at `t`, reached without a turn since the last event.
    pub fn strain(&self, t: f64) -> Strain {
        let (law, thermal) = (&*self.law, self.phases.thermal_strain(&self.law, t));
        Strain {
            elastic: law.elastic(self.phases.stress_pa(law, t)),
            phase: self.phases.strain_at(t) + law.rest_strain() - thermal,
            thermal,
        }
    }

    /// The straight piece that leads on from the last event.
    pub const fn branch(&self) -> Line {
        *self.phases.line_on()
    }

    /// Motion of the skin from `t` on under a wire that is worn. Where skin and wire part the bow has a knot, so the motion
    /// holds as long as the branch does.
    pub fn motion(&self, worn: &Worn, t: f64) -> Motion {
        let (at_m, m_per_k) = match self.phases.is_apart(&self.law) {
            true => (worn.parting_m - worn.rest_m, 0.0),
            false => (self.u_m(t) - worn.rest_m, self.phases.line_on().u_m),
        };
        Motion {
            at_m,
            m_per_k,
            from_c: t,
        }
    }

    /// Displacement of the bow from its sag at `t`, m.
    pub fn u_m(&self, t: f64) -> f64 {
        self.phases.u_m(&self.law, t)
    }

    /// Takes a turn of the temperature or a threshold passed at `t`.
    pub fn commit(&mut self, t: f64, heading: Heading) {
        self.phases.commit(&self.law, t, heading == Heading::Up);
        self.tight |= self.phases.is_tight(&self.law);
    }

    /// True once the bow has been past nine tenths of its sag.
    pub const fn was_tight(&self) -> bool {
        self.tight
    }
}
