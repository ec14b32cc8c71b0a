//! The canonical trace: everything a run did, in integers, in order. Schedule, contacts and
//! goldens read this and nothing else, so a golden, a report and a schedule file cannot tell different stories.

pub mod event;

pub use event::{EnergyPermille, Event, FeltAt, PlaceUm, sort_by_time};

use crate::margin::{Limited, Margin};
use event::EventKind;
use palpate_core::schedule::Entry;
use palpate_core::units::Prescale;
use serde::{Serialize, Serializer};

/// Version of the trace's meaning; grows when a field changes what it says.
pub const VERSION: u32 = 5;

palpate_core::listed! {
    /// Source of a record: emulators or hardware.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "lowercase")]
    pub enum Source: word {
        /// Both ends were emulators.
        Emulated = "emulated",
        /// At least one end was real.
        Real = "real",
        /// Both ends were emulators, and the guard only looked on.
        Observed = "observed",
    }
}

/// Banner of everything that comes of a run which the guard only observed.
pub const OBSERVED: &str = "observed: the guard changed nothing; not for a person";

impl Source {
    /// The source of this word.
    pub fn named(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|source| source.word() == word)
    }

    /// Tells whether the record is free of hardware.
    pub const fn is_emulated(self) -> bool {
        !matches!(self, Self::Real)
    }

    /// Banner that has to stand beside the record, if any.
    pub const fn banner(self) -> Option<&'static str> {
        match self {
            Self::Observed => Some(OBSERVED),
            Self::Emulated | Self::Real => None,
        }
    }

    /// The banner, or the word.
    pub fn words(self) -> &'static str {
        self.banner().unwrap_or(self.word())
    }
}

/// One wire of the display and the output that drives it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct WireInfo {
    /// Place on the unrolled display.
    pub place: PlaceUm,
    /// Board that drives it.
    pub board: u8,
    /// Channel of that board.
    pub channel: u8,
}

/// Facts of a run: scene, bench and limits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Header {
    /// Emulated or real.
    pub source: Source,
    /// Scene name, or the replayed file's name.
    pub scene: String,
    /// Bench name.
    pub bench: String,
    /// Seed of every random stream.
    pub seed: u64,
    /// SHA-256 of the values of the scene, first 16 hex digits.
    pub scene_digest: String,
    /// SHA-256 of the values of the limit table in force, first 16 hex digits.
    pub limits_digest: String,
    /// PRE_SCALE of every board: with it the true PWM frequency.
    #[serde(serialize_with = "plain")]
    pub pre_scale: Prescale,
    /// Stimulus duration tau_d, microseconds.
    pub tau_d_us: u64,
    /// Stimulus onset asynchrony, microseconds.
    pub soa_us: u64,
    /// Name of the emulated person.
    pub person: String,
    /// Name of the wires' file: what the person's levels hold for.
    pub preset: String,
    /// Name of the illusion model.
    pub illusion: String,
    /// Most contacts a frame may have.
    pub kc: u16,
    /// Taxels of the module that drives the display.
    pub taxels: Vec<PlaceUm>,
    /// The display's wires; of several displays one after the other.
    pub wires: Vec<WireInfo>,
    /// Several displays; empty for one.
    pub displays: Vec<DisplayInfo>,
    /// Names of the joints whose angles are kept.
    pub joints: Vec<String>,
    /// `true` where a Peltier module is under the fingertip.
    pub warmth: bool,
    /// `true` where the display has motors in place of wires: widths are their levels, of 4096 for the highest.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub motors: bool,
}

impl Header {
    /// Noun for one actuator of the display.
    pub const fn actuator(&self) -> &'static str {
        match self.motors {
            true => "motor",
            false => "wire",
        }
    }

    /// Noun for the strength of a stimulus, which is a share of all there is.
    pub const fn strength(&self) -> &'static str {
        match self.motors {
            true => "level",
            false => "duty",
        }
    }
}

/// A register value and its clock as integers.
fn plain<S: Serializer>(pre_scale: &Prescale, serializer: S) -> Result<S::Ok, S::Error> {
    let clock = pre_scale.clock();
    (pre_scale.get(), clock.hz(), clock.tolerance_ppm()).serialize(serializer)
}

/// One of several displays: a fingertip.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DisplayInfo {
    /// Name of the display on the bench.
    pub name: String,
    /// Number of the display's wires, which follow those of the displays before it.
    pub wires: usize,
    /// Modules of the display, zero-based.
    pub modules: Vec<u16>,
}

/// Commands to the wires, counted entry by entry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Driven {
    /// Stimuli with a pulse.
    pub stimuli: u64,
    /// Times the guard applied something other than what was requested, or would have where it only observed.
    pub limiter_events: u32,
    /// Widest pulse, ticks.
    pub widest: u16,
}

impl Driven {
    /// Counts one entry of a schedule.
    pub fn add(&mut self, entry: &Entry) {
        let width = entry.width().get();
        self.stimuli += u64::from(width > 0);
        self.limiter_events += u32::from(entry.reason.is_some());
        self.widest = self.widest.max(width);
    }
}

/// Totals of a run that no single event carries, counted or measured while it goes, integers: every printed total
/// is one of these.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Ledger {
    /// Commands to the wires.
    pub driven: Driven,
    /// Electrical energy into all wires, microjoules.
    pub energy_uj: u64,
    /// Highest temperature of any wire, thousandths of a degree Celsius, and that wire.
    pub hottest_wire: Option<(i32, u16)>,
    /// True if a wire's bow was pulled straighter than its model knows.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub tight: bool,
    /// Every limit and the worst that came, measured behind the guard, the most used up first; empty where nothing
    /// measures it.
    #[serde(serialize_with = "billionths")]
    pub margins: Vec<Margin>,
    /// Simulated (or real) length of the run, microseconds.
    pub length_us: u64,
}

/// Margins as integers: their own form has numbers in the unit.
fn billionths<S: Serializer>(margins: &[Margin], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(
        margins
            .iter()
            .map(|m| (m.of.name(), m.worst_nano, m.limit_nano)),
    )
}

impl Ledger {
    /// The margin of one limit.
    pub fn margin(&self, of: Limited) -> Option<&Margin> {
        self.margins.iter().find(|m| m.of == of)
    }
}

/// A whole run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trace {
    /// Facts of the run.
    pub header: Header,
    /// Events of the run, sorted by time.
    pub events: Vec<Event>,
    /// Totals of the run.
    pub ledger: Ledger,
}

impl Trace {
    /// Every event of a kind, in the order of time.
    pub fn each<'a, K: EventKind + 'a>(&'a self) -> impl DoubleEndedIterator<Item = &'a K> + Clone {
        event::each(&self.events)
    }
}
