//! Tables of textures: properties of surfaces, and people's ratings of them.

use serde::Deserialize;

use super::error::FileError;
use super::settings::bounds;
use super::source::Source;

/// A table of textures.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TextureTable {
    /// Name, in lower case with hyphens.
    pub name: String,
    /// The table, in a sentence.
    pub description: String,
    /// The values that are assumed; reports flag it.
    pub assumed: Option<String>,
    /// The taxel that always answers its rest value, from 0; left out: none.
    pub dead_taxel: Option<usize>,
    /// The textures.
    pub texture: Vec<TextureEntry>,
}

/// A texture.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TextureEntry {
    /// Name, in lower case with hyphens.
    pub name: String,
    /// True if a network may be trained on it.
    pub trained: bool,
    /// Force per depth under a module's whole face, N/mm.
    pub stiffness_n_per_mm: f64,
    /// Root mean square of the relief, micrometres.
    pub relief_um: f64,
    /// Middle of the relief's spectrum, mm.
    pub wavelength_mm: f64,
    /// Width of the spectrum, octaves.
    pub octaves: f64,
    /// Coefficient of friction against the gripping tape on a module.
    pub friction: f64,
    /// Coefficient of friction against a finger pad.
    pub finger_friction: f64,
    /// Ratings of people with a bare finger; left out where no person has touched it.
    pub rated: Option<Rated>,
}

/// Ratings from 1 to 6.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Rated {
    /// Hardness, from very soft to very hard.
    pub hardness: f64,
    /// Roughness, from very smooth to very rough.
    pub roughness: f64,
    /// Friction, from very slippery to very sticky.
    pub friction: f64,
}

impl TextureTable {
    /// Reads and checks a table.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let file: Self = source.read()?;
        source.heading(&file.name, &file.description)?;
        bounds!(source, "", file; dead_taxel: 0..=15)?;
        for (i, texture) in file.texture.iter().enumerate() {
            let key = format!("texture[{i}]");
            let at = |name: &str| format!("{key}.{name}");
            let word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
            let earlier = &file.texture[..i];
            if texture.name.is_empty() || !texture.name.chars().all(word) {
                return Err(source.bad(&at("name"), "lower case letters, digits and hyphens"));
            }
            if earlier.iter().any(|t| t.name == texture.name) {
                return Err(source.bad(&at("name"), "a name that no other texture here has"));
            }
            bounds!(source, &key, texture;
                stiffness_n_per_mm: 0.01..=1e4, "N/mm";
                relief_um: 0.0..=5e3, "um";
                wavelength_mm: 0.01..=100.0, "mm";
                octaves: 0.0..=10.0;
                friction: 0.0..=10.0;
                finger_friction: 0.0..=10.0)?;
            if let Some(rated) = texture.rated {
                bounds!(source, &at("rated"), rated;
                    hardness: 1.0..=6.0;
                    roughness: 1.0..=6.0;
                    friction: 1.0..=6.0)?;
            }
        }
        Ok(file)
    }
}
