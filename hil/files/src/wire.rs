//! Wires and alloys: the figures of shape-memory wires. The built-in files carry the program's own constants.

mod guarded;
mod history;
mod r_phase;

use palpate_core::physics::{self, Alloy, History, Mechanics, WireParameters};
use serde::Deserialize;

use super::error::FileError;
use super::settings::bounds;
use super::source::Source;
use super::words::choice;
pub(super) use history::check_rest;
pub use r_phase::RPhaseEntry;

/// A wire, its alloy left open.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct WireFile {
    /// Name, in lower case with hyphens.
    pub name: String,
    /// The wire, in a sentence.
    pub description: String,
    /// Diameter, micrometres.
    pub diameter_um: f64,
    /// Length between the crimps, millimetres.
    pub length_mm: f64,
    /// Resistances, which make heat.
    pub electrical: Electrical,
    /// Figures of the heat, its store and its ways out.
    pub thermal: ThermalValues,
    /// Share of the martensite that transforms without hysteresis, about the alloy's middle; left out: none.
    #[serde(default)]
    pub reversible: f64,
    /// R phase; left out: austenite cools to martensite alone.
    pub r_phase: Option<RPhaseEntry>,
    /// State in which the bench's sag was measured.
    pub sag_state: WireState,
    /// State in which the wire begins; left out: `cold`.
    #[serde(default = "cold")]
    pub state: WireState,
    /// Coldest that a wire has been since it was passed, degrees C; left out: no colder than at rest.
    pub coldest_c: Option<f64>,
    /// Moduli and strains.
    pub mechanical: Mechanical,
}

/// Resistance of the wire and its changes.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Electrical {
    /// Resistance between the terminals, as martensite at 33 C, Ohm.
    pub resistance_ohm: f64,
    /// Share of that resistance that is wire and not crimps and leads.
    pub wire_share: f64,
    /// The wire's resistance as austenite over that as martensite.
    pub austenite_ratio: f64,
    /// Relative change of the wire's resistance with temperature, 1/K.
    pub per_kelvin: f64,
}

/// Heat of the wire, its store and its ways out.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ThermalValues {
    /// Density, kg/m3.
    pub density_kg_m3: f64,
    /// Specific heat, J/(kg K).
    pub specific_heat_j_kgk: f64,
    /// Latent heat of the whole transformation, J/kg.
    pub latent_heat_j_kg: f64,
    /// Conductivity, W/(m K).
    pub conductivity_w_mk: f64,
    /// Heat transfer to still air, W/(m2 K).
    pub air_w_m2k: f64,
    /// Conductance to the mount, W/K.
    pub mount_w_k: f64,
}

/// Moduli and strains of the wire.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Mechanical {
    /// Constant stress, MPa.
    pub bias_stress_mpa: f64,
    /// Young's modulus of austenite, GPa.
    pub modulus_austenite_gpa: f64,
    /// Young's modulus of martensite, GPa.
    pub modulus_martensite_gpa: f64,
    /// Strain of the whole transformation.
    pub transformation_strain: f64,
    /// Thermal expansion of austenite, 1/K.
    pub expansion_austenite_per_k: f64,
    /// Thermal expansion of martensite, 1/K.
    pub expansion_martensite_per_k: f64,
}

/// Strain that bends a straight wire as deep as a bow may be: sag (2/pi) L sqrt(strain).
const MOST_STRAIN: f64 = {
    let slope = physics::DEEPEST * core::f64::consts::FRAC_PI_2;
    slope * slope
};

choice! {
    /// A state that a wire is brought into by temperature alone.
    WireState {
        /// All martensite: cooled far below the temperature at which that begins to form.
        Cold = "cold",
        /// A wire that was heated until all of it was austenite, then cooled to rest.
        Passed = "passed",
    }
}

impl WireState {
    /// The state as a file writes it.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Cold => "cold",
            Self::Passed => "passed",
        }
    }

    const fn physical(self) -> physics::WireState {
        match self {
            Self::Cold => physics::WireState::Cold,
            Self::Passed => physics::WireState::Passed,
        }
    }
}

const fn cold() -> WireState {
    WireState::Cold
}

/// Transformation temperatures.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AlloyFile {
    /// Name, in lower case with hyphens.
    pub name: String,
    /// The alloy, in a sentence.
    pub description: String,
    /// Heating: austenite begins to form, degrees C.
    pub austenite_start_c: f64,
    /// Heating: all austenite, degrees C.
    pub austenite_finish_c: f64,
    /// Cooling: martensite begins to form, degrees C.
    pub martensite_start_c: f64,
    /// Cooling: all martensite, degrees C.
    pub martensite_finish_c: f64,
    /// Stress at which these hold, MPa.
    pub reference_stress_mpa: f64,
    /// Rise of the stress that moves them by a kelvin, MPa/K.
    pub stress_mpa_k: f64,
}

impl AlloyFile {
    /// Reads an alloy; [`WireFile::parameters`] checks its temperatures.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let alloy: Self = source.read()?;
        source.heading(&alloy.name, &alloy.description)?;
        let order = [
            (
                "martensite_start_c",
                alloy.martensite_start_c,
                alloy.martensite_finish_c,
            ),
            (
                "austenite_start_c",
                alloy.austenite_start_c,
                alloy.martensite_start_c,
            ),
            (
                "austenite_finish_c",
                alloy.austenite_finish_c,
                alloy.austenite_start_c,
            ),
        ];
        bounds!(source, "", alloy; martensite_finish_c: -200.0..=1000.0, "C")?;
        for (key, value, below) in order {
            source.range(key, &value, -200.0..=1000.0, "C")?;
            if value <= below {
                let order = format!("more than {below}: Mf < Ms < As < Af");
                return Err(source.bad(key, order));
            }
        }
        bounds!(source, "", alloy;
            reference_stress_mpa: 0.0..=2000.0, "MPa";
            stress_mpa_k: 0.1..=100.0, "MPa/K")?;
        Ok(alloy)
    }
}

impl WireFile {
    /// Reads a wire.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        history::check_version(source)?;
        let wire: Self = source.read()?;
        source.heading(&wire.name, &wire.description)?;
        guarded::size(&wire, source)?;
        bounds!(source, "electrical", wire.electrical;
            resistance_ohm: 0.01..=1000.0, "Ohm";
            wire_share: 0.0..=1.0;
            austenite_ratio: 0.2..=5.0;
            per_kelvin: -0.01..=0.01, "1/K")?;
        bounds!(source, "thermal", wire.thermal;
            density_kg_m3: 1000.0..=20_000.0, "kg/m3";
            specific_heat_j_kgk: 100.0..=2000.0, "J/kgK";
            latent_heat_j_kg: 0.0..=1e5, "J/kg";
            conductivity_w_mk: 0.0..=500.0, "W/mK";
            air_w_m2k: 0.0..=2000.0, "W/m2K";
            mount_w_k: 0.0..=1.0, "W/K")?;
        guarded::heat(&wire, source)?;
        bounds!(source, "mechanical", wire.mechanical;
            bias_stress_mpa: 0.0..=1000.0, "MPa";
            modulus_austenite_gpa: 1.0..=500.0, "GPa";
            modulus_martensite_gpa: 1.0..=500.0, "GPa";
            transformation_strain: 0.0..=MOST_STRAIN, "of its length: more bends it deeper than a bow may be";
            expansion_austenite_per_k: 0.0..=1e-4, "1/K";
            expansion_martensite_per_k: 0.0..=1e-4, "1/K")?;
        bounds!(source, "", wire; reversible: 0.0..=1.0, "of the martensite")?;
        if let Some(r) = &wire.r_phase {
            r.check(source, &wire)?;
        }
        wire.check_history(source)?;
        Ok(wire)
    }

    /// The wire of an alloy as the model takes it. Divisions, so that the numbers are those that stand in the
    /// program.
    #[must_use]
    pub fn parameters(&self, alloy: &AlloyFile) -> WireParameters {
        let (e, t, m) = (&self.electrical, &self.thermal, &self.mechanical);
        WireParameters {
            diameter_m: self.diameter_um / 1e6,
            length_m: self.length_mm / 1e3,
            density: t.density_kg_m3,
            specific_heat: t.specific_heat_j_kgk,
            latent_heat: t.latent_heat_j_kg,
            conductivity: t.conductivity_w_mk,
            resistance_ohm: e.resistance_ohm,
            wire_share: e.wire_share,
            austenite_ratio: e.austenite_ratio,
            resistance_per_kelvin: e.per_kelvin,
            air_h: t.air_w_m2k,
            mount_w_per_k: t.mount_w_k,
            bias_stress_pa: m.bias_stress_mpa * 1e6,
            alloy: Alloy {
                austenite_start_c: alloy.austenite_start_c,
                austenite_finish_c: alloy.austenite_finish_c,
                martensite_start_c: alloy.martensite_start_c,
                martensite_finish_c: alloy.martensite_finish_c,
                stress_per_kelvin: alloy.stress_mpa_k * 1e6,
                reference_stress_pa: alloy.reference_stress_mpa * 1e6,
            },
            reversible: self.reversible,
            r_phase: self.r_phase.as_ref().map(RPhaseEntry::parameters),
            mechanics: Mechanics {
                modulus_austenite_pa: m.modulus_austenite_gpa * 1e9,
                modulus_martensite_pa: m.modulus_martensite_gpa * 1e9,
                transformation_strain: m.transformation_strain,
                expansion_austenite: m.expansion_austenite_per_k,
                expansion_martensite: m.expansion_martensite_per_k,
                ..Mechanics::DEFAULT
            },
            history: History {
                state: self.state.physical(),
                sag_state: self.sag_state.physical(),
                coldest_c: self.coldest_c,
            },
            ..WireParameters::FINAL
        }
    }
}

#[cfg(test)]
#[path = "wire_tests.rs"]
mod tests;
