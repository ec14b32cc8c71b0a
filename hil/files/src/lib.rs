//! Every settings file a user hands in: scenes, benches, layouts, limit tables, wires, persons.
//!
//! Text becomes plain, checked configuration here, or a [`FileError`] that names file, line, key, what was
//! expected and what was found. Nothing here knows a bus, a clock or the loop; the structs are converted to
//! the core's own types where a run is set up.
#![forbid(unsafe_code)]

mod activation;
mod bench;
mod error;
mod fault;
mod felt;
mod illusion;
mod layout;
mod limits;
mod quarantine;
mod resolve;
mod scene;
mod setup;
mod source;
mod texture;
mod touch;
mod wire;
mod wording;

#[cfg(test)]
mod schema;
#[cfg(test)]
mod tests;

pub use activation::{ActivationFile, Both};
pub use bench::{Amplifier, Bench, BenchKind, Drive, Output, OutputEnable, Real, Wire};
pub use error::FileError;
pub use fault::{Fault, FaultKind};
pub use felt::{Carrier, Draw, Felt};
pub use illusion::{
    Distances, Illusion, IllusionModel, PerceiverFile, Sharing, Stroke, Timing, Wearer,
};
pub use layout::{
    DisplayLayout, Grid, ImageCell, ImageSize, LayoutFile, Module, SensorLayout, Surface, Taxel,
};
pub use limits::{
    Burst, Dose, FingertipPower, HARD_LIMITS, Limits, Pulse, Skin, Watchdog, WirePower,
};
pub use quarantine::{Quarantine, Quarantined};
pub use resolve::{Kind, resolve, resolve_from};
pub use scene::{
    Axes, Boards, Compression, DRIFT_S, Expect, Generation, Map, Norm, Overload, Scene, Scope,
    THRESHOLD_FLOOR, THRESHOLD_SIGMAS, ThresholdRule,
};
pub use setup::{
    Loaded, Setup, Stroked, load_activation, load_bench, load_layout, load_limits, load_perceiver,
    load_scene, load_textures, sensor_of,
};
pub use source::Source;
pub use texture::{Rated, TextureEntry, TextureTable};
pub use touch::{Force, Path, PathKind, Touch, TouchPoint};
pub use wire::{AlloyFile, Electrical, HysteresisLaw, Mechanical, ThermalValues, WireFile};
