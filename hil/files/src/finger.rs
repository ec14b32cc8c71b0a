//! What drives the displays of a bench that has several, as a scene says it.

use serde::Deserialize;

use super::felt::Felt;
use super::illusion::SceneStroke;
use super::joint::When;
use super::words::choice;

choice! { /** How several modules drive one display. */ FingerRule {
    /** The first one drives; the others are compressed and recorded. */ First = "first",
    /** All drive: `kc` contacts over all of them, as they lie in the layout's plane. */ Merged = "merged",
}}

/// What drives one of a bench's displays.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SceneFinger {
    /// The display, by its name on the bench.
    pub display: String,
    /// Its modules, counted from zero.
    pub modules: Vec<usize>,
    /// How they drive it, where there are several.
    pub rule: Option<FingerRule>,
    /// The joint angles at which it is felt; left out: always.
    pub when: Option<When>,
    /// The texture that is felt there; none if left out.
    pub texture: Option<Felt>,
    /// Strokes over this display that are known beforehand; none if left out.
    #[serde(default)]
    pub strokes: Vec<SceneStroke>,
}
