//! Materials of wire and finger: plain parameters and constants, no solver.
//!
//! The emulators' model and the guard's predictor both start from these numbers and share no code
//! beyond them. Each default names its origin: \[V\] a vendor's or a paper's figure, \[C\] computed from such, \[A\]
//! assumed and to be measured on a bench, \[F\] fitted. SI units, temperatures in degrees Celsius.

mod bow;
mod curve;
mod history;
mod law;
mod peltier;
mod phases;
mod r_phase;

pub use bow::{Bow, DEEPEST, Ends, Mount};
pub use curve::{BEND_M, Curve, Piece, TIGHTEST};
pub use history::{History, WireState};
pub use law::{Law, SHARES};
pub use peltier::{PeltierParameters, Thermistor};
pub use phases::{Line, Phases};
pub use r_phase::RPhase;

/// Zero of the Celsius scale, in kelvin.
pub const ZERO_CELSIUS_K: f64 = 273.15;
/// Molar gas constant, J/(mol K).
pub const GAS_CONSTANT: f64 = 8.314_462_618;
/// Frequency factor of the Henriques burn integral, 1/s.
pub const HENRIQUES_A: f64 = 3.1e98;
/// Natural logarithm of [`HENRIQUES_A`].
pub const LN_HENRIQUES_A: f64 = 226.78474122490758;
/// Activation energy of the Henriques burn integral, J/mol.
pub const HENRIQUES_EA: f64 = 6.27e5;
/// Depth under the skin's surface at which the plateau limits of the epidermis hold, metres.
pub const DEPTH_SHALLOW_M: f64 = 0.1e-3;
/// Depth of the dermis at which the second plateau limit holds, metres.
pub const DEPTH_DEEP_M: f64 = 0.4e-3;
/// Duty of the thesis's full drive: 100 of 4096 ticks (2.44 %).
pub(crate) const FULL_DRIVE_DUTY: f64 = 100.0 / 4096.0;

/// Transformation temperatures of an alloy, or of its R phase, at [`Alloy::reference_stress_pa`]. In an [`RPhase`] the R
/// phase stands where the martensite stands here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alloy {
    /// Heating: austenite begins to form, degrees C.
    pub austenite_start_c: f64,
    /// Heating: all austenite, degrees C.
    pub austenite_finish_c: f64,
    /// Cooling: martensite begins to form, degrees C.
    pub martensite_start_c: f64,
    /// Cooling: all martensite, degrees C.
    pub martensite_finish_c: f64,
    /// Rise of all four with stress, Pa/K (d sigma/dT).
    pub stress_per_kelvin: f64,
    /// Stress at which the four were measured, Pa.
    pub reference_stress_pa: f64,
}

impl Alloy {
    /// The vendor's low-temperature wire without stress: 68/78/52/42 C at 172 MPa \[V\], 7 MPa/K.
    pub const LOW: Self = Self::unloaded([68.0, 78.0, 52.0, 42.0]);
    /// The vendor's high-temperature wire without stress: 88/98/72/62 C at 172 MPa \[V\], 7 MPa/K.
    pub const HIGH: Self = Self::unloaded([88.0, 98.0, 72.0, 62.0]);

    /// Makes an alloy without stress of its temperatures at the vendor's.
    const fn unloaded(at_vendors: [f64; 4]) -> Self {
        let [
            austenite_start_c,
            austenite_finish_c,
            martensite_start_c,
            martensite_finish_c,
        ] = at_vendors;
        let shift = 172.0 / 7.0;
        Self {
            austenite_start_c: austenite_start_c - shift,
            austenite_finish_c: austenite_finish_c - shift,
            martensite_start_c: martensite_start_c - shift,
            martensite_finish_c: martensite_finish_c - shift,
            stress_per_kelvin: 7e6,
            reference_stress_pa: 0.0,
        }
    }
}

/// Mechanics of the alloy, for strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mechanics {
    /// Young's modulus of austenite, Pa \[V\].
    pub modulus_austenite_pa: f64,
    /// Young's modulus of martensite, Pa \[V\].
    pub modulus_martensite_pa: f64,
    /// Two-way strain of martensite against austenite, 1 \[A\]; under the vendor's tension 4 to 5 % \[V\].
    pub transformation_strain: f64,
    /// Thermal expansion of austenite, 1/K \[V\].
    pub expansion_austenite: f64,
    /// Thermal expansion of martensite, 1/K \[V\].
    pub expansion_martensite: f64,
    /// Temperature of zero thermal strain, degrees C.
    pub rest_c: f64,
}

impl Mechanics {
    /// The vendor's alloy, strain-free at skin temperature.
    pub const DEFAULT: Self = Self {
        modulus_austenite_pa: 75e9,
        modulus_martensite_pa: 28e9,
        transformation_strain: 0.002,
        expansion_austenite: 11e-6,
        expansion_martensite: 6.6e-6,
        rest_c: 33.0,
    };
}

/// Power of the diameter with which a wire's heat transfer to still air goes: Nu = 0.675 Ra^0.058 (Morgan), Ra ~ d^3.
pub const AIR_POWER: f64 = 3.0 * 0.058 - 1.0;

/// One shape-memory wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WireParameters {
    /// Diameter, m.
    pub diameter_m: f64,
    /// Length, m.
    pub length_m: f64,
    /// Density, kg/m3 \[V\].
    pub density: f64,
    /// Specific heat, J/(kg K) \[V\]; stated range 322 to 837.
    pub specific_heat: f64,
    /// Latent heat of the full transformation, J/kg \[V\]; stated range 0 to 24 000.
    pub latent_heat: f64,
    /// Thermal conductivity of the wire, W/(m K) \[V\]; conducts to both ends.
    pub conductivity: f64,
    /// Resistance between the terminals with the wire as martensite at `reference_c`, Ohm.
    pub resistance_ohm: f64,
    /// Share of that resistance which is wire and not crimps and leads, 1 \[C\]; report 0.6 and 1.0.
    pub wire_share: f64,
    /// Resistance of the wire as austenite relative to martensite, 1. 1 switches the effect off (the
    /// default); the vendor's resistivities give 1.25, trained wire is measured the other way round.
    pub austenite_ratio: f64,
    /// Relative change of the wire's resistance with temperature, 1/K; 0 by default.
    pub resistance_per_kelvin: f64,
    /// Temperature at which `resistance_ohm` holds, degrees C.
    pub reference_c: f64,
    /// Heat transfer to still air, W/(m2 K) \[V\] (Morgan).
    pub air_h: f64,
    /// Conductance to the mount, W/K \[A\]; 0 by default.
    pub mount_w_per_k: f64,
    /// Temperature of ends and mount, degrees C.
    pub ends_c: f64,
    /// Stress of the bow at the sag that was measured, Pa \[A\]; stress shifts the transformation temperatures.
    pub bias_stress_pa: f64,
    /// Transformation temperatures.
    pub alloy: Alloy,
    /// Share of the martensite that transforms without hysteresis, about the alloy's middle, 1 \[A\]; 0 by default.
    pub reversible: f64,
    /// R phase; `None`: austenite cools to martensite alone.
    pub r_phase: Option<RPhase>,
    /// Strain.
    pub mechanics: Mechanics,
    /// Seat of the wire on the finger.
    pub mount: Mount,
    /// Heat and cold that it went through.
    pub history: History,
}

impl WireParameters {
    /// Final module: 75 um x 5 mm, 1.9 Ohm, low-temperature alloy, 60.2 % of the heat in the wire. Cold at 10 MPa, with an
    /// R phase and a two-way strain of 0.2 % \[A\], which fit what is published of its stroke (`docs/felt.md`).
    pub const FINAL: Self = Self {
        diameter_m: 75e-6,
        length_m: 5e-3,
        density: 6450.0,
        specific_heat: 460.0,
        latent_heat: 12e3,
        conductivity: 18.0,
        resistance_ohm: 1.9,
        wire_share: 0.602,
        austenite_ratio: 1.0,
        resistance_per_kelvin: 0.0,
        reference_c: 33.0,
        air_h: 172.0,
        mount_w_per_k: 0.0,
        ends_c: 33.0,
        bias_stress_pa: 10e6,
        alloy: Alloy::LOW,
        reversible: 0.0,
        r_phase: Some(RPhase::LOW),
        mechanics: Mechanics::DEFAULT,
        mount: Mount::DEFAULT,
        history: History::COLD,
    };
    /// First module: 100 um x 5 mm, 1.4 Ohm, 46 % of the heat in the wire.
    pub const FIRST: Self = Self {
        diameter_m: 100e-6,
        resistance_ohm: 1.4,
        wire_share: 0.46,
        air_h: 136.0,
        ..Self::FINAL
    };

    /// Puts the wire under the tension at which its vendor states its temperatures, 172 MPa, with the two-way strain of
    /// 4.5 % that it has there \[V\]; cold, and without an R phase.
    #[must_use]
    pub const fn taut(self) -> Self {
        Self {
            bias_stress_pa: 172e6,
            reversible: 0.0,
            r_phase: None,
            mechanics: Mechanics {
                transformation_strain: 0.045,
                ..self.mechanics
            },
            history: History::COLD,
            ..self
        }
    }

    /// Mass, kg.
    pub fn mass(&self) -> f64 {
        let section = core::f64::consts::FRAC_PI_4 * self.diameter_m * self.diameter_m;
        self.density * section * self.length_m
    }

    /// Heat capacity without latent heat, J/K.
    pub fn heat_capacity(&self) -> f64 {
        self.mass() * self.specific_heat
    }

    /// Conductance to both ends, 12 k A / L (mean temperature of a parabolic profile), W/K.
    pub fn ends_w_per_k(&self) -> f64 {
        let section = core::f64::consts::FRAC_PI_4 * self.diameter_m * self.diameter_m;
        12.0 * self.conductivity * section / self.length_m
    }

    /// Checks that the model can compute with every value. The ranges stated at the fields lie
    /// well inside.
    ///
    /// # Errors
    /// The name of the first parameter that is not finite, not positive where it must be, or out of order.
    pub fn check(&self) -> Result<(), ParameterError> {
        positive("diameter_m", self.diameter_m)?;
        positive("length_m", self.length_m)?;
        positive("density", self.density)?;
        positive("specific_heat", self.specific_heat)?;
        not_negative("latent_heat", self.latent_heat)?;
        not_negative("conductivity", self.conductivity)?;
        positive("resistance_ohm", self.resistance_ohm)?;
        not_negative("wire_share", self.wire_share)?;
        not_negative("1 - wire_share", 1.0 - self.wire_share)?;
        positive("austenite_ratio", self.austenite_ratio)?;
        finite("resistance_per_kelvin", self.resistance_per_kelvin)?;
        finite("reference_c", self.reference_c)?;
        not_negative("air_h", self.air_h)?;
        not_negative("mount_w_per_k", self.mount_w_per_k)?;
        finite("ends_c", self.ends_c)?;
        not_negative("bias_stress_pa", self.bias_stress_pa)?;
        let a = &self.alloy;
        positive("alloy.stress_per_kelvin", a.stress_per_kelvin)?;
        finite("alloy.reference_stress_pa", a.reference_stress_pa)?;
        let rising = [
            (
                "alloy.austenite_finish_c",
                a.austenite_finish_c - a.austenite_start_c,
            ),
            (
                "alloy.martensite_finish_c",
                a.martensite_start_c - a.martensite_finish_c,
            ),
            (
                "alloy.austenite_start_c",
                a.austenite_start_c - a.martensite_start_c,
            ),
        ];
        for (name, width) in rising {
            positive(name, width)?;
        }
        let m = &self.mechanics;
        positive("mechanics.modulus_austenite_pa", m.modulus_austenite_pa)?;
        positive("mechanics.modulus_martensite_pa", m.modulus_martensite_pa)?;
        finite("mechanics.transformation_strain", m.transformation_strain)?;
        finite("mechanics.expansion_austenite", m.expansion_austenite)?;
        finite("mechanics.expansion_martensite", m.expansion_martensite)?;
        finite("mechanics.rest_c", m.rest_c)?;
        self.mount.check(self.length_m)?;
        self.check_phases()
    }
}

impl Default for WireParameters {
    fn default() -> Self {
        Self::FINAL
    }
}

/// The finger under one wire, and the contact between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TissueParameters {
    /// Heat transfer of the contact, W/(m2 K) \[A\]; stated range 1000 to 10 000.
    pub contact_h: f64,
    /// Part of the wire's circumference that touches, 1 \[A\]; stated range 0.1 to 0.5, 0 is free in air.
    pub contact_fraction: f64,
    /// Conductivity down to `outer_depth_m`, W/(m K).
    pub outer_conductivity: f64,
    /// Conductivity below, W/(m K).
    pub inner_conductivity: f64,
    /// Depth at which the conductivity changes, m.
    pub outer_depth_m: f64,
    /// Volumetric heat capacity, J/(m3 K).
    pub heat_capacity: f64,
    /// Radius at which the body holds its temperature, m.
    pub outer_radius_m: f64,
    /// Temperature of the body there, degrees C.
    pub body_c: f64,
    /// Temperature of the air, degrees C.
    pub air_c: f64,
    /// Young's modulus of the skin, Pa \[A\]; stated range 30e3 to 300e3.
    pub modulus_pa: f64,
    /// Width of the strip on which wire and skin touch, m \[A\].
    pub contact_width_m: f64,
}

impl TissueParameters {
    /// The finger with a contact of 2000 W/m2K over half the circumference, 0.25 / 0.45 W/mK, 8 mm, 33 C; 100 kPa
    /// over 60 um.
    pub const DEFAULT: Self = Self {
        contact_h: 2000.0,
        contact_fraction: 0.5,
        outer_conductivity: 0.25,
        inner_conductivity: 0.45,
        outer_depth_m: 0.4e-3,
        heat_capacity: 3.8e6,
        outer_radius_m: 8e-3,
        body_c: 33.0,
        air_c: 25.0,
        modulus_pa: 100e3,
        contact_width_m: 60e-6,
    };

    /// Checks that the model can compute with every value.
    ///
    /// # Errors
    /// The name of the first parameter that is not finite or out of range.
    pub fn check(&self) -> Result<(), ParameterError> {
        not_negative("contact_h", self.contact_h)?;
        not_negative("contact_fraction", self.contact_fraction)?;
        not_negative("1 - contact_fraction", 1.0 - self.contact_fraction)?;
        positive("outer_conductivity", self.outer_conductivity)?;
        positive("inner_conductivity", self.inner_conductivity)?;
        not_negative("outer_depth_m", self.outer_depth_m)?;
        positive("heat_capacity", self.heat_capacity)?;
        positive("outer_radius_m", self.outer_radius_m)?;
        finite("body_c", self.body_c)?;
        finite("air_c", self.air_c)?;
        positive("modulus_pa", self.modulus_pa)?;
        positive("contact_width_m", self.contact_width_m)
    }
}

impl Default for TissueParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// A physical parameter that cannot be computed with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("physical parameter `{name}` is out of range")]
pub struct ParameterError {
    /// The parameter's name as the struct spells it.
    pub name: &'static str,
}

fn check(name: &'static str, good: bool) -> Result<(), ParameterError> {
    if good {
        Ok(())
    } else {
        Err(ParameterError { name })
    }
}

fn finite(name: &'static str, value: f64) -> Result<(), ParameterError> {
    check(name, value.is_finite())
}

fn positive(name: &'static str, value: f64) -> Result<(), ParameterError> {
    check(name, value.is_finite() && value > 0.0)
}

fn not_negative(name: &'static str, value: f64) -> Result<(), ParameterError> {
    check(name, value.is_finite() && value >= 0.0)
}
