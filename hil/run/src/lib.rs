//! A bench assembled and run turn by turn: a scene or a recording through the loop onto a display.
//!
//! This room has no clock, thread, file, socket or terminal: time is virtual, a stopwatch and a view are handed in
//! as a [`Host`]. The program `hil`, tests, a page and other languages use the same one. Every run, that of a real
//! bench too, is built on a [`Session`].
//!
#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod activations;
mod actuator_bus;
mod band;
mod boards;
pub mod calibrate;
pub mod design;
pub mod display_end;
pub mod effects;
pub mod effort;
mod emulated_end;
pub mod failure;
mod feel;
mod finder;
mod fingers;
pub mod frequency;
mod glance;
mod hand;
mod header;
mod heat;
pub mod identify;
pub mod join;
mod known;
mod levels;
pub mod live;
mod loops;
mod margins;
mod motors;
mod numbers;
mod onsets;
mod output_enable;
pub mod pass;
mod path_error;
pub mod picture;
mod piece;
pub mod place;
pub mod plan;
pub mod policy;
pub mod recorded;
mod recorder;
mod replay;
mod runner;
pub mod script;
mod scripted;
mod session;
pub mod skin;
pub mod skin_end;
mod stagger;
mod states;
mod summary;
mod summary_felt;
mod summary_text;
mod supervisor;
pub mod sweep;
mod tape;
mod taxels;
mod texture_summary;
pub mod unit;
mod verdict;
pub mod wires;
mod wish;

pub use activations::Activations;
pub use boards::{BoardReport, BusReport, CanReport, Pacing, Spread};
pub use emulated_end::EmulatedEnd;
pub use failure::{Failure, damaged};
pub use finder::{Finder, Search};
pub use fingers::Fingers;
pub use hand::Hand;
pub use header::{attachments, header};
pub use heat::{HeatReport, RemoteHeat};
pub use levels::{Intensities, dynamic_levels};
pub use live::{EmulatedSession, HeldSession, Live, SessionOn, press};
pub use loops::{build, build_with, fits};
pub use margins::exceeded;
pub use motors::{EmulatedMotors, MotorReport};
pub use numbers::{joined_header, whole_boards};
pub use onsets::Onsets;
pub use piece::Piece;
pub use policy::Policy;
pub use recorder::{Recorder, Truth};
pub use replay::{
    CanFrames, CanPlayer, FrameSource, Frames, Identifiers, NextRow, RowSource, Rows, TaxelTable,
};
pub use runner::{passed, run_with, scene_end, scene_levels};
pub use script::FaultReport;
pub use session::{Session, Turn};
pub use skin::EmulatedSkin;
pub use stagger::stagger;
pub use states::FeltState;
pub use summary::{DisplaySummary, IllTaxel, Refresh, Summary, Taxels, finished};
pub use summary_felt::{AskedLevel, CountedError, FeltError, FeltSummary, LevelDb, SkinUm};
pub use supervisor::Supervisor;
pub use taxels::taxels;
pub use verdict::stopped_by;
pub use wish::Wish;

use std::sync::Arc;

use palpate_core::bus::Received;
use palpate_core::projector::Projector;
use palpate_core::units::Instant;
use palpate_emulators::worn::Aside;
use palpate_files::Setup;
use palpate_records::i2c::Transfer;
use palpate_records::readings::Readings;
use palpate_records::report::Warmth;
use palpate_records::trace::{Event, Header, Trace};

use effort::Effort;
use pass::PassEnd;
use picture::{State, Wants};

/// Source of the sensor readings of a run.
#[derive(Clone, Debug)]
pub enum Input {
    /// The scene's touches on an emulated skin.
    Scene,
    /// Recorded rows, one source per module.
    Rows(Vec<Arc<dyn RowSource>>),
    /// Recorded frames of all sensor buses.
    Frames(Arc<dyn FrameSource>),
    /// Rows of the whole skin that come meanwhile, until the scene ends.
    Stream(Arc<dyn RowSource>),
}

impl Input {
    /// Recorded rows that are held, one table per module.
    #[must_use]
    pub fn tables(tables: impl IntoIterator<Item = TaxelTable>) -> Self {
        let source = |table| Arc::new(table) as Arc<dyn RowSource>;
        Self::Rows(tables.into_iter().map(source).collect())
    }
}

/// A finished run.
#[derive(Debug)]
pub struct Outcome {
    /// Trace of the run: every event.
    pub trace: Trace,
    /// Summary of the run.
    pub summary: Summary,
    /// Computing time of each frame, microseconds.
    pub frame_us: Vec<f32>,
    /// Temperatures over time.
    pub warmth: Vec<Warmth>,
    /// Work of the run, and work that it left out.
    pub effort: Effort,
    /// Failure that ended the run before its time; the outputs are off.
    pub failure: Option<Failure>,
    /// Frames on the sensor buses as the host saw them, if they were to be kept.
    pub can: Vec<Received>,
    /// Messages on the actuator buses, if they were to be kept.
    pub i2c: Vec<Transfer>,
    /// Samples that the sound card of a bench's voice coils played, where it has one; empty if they were not to be kept.
    pub sound: Option<Sound>,
    /// Readings of taxels, where they are kept.
    pub readings: Option<Readings>,
    /// Remarks for the user, such as a recording that ends too early.
    pub notes: Vec<String>,
    /// Outcomes of the fingers, where the bench has several displays; empty else.
    pub displays: Vec<DisplayOutcome>,
    /// End of the hot pass, where the run was one on one display.
    pub pass: Option<PassEnd>,
}

impl Outcome {
    /// Tells whether every wire had its pulses in the newest hot pass of this run; `None` where it had none.
    #[must_use]
    pub fn has_passed(&self) -> Option<bool> {
        let displays = self.displays.iter().map(|display| &display.outcome.pass);
        let each = displays.chain([&self.pass]).flatten();
        each.map(|pass| pass.refused.is_none() && pass.passed == pass.wires)
            .reduce(|all, own| all && own)
    }
}

/// Samples as a sound card played them, silence included, from the start of the run on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sound {
    /// Frames per second.
    pub rate_hz: u32,
    /// Samples in a frame.
    pub channels: usize,
    /// Frame after frame.
    pub samples: Vec<i16>,
}

/// The run of one of several displays. Wires have the display's own numbers, boards and modules those of bench and skin.
#[derive(Debug)]
pub struct DisplayOutcome {
    /// The display's name on the bench.
    pub name: String,
    /// Outcome of the display.
    pub outcome: Outcome,
}

/// Records that a run keeps beside its trace.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Keep {
    /// Every frame on the sensor buses: 24 bytes each, 1600 per second for a module of 16 taxels at 100 Hz.
    pub can: bool,
    /// Every message on the actuator buses.
    pub i2c: bool,
    /// Every sample that a sound card plays: 0.8 MB a second for eight channels of 48 kHz.
    pub audio: bool,
    /// Readings of taxels to keep.
    pub readings: KeptReadings,
    /// The summary alone: records that no figure of the summary needs are dropped while the run goes on, so that memory
    /// is bounded whatever the length. Trace, frame times and temperatures are then in part.
    pub summary: bool,
    /// Figures that only summaries and reports for people show: the bench's band, and the run through wires in the other state,
    /// which are emulated beside.
    pub spread: bool,
}

/// Readings of taxels that a run keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KeptReadings {
    /// No readings.
    #[default]
    None,
    /// Samples for a report to play, in a bounded space.
    Sampled,
    /// All readings: 8 bytes for each taxel of each frame.
    All,
}

/// A turn as a host sees it.
pub struct TurnView<'a> {
    /// The time of the turn.
    pub now: Instant,
    /// Number of the display whose turn it is, where the bench has several: they are counted as they began.
    pub display: usize,
    /// Events so far.
    pub events: &'a [Event],
    /// The newest relative reading of every taxel, raw counts, NaN for one that is left out.
    pub counts: &'a [f32],
    /// The sensor buses, a line each.
    pub buses: &'a dyn Fn() -> Vec<String>,
    /// Takes the state of guard and wires, as far as it is wanted.
    pub state: &'a dyn Fn(Wants) -> State,
}

/// A run that is about to begin, or that of one of several displays.
pub struct Beginning<'a> {
    /// Setup of the run; for one of several displays, the setup that it would have alone.
    pub setup: &'a Setup,
    /// Header of the run's trace.
    pub header: &'a Header,
    /// The loop.
    pub projector: &'a Projector,
    /// Time at which the run ends.
    pub end: Instant,
    /// The display's name, where there are several.
    pub display: Option<&'a str>,
}

/// Hooks that a run calls outside. A host changes no result.
pub trait Host {
    /// Clock to time frames by, where there is one.
    fn stopwatch(&self) -> Option<effort::Stopwatch> {
        None
    }

    /// Way to compute beside the run what nothing of it waits for, where there is one.
    fn aside(&self) -> Option<Aside> {
        None
    }

    /// Tells whether the host watches the run: each turn is then played once, with all readings.
    fn looks_on(&self) -> bool {
        false
    }

    /// The run is about to begin. Of several displays each begins by itself.
    ///
    /// # Errors
    /// Failure that keeps the host from looking on; the run does not begin.
    fn begin(&mut self, run: &Beginning<'_>) -> Result<(), Failure> {
        let _ = run;
        Ok(())
    }

    /// Takes a turn. Returns `true` to end the run.
    fn turn(&mut self, seen: &TurnView<'_>) -> bool {
        let _ = seen;
        false
    }

    /// Asks after a turn for a wish of those who look on.
    fn wish(&mut self) -> Option<Wish> {
        None
    }

    /// Hears the part of the run that has passed, from 0 to 1, after every turn; `true` ends the run.
    fn passed(&mut self, part: f64) -> bool {
        let _ = part;
        false
    }

    /// Tells whether the host records: it then gets pieces of the trace, and the run keeps only what its summary needs.
    fn records(&self) -> bool {
        false
    }

    /// Takes the piece of the trace since the last one.
    ///
    /// # Errors
    /// Failure that keeps the host from recording; the run ends.
    fn record(&mut self, piece: Piece) -> Result<(), Failure> {
        let _ = piece;
        Ok(())
    }

    /// Ends the work of the host: the run is over, for whatever cause.
    fn end(&mut self) {}
}

/// A host without clock and view.
impl Host for () {}

/// Runs a scene on an emulated bench.
///
/// # Errors
/// [`Failure`] for input that fits no loop, a bus that fails, or a bench of hardware.
pub fn run(setup: &Setup, input: &Input, seed: u64) -> Result<Outcome, Failure> {
    run_with(setup, input, seed, Keep::default(), &mut ())
}
