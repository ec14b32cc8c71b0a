//! The canonical trace: everything a run did, in integers, in order. Schedule, contacts and
//! goldens read this and nothing else, so a golden, a report and a schedule file cannot tell different stories.

use crate::margin::{Limited, Margin};
use palpate_core::schedule::Entry;
use palpate_core::units::{Point, Prescale};
use serde::Serialize;

/// Version of the trace's meaning; grows when a field changes what it says.
pub const VERSION: u32 = 5;

/// Whether hardware took part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// Both ends were emulators.
    Emulated,
    /// At least one end was real.
    Real,
    /// Both ends were emulators, and the guard only looked on.
    Observed,
}

/// What everything says that comes of a run which the guard only observed.
pub const OBSERVED: &str = "observed: the guard changed nothing; not for a person";

impl Source {
    /// Every source.
    const ALL: [Self; 3] = [Self::Emulated, Self::Real, Self::Observed];

    /// As records say it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Emulated => "emulated",
            Self::Real => "real",
            Self::Observed => "observed",
        }
    }

    /// The source of this word.
    pub fn of(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|source| source.word() == word)
    }

    /// Whether nothing of it was hardware.
    pub const fn is_emulated(self) -> bool {
        !matches!(self, Self::Real)
    }

    /// What has to stand beside it, if anything has.
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

/// A place in micrometres: origin at the centre, x right, y up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PlaceUm {
    /// Micrometres to the right.
    pub x: i32,
    /// Micrometres up.
    pub y: i32,
}

impl From<Point> for PlaceUm {
    /// Of a place in millimetres, rounded.
    fn from(p: Point) -> Self {
        let um = |mm: f32| (f64::from(mm) * 1e3).round() as i32;
        Self {
            x: um(p.x),
            y: um(p.y),
        }
    }
}

/// What a person meets of an onset: where, by the two centroids, and how far over threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FeltAt {
    /// Mean of the wires' places weighted by energy.
    pub energy: PlaceUm,
    /// The same weighted by amplitude.
    pub amplitude: PlaceUm,
    /// How far over threshold all wires together are, thousandths of a decibel.
    pub level_mdb: i32,
    /// Whether the stimulus is so short that it feels like a tap.
    pub tap: bool,
}

impl FeltAt {
    /// Whether it is felt: the level is not below 0 dB.
    pub const fn is_felt(&self) -> bool {
        self.level_mdb >= 0
    }
}

/// Energy of an onset in thousandths of one wire's at full drive for the same level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct EnergyPermille {
    /// By the widths that the illusion asked for.
    pub requested: u32,
    /// By the widths that the guard applied.
    pub applied: u32,
    /// By the wires' motion, as the filter of a person's skin lets it through; that of one wire alone and from rest is a
    /// thousand.
    pub felt: u32,
}

/// One wire of the display and the output that drives it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct WireInfo {
    /// Where it lies on the unrolled display.
    pub place: PlaceUm,
    /// Board that drives it.
    pub board: u8,
    /// Channel of that board.
    pub channel: u8,
}

/// What was run, on what, under which limits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    /// Emulated or real.
    pub source: Source,
    /// Scene name, or the replayed file's name.
    pub scene: String,
    /// Bench name.
    pub bench: String,
    /// Seed of every random stream.
    pub seed: u64,
    /// SHA-256 of the scene file, first 16 hex digits.
    pub scene_digest: String,
    /// SHA-256 of the limit table in force, first 16 hex digits.
    pub limits_digest: String,
    /// PRE_SCALE of every board: with it the true PWM frequency.
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
    /// Whether a Peltier module is under the fingertip.
    pub warmth: bool,
}

/// One of several displays: a fingertip.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DisplayInfo {
    /// Its name on the bench.
    pub name: String,
    /// How many of the wires are its own: those after the wires of the displays before it.
    pub wires: usize,
    /// Its modules, zero-based.
    pub modules: Vec<u16>,
}

/// Something that happened. Times are microseconds since the start of the run unless they say `ns`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// A complete sensor scan went through the core.
    Frame {
        /// End of the scan.
        t_us: u64,
        /// Zero-based frame number.
        frame: u32,
        /// Taxels above the contact threshold.
        in_contact: u16,
        /// Largest relative reading (Euclidean norm over the axes), raw counts rounded.
        peak_counts: u32,
    },
    /// A contact the compression found in that frame.
    Contact {
        /// End of the scan.
        t_us: u64,
        /// Frame number.
        frame: u32,
        /// Module it lies on.
        module: u16,
        /// Stable identity.
        contact: u32,
        /// Place on the sensor.
        place: PlaceUm,
        /// Interpolated intensity, thousandths of a raw count.
        intensity_milli: u32,
        /// Level, 1 ..= K_I.
        level: u16,
        /// Taxels in its cluster.
        members: u32,
    },
    /// Where something truly touched the skin at the frame's time (emulated skins know).
    Truth {
        /// End of the scan.
        t_us: u64,
        /// Place on the sensor.
        place: PlaceUm,
        /// Normal force, millinewtons.
        force_mn: u32,
    },
    /// A channel was given a pulse train, or refused one. The end of one is its `until`; it makes no event.
    Schedule(Entry),
    /// A board's PRE_SCALE was set.
    PreScale {
        /// When.
        t_us: u64,
        /// Board.
        board: u8,
        /// Register value.
        pre_scale: u8,
    },
    /// Every output of a board was switched off at once.
    AllOff {
        /// When.
        t_us: u64,
        /// Board.
        board: u8,
        /// Why, one word or a few with hyphens.
        cause: &'static str,
    },
    /// An output changed.
    Edge {
        /// When, nanoseconds.
        t_ns: u64,
        /// Board.
        board: u8,
        /// Channel.
        channel: u8,
        /// New state.
        high: bool,
    },
    /// What a person would feel of one onset.
    Felt {
        /// The onset.
        t_us: u64,
        /// Where the contact was, mapped to the display.
        target: PlaceUm,
        /// Whether that place lies inside the display's hull.
        inside: bool,
        /// What is met of it, felt or not; `None` where no wire moved.
        met: Option<FeltAt>,
        /// Energy of all wires together.
        energy: EnergyPermille,
    },
    /// Temperature of a wire.
    Wire {
        /// When.
        t_us: u64,
        /// Wire index in the display's layout.
        wire: u16,
        /// Thousandths of a degree Celsius.
        milli_c: i32,
    },
    /// Temperature of the skin under a wire, at the guard's depth of 0.1 mm.
    Skin {
        /// When.
        t_us: u64,
        /// Wire index in the display's layout.
        wire: u16,
        /// Thousandths of a degree Celsius.
        milli_c: i32,
    },
    /// A Peltier module under the fingertip.
    Face {
        /// When.
        t_us: u64,
        /// Its face on the skin, thousandths of a degree Celsius.
        face_mc: i32,
        /// What the face is to be now, thousandths of a degree Celsius; `None` while nothing is driven.
        aim_mc: Option<i32>,
        /// Its sink, thousandths of a degree Celsius.
        sink_mc: i32,
        /// Its current, mA; positive cools the face.
        milliamps: i32,
    },
    /// A joint's angle when a scan ended.
    Joint {
        /// End of the scan.
        t_us: u64,
        /// Which of the header's joints.
        joint: u16,
        /// Thousandths of a degree.
        milli_deg: i32,
    },
    /// A window of texture ended: where it lies in the latent space, and what that asks of the wires.
    Latent {
        /// End of the window.
        t_us: u64,
        /// The latent vector z, thousandths.
        z_milli: Vec<i32>,
        /// How rough that is, thousandths.
        rough_permille: u16,
        /// f_PWM of (3.2), millihertz.
        rate_mhz: u32,
    },
    /// Anything worth a line: a fault, a taxel left out, a degraded bus.
    Note {
        /// When.
        t_us: u64,
        /// The line.
        text: String,
    },
}

/// Sorts events by their time; those of one time stay in their order.
pub fn sort_by_time(events: &mut [Event]) {
    events.sort_by_key(Event::t_ns);
}

impl Event {
    /// When it happened, nanoseconds.
    pub fn t_ns(&self) -> u64 {
        match self {
            Self::Edge { t_ns, .. } => *t_ns,
            Self::Schedule(entry) => entry.at.as_micros().saturating_mul(1000),
            Self::Frame { t_us, .. }
            | Self::Contact { t_us, .. }
            | Self::Truth { t_us, .. }
            | Self::PreScale { t_us, .. }
            | Self::AllOff { t_us, .. }
            | Self::Felt { t_us, .. }
            | Self::Wire { t_us, .. }
            | Self::Skin { t_us, .. }
            | Self::Face { t_us, .. }
            | Self::Joint { t_us, .. }
            | Self::Latent { t_us, .. }
            | Self::Note { t_us, .. } => t_us.saturating_mul(1000),
        }
    }
}

/// What the wires were told, counted entry by entry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ledger {
    /// What the wires were told.
    pub driven: Driven,
    /// Electrical energy into all wires, microjoules.
    pub energy_uj: u64,
    /// Hottest any wire was, thousandths of a degree Celsius, and which wire.
    pub hottest_wire: Option<(i32, u16)>,
    /// Every limit and the worst that came, measured behind the guard, the most used up first; empty where nothing
    /// measures it.
    pub margins: Vec<Margin>,
    /// Simulated (or real) length of the run, microseconds.
    pub length_us: u64,
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
    /// What was run.
    pub header: Header,
    /// What happened, sorted by time.
    pub events: Vec<Event>,
    /// What it came to.
    pub ledger: Ledger,
}
