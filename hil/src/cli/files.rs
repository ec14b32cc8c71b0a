//! Options of the commands about files and the program itself: `hil list`, `check`, `new`, `export`, `completions`,
//! `man`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::{positive, ranges, whole};

/// Shelves that `hil list` shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Shelf {
    /// Scenes: touches of a skin, and their projection.
    Scenes,
    /// Benches: hardware, emulated or real.
    Benches,
    /// Layouts: places of taxels or wires.
    Layouts,
    /// Limits that the guard enforces.
    Limits,
    /// Emulated people.
    Persons,
    /// Calibrations.
    Wearers,
    /// Shape-memory wires.
    Wires,
    /// Alloys: the materials of wires.
    Alloys,
    /// Activations: maps from roughness to pulses.
    Activations,
    /// Priors of what has not been measured.
    Priors,
    /// Evidence about wires and people.
    Evidence,
    /// Bands: what is felt of a bench over all that is not measured.
    Bands,
    /// Tables of textures.
    Textures,
    /// Studies with people.
    Protocols,
    /// Laws of illusion.
    Illusions,
}

/// Options of `hil list`.
#[derive(Debug, Args)]
pub struct ListArgs {
    /// Shelves to list (default: all of them).
    #[arg(value_enum, hide_possible_values = false)]
    pub shelves: Vec<Shelf>,
    /// The folder whose files are listed beside the built-in ones, with those below it; repeatable (default: this
    /// folder alone).
    #[arg(long, value_name = "DIR")]
    pub dir: Vec<PathBuf>,
    /// Print a JSON array of {kind, name, description, file}.
    #[arg(long)]
    pub json: bool,
}

/// States of a wire in which the sag of its bow may have been measured.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum SagState {
    /// All martensite.
    Cold,
    /// Heated until all of it was austenite, then cooled to rest.
    Passed,
}

/// Options of `hil check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Scenes, benches, layouts, limit tables, wires, persons: any settings files.
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Write what files of an earlier version become beside them (`mine.toml`: `mine.migrated.toml`), and check that.
    /// Comments stay.
    #[arg(long)]
    pub migrate: bool,
    /// With --migrate: the state in which a bench's sag was measured, for wires of an earlier version, which do not say it.
    #[arg(long, requires = "migrate", value_name = "STATE")]
    pub sag_state: Option<SagState>,
    /// With --migrate: change the files themselves, and keep what they were as `mine.toml.old`.
    #[arg(short = 'f', long, requires = "migrate")]
    pub force: bool,
    /// Print a JSON array of {file, kind, complete, errors}.
    #[arg(long)]
    pub json: bool,
    /// Print nothing where nothing is wrong.
    #[arg(short = 'q', long, conflicts_with = "json")]
    pub quiet: bool,
}

/// Kinds of `hil new`.
#[derive(Debug, Subcommand)]
pub enum NewKind {
    /// A scene: what touches which skin.
    Scene(NewScene),
    /// A bench: which hardware, emulated or real.
    Bench(NewBench),
    /// A layout: a grid of taxels or of wires.
    Layout(NewLayout),
    /// A shape-memory wire.
    Wire(NewWire),
    /// A protocol of a study with people.
    Protocol(NewProtocol),
}

/// Name and description of a new file.
#[derive(Debug, Args)]
pub struct NewFile {
    /// Name of the file: lower-case letters, digits and hyphens.
    pub name: String,
    /// Description in a sentence.
    #[arg(long, value_name = "TEXT")]
    pub description: Option<String>,
    /// File to write, or a folder for NAME.toml (default: this folder).
    #[arg(short = 'o', long, value_name = "FILE|DIR")]
    pub out: Option<PathBuf>,
    /// Overwrite a file that is there.
    #[arg(short = 'f', long)]
    pub force: bool,
}

/// Motions of a new scene's sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Motion {
    /// Along the module and back.
    Line,
    /// Around its middle.
    Circle,
    /// Rest in the middle.
    Hold,
    /// No touch.
    None,
}

/// Kinds of a new bench's motors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NewMotors {
    /// Linear resonant actuators behind DRV2605L drivers, all behind TCA9548A switches.
    Lra,
    /// Eccentric rotating masses behind such drivers.
    Erm,
    /// Voice coils on the channels of a sound card.
    VoiceCoil,
}

/// Options of `hil new scene`.
#[derive(Debug, Args)]
pub struct NewScene {
    #[command(flatten)]
    pub(crate) file: NewFile,
    /// Sensor layout: a built-in name or a file (default: uskin-4x4).
    #[arg(long, value_name = "NAME|FILE")]
    pub layout: Option<String>,
    /// Motion of the sphere (default: line).
    #[arg(long, value_enum, value_name = "PATH")]
    pub path: Option<Motion>,
    /// Simulated length in seconds (default: 10).
    #[arg(long, value_name = "S", value_parser = positive, allow_hyphen_values = true)]
    pub length_s: Option<f64>,
}

/// Options of `hil new bench`.
#[derive(Debug, Args)]
pub struct NewBench {
    #[command(flatten)]
    pub(crate) file: NewFile,
    /// Display layout: a built-in name or a file (default: thimble-8).
    #[arg(long, value_name = "NAME|FILE")]
    pub display: Option<String>,
    /// Wire: a built-in name or a file (default: final-75um).
    #[arg(long, value_name = "NAME|FILE")]
    pub wire: Option<String>,
    /// Motors in place of wires.
    #[arg(long, value_enum, value_name = "KIND", conflicts_with_all = ["wire", "current_ma", "supply_limit_ma"])]
    pub motors: Option<NewMotors>,
    /// Current through a wire that is on, mA (default: 990).
    #[arg(long, value_name = "MA", value_parser = positive, allow_hyphen_values = true)]
    pub current_ma: Option<f64>,
    /// Most current that the supply gives, mA (default: 4000).
    #[arg(long, value_name = "MA", value_parser = positive, allow_hyphen_values = true)]
    pub supply_limit_ma: Option<f64>,
    /// A CAN interface; repeatable. Makes the bench real.
    #[arg(long, value_name = "IFACE", requires = "i2c")]
    pub can: Vec<String>,
    /// An I2C adapter (/dev/i2c-N); repeatable. Makes the bench real.
    #[arg(long, value_name = "DEVICE", requires = "can")]
    pub i2c: Vec<PathBuf>,
}

/// Kinds of new layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LayoutKind {
    /// Taxels of a skin.
    Sensor,
    /// Wires of a display.
    Display,
}

/// Options of `hil new layout`.
#[derive(Debug, Args)]
pub struct NewLayout {
    #[command(flatten)]
    pub(crate) file: NewFile,
    /// Taxels or wires (default: sensor).
    #[arg(long, value_enum, value_name = "KIND")]
    pub kind: Option<LayoutKind>,
    /// Rows, from top to bottom (default: 4).
    #[arg(long, value_name = "N", value_parser = whole::<u16, 1, 256>, allow_hyphen_values = true)]
    pub rows: Option<u16>,
    /// Columns, from left to right (default: 4).
    #[arg(long, value_name = "N", value_parser = whole::<u16, 1, 256>, allow_hyphen_values = true)]
    pub columns: Option<u16>,
    /// Distance between neighbours, both ways, mm (default: 4.7).
    #[arg(long, value_name = "MM", value_parser = positive, allow_hyphen_values = true)]
    pub pitch_mm: Option<f64>,
}

/// Options of `hil new wire`.
#[derive(Debug, Args)]
pub struct NewWire {
    #[command(flatten)]
    pub(crate) file: NewFile,
    /// Diameter, micrometres (default: 75).
    #[arg(long, value_name = "UM", value_parser = positive, allow_hyphen_values = true)]
    pub diameter_um: Option<f64>,
    /// Length between the crimps, mm (default: 5).
    #[arg(long, value_name = "MM", value_parser = positive, allow_hyphen_values = true)]
    pub length_mm: Option<f64>,
    /// Resistance between the terminals, Ohm (default: computed from the built-in final-75um).
    #[arg(long, value_name = "OHM", value_parser = positive, allow_hyphen_values = true)]
    pub resistance_ohm: Option<f64>,
}

/// Options of `hil new protocol` and `hil study new`.
#[derive(Debug, Args)]
pub struct NewProtocol {
    #[command(flatten)]
    pub(crate) file: NewFile,
    /// The built-in protocol that it begins as.
    #[arg(long, value_name = "NAME", default_value = "wearer")]
    pub like: String,
}

/// Files that `hil export` writes.
#[derive(Debug, Subcommand)]
pub enum ExportKind {
    /// The raw readings of a scene's emulated skin, as a recording that `hil run --replay` takes.
    Taxels(ExportTaxels),
    /// Ready views of a recording (.mcap): foxglove.json for Foxglove, plotjuggler.xml for PlotJuggler.
    Views(ExportViews),
}

/// Options of `hil export views`.
#[derive(Debug, Args)]
pub struct ExportViews {
    /// Folder to write them into; made where there is none.
    #[arg(short = 'o', long, value_name = "DIR", default_value = ".")]
    pub out: PathBuf,
    /// Overwrite files that are no such views.
    #[arg(short = 'f', long)]
    pub force: bool,
}

/// Options of `hil export taxels`.
#[derive(Debug, Args)]
pub struct ExportTaxels {
    /// A built-in scene or a file.
    pub scene: String,
    /// File to write (.csv). A skin of several modules makes one file per module: FILE-0.csv, FILE-1.csv and so on.
    #[arg(short = 'o', long, value_name = "FILE")]
    pub out: PathBuf,
    /// Seed of all randomness.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u64, 0, { u64::MAX }>, allow_hyphen_values = true)]
    pub seed: u64,
    /// A value in place of the scene's, as for `hil run`. Repeatable.
    #[arg(short = 's', long, value_name = "KEY=VALUE", value_parser = ranges::key_value)]
    pub set: Vec<String>,
    /// Overwrite files that are no recordings of taxels.
    #[arg(short = 'f', long)]
    pub force: bool,
}

/// Options of `hil completions`.
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

/// Options of `hil man`.
#[derive(Debug, Args)]
pub struct ManArgs {
    /// A command, and one below it: `hil man study run` (default: the page of `hil` itself).
    #[arg(value_name = "COMMAND")]
    pub command: Vec<String>,
}
