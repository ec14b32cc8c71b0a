//! Plays that transform in a wire beside its martensite.

use palpate_core::physics::{Alloy, DEEPEST, MOST_BESIDE, Play};
use serde::Deserialize;

use super::error::FileError;
use super::settings::bounds;
use super::source::Source;

/// A share of a wire that transforms by bands of its own.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PlayEntry {
    /// Start of the turn on heating, degrees C at the reference stress.
    pub heating_start_c: f64,
    /// End of the turn on heating, degrees C.
    pub heating_finish_c: f64,
    /// Start of the turn back on cooling, degrees C.
    pub cooling_start_c: f64,
    /// End of the turn back on cooling, degrees C.
    pub cooling_finish_c: f64,
    /// Stress at which these hold, MPa; left out: 0.
    #[serde(default)]
    pub reference_stress_mpa: f64,
    /// Rise of the stress that moves them by a kelvin, MPa/K.
    pub stress_mpa_k: f64,
    /// Strain of the whole share, cold against hot; positive is longer.
    pub strain: f64,
    /// Latent heat of the whole share, J/kg of wire.
    pub latent_heat_j_kg: f64,
}

/// Strain that bends a straight wire as deep as a bow may be: sag (2/pi) L sqrt(strain).
const MOST_STRAIN: f64 = {
    let slope = DEEPEST * core::f64::consts::FRAC_PI_2;
    slope * slope
};

/// Checks the plays of a wire, and the strains of all phases together.
pub(super) fn check_plays(
    source: &Source,
    plays: &[PlayEntry],
    martensite: f64,
) -> Result<(), FileError> {
    if plays.len() > MOST_BESIDE {
        let expected = format!("at most {MOST_BESIDE} plays beside the martensite");
        return Err(source.bad_found("plays", expected, plays.len().to_string()));
    }
    let (mut strain, mut last) = (martensite, "mechanical.transformation_strain".to_owned());
    for (index, play) in plays.iter().enumerate() {
        play.check(source, index)?;
        strain += play.strain.abs();
        last = format!("plays[{index}].strain");
    }
    if strain > MOST_STRAIN {
        let expected = format!(
            "strains of all phases that come to {MOST_STRAIN:.4} at most: more bends a wire deeper than {DEEPEST} of its length"
        );
        return Err(source.bad_found(&last, expected, format!("{strain:.4} in all")));
    }
    Ok(())
}

impl PlayEntry {
    /// Parameters of the model's play.
    pub(super) fn play(&self) -> Play {
        Play {
            bands: Alloy {
                austenite_start_c: self.heating_start_c,
                austenite_finish_c: self.heating_finish_c,
                martensite_start_c: self.cooling_start_c,
                martensite_finish_c: self.cooling_finish_c,
                stress_per_kelvin: self.stress_mpa_k * 1e6,
                reference_stress_pa: self.reference_stress_mpa * 1e6,
            },
            martensite: 0.0,
            strain: self.strain,
            latent_heat: self.latent_heat_j_kg,
        }
    }

    fn check(&self, source: &Source, index: usize) -> Result<(), FileError> {
        let key = format!("plays[{index}]");
        bounds!(source, &key, self;
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
        bounds!(source, &key, self;
            reference_stress_mpa: 0.0..=2000.0, "MPa";
            stress_mpa_k: 0.1..=100.0, "MPa/K";
            strain: -MOST_STRAIN..=MOST_STRAIN;
            latent_heat_j_kg: 0.0..=1e5, "J/kg")
    }
}
