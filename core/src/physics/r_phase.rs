//! The R phase, and how stress moves the bands of a transformation.

use super::{Alloy, ParameterError, WireParameters, check, finite, not_negative, positive};

/// The R phase of an alloy: austenite cools to it, and it cools to martensite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RPhase {
    /// Bands of R and their rise with stress. Heating and cooling bands may overlap (a hysteresis narrower than they are)
    /// or coincide (none), but may not cross.
    pub bands: Alloy,
    /// Strain of a wire that is all R, against austenite, 1; positive is longer.
    pub strain: f64,
    /// Latent heat of a wire that is all R, against austenite, J/kg.
    pub latent_heat: f64,
}

impl RPhase {
    /// The low-temperature wire's: 45/35 C on cooling without stress, 2 K of hysteresis, 15 MPa/K, 0.1 %, 4 kJ/kg \[A\].
    pub const LOW: Self = Self {
        bands: Alloy {
            austenite_start_c: 37.0,
            austenite_finish_c: 47.0,
            martensite_start_c: 45.0,
            martensite_finish_c: 35.0,
            stress_per_kelvin: 15e6,
            reference_stress_pa: 0.0,
        },
        strain: 1e-3,
        latent_heat: 4e3,
    };
}

impl Alloy {
    /// Makes the alloy under a stress: all four temperatures shift by stress over slope.
    #[must_use]
    pub fn under(&self, stress_pa: f64) -> Self {
        let shift = (stress_pa - self.reference_stress_pa) / self.stress_per_kelvin;
        Self {
            austenite_start_c: self.austenite_start_c + shift,
            austenite_finish_c: self.austenite_finish_c + shift,
            martensite_start_c: self.martensite_start_c + shift,
            martensite_finish_c: self.martensite_finish_c + shift,
            reference_stress_pa: stress_pa,
            ..*self
        }
    }

    /// Makes one band for both ways: as wide as both are on the average, about the middle of the hysteresis.
    pub(super) fn reversible(&self) -> Self {
        let top = (self.austenite_finish_c + self.martensite_start_c) / 2.0;
        let bottom = (self.austenite_start_c + self.martensite_finish_c) / 2.0;
        Self {
            austenite_start_c: bottom,
            austenite_finish_c: top,
            martensite_start_c: top,
            martensite_finish_c: bottom,
            ..*self
        }
    }

    /// Checks that both bands have a width and do not cross.
    fn check_apart(&self) -> Result<(), ParameterError> {
        positive("stress_per_kelvin", self.stress_per_kelvin)?;
        finite("reference_stress_pa", self.reference_stress_pa)?;
        positive(
            "heating band",
            self.austenite_finish_c - self.austenite_start_c,
        )?;
        positive(
            "cooling band",
            self.martensite_start_c - self.martensite_finish_c,
        )?;
        not_negative(
            "hysteresis",
            self.austenite_start_c - self.martensite_finish_c,
        )?;
        not_negative(
            "hysteresis",
            self.austenite_finish_c - self.martensite_start_c,
        )
    }
}

impl WireParameters {
    /// Checks that the phases of a wire can exclude one another.
    pub(super) fn check_phases(&self) -> Result<(), ParameterError> {
        self.alloy.check_apart()?;
        not_negative("reversible", self.reversible)?;
        not_negative("1 - reversible", 1.0 - self.reversible)?;
        finite(
            "history.coldest_c",
            self.history.coldest_c.unwrap_or_default(),
        )?;
        let (mut strain, mut latent) = (0.0, 0.0);
        if let Some(r) = &self.r_phase {
            r.bands.check_apart()?;
            not_negative("r_phase.strain", r.strain)?;
            not_negative("r_phase.latent_heat", r.latent_heat)?;
            (strain, latent) = (r.strain, r.latent_heat);
        }
        // R that turns to martensite lengthens a wire and gives off heat; the other way round stress would run away.
        check(
            "mechanics.transformation_strain",
            self.mechanics.transformation_strain >= strain,
        )?;
        check("latent_heat", self.latent_heat >= latent)
    }
}

#[cfg(test)]
#[path = "r_phase_tests.rs"]
mod tests;
