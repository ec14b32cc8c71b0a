//! From a contact on the sensor to activations of wires (thesis chapter 5): the sensor-to-display map,
//! the display's geometry, the phantom models and the onset timing.

mod display;
mod map;
mod phantom;
mod timing;

pub use display::{Display, DisplayError, Wire};
pub use map::{Map, MapError, Rect};
pub use phantom::{Drive, LogPhantom, Shape};
pub use timing::{TimingError, soa_tactile_brush, timing};
