//! Illusions: contacts on the sensor become activations of wires (thesis chapter 5). The module holds the
//! sensor-to-display map, the display's geometry, the laws behind one trait, several contacts, intensity, timing and
//! known strokes.

mod cells;
mod display;
mod drive;
mod geometry;
mod inverse;
mod law;
mod map;
mod mix;
mod model;
mod phantom;
mod reach;
mod shares;
mod stroke;
mod surface;
mod timing;
// The projector alone follows places (see `lib.rs`).
#[cfg(target_has_atomic = "ptr")]
mod track;

pub use cells::Cells;
pub use display::{Display, DisplayError, DisplayWire};
pub use drive::{Calibration, CalibrationError, Drive, Steps};
pub use inverse::Inverse;
pub use law::{Illusion, IllusionError};
pub use map::{Map, MapError, Rect};
pub use mix::{Mixer, Sharing, Target};
pub use model::{Distances, IllusionModel, ModelSettings, ShapeChoice, build, inverse};
pub use stroke::{Dab, Planned, Stroke, StrokeError};
pub use surface::Surface;
pub use timing::{LONGEST, TimingError, TimingLaw};
#[cfg(target_has_atomic = "ptr")]
pub use track::AHEAD;
pub(crate) use track::Tracks;
