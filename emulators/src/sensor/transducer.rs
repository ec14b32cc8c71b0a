//! The transducer of a taxel: its counts at rest, how touch changes them, how far they go.

use super::mechanics::Silicone;

/// Boards of different years rest at different counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Generation {
    /// X, Y about 16.4k, Z 32k to 36k.
    Y2019,
    /// X about 48.9k, Y about 16.4k, Z about 37.4k.
    Y2021,
    /// X, Y about 32.8k, Z about 37.4k.
    #[default]
    Now,
}

/// Conversion of force into counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Transducer {
    /// Magnets over Hall chips, as the uSkin's: three axes of 16 bits, rest values of a generation.
    Magnetic(Generation),
    /// Capacitors, as the iCub's: 8 bits, about 235 at rest, lower under pressure.
    Capacitive,
    /// Blocks of a camera's picture of a gel, as the DIGIT's: mean brightness of 8 bits, which rises under pressure.
    Camera,
    /// Cells of several sensors, as the H1's: x is proximity, y acceleration, z normal force. Touch moves the force
    /// alone: nothing approaches or accelerates here.
    Cells,
}

impl Default for Transducer {
    fn default() -> Self {
        Self::Magnetic(Generation::Now)
    }
}

impl Transducer {
    /// Middle and half width of the rest values, counts, for x, y and z.
    pub(super) const fn rest(self) -> [(f64, f64); 3] {
        match self {
            Self::Magnetic(Generation::Y2019) => {
                [(16_400.0, 600.0), (16_400.0, 600.0), (34_000.0, 2000.0)]
            }
            Self::Magnetic(Generation::Y2021) => {
                [(48_900.0, 600.0), (16_400.0, 600.0), (37_400.0, 300.0)]
            }
            Self::Magnetic(Generation::Now) => {
                [(32_800.0, 600.0), (32_800.0, 600.0), (37_400.0, 300.0)]
            }
            Self::Capacitive => [(0.0, 0.0), (0.0, 0.0), (235.0, 6.0)],
            Self::Camera => [(0.0, 0.0), (0.0, 0.0), (90.0, 30.0)],
            Self::Cells => [(2000.0, 500.0), (32_768.0, 200.0), (1000.0, 300.0)],
        }
    }

    /// The largest count.
    pub(super) const fn most(self) -> f64 {
        match self {
            Self::Magnetic(_) | Self::Cells => 65_535.0,
            Self::Capacitive | Self::Camera => 255.0,
        }
    }

    /// Tells whether shear counts too.
    pub(super) const fn shears(self) -> bool {
        matches!(self, Self::Magnetic(_))
    }

    /// Silicone or another cover over the taxels. All values but the magnetic skin's are assumed.
    #[must_use]
    pub fn silicone(self) -> Silicone {
        match self {
            Self::Magnetic(_) => Silicone::default(),
            // Thin foam over taxels of several millimetres: 1 N of the 19.45 mm sphere is about a fifth of the range.
            Self::Capacitive => Silicone {
                counts_per_newton: -65.0,
                spread_mm: 3.0,
                modulus_n_mm2: 0.3,
                shear: 0.0,
                crosstalk: 0.0,
                ..Silicone::default()
            },
            // A soft gel, seen through: hardly any spread beyond the contact itself.
            Self::Camera => Silicone {
                counts_per_newton: 7000.0,
                spread_mm: 0.3,
                modulus_n_mm2: 0.2,
                bleed_mm2_per_n: 0.0,
                shear: 0.0,
                crosstalk: 0.0,
                lag_s: 0.0,
            },
            // Stiff cells under thick foam that reaches from cell to cell.
            Self::Cells => Silicone {
                counts_per_newton: 2000.0,
                spread_mm: 14.0,
                shear: 0.0,
                crosstalk: 0.0,
                ..Silicone::default()
            },
        }
    }
}
