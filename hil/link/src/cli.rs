//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use palpate_core::units::Instant;
use palpate_files::{Bench, Loaded, Overrides, Setup, load_scene};
use palpate_hil::cli::{GuardianArgs, UnitOn, within};
use palpate_hil::command::{bench_on, enough_adapters, skin_on};
use palpate_run::Failure;

use crate::name::{FingerName, Name};
use crate::net::At;

/// A robot's skin here, a wearer's finger there: frames over zenoh, safety on the wearer's machine.
#[derive(Debug, Parser)]
#[command(name = "palpate-link", version)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Publish the readings of a robot's skin.
    Skin(SkinArgs),
    /// Render on a bench's outputs what comes of a finger.
    Display(DisplayArgs),
    /// Publish how a wearer's hand bends, and measure the time until the robot's skin answers.
    Glove(GloveArgs),
    /// Be where ends meet: those with --connect find each other here, those with --relay speak through it.
    Relay(RelayArgs),
    /// Say who publishes and who feels what.
    List(ListArgs),
    /// Record what crosses the network (MCAP).
    Record(RecordArgs),
    /// Join recordings of the two ends into one, on the robot's clock.
    Merge(MergeArgs),
    /// Make certificates and the access list of a lab.
    Keys(KeysArgs),
    /// Publish contacts so that ROS 2 reads them.
    Ros(RosArgs),
    /// Print the messages, for protoc or, with --binary, for a library of protocol buffers.
    Schema(SchemaArgs),
    /// The process that switches off when a display dies (internal; `display` starts it).
    #[command(hide = true)]
    Guardian(GuardianArgs),
}

/// Options of `palpate-link schema`.
#[derive(Debug, Args)]
pub struct SchemaArgs {
    /// A `google.protobuf.FileDescriptorSet` in place of text.
    #[arg(long)]
    pub binary: bool,
}

/// Addresses of the others.
#[derive(Clone, Debug, Args)]
pub struct AtArgs {
    /// Listen here, HOST:PORT; repeatable. Without --listen and --connect programs of one machine find each other.
    #[arg(long, value_name = "HOST:PORT")]
    pub listen: Vec<String>,
    /// Connect there; repeatable. It is tried until it succeeds.
    #[arg(long, value_name = "HOST:PORT")]
    pub connect: Vec<String>,
    /// Folder of this machine's certificate and access list, as `palpate-link keys` made it.
    #[arg(long, value_name = "DIR")]
    pub keys: Option<PathBuf>,
    /// Let plain text leave this machine: anyone on the network reads, feeds and stops then.
    #[arg(long, conflicts_with = "keys")]
    pub plain: bool,
}

impl AtArgs {
    /// Addresses and keys as the network takes them.
    #[must_use]
    pub fn at(&self) -> At {
        At {
            listen: self.listen.clone(),
            connect: self.connect.clone(),
            keys: self.keys.clone(),
            plain: self.plain,
            relay: None,
        }
    }
}

/// Addresses of the others, for an end.
#[derive(Clone, Debug, Args)]
pub struct EndAtArgs {
    /// Addresses that a relay takes too.
    #[command(flatten)]
    pub direct: AtArgs,
    /// Speak through the relay there, for ends that cannot reach each other. It is tried until it answers.
    #[arg(long, value_name = "HOST:PORT", conflicts_with_all = ["listen", "connect"])]
    pub relay: Option<String>,
}

/// Number of connections that frames cross.
#[derive(Clone, Copy, Debug, Args)]
pub struct TwiceArgs {
    /// Frames over one connection: half of the bytes, and every lost packet is a pause.
    #[arg(long)]
    pub once: bool,
    /// Frames over two connections on one machine too.
    #[arg(long, conflicts_with = "once")]
    pub twice: bool,
}

impl EndAtArgs {
    /// Tells whether this end opens a second connection: unless told otherwise to other machines alone, which may lose
    /// packets.
    #[must_use]
    pub fn is_twice(&self, args: TwiceArgs) -> bool {
        let at = self.at();
        // The end that connects opens both connections.
        let only_listens = at.relay.is_none() && at.connect.is_empty() && !at.listen.is_empty();
        !only_listens && (args.twice || (!args.once && at.leaves_machine()))
    }

    /// Addresses and keys as the network takes them.
    #[must_use]
    pub fn at(&self) -> At {
        At {
            relay: self.relay.clone(),
            ..self.direct.at()
        }
    }
}

/// The scene and bench of an end.
#[derive(Debug, Args)]
pub struct On {
    /// A scene's name or file.
    #[arg(default_value = "sphere-along")]
    pub scene: String,
    /// A bench's name or file (default: emulated).
    #[arg(long, value_name = "NAME|FILE")]
    pub bench: Option<String>,
    /// Change a key of scene or bench, such as illusion.model=inverse; repeatable.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Seed of all that is random.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

impl On {
    /// Everything that the files say, with a bench that `bench` makes of its name and the changes.
    fn setup(
        &self,
        unit: &UnitOn,
        bench: impl FnOnce(Option<&str>, &Overrides) -> Result<Loaded<Bench>, Failure>,
    ) -> Result<Setup, Failure> {
        let mut overrides = Overrides::default();
        for text in &self.set {
            overrides.set("--set", text)?;
        }
        unit.change(&mut overrides);
        let scene = load_scene(&self.scene)?.with(&overrides)?;
        let named = self.bench.as_deref();
        let bench = bench(Some(named.unwrap_or(scene.value.own_bench())), &overrides)?;
        Ok(Setup::join(scene, bench)?)
    }
}

impl SkinArgs {
    /// Everything that the files say.
    ///
    /// # Errors
    /// [`Failure`] for what cannot be in them, or does not fit together.
    pub fn setup(&self) -> Result<Setup, Failure> {
        let bench = |name: Option<&str>, changed: &Overrides| skin_on(name, changed, &self.can);
        self.on.setup(&UnitOn::default(), bench)
    }
}

impl DisplayArgs {
    /// Everything that the files say.
    ///
    /// # Errors
    /// [`Failure`] for what cannot be in them, or does not fit together.
    pub fn setup(&self) -> Result<Setup, Failure> {
        self.on.setup(&self.unit, |name, changed| {
            let bench = bench_on(name, changed, &[], &self.i2c)?;
            enough_adapters(&bench.value)?;
            Ok(bench)
        })
    }
}

/// Payloads that cross the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// Contacts: compression on the robot's side.
    Contacts,
    /// Every taxel's counts: compression on the wearer's side.
    Scans,
}

impl Kind {
    /// The word of the option.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Contacts => "contacts",
            Self::Scans => "scans",
        }
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    within(text, (0.1, 86_400.0), "")
}

/// Time on a run's clock, so many seconds after its start.
pub(crate) fn after(seconds: f64) -> Instant {
    Instant::from_micros((seconds * 1e6) as u64)
}

/// Options of `palpate-link skin`.
#[derive(Debug, Args)]
pub struct SkinArgs {
    /// Scene and bench: the touches that are felt.
    #[command(flatten)]
    pub on: On,
    /// The finger: ROBOT/HAND/FINGER.
    #[arg(long, value_name = "R/H/F")]
    pub finger: FingerName,
    /// A CAN interface of boards in place of the bench's skin; once per bus of the layout.
    #[arg(long, value_name = "IFACE", conflicts_with = "replay")]
    pub can: Vec<String>,
    /// Payload that crosses the network.
    #[arg(long, value_enum, default_value_t = Kind::Contacts)]
    pub send: Kind,
    /// A recording in place of the scene's touches; one CSV per module, or a recording of buses.
    #[arg(long, value_name = "FILE")]
    pub replay: Vec<PathBuf>,
    /// Let this wearer's glove bend the emulated hand, in place of the scene's touches.
    #[arg(long, value_name = "WEARER", conflicts_with_all = ["can", "replay"])]
    pub glove: Option<Name>,
    /// Rows per second of a recording without times.
    #[arg(long, value_name = "HZ")]
    pub rate: Option<f64>,
    /// Stop after so long (default: at the end of scene or recording; boards are read until Ctrl-C).
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Record to this file; the ending names the format: .mcap, .csv; repeatable.
    #[arg(long, value_name = "FILE")]
    pub record: Vec<PathBuf>,
    /// Replace files that are there.
    #[arg(long)]
    pub force: bool,
    /// Print what came of it as JSON.
    #[arg(long)]
    pub json: bool,
    /// Say nothing but errors.
    #[arg(long)]
    pub quiet: bool,
    /// Number of connections that frames cross.
    #[command(flatten)]
    pub twice: TwiceArgs,
    /// Addresses of the others.
    #[command(flatten)]
    pub at: EndAtArgs,
}

/// Options of `palpate-link display`.
#[derive(Debug, Args)]
pub struct DisplayArgs {
    /// Bench that renders it.
    #[command(flatten)]
    pub on: On,
    /// The finger that is felt: ROBOT/HAND/FINGER.
    #[arg(long, value_name = "R/H/F")]
    pub finger: FingerName,
    /// An I2C adapter (/dev/i2c-N) in place of the bench's outputs; once per bus of the outputs.
    #[arg(long, value_name = "DEVICE")]
    pub i2c: Vec<PathBuf>,
    /// A driver unit in place of them.
    #[command(flatten)]
    pub unit: UnitOn,
    /// The wearer's name; with --keys that of the certificate.
    #[arg(long, value_name = "NAME", default_value = "wearer")]
    pub wearer: Name,
    /// Stop after so long (default: at Ctrl-C, which is the wearer's STOP).
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Record to this file; the ending names the format: .mcap, .csv, .jsonl, .vcd; repeatable.
    #[arg(long, value_name = "FILE")]
    pub record: Vec<PathBuf>,
    /// Write the report of the run, with its latency budget, as one page, .html.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Replace files that are there.
    #[arg(long)]
    pub force: bool,
    /// Print what came of it as JSON.
    #[arg(long)]
    pub json: bool,
    /// Say nothing but errors.
    #[arg(long)]
    pub quiet: bool,
    /// Number of connections that frames cross.
    #[command(flatten)]
    pub twice: TwiceArgs,
    /// Addresses of the others.
    #[command(flatten)]
    pub at: EndAtArgs,
}

/// Options of `palpate-link glove`.
#[derive(Debug, Args)]
pub struct GloveArgs {
    /// The scene whose joints bend: a name or file.
    #[arg(default_value = "finger-flexes")]
    pub scene: String,
    /// The finger that follows: ROBOT/HAND/FINGER.
    #[arg(long, value_name = "R/H/F")]
    pub finger: FingerName,
    /// The wearer's name; with --keys that of the certificate.
    #[arg(long, value_name = "NAME", default_value = "wearer")]
    pub wearer: Name,
    /// A recording with columns joint_NAME in place of the scene's joints.
    #[arg(long, value_name = "FILE")]
    pub replay: Option<PathBuf>,
    /// Stop after so long (default: at the last point of a joint).
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Print what came of it as JSON.
    #[arg(long)]
    pub json: bool,
    /// Say nothing but errors.
    #[arg(long)]
    pub quiet: bool,
    /// Addresses of the others.
    #[command(flatten)]
    pub at: EndAtArgs,
}

/// Options of `palpate-link relay`.
#[derive(Debug, Args)]
pub struct RelayArgs {
    /// Stop after so long (default: at Ctrl-C).
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Addresses of the others.
    #[command(flatten)]
    pub at: AtArgs,
}

/// Options of `palpate-link list`.
#[derive(Debug, Args)]
pub struct ListArgs {
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Wait so long for answers.
    #[arg(long, value_name = "S", value_parser = seconds, default_value_t = 1.0)]
    pub seconds: f64,
    /// Addresses of the others.
    #[command(flatten)]
    pub at: EndAtArgs,
}

/// Options of `palpate-link record`.
#[derive(Debug, Args)]
pub struct RecordArgs {
    /// The file, .mcap.
    pub file: PathBuf,
    /// Stop after so long (default: at Ctrl-C).
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Replace a file that is there.
    #[arg(long)]
    pub force: bool,
    /// Addresses of the others.
    #[command(flatten)]
    pub at: EndAtArgs,
}

/// Options of `palpate-link merge`.
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// The recording of `palpate-link skin --record`, .mcap: its clock is that of the result.
    pub robot: PathBuf,
    /// A recording of `palpate-link display --record`, .mcap.
    pub wearer: PathBuf,
    /// The result, .mcap.
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Write the contacts of both to this folder too, robot.csv and wearer.csv, frame beside frame for `hil diff`.
    #[arg(long, value_name = "DIR")]
    pub contacts: Option<PathBuf>,
    /// Replace a file that is there.
    #[arg(long)]
    pub force: bool,
    /// Print what came of it as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Options of `palpate-link keys`.
#[derive(Debug, Args)]
pub struct KeysArgs {
    /// The lab's folder; it holds the authority's key, which no machine but this one needs.
    pub folder: PathBuf,
    /// A robot and the fingers that it may publish: NAME=R/H/F,R/H/F with * for any; without =, all of its own name. Repeatable.
    #[arg(long, value_name = "NAME[=FINGERS]")]
    pub robot: Vec<String>,
    /// A wearer and the fingers that may be felt: NAME=R/H/F,R/H/F; without =, all. Repeatable.
    #[arg(long, value_name = "NAME[=FINGERS]")]
    pub wearer: Vec<String>,
    /// A relay; repeatable.
    #[arg(long, value_name = "NAME")]
    pub relay: Vec<String>,
    /// Someone who may read everything: `list` and `record`; repeatable.
    #[arg(long, value_name = "NAME")]
    pub watcher: Vec<String>,
    /// Validity of the certificates, days.
    #[arg(long, value_name = "DAYS", default_value_t = 365, value_parser = clap::value_parser!(i64).range(0..=3650))]
    pub days: i64,
}

/// Options of `palpate-link ros`.
#[derive(Debug, Args)]
pub struct RosArgs {
    /// The finger: ROBOT/HAND/FINGER.
    #[arg(long, value_name = "R/H/F")]
    pub finger: FingerName,
    /// The ROS domain.
    #[arg(long, default_value_t = 0)]
    pub domain: u16,
    /// Stop after so long (default: at Ctrl-C).
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Addresses of the others.
    #[command(flatten)]
    pub at: EndAtArgs,
}
