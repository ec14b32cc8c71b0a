//! Options of the commands about buses and what hangs on them: recording, replay, emulation, doctor, off.

use std::path::PathBuf;

use clap::Args;
use palpate_buses::guardian::{WatchedBus, parse_bus, parse_line};

use super::{UnitOn, Voice, positive, whole};

/// Options of `hil record`.
#[derive(Debug, Args)]
pub struct RecordArgs {
    /// Files to write, .log (candump) or .mcap.
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// A CAN interface; repeatable, the n-th is bus n.
    #[arg(long, value_name = "IFACE", required = true)]
    pub can: Vec<String>,
    /// Length of the recording in seconds (default: until Ctrl-C).
    #[arg(long, value_name = "S", value_parser = positive, allow_hyphen_values = true)]
    pub seconds: Option<f64>,
    /// Overwrite existing files even if hil did not write them.
    #[arg(short = 'f', long)]
    pub force: bool,
    /// Amount that the command says.
    #[command(flatten)]
    pub voice: Voice,
}

/// Options of `hil replay`.
#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// The recording, .log (candump) or .mcap.
    pub file: PathBuf,
    /// Take jumps of the clock out: play what follows one right after what came before it.
    #[arg(long)]
    pub split_jumps: bool,
    /// Skin of the recording, whose `bitrate` its frames cannot exceed (default: 1 Mbit/s).
    #[arg(long, value_name = "NAME|FILE")]
    pub layout: Option<String>,
    /// A CAN interface; repeatable, bus n of the recording plays on the n-th.
    #[arg(long, value_name = "IFACE", required = true)]
    pub can: Vec<String>,
    /// Amount that the command says.
    #[command(flatten)]
    pub voice: Voice,
}

/// Options of `hil doctor`.
#[derive(Debug, Args)]
pub struct DoctorArgs {
    /// Check only the buses of this bench (default: all buses of the machine).
    #[arg(short = 'b', long, value_name = "NAME|FILE")]
    pub bench: Option<String>,
    /// Check this driver unit beside them.
    #[command(flatten)]
    pub unit: UnitOn,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// Options of `hil off`.
#[derive(Debug, Args)]
pub struct OffArgs {
    /// A bench of real buses: a file.
    #[arg(short = 'b', long, value_name = "NAME|FILE", required_unless_present_any = ["i2c", "unit"])]
    pub bench: Option<String>,
    /// An I2C adapter in place of a bench; repeatable. Every chip that answers there is switched off.
    #[arg(long, value_name = "DEVICE", conflicts_with = "bench")]
    pub i2c: Vec<PathBuf>,
    /// A driver unit in place of a bench: it switches off under any host, and no host goes on by itself.
    #[command(flatten)]
    pub unit: UnitOn,
    /// Clear a latched stop too. Look at the bench first.
    #[arg(long)]
    pub unlatch: bool,
    /// Forget the heat of its hardware too, and the dose of a wearer without a name: type the bench's name, or the
    /// unit's address. For another wearer, or one who has rested.
    #[arg(long, value_name = "BENCH")]
    pub forget_heat: Option<String>,
    /// Forget the dose of the wearer of this name instead; repeatable.
    #[arg(long, value_name = "NAME", requires = "forget_heat")]
    pub wearer: Vec<String>,
}

/// Options of `hil pulse`.
#[derive(Debug, Args)]
pub struct PulseArgs {
    /// The wire or motor, counted from 0 in the order of the display, as benches, protocols and records count it.
    #[arg(value_name = "WIRE", value_parser = whole::<u16, 0, 127>, allow_hyphen_values = true)]
    pub wire: u16,
    /// A built-in bench or a file (default: emulated).
    #[arg(short = 'b', long, value_name = "NAME|FILE")]
    pub bench: Option<String>,
    /// Driver unit of the bench.
    #[command(flatten)]
    pub unit: UnitOn,
    /// The display whose wire it is, of a bench of several.
    #[arg(long, value_name = "DISPLAY")]
    pub finger: Option<String>,
    /// Sensor layout of the skin, which has to be heard before a wire is heated.
    #[arg(long, value_name = "NAME|FILE", default_value = "uskin-4x4")]
    pub layout: String,
    /// Heat the wire without a question. Needed where standard input is no terminal.
    #[arg(long)]
    pub yes: bool,
    /// Amount that the command says.
    #[command(flatten)]
    pub voice: Voice,
}

/// Options of the guardian process.
#[derive(Debug, Args)]
pub struct GuardianArgs {
    /// Adapter, addresses of its boards, and of the converters beside them.
    #[arg(long, value_name = "PATH=ADDRESS,..+ADDRESS,..", value_parser = parse_bus)]
    pub i2c: Vec<WatchedBus>,
    /// GPIO chip and line of the OE pins.
    #[arg(long, value_name = "CHIP=LINE", value_parser = parse_line)]
    pub oe: Option<(PathBuf, u32)>,
    /// Silence after which the run counts as hung.
    #[arg(long, value_name = "MS", value_parser = whole::<u64, 1, 10_000>)]
    pub heartbeat_ms: u64,
    /// Time that one transfer may take.
    #[arg(long, value_name = "MS", value_parser = whole::<u64, 1, 10_000>)]
    pub transfer_ms: u64,
}

/// Options of `hil emulate`.
#[derive(Debug, Args)]
pub struct EmulateArgs {
    /// A built-in bench or a file (default: the bench that the scene wants, or emulated).
    #[arg(short = 'b', long, value_name = "NAME|FILE")]
    pub bench: Option<String>,
    /// The scene that touches the boards, over and over: a built-in name or a file (default: sphere-along).
    #[arg(long, value_name = "NAME|FILE")]
    pub scene: Option<String>,
    /// A CAN interface that is up; give it once per sensor bus of the scene's layout (default: vcan0,
    /// vcan1, ...).
    #[arg(long, value_name = "IFACE")]
    pub can: Vec<String>,
    /// Let the boards wait for a start command (20f#0700). The scene begins with it.
    #[arg(long)]
    pub await_start: bool,
    /// Connect pin 0 of the bridge, a GPIO line with a pull-up, to the chips' OE pins. It cuts every output.
    #[arg(long)]
    pub oe: bool,
    /// Seed of all randomness.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u64, 0, { u64::MAX }>, allow_hyphen_values = true)]
    pub seed: u64,
    /// Print what happens as JSON Lines: every edge of an output, every all-off, the record at the end.
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors.
    #[arg(short = 'q', long, conflicts_with = "json")]
    pub quiet: bool,
}
