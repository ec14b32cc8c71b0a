//! The command line.

mod calibrate;
mod compare;
mod contacts;
mod design;
mod files;
mod hardware;
mod help;
mod identify;
mod import;
mod meant;
mod names;
pub(crate) mod ranges;
mod reproduce;
mod serve;
mod study;
mod sweep;
mod texture;
mod unit;

use std::io::{self, IsTerminal, Write};
use std::net::SocketAddr;
use std::path::PathBuf;

pub use calibrate::{CalibrateArgs, Planned};
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
pub use compare::{DiffArgs, ReviewAction, ReviewArgs, TestArgs};
pub use contacts::{ContactsArgs, StaleArg, Threshold, threshold};
pub use design::{DesignArgs, Numbers};
pub use files::{
    CheckArgs, CompletionsArgs, ExportKind, ExportTaxels, ExportViews, LayoutKind, ListArgs,
    ManArgs, Motion, NewBench, NewFile, NewKind, NewLayout, NewMotors, NewProtocol, NewScene,
    NewWire, SagState, Shelf,
};
pub use hardware::{
    DoctorArgs, EmulateArgs, GuardianArgs, OffArgs, PulseArgs, RecordArgs, ReplayArgs,
};
pub use help::{command, shown};
pub use identify::{IdentifyArgs, SignalArg};
pub use import::ImportArgs;
pub use meant::meant;
pub use names::{VARIABLE, complete};
use palpate_files::{Gain, TimeColumn};
use palpate_live::output::{print, print_json};
use palpate_run::Failure;
pub use reproduce::ReproduceArgs;
use serde::Serialize;
pub use serve::ServeArgs;
pub use study::{AnalyseArgs, SimulateArgs, StudyAction, StudyRunArgs};
pub use sweep::{CompareArgs, Seeds, SweepArgs};
pub use texture::{
    EncodeArgs, ExportArgs, MapArgs, MaterialsArgs, PanelArgs, RebuildArgs, ResponseArgs,
    StrokesArgs, TextureAction, TrainArgs,
};
pub use unit::{UnitArgs, UnitOn};

/// Tactile feedback with hardware in the loop: robot skin to wires on a finger.
#[derive(Debug, Parser)]
#[command(name = "hil", version)]
pub struct Cli {
    /// The command; without one, `hil run` of the default scene.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Colours: auto (a terminal, no NO_COLOR), always, never.
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t = Color::Auto)]
    #[arg(hide_default_value = true, hide_possible_values = true)]
    pub color: Color,
}

/// Places where messages are coloured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Color {
    /// Colour on a terminal.
    Auto,
    /// Colour on a terminal and in a pipe.
    Always,
    /// Never.
    Never,
}

impl Color {
    /// Decides whether output to this stream is coloured; with `NO_COLOR` in the environment, only `always` colours
    /// it.
    pub fn on(self, stream: &impl IsTerminal) -> bool {
        match self {
            Self::Always => true,
            Self::Never => false,
            Self::Auto => {
                let unwanted = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
                !unwanted && stream.is_terminal()
            }
        }
    }
}

/// A number within bounds, which `unit` follows in words.
///
/// # Errors
/// The bounds, for anything else; NaN is outside of all.
pub fn within(text: &str, (low, high): (f64, f64), unit: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(number) if (low..=high).contains(&number) => Ok(number),
        _ => Err(format!("expected {low} to {high}{unit}")),
    }
}

/// Rows per second, whatever the file says about its times: slower ones would outlast any run, faster ones have no
/// microsecond of their own.
pub(crate) fn rate(text: &str) -> Result<f64, String> {
    within(text, (0.1, 1e6), " Hz")
}

/// A whole number within bounds.
pub(crate) fn whole<T: TryFrom<u64>, const LOW: u64, const HIGH: u64>(
    text: &str,
) -> Result<T, String> {
    let number: Option<u64> = text.parse().ok();
    number
        .filter(|n| (LOW..=HIGH).contains(n))
        .and_then(|n| T::try_from(n).ok())
        .ok_or_else(|| format!("expected a whole number from {LOW} to {HIGH}"))
}

/// A positive number that files take too.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    within(text, (0.01, 86_400.0), "")
}

/// Default address at which a page is served.
const SERVE_AT: &str = "127.0.0.1:8137";

/// Port of `--foxglove` without a value.
const FOXGLOVE_AT: &str = "8765";

/// Parses the address at which a page is served.
fn serve_at(text: &str) -> Result<SocketAddr, String> {
    palpate_live::serve::address(text)
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a scene or a recording on a bench, and print a summary.
    ///
    /// Without a scene a sphere rolls over the skin (`sphere-along`).
    Run(Box<RunArgs>),
    /// Find the contacts in each frame of a recording, as CSV.
    Contacts(ContactsArgs),
    /// Propose a recipe for another maker's recording, and show the skin.
    ///
    /// It says what it understood and what it assumed, with the option that changes that.
    Import(ImportArgs),
    /// Serve emulated boards and displays to other programs.
    ///
    /// Boards stand on CAN interfaces, the display behind a /dev/i2c-N, until stopped.
    Emulate(EmulateArgs),
    /// Be a driver unit, which plays the stimuli of a host.
    ///
    /// Stimuli from UDP pass its own guard to emulated boards, or to those of an I2C adapter, until stopped.
    Unit(UnitArgs),
    /// Show a run, or a recording of one, in browsers.
    ///
    /// A scene runs with its page, as by `hil run --serve`. A recording (.mcap), or two beside each other, are shown until
    /// stopped; a folder of `hil run --out` stands for the recordings in it.
    Serve(ServeArgs),
    /// Record every frame on live CAN interfaces until stopped.
    Record(RecordArgs),
    /// Send a recording onto CAN interfaces, each frame at its time.
    Replay(ReplayArgs),
    /// Say in words how two goldens, schedules or contacts differ.
    ///
    /// Folders of `hil run --out` stand for the files in them. Exits with 1 if a difference could be felt or measured.
    Diff(DiffArgs),
    /// Accept or reject changed goldens, in words and charts.
    Review(ReviewArgs),
    /// Try scenes against their expectations and goldens.
    ///
    /// Every scene with expectations is a trial on a bench (default: what each wants, or emulated). Exits with 1 if one fails.
    Test(TestArgs),
    /// Run a scene over a grid of values and seeds, as a table.
    ///
    /// All cores share the runs, and a row is one run. The same command goes on with a table that is there.
    Sweep(SweepArgs),
    /// Find the figures of a wire, with intervals, from a trace (CSV).
    ///
    /// The trace has the wire's displacement or resistance.
    Identify(IdentifyArgs),
    /// Compute what is felt on a bench over all that is not measured.
    ///
    /// Wires, fingers and people are drawn from priors and weighed by evidence.
    Calibrate(CalibrateArgs),
    /// Say figure by figure how two results differ.
    ///
    /// Results are summaries, folders of `hil run --out` or tables of sweeps; of a folder of earlier summaries it shows how
    /// figures went over time. Exits with 1 if a figure differs.
    Compare(CompareArgs),
    /// Compute how makes of wire and patterns of pulses are felt.
    ///
    /// The table has tissue temperature and current beside the felt level.
    Design(DesignArgs),
    /// Compute figures and claims of the thesis from this program.
    ///
    /// Each row says what the thesis says, what comes out here, and whether both agree.
    Reproduce(ReproduceArgs),
    /// List scenes, benches, layouts, wires, laws: all there is.
    ///
    /// Built-in files come first, then those of this folder.
    List(ListArgs),
    /// Write a commented file with values that differ from the defaults.
    #[command(subcommand)]
    New(NewKind),
    /// List all errors of settings files.
    ///
    /// Files may be of any kind. Exits with 1 if there is an error.
    Check(CheckArgs),
    /// Write the readings of a scene, and other files, for other programs.
    #[command(subcommand)]
    Export(ExportKind),
    /// Train, map and try the texture model.
    #[command(subcommand)]
    Texture(TextureAction),
    /// Conduct, simulate and analyse studies with people.
    #[command(subcommand)]
    Study(StudyAction),
    /// Say what this machine has and lacks, and which commands add it.
    Doctor(DoctorArgs),
    /// Heat one wire of a bench once, by the smallest pulse.
    ///
    /// Its bursts are felt. The first thing to do with a new bench; asks before.
    Pulse(PulseArgs),
    /// Switch everything off on a bench, from any state.
    ///
    /// What was found is reported.
    Off(OffArgs),
    /// Print a script that completes commands and names in a shell.
    Completions(CompletionsArgs),
    /// Print a page for `man`: hil man | man -l -
    Man(ManArgs),
    /// The process that switches off when a run dies (internal; `hil run` starts it).
    #[command(hide = true)]
    Guardian(GuardianArgs),
}

/// The bench of a command, and the seed.
#[derive(Clone, Debug, Default, Args)]
pub struct Buses {
    /// A built-in bench or a file (default: the bench that the scene wants, or emulated).
    #[arg(short = 'b', long, value_name = "NAME|FILE")]
    pub bench: Option<String>,
    /// A CAN interface in place of the bench's; give it once per bus of the layout. Makes the bench real.
    #[arg(long, value_name = "IFACE")]
    pub can: Vec<String>,
    /// An I2C adapter (/dev/i2c-N) in place of the bench's; give it once per bus of the outputs.
    #[arg(long, value_name = "DEVICE")]
    pub i2c: Vec<PathBuf>,
    /// Seed of all randomness.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u64, 0, { u64::MAX }>, allow_hyphen_values = true)]
    pub seed: u64,
}

/// Amount that a command says.
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct Voice {
    /// Print the result as one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors.
    #[arg(short = 'q', long, conflicts_with = "json")]
    pub quiet: bool,
}

impl Voice {
    /// Prints a result: nothing where quiet, JSON where that is wanted, otherwise the text.
    ///
    /// # Errors
    /// Errors of [`print()`].
    pub fn tell<T: Serialize>(
        self,
        json: impl FnOnce() -> T,
        text: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        match self {
            Self { json: true, .. } => print_json(&json()),
            Self { quiet: true, .. } => Ok(()),
            _ => print(text),
        }
    }
}

/// Switch: on or off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    /// On.
    On,
    /// Off.
    Off,
}

/// Options of `hil run`.
#[derive(Clone, Debug, Default, Args)]
#[command(group = ArgGroup::new("readings").args(["replay", "stream"]).multiple(true))]
pub struct RunArgs {
    /// A built-in scene or a file (default: sphere-along).
    pub scene: Option<String>,
    /// Bench of the run.
    #[command(flatten)]
    pub on: Buses,
    /// Driver unit of the bench.
    #[command(flatten)]
    pub unit: UnitOn,
    /// Recorded taxels in place of the scene's touches: one CSV per module of the layout, or one recording
    /// of all buses (candump .log or .mcap).
    #[arg(long, value_name = "FILE")]
    pub replay: Vec<PathBuf>,
    /// Recipe that tells how to read the recording, such as `hil import` proposes (default: the recording itself if it is
    /// a recipe, else its name with the ending .toml).
    #[arg(long, value_name = "FILE", requires = "replay", conflicts_with_all = ["columns", "gain"])]
    pub recipe: Option<PathBuf>,
    /// Readings of the whole skin that another machine sends over TCP, a line each, in place of the scene's touches,
    /// until the scene's length is over.
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "replay")]
    pub stream: Option<String>,
    /// Sensor layout of the recording or stream (default: the scene's).
    #[arg(long, value_name = "NAME|FILE", requires = "readings")]
    pub layout: Option<String>,
    /// Rows per second of a recording without a time_us column (default: frequency_hz of meta_data.csv
    /// beside it).
    #[arg(long, value_name = "HZ", requires = "replay", value_parser = rate, allow_hyphen_values = true)]
    pub rate: Option<f64>,
    /// Column of the rows' times, and its unit: s, ms, us, ns or date (default: a column whose name says that it holds
    /// times).
    #[arg(
        long,
        value_name = "COLUMN[:UNIT]",
        requires = "replay",
        conflicts_with = "rate"
    )]
    pub time: Option<TimeColumn>,
    /// Read the columns whose names begin with PREFIX, in the order of the numbers in their names (default: `txl1_x` and so
    /// on, or the only columns whose count fits).
    #[arg(long, value_name = "PREFIX", requires = "replay")]
    pub columns: Option<String>,
    /// The topic whose messages are rows, in an MCAP file of another program (default: the one with the most numbers).
    #[arg(long, value_name = "TOPIC", requires = "replay")]
    pub topic: Option<String>,
    /// Counts per unit, and counts at zero, for a recording in another unit than counts (`100:32768`).
    #[arg(
        long,
        value_name = "COUNTS[:OFFSET]",
        requires = "replay",
        allow_hyphen_values = true
    )]
    pub gain: Option<Gain>,
    /// Join both sides of a jump of the recording's clock, without the gap.
    #[arg(long, requires = "replay")]
    pub split_jumps: bool,
    /// A value in place of the scene's (`illusion.weber=0.1`) or the bench's (`bench.drive.current_ma=900`): any key of
    /// the files, checked as if the file said so. Repeatable.
    #[arg(short = 's', long, value_name = "KEY=VALUE", value_parser = ranges::key_value)]
    pub set: Vec<String>,
    /// Write summary.json, schedule.jsonl, contacts.csv and report.html into this folder.
    #[arg(short = 'o', long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Overwrite existing files even if hil did not write them.
    #[arg(short = 'f', long)]
    pub force: bool,
    /// Amount that the command says.
    #[command(flatten)]
    pub voice: Voice,
    /// Print every figure in place of the eight lines.
    #[arg(long, conflicts_with_all = ["json", "quiet"])]
    pub long: bool,
    /// Let the guard only observe: it notes each change that it would make, and makes none. Emulated benches only.
    #[arg(long, conflicts_with = "junit")]
    pub observe: bool,
    /// Print the plan before the run, and the work done and left out after it.
    #[arg(long)]
    pub explain: bool,
    /// Show the run on a terminal as it goes. An emulated run then keeps to the wall clock.
    #[arg(short = 'w', long)]
    pub watch: bool,
    /// Show the run in browsers as it goes, at PORT of this computer or ADDRESS or ADDRESS:PORT (default: 127.0.0.1:8137; port 0
    /// takes a free one). It begins when a page opens there, and its page stays until Ctrl-C. An emulated run then keeps to the
    /// wall clock.
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = SERVE_AT, value_parser = serve_at)]
    pub serve: Option<SocketAddr>,
    /// Show the run in Foxglove as it goes, at PORT of this computer (default: 8765; port 0 takes a free one): its WebSocket
    /// protocol, with the topics of a record. It begins when a client connects there. An emulated run then keeps to the wall
    /// clock. Benches with one display.
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = FOXGLOVE_AT, conflicts_with = "again")]
    pub foxglove: Option<u16>,
    /// Open the page in this computer's browser (xdg-open).
    #[arg(long, requires = "serve")]
    pub open: bool,
    /// Begin anew whenever the run is over, until Ctrl-C or STOP. Emulated benches only, and nothing is written.
    #[arg(long = "loop", requires = "serve", conflicts_with_all = ["stream", "out", "schedule", "html", "record", "junit"])]
    pub again: bool,
    /// Write the schedule as JSON Lines.
    #[arg(long, value_name = "FILE")]
    pub schedule: Option<PathBuf>,
    /// Write the report: one page with plots.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Write what the sound card of a bench of voice coils played, as a WAV file of all channels; `-` is standard output, and
    /// nothing else goes there. Emulated benches.
    #[arg(long, value_name = "FILE", conflicts_with = "again")]
    pub wav: Option<PathBuf>,
    /// Write a record; the ending names the format: .csv contacts, .jsonl schedule, .log candump, .mcap
    /// everything, .vcd pins, ticks and temperatures, .snap golden. Repeatable.
    #[arg(short = 'r', long, value_name = "FILE")]
    pub record: Vec<PathBuf>,
    /// Check the scene's expectations and write the result as JUnit XML. Exits with 1 if one fails.
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Let intensity levels change the drive.
    #[arg(long, value_name = "on|off")]
    pub intensity: Option<Switch>,
    /// Illusion model: phantom, energy, linear, square, balanced, inverse, three-nearest, gaussian or nearest.
    #[arg(long, value_name = "NAME")]
    pub illusion: Option<String>,
    /// Render contacts of `inverse` in this style: smooth (a vibration), tap, or auto (taps while a contact rests).
    #[arg(long, value_name = "STYLE")]
    pub render: Option<String>,
    /// The wearer's calibration for the loop, built in or a file, such as `hil study analyse` writes.
    #[arg(long, value_name = "NAME|FILE")]
    pub wearer: Option<String>,
    /// The emulated person who feels it, built in (typical, sensitive, dull, back) or a file.
    #[arg(long, value_name = "NAME|FILE")]
    pub person: Option<String>,
}
