//! Files of a user: scenes, benches, layouts, limit tables, wires, persons; and the reading of any file.
//!
//! Text becomes plain, checked configuration here, or a [`FileError`] that names file, line, key, the expectation and
//! the finding. A value for which the core has a type is of that type. Nothing here knows a bus, a clock or the loop.
#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod activation;
mod address;
mod arrays;
mod attached;
mod band;
mod bare;
mod bench;
mod blocks;
mod change;
mod check;
mod clock;
mod columns;
mod dialect;
mod error;
mod evidence;
mod fault;
mod felt;
mod finger;
mod format;
mod gain;
#[cfg(not(target_family = "wasm"))]
mod half;
mod hardware;
mod illusion;
mod joint;
mod layout;
mod limits;
mod loaded;
mod made;
mod messages;
mod migrate;
mod module;
mod mount;
mod near;
mod number;
mod objects;
mod on_motors;
mod opening;
mod order;
mod overrides;
mod own_bench;
mod pace;
mod packed;
mod person;
mod placeholder;
mod plain;
mod preface;
mod priors;
mod proposal;
mod protocol;
mod quantity;
mod quarantine;
mod reading;
mod recipe;
mod recipe_plan;
mod resolve;
mod rows;
mod saved;
mod scene;
mod seam;
mod seat;
mod settings;
mod setup;
mod shape;
mod shelf;
mod source;
mod stream;
mod taken;
mod texture;
#[cfg(not(target_family = "wasm"))]
mod texture_file;
mod texture_layer;
mod texture_model;
mod times;
mod touch;
mod transducer;
mod turns;
mod wants;
mod warmth;
mod wire;
mod wording;
mod words;

#[cfg(test)]
#[path = "schema_tests.rs"]
mod schema;
#[cfg(test)]
mod tests;

pub use activation::{ActivationFile, Both};
pub use address::repeated_bus;
pub use band::BandFile;
pub use bench::{
    Amplifier, Bench, BenchAudio, BenchDac, BenchDisplay, BenchHaptics, BenchHeat, BenchKind,
    BenchUnit, BenchWire, Drive, ExternalClock, HapticDriver, MotorKind, Network, Output,
    OutputEnable, Real,
};
pub use check::{Checked, check, check_source, kind_of};
pub use clock::Timing;
pub use columns::{Columns, JOINT, Take};
pub use error::{FileError, said, unnumbered};
pub use evidence::{Bound, EvidenceDrive, EvidenceFile, EvidenceRow, Measured};
pub use fault::{Fault, FaultKind};
pub use felt::{DrivenBy, Felt, FeltBy};
pub use finger::{FingerRule, SceneFinger};
pub use format::{Format, headed};
pub use gain::Gain;
pub use illusion::{Illusion, SceneStroke};
pub use joint::{Gate, Joint, JointPress, MOST_DEG, When};
pub use layout::{DisplayLayout, FingerSurface, ImageSize, LayoutFile, SensorLayout};
pub use limits::LimitTable;
pub use loaded::{
    Loaded, Settings, load_activation, load_alloy, load_bench, load_evidence, load_layout,
    load_person, load_priors, load_protocol, load_recipe, load_scene, load_skin, load_textures,
    load_wire,
};
pub use messages::holds_frames;
pub use migrate::{Migrated, migrated};
pub use module::{Grid, ImageCell, Repeat, SkinModule, Taxel};
pub use mount::{BenchMount, BenchTissue};
pub use near::{did_you_mean, nearest};
pub use number::Number;
pub use overrides::Overrides;
pub use own_bench::DEFAULT_BENCH;
pub use pace::{Pace, USUAL_BITRATE};
pub use packed::{Unpacked, open_unpacked};
pub use person::{FeltChannel, PersonFile, Spread, Wearer};
pub use placeholder::keys;
pub use priors::{Prior, PriorEntry, PriorsFile};
pub use proposal::{Assumed, Proposal, propose};
pub use protocol::{
    ChoiceTask, Condition, DifferenceTask, DrawTask, Groups, LocateTask, MatchTask, Normal, Order,
    Protocol, Question, RatingScale, RatingTask, SimulatedChoices, SimulatedDifferences,
    SimulatedDrawings, SimulatedMatches, SimulatedPlaces, SimulatedRatings, SimulatedThresholds,
    TaskKind, ThresholdMethod, ThresholdTask,
};
pub use quantity::{Quantity, QuantityTable};
pub use quarantine::{Quarantine, Quarantined};
pub use reading::{
    LONGEST_LINE, Lines, MOST_VALUES, Text, entries, format_of, is_stream, open, read_bytes,
    read_text,
};
pub use recipe::{ColumnOrder, Delimiter, Recipe, RecipeModule, RecipeTime};
pub use recipe_plan::RecipePlan;
pub use resolve::{FileKind, resolve, resolve_from};
pub use rows::{Input, RowAt, Rows};
pub use scene::{
    Boards, Compression, DRIFT_S, Expect, Generation, LevelsFrom, Map, Overload, REFERENCE_ROWS,
    Scene, THRESHOLD_FLOOR, THRESHOLD_SIGMAS, ThresholdFrom,
};
pub use seam::LayoutSeam;
pub use seat::Seat;
pub use setup::{Drawn, Finger, Pass, Setup, Stroked, plan_of, sensor_of};
pub use shelf::{Listed, built_in, illusions, of_folder};
pub use source::Source;
pub use stream::Stream;
pub use texture::{Rated, TextureEntry, TextureTable};
#[cfg(not(target_family = "wasm"))]
pub use texture_file::{Precision, TextureDecoder, model_file};
pub use texture_layer::{Layer, Tensor};
pub use texture_model::{Split, Standing, Stands, TextureModel, taxel};
pub use times::{DISORDER_US, LONGEST_US, OutOfTime, TimeColumn, TimeUnit, Times};
pub use touch::{Force, HandSample, MOST_SAMPLES, Path, PathKind, Touch, TouchPoint, check_sample};
pub use transducer::Transducer;
pub use warmth::{SKIN_C, SceneMaterial, warmth_c};
pub use wire::{
    AlloyFile, Electrical, Mechanical, RPhaseEntry, ThermalValues, WireFile, WireState,
};
pub use words::{axes_named, norm, scope};
