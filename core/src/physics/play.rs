//! Shares of a wire that transform in parallel, each by a play with straight branches.

use alloc::vec::Vec;

use super::{
    Alloy, Hysteresis, ParameterError, WireParameters, check, finite, not_negative, positive,
};

/// Plays that a wire may have beside its martensite.
pub const MOST_BESIDE: usize = 4;

/// A share of a wire, all of it cold (p = 1), none of it hot (p = 0): p = min(max(p, c(T)), h(T)), both branches
/// straight over their bands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Play {
    /// Temperatures of both bands and their rise with stress. Heating and cooling bands may overlap (a hysteresis
    /// narrower than they are) or coincide (none), but may not cross.
    pub bands: Alloy,
    /// Share of the martensite fraction xi, 1; 0 stands beside the martensite, as the R phase does.
    pub martensite: f64,
    /// Strain of the whole share, cold against hot, 1; positive is longer.
    pub strain: f64,
    /// Latent heat of the whole share, J/kg of wire.
    pub latent_heat: f64,
}

impl Play {
    /// The R phase of a loose wire: 45/35 C on cooling without stress, 2 K of hysteresis, 15 MPa/K, 0.1 %, 4 kJ/kg \[A\].
    pub const R_PHASE: Self = Self {
        bands: Alloy {
            austenite_start_c: 37.0,
            austenite_finish_c: 47.0,
            martensite_start_c: 45.0,
            martensite_finish_c: 35.0,
            stress_per_kelvin: 15e6,
            reference_stress_pa: 0.0,
        },
        martensite: 0.0,
        strain: 1e-3,
        latent_heat: 4e3,
    };

    fn check(&self) -> Result<(), ParameterError> {
        self.bands.check_apart()?;
        finite("beside.strain", self.strain)?;
        not_negative("beside.latent_heat", self.latent_heat)?;
        check("beside.martensite", self.martensite == 0.0)
    }
}

impl Alloy {
    /// Returns the alloy under a stress: all four temperatures shift by stress over slope.
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

    /// Returns the alloy with its hysteresis scaled about the middle: 1 changes nothing, 0 leaves none.
    fn narrowed(&self, scale: f64) -> Self {
        let up = (self.austenite_start_c + self.austenite_finish_c) / 2.0;
        let down = (self.martensite_start_c + self.martensite_finish_c) / 2.0;
        let inward = (up - down) / 2.0 * (1.0 - scale);
        Self {
            austenite_start_c: self.austenite_start_c - inward,
            austenite_finish_c: self.austenite_finish_c - inward,
            martensite_start_c: self.martensite_start_c + inward,
            martensite_finish_c: self.martensite_finish_c + inward,
            ..*self
        }
    }

    /// One band for both ways: as wide as both are on the average, about the middle of the hysteresis.
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
    pub(super) fn check_apart(&self) -> Result<(), ParameterError> {
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
    /// Plays of the wire under its stress: those of the martensite by the law of hysteresis, its reversible part, and
    /// the phases beside it.
    ///
    /// # Errors
    /// Bands that cross, or a share that cannot be.
    pub fn plays(&self) -> Result<Vec<Play>, ParameterError> {
        not_negative("reversible", self.reversible)?;
        not_negative("1 - reversible", 1.0 - self.reversible)?;
        let bands = self.alloy.under(self.bias_stress_pa);
        let mut plays = Vec::new();
        let mut martensite = |bands: Alloy, share: f64| {
            bands.check_apart()?;
            if share > 0.0 {
                plays.push(Play {
                    bands,
                    martensite: share,
                    strain: self.mechanics.transformation_strain * share,
                    latent_heat: self.latent_heat * share,
                });
            }
            Ok(())
        };
        let rest = 1.0 - self.reversible;
        match self.hysteresis {
            Hysteresis::Play => martensite(bands, rest)?,
            Hysteresis::Plays { count, narrowest } => {
                check("hysteresis", (1..=16).contains(&count))?;
                check("hysteresis", narrowest > 0.0 && narrowest <= 1.0)?;
                let n = f64::from(count);
                for k in 0..count {
                    let place = if count > 1 {
                        f64::from(k) / (n - 1.0)
                    } else {
                        1.0
                    };
                    let scale = narrowest + (1.0 - narrowest) * place;
                    martensite(bands.narrowed(scale), rest / n)?;
                }
            }
        }
        martensite(bands.reversible(), self.reversible)?;
        for play in self.beside.iter().flatten() {
            play.check()?;
            plays.push(Play {
                bands: play.bands.under(self.bias_stress_pa),
                ..*play
            });
        }
        Ok(plays)
    }
}

#[cfg(test)]
#[path = "play_tests.rs"]
mod tests;
