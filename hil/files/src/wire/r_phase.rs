//! The R phase of a wire.

use palpate_core::physics::{Alloy, RPhase};
use serde::Deserialize;

use super::WireFile;
use crate::error::FileError;
use crate::settings::bounds;
use crate::source::Source;

/// The R phase: austenite cools to it, and it cools to martensite.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RPhaseEntry {
    /// Heating: R begins to turn to austenite, degrees C at the reference stress.
    pub heating_start_c: f64,
    /// Heating: all R is austenite, degrees C.
    pub heating_finish_c: f64,
    /// Cooling: R begins to form, degrees C.
    pub cooling_start_c: f64,
    /// Cooling: all austenite is R, degrees C.
    pub cooling_finish_c: f64,
    /// Stress at which these hold, MPa; left out: 0.
    #[serde(default)]
    pub reference_stress_mpa: f64,
    /// Rise of the stress that moves them by a kelvin, MPa/K.
    pub stress_mpa_k: f64,
    /// Strain of a wire that is all R, against austenite; positive is longer.
    pub strain: f64,
    /// Latent heat of a wire that is all R, against austenite, J/kg.
    pub latent_heat_j_kg: f64,
}

impl RPhaseEntry {
    /// Makes the R phase as the model takes it.
    pub(super) fn parameters(&self) -> RPhase {
        RPhase {
            bands: Alloy {
                austenite_start_c: self.heating_start_c,
                austenite_finish_c: self.heating_finish_c,
                martensite_start_c: self.cooling_start_c,
                martensite_finish_c: self.cooling_finish_c,
                stress_per_kelvin: self.stress_mpa_k * 1e6,
                reference_stress_pa: self.reference_stress_mpa * 1e6,
            },
            strain: self.strain,
            latent_heat: self.latent_heat_j_kg,
        }
    }

    /// Checks the bands, and that the R phase of `wire` lies between its austenite and martensite.
    ///
    /// # Errors
    /// Names the line and key of what cannot be.
    pub(super) fn check(&self, source: &Source, wire: &WireFile) -> Result<(), FileError> {
        let key = "r_phase";
        bounds!(source, key, self;
            heating_start_c: -200.0..=1000.0, "C";
            heating_finish_c: -200.0..=1000.0, "C";
            cooling_start_c: -200.0..=1000.0, "C";
            cooling_finish_c: -200.0..=1000.0, "C")?;
        let (hot, hottest) = (self.heating_start_c, self.heating_finish_c);
        let (cool, coolest) = (self.cooling_start_c, self.cooling_finish_c);
        let order = [
            (
                "heating_finish_c",
                hottest > hot,
                "more than heating_start_c",
                hot,
            ),
            (
                "cooling_finish_c",
                coolest < cool,
                "less than cooling_start_c",
                cool,
            ),
            (
                "heating_start_c",
                hot >= coolest,
                "at least cooling_finish_c, so that the bands do not cross",
                coolest,
            ),
            (
                "heating_finish_c",
                hottest >= cool,
                "at least cooling_start_c, so that the bands do not cross",
                cool,
            ),
        ];
        for (name, holds, expected, bound) in order {
            if !holds {
                return Err(source.bad(&format!("{key}.{name}"), format!("{expected}: {bound}")));
            }
        }
        bounds!(source, key, self;
            reference_stress_mpa: 0.0..=2000.0, "MPa";
            stress_mpa_k: 0.1..=100.0, "MPa/K";
            strain: 0.0..=wire.mechanical.transformation_strain, "of its length: martensite's, which R turns to";
            latent_heat_j_kg: 0.0..=wire.thermal.latent_heat_j_kg, "J/kg: the martensite's")
    }
}
