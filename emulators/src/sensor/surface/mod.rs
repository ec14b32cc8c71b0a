//! Textured surfaces and strokes over them: a skin module is pressed against such surfaces in chapter 3 of the thesis.
//!
//! [`SurfaceTexture`] has the properties of a surface, and [`Relief`] is one drawn piece of it. [`SurfaceStroke`] moves a
//! module over it, and is the touch of the module. [`Explorer`] makes a recording of every stroke. [`spearman`] tells how
//! well a learnt coordinate follows a property. The taxels, their noise and their silicone are those of
//! [`crate::sensor`]. Only the names are published: all constants are assumed.

mod explorer;
mod rank;
mod relief;
mod rub;
mod stroke;
#[cfg(test)]
mod tests;
mod vibration;

pub use explorer::{Explorer, Recording, SAMPLES};
pub use rank::spearman;
pub use relief::Relief;
pub use rub::Rub;
pub use stroke::{Habits, SurfaceStroke, SurfaceStrokes};
pub use vibration::{ACCELEROMETER_HZ, milli_g};

/// Properties of a surface, as far as a skin module can tell.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceTexture {
    /// Names its random streams.
    pub name: String,
    /// Hardness: force per depth over the whole face of a flat module, N/mm.
    pub stiffness_n_per_mm: f64,
    /// Roughness: root mean square of the relief, mm.
    pub relief_mm: f64,
    /// Middle of the relief's spectrum as a wavelength, mm.
    pub wavelength_mm: f64,
    /// Width of the spectrum around the middle, octaves: near 0 for a weave, 2 for a grain.
    pub octaves: f64,
    /// Coefficient of friction against the gripping tape that covers the module.
    pub friction: f64,
}

impl SurfaceTexture {
    /// Stiffness of the surface and the module's silicone in series, N/mm over the module's face.
    fn contact_stiffness(&self) -> f64 {
        let surface = self.stiffness_n_per_mm.max(0.0);
        SILICONE_N_PER_MM * surface / (SILICONE_N_PER_MM + surface)
    }

    /// Roughness as a moving skin meets it: the root mean square slope of the relief, less what neighbouring
    /// asperities under the whole pad average out.
    pub fn drag_roughness(&self) -> f64 {
        let slope = core::f64::consts::TAU * self.relief_mm / self.wavelength_mm.max(1e-3);
        slope * (self.wavelength_mm / PAD_MM).min(1.0)
    }
}

/// Smallest and largest stiffness of materials that are drawn, N/mm; all such ranges are assumed.
pub const STIFFNESS_N_PER_MM: (f64, f64) = (1.0, 100.0);
/// Smallest and largest relief of materials that are drawn, mm.
pub const RELIEF_MM: (f64, f64) = (0.005, 0.35);
/// Smallest and largest wavelength of their relief, mm.
pub const WAVELENGTH_MM: (f64, f64) = (0.3, 5.0);
/// Smallest and largest coefficient of their friction.
pub const FRICTION: (f64, f64) = (0.3, 1.5);

/// Stiffness of a module's silicone over its whole face, N/mm (assumed).
const SILICONE_N_PER_MM: f64 = 12.0;
/// Side of the field of taxels, mm.
const PAD_MM: f64 = 18.8;
