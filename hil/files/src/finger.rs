//! Skin modules that drive the displays of a bench with several, as a scene states them.

use serde::Deserialize;

use super::felt::Felt;
use super::illusion::SceneStroke;
use super::joint::When;
use super::words::choice;

choice! { /** Rules by which several modules drive one display. */ FingerRule {
    /** The first one drives; the others are compressed and recorded. */ First = "first",
    /** All drive: `kc` contacts over all of them, as they lie in the layout's plane. */ Merged = "merged",
}}

/// Skin modules that drive one of a bench's displays.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SceneFinger {
    /// The display, by its name on the bench.
    pub display: String,
    /// Numbers of its modules, from zero.
    pub modules: Vec<usize>,
    /// The rule by which several modules drive it.
    pub rule: Option<FingerRule>,
    /// The joint angles at which the display is felt; left out: always.
    pub when: Option<When>,
    /// The texture that is felt there; left out: none.
    pub texture: Option<Felt>,
    /// Strokes over this display that are known beforehand; left out: none.
    #[serde(default)]
    pub strokes: Vec<SceneStroke>,
}
