//! The history of a wire before its first pulse.

use super::{Hysteresis, ParameterError, WireParameters, check, finite};

/// A state that a wire is brought into by temperature alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireState {
    /// All martensite: cooled far below its martensite finish.
    Cold,
    /// Austenite and R: heated until all of it was austenite, then cooled to rest.
    Passed,
}

/// History of a wire whose phases exclude one another, moved by the stress in its bow ([`super::Law`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct History {
    /// State in which the wire begins.
    pub state: WireState,
    /// State in which [`super::Mount::sag_m`] was measured.
    pub sag_state: WireState,
    /// Lowest temperature since a pass, degrees C; `None`: that of rest.
    pub coldest_c: Option<f64>,
}

impl WireParameters {
    /// Checks that phases that exclude one another can be computed of the wire.
    pub(super) fn check_history(&self) -> Result<(), ParameterError> {
        let Some(history) = &self.history else {
            return Ok(());
        };
        check("hysteresis", self.hysteresis == Hysteresis::Play)?;
        check("beside", self.beside[1..].iter().all(Option::is_none))?;
        finite("history.coldest_c", history.coldest_c.unwrap_or_default())?;
        let (strain, latent) = self.beside[0].map_or((0.0, 0.0), |r| (r.strain, r.latent_heat));
        check("beside.strain", strain >= 0.0)?;
        // R that turns to martensite lengthens a wire and gives off heat; the other way round stress would run away.
        check(
            "mechanics.transformation_strain",
            self.mechanics.transformation_strain >= strain,
        )?;
        check("latent_heat", self.latent_heat >= latent)
    }
}
