//! Feel of a material at first touch: the temperature at which skin and material meet.
//!
//! Two half-spaces of temperatures T1 and T2 in perfect contact meet at (e1 T1 + e2 T2)/(e1 + e2), with the effusivity
//! e = sqrt(k rho c) of each (Carslaw and Jaeger, *Conduction of Heat in Solids*, 2nd edition, 2.15). The face then
//! holds it. A real finger warms what it touches over seconds; that is left out.

use crate::listed::listed;

/// Effusivity of skin, J/(m2 K sqrt s): k 0.37 W/mK, 1000 kg/m3, 3770 J/kgK.
const SKIN_EFFUSIVITY: f64 = 1181.0;

listed! {
    /// A material that is touched, by the properties of its kind in handbooks at 25 degrees C.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Material: name {
        /// Aluminium: 237 W/mK, 2700 kg/m3, 900 J/kgK.
        Metal = "metal",
        /// Soda-lime glass: 1.0 W/mK, 2500 kg/m3, 750 J/kgK.
        Glass = "glass",
        /// Pine across its grain: 0.12 W/mK, 510 kg/m3, 1380 J/kgK.
        Wood = "wood",
        /// Woven cotton: 0.06 W/mK, 300 kg/m3, 1300 J/kgK.
        Cloth = "cloth",
    }
}

impl Material {
    /// Conductivity, W/mK, density, kg/m3, and specific heat, J/kgK.
    const fn properties(self) -> [f64; 3] {
        match self {
            Self::Metal => [237.0, 2700.0, 900.0],
            Self::Glass => [1.0, 2500.0, 750.0],
            Self::Wood => [0.12, 510.0, 1380.0],
            Self::Cloth => [0.06, 300.0, 1300.0],
        }
    }

    /// Effusivity, J/(m2 K sqrt s).
    fn effusivity(self) -> f64 {
        libm::sqrt(self.properties().into_iter().product())
    }

    /// Temperature at which skin and an object of this material meet, degrees C.
    pub fn contact_c(self, skin_c: f64, object_c: f64) -> f64 {
        let e = self.effusivity();
        (SKIN_EFFUSIVITY * skin_c + e * object_c) / (SKIN_EFFUSIVITY + e)
    }
}
