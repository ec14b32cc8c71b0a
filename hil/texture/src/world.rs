//! Materials with independent properties, for questions to a model about one property at a time.

use std::io::{self, Write};

use palpate_core::random::RandomStream;
use palpate_emulators::sensor::surface::{self, Habits, SurfaceTexture};

/// Width of a drawn material's spectrum, octaves.
const OCTAVES: f64 = 1.0;

/// Factors of a stroke over a surface: four properties of the surface, and two of the hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Factor {
    /// Root mean square height of the relief.
    Relief,
    /// Middle of the relief's spectrum.
    Wavelength,
    /// Friction against the module.
    Friction,
    /// Force per depth under the module's face.
    Stiffness,
    /// The hand's speed.
    Speed,
    /// The hand's force.
    Force,
}

impl Factor {
    /// Factors of the surface.
    pub const PROPERTIES: [Self; 4] = [
        Self::Relief,
        Self::Wavelength,
        Self::Friction,
        Self::Stiffness,
    ];
    /// All of them, the surface's first.
    pub const ALL: [Self; 6] = [
        Self::Relief,
        Self::Wavelength,
        Self::Friction,
        Self::Stiffness,
        Self::Speed,
        Self::Force,
    ];

    /// Name of the factor, in a word.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Relief => "relief",
            Self::Wavelength => "wavelength",
            Self::Friction => "friction",
            Self::Stiffness => "stiffness",
            Self::Speed => "speed",
            Self::Force => "force",
        }
    }

    /// Range of the factor, in the unit of [`SurfaceTexture`] and [`Habits`]. The surface's ranges hold the materials
    /// of the thesis but the smoothest, the hand's are fourfold around its habits. All assumed.
    pub const fn range(self) -> (f64, f64) {
        match self {
            Self::Relief => surface::RELIEF_MM,
            Self::Wavelength => surface::WAVELENGTH_MM,
            Self::Friction => surface::FRICTION,
            Self::Stiffness => surface::STIFFNESS_N_PER_MM,
            Self::Speed => (40.0, 160.0),
            Self::Force => (1.5, 6.0),
        }
    }

    /// Value at a share of the factor's range, 0 to 1, by ratios.
    pub fn at(self, share: f64) -> f64 {
        let (low, high) = self.range();
        low * (high / low).powf(share)
    }

    /// Gives a surface a value of the factor.
    pub const fn set(self, surface: &mut SurfaceTexture, habits: &mut Habits, value: f64) {
        match self {
            Self::Relief => surface.relief_mm = value,
            Self::Wavelength => surface.wavelength_mm = value,
            Self::Friction => surface.friction = value,
            Self::Stiffness => surface.stiffness_n_per_mm = value,
            Self::Speed => habits.speed_mm_s = value,
            Self::Force => habits.force_n = value,
        }
    }

    /// Value of the factor for a surface; `None` for a factor of the hand.
    pub const fn value(self, surface: &SurfaceTexture) -> Option<f64> {
        match self {
            Self::Relief => Some(surface.relief_mm),
            Self::Wavelength => Some(surface.wavelength_mm),
            Self::Friction => Some(surface.friction),
            Self::Stiffness => Some(surface.stiffness_n_per_mm),
            Self::Speed | Self::Force => None,
        }
    }
}

/// A surface with every property at this share of its range.
pub fn at_share(name: String, share: impl Fn(Factor) -> f64) -> SurfaceTexture {
    let at = |factor: Factor| factor.at(share(factor));
    SurfaceTexture {
        name,
        stiffness_n_per_mm: at(Factor::Stiffness),
        relief_mm: at(Factor::Relief),
        wavelength_mm: at(Factor::Wavelength),
        octaves: OCTAVES,
        friction: at(Factor::Friction),
    }
}

/// Draws materials for a table: every property by itself, by ratios even over its range.
pub fn draw(count: usize, seed: u64) -> Vec<SurfaceTexture> {
    drawn(("material", "independent materials"), count, seed)
}

/// Draws materials that are in no table of any seed: other properties, and other names, hence other strokes.
pub fn draw_unseen(count: usize, seed: u64) -> Vec<SurfaceTexture> {
    drawn(("unseen", "materials in no table"), count, seed)
}

fn drawn((name, stream): (&str, &str), count: usize, seed: u64) -> Vec<SurfaceTexture> {
    let mut stream = RandomStream::new(seed, stream);
    let material = |n: usize| {
        let shares = Factor::PROPERTIES.map(|factor| (factor, stream.uniform()));
        let share = |factor| shares.iter().find(|(of, _)| *of == factor);
        at_share(format!("{name}-{n:04}"), |f| share(f).map_or(0.5, |s| s.1))
    };
    (0..count).map(material).collect()
}

/// Writes materials as a table of textures; the last `unseen` of them are not to be trained on.
///
/// # Errors
/// Error of the output.
pub fn write_table(
    materials: &[SurfaceTexture],
    (unseen, seed): (usize, u64),
    out: &mut dyn Write,
) -> io::Result<()> {
    let trained = materials.len().saturating_sub(unseen);
    writeln!(
        out,
        "#:schema textures.json\nname = \"independent\"\ndescription = \"Materials whose stiffness, friction, relief and wavelength are drawn independently, seed {seed}\"\nassumed = \"the ranges of all properties\""
    )?;
    for (n, material) in materials.iter().enumerate() {
        let SurfaceTexture {
            name,
            stiffness_n_per_mm: stiffness,
            relief_mm,
            wavelength_mm: wavelength,
            octaves,
            friction,
        } = material;
        let (is_trained, relief) = (n < trained, 1e3 * relief_mm);
        writeln!(
            out,
            "\n[[texture]]\nname = \"{name}\"\ntrained = {is_trained}\nstiffness_n_per_mm = {stiffness:.3}\nrelief_um = {relief:.2}\nwavelength_mm = {wavelength:.4}\noctaves = {octaves:.1}\nfriction = {friction:.4}\nfinger_friction = {friction:.4}"
        )?;
    }
    Ok(())
}

#[cfg(test)]
#[path = "world_tests.rs"]
mod tests;
