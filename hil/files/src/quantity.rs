//! Quantities of wire, finger and person that are drawn: their names, units and bounds, shared by priors and evidence.

/// The quantities, each with its unit, its bounds, and the factor to the unit of the model.
macro_rules! quantities {
    ($($(#[$doc:meta])* $variant:ident $key:ident $unit:literal $low:literal $high:literal $factor:literal;)+) => {
        /// A quantity that is drawn.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Quantity { $($(#[$doc])* $variant),+ }

        impl Quantity {
            /// Every quantity, in the order in which they are drawn.
            pub const ALL: [Self; [$(Self::$variant),+].len()] = [$(Self::$variant),+];

            /// Key in files.
            #[must_use]
            pub const fn key(self) -> &'static str {
                match self { $(Self::$variant => stringify!($key)),+ }
            }

            /// Unit in files; `1` for a ratio.
            #[must_use]
            pub const fn unit(self) -> &'static str {
                match self { $(Self::$variant => $unit),+ }
            }

            /// Bounds of a value, in its unit.
            #[must_use]
            pub const fn bounds(self) -> (f64, f64) {
                match self { $(Self::$variant => ($low, $high)),+ }
            }

            /// Factor from the unit of files to that of the model.
            #[must_use]
            pub const fn factor(self) -> f64 {
                match self { $(Self::$variant => $factor),+ }
            }
        }

        /// Values by quantity.
        #[derive(Debug, Clone, PartialEq, Default, serde::Deserialize)]
        #[cfg_attr(test, derive(schemars::JsonSchema))]
        #[cfg_attr(test, schemars(bound = "T: schemars::JsonSchema + Default"))]
        #[serde(default, deny_unknown_fields)]
        pub struct QuantityTable<T> { $($(#[$doc])* pub $key: Option<T>),+ }

        impl<T> QuantityTable<T> {
            /// The value of a quantity.
            #[must_use]
            pub const fn entry(&self, quantity: Quantity) -> Option<&T> {
                match quantity { $(Quantity::$variant => self.$key.as_ref()),+ }
            }
        }
    };
}

quantities! {
    /// Bias stress of a loose wire, MPa.
    Stress stress "MPa" 0.0 1000.0 1e6;
    /// Bias stress of a taut wire, MPa.
    TautStress taut_stress "MPa" 0.0 1000.0 1e6;
    /// Cooling: R phase begins to form without stress, C.
    RStart r_start "C" -200.0 200.0 1.0;
    /// Width of both bands of the R phase, K.
    RWidth r_width "K" 0.1 100.0 1.0;
    /// Hysteresis of the R phase, K.
    RHysteresis r_hysteresis "K" 0.0 100.0 1.0;
    /// Strain of the R phase, %.
    RStrain r_strain "%" 0.0 9.0 1e-2;
    /// Latent heat of the R phase, kJ/kg.
    RLatent r_latent "kJ/kg" 0.0 100.0 1e3;
    /// Stress that moves the R phase by a kelvin, MPa/K.
    RSlope r_slope "MPa/K" 0.1 100.0 1e6;
    /// Two-way strain of martensite, %.
    Strain strain "%" 0.0 9.0 1e-2;
    /// Share of the martensite without hysteresis.
    Reversible reversible "1" 0.0 1.0 1.0;
    /// Specific heat, J/kgK.
    SpecificHeat specific_heat "J/kgK" 100.0 2000.0 1.0;
    /// Latent heat of the whole transformation, kJ/kg.
    Latent latent "kJ/kg" 0.0 100.0 1e3;
    /// Heat transfer of the contact, W/m2K.
    ContactHeat contact_heat "W/m2K" 1.0 1e6 1.0;
    /// Part of the circumference that touches.
    Contact contact "1" 0.0 1.0 1.0;
    /// Share of the resistance that is wire.
    WireShare wire_share "1" 0.0 1.0 1.0;
    /// Young's modulus of the skin, kPa.
    Skin skin "kPa" 1.0 1e4 1e3;
    /// Sag of the published modules' wires, um.
    PublishedSag published_sag "um" 1.0 1e4 1e-6;
    /// Sag of the bench's wires, um; left out: the bench's.
    Sag sag "um" 1.0 1e4 1e-6;
    /// Resistance between the terminals, Ohm; left out: the bench's.
    Resistance resistance "Ohm" 0.01 1e3 1.0;
    /// Resistance as austenite over that as martensite; left out: the wire's.
    AusteniteRatio austenite_ratio "1" 0.2 5.0 1.0;
    /// Temperature of the finger at rest, C.
    Finger finger "C" 10.0 42.0 1.0;
    /// Vibration that a person just feels, um: amplitude of a long sine at 250 Hz.
    Vibration vibration "um" 1e-3 1e3 1.0;
    /// Flutter or tap that a person just feels, um: peak of the filtered displacement.
    Flutter flutter "um" 1e-3 1e3 1.0;
}

impl Quantity {
    /// The quantity of a key.
    #[must_use]
    pub fn of_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|q| q.key() == key)
    }

    /// True of a quantity that a file of priors may leave out: the bench has a value.
    #[must_use]
    pub const fn is_of_bench(self) -> bool {
        matches!(self, Self::Sag | Self::Resistance | Self::AusteniteRatio)
    }
}
