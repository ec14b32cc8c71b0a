//! What a scene's things are made of: the warmth that a bench with a Peltier module shows beside touch.

use palpate_core::peltier::Material;
use serde::Deserialize;

use super::error::FileError;
use super::source::Source;
use super::words;

/// Skin at rest, degrees C: what the face shows while nothing is touched.
pub const SKIN_C: f64 = 33.0;

/// A contact with a material, from when until when.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct SceneMaterial {
    /// When it is touched, seconds.
    pub start_s: f64,
    /// When no longer; left out: with the scene.
    pub end_s: Option<f64>,
    /// What it is made of.
    #[serde(with = "words::Material")]
    pub material: Material,
    /// How warm it is, degrees C.
    pub object_c: f64,
}

impl Default for SceneMaterial {
    /// Wood that has stood in a room.
    fn default() -> Self {
        Self {
            start_s: 0.0,
            end_s: None,
            material: Material::Wood,
            object_c: 23.0,
        }
    }
}

impl SceneMaterial {
    pub(super) fn check(&self, source: &Source, key: &str, length_s: f64) -> Result<(), FileError> {
        let at = |name: &str| format!("{key}.{name}");
        source.range(&at("start_s"), self.start_s, 0.0..=length_s, "s")?;
        if let Some(end) = self.end_s {
            source.range(&at("end_s"), end, self.start_s..=length_s, "s")?;
        }
        source.range(&at("object_c"), self.object_c, -20.0..=60.0, "C")
    }

    fn touches(&self, t_s: f64) -> bool {
        t_s >= self.start_s && self.end_s.is_none_or(|end| t_s < end)
    }
}

/// What the face shall be at `t_s`, degrees C: where skin meets the thing touched first, else skin at rest.
#[must_use]
pub fn warmth_c(materials: &[SceneMaterial], t_s: f64) -> f64 {
    let touched = materials.iter().find(|m| m.touches(t_s));
    touched.map_or(SKIN_C, |m| m.material.contact_c(SKIN_C, m.object_c))
}
