//! Materials of a scene's things: the warmth that a bench with a Peltier module shows beside touch.

use palpate_core::peltier::Material;

use super::error::FileError;
use super::settings::{bounds, settings};
use super::source::Source;
use super::words;

/// Skin at rest, degrees C: the temperature of the face while nothing is touched.
pub const SKIN_C: f64 = 33.0;

settings! {
    /// A contact with a material, between two times.
    #[derive(Copy)]
    pub struct SceneMaterial {
        /// Start of the touch, seconds.
        pub start_s: f64 = 0.0,
        /// End of the touch, seconds; left out: the end of the scene.
        pub end_s: Option<f64>,
        /// Material of the thing.
        #[serde(with = "words::Material")]
        pub material: Material = Material::Wood,
        /// Temperature of the thing, degrees C.
        pub object_c: f64 = 23.0,
    }

    /// A touch of wood that has stood in a room.
    default
}

impl SceneMaterial {
    pub(super) fn check(&self, source: &Source, key: &str, length_s: f64) -> Result<(), FileError> {
        bounds!(source, key, self;
            start_s: 0.0..=length_s, "s";
            end_s: self.start_s..=length_s, "s";
            object_c: -20.0..=60.0, "C")
    }

    fn touches(&self, t_s: f64) -> bool {
        t_s >= self.start_s && self.end_s.is_none_or(|end| t_s < end)
    }
}

/// Temperature of the face at `t_s`, degrees C: where skin meets the thing touched first, else skin at rest.
#[must_use]
pub fn warmth_c(materials: &[SceneMaterial], t_s: f64) -> f64 {
    let touched = materials.iter().find(|m| m.touches(t_s));
    touched.map_or(SKIN_C, |m| m.material.contact_c(SKIN_C, m.object_c))
}
