//! Textures of a scene: the stroked surface, the network, and the carrier to the finger.

use palpate_core::texture::Draw;

use super::error::FileError;
use super::settings::{bounds, settings};
use super::source::Source;
use super::words::{self, choice};

choice! { /** Carriers of a texture. */ FeltBy {
    /** The whole display: the pulses of (3.1) move over its wires, contacts do not show. */ Display = "display",
    /** The contacts: their bursts are thinned out. */ Contacts = "contacts",
}}

choice! { /** Latent coordinates that drive pulses. */ DrivenBy {
    /** Those that the model's file names for roughness, friction and hardness. */ Meaning = "meaning",
    /** z1 alone: mean, deviation and frequency, as in section 3.5.2 of the thesis. Hardness is not felt. */ First = "z1",
}}

settings! {
    /// A texture that is felt.
    pub struct Felt {
        /// The surface that is stroked, by its name in the table; left out: none, as where recordings are replayed.
        pub surface: Option<String>,
        /// The table of textures: a built-in name or a file.
        pub table: String = "thesis".into(),
        /// The stroked module, counted from zero; left out: the one that drives the display.
        pub module: Option<usize>,
        /// Starts of the strokes, seconds.
        pub strokes_s: Vec<f64>,
        /// Length of each stroke, seconds; the thesis's is 2.
        pub stroke_s: f64 = 2.0,
        /// True if the scene's touches of that module are of this surface themselves, and rub it over the skin; the
        /// network hears them as a stroke over the whole module.
        pub rubs: bool = false,
        /// The texture model: a built-in name or a file.
        pub model: String = "default".into(),
        /// The latent coordinates that drive its pulses.
        pub driver: DrivenBy = DrivenBy::Meaning,
        /// True to let hardness be felt where the surface is met and left; left out: where the model knows it and the
        /// activation has taps.
        pub hardness: Option<bool>,
        /// The map from roughness to pulses: a built-in name or a file.
        pub activation: String = "assumed".into(),
        /// The carrier of the texture.
        pub carrier: FeltBy = FeltBy::Display,
        /// The rule by which pulses are drawn. A carrier of contacts draws nothing.
        #[serde(with = "words::Draw")]
        pub draw: Draw = Draw::Bernoulli,
    }

    /// The texture with pulses over the whole display and nothing stroked.
    default
}

impl Felt {
    /// Checks the section by itself: the skin is free of contact for `quiet_s`.
    pub(super) fn check(
        &self,
        source: &Source,
        section: &str,
        (quiet_s, length_s): (f64, f64),
    ) -> Result<(), FileError> {
        let at = |key: &str| format!("{section}.{key}");
        bounds!(source, section, self; stroke_s: 0.1..=3600.0, "s")?;
        let mut free_s = quiet_s;
        for (i, &start_s) in self.strokes_s.iter().enumerate() {
            let key = at(&format!("strokes_s[{i}]"));
            let unit =
                "s (after reference and threshold frames and the stroke before, within the scene)";
            let last = length_s - self.stroke_s;
            source.range(&key, &start_s, free_s..=last.max(free_s), unit)?;
            if start_s > last {
                return Err(source.bad(
                    &key,
                    format!("at most {last} s: a stroke ends within the scene"),
                ));
            }
            free_s = start_s + self.stroke_s;
        }
        if self.rubs && !(self.surface.is_some() && self.strokes_s.is_empty()) {
            return Err(source.bad(&at("rubs"), "a surface and no strokes beside it"));
        }
        if self.surface.is_none() && !self.strokes_s.is_empty() {
            return Err(source.bad(&at("strokes_s"), "no strokes, or a surface to stroke"));
        }
        Ok(())
    }
}
