//! Events of a run.

use palpate_core::schedule::{Entry, Reason};
use palpate_core::units::{Instant, Point};
use serde::{Serialize, Serializer};

/// A place in micrometres: origin at the centre, x right, y up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PlaceUm {
    /// Micrometres to the right.
    pub x: i32,
    /// Micrometres up.
    pub y: i32,
}

impl From<Point> for PlaceUm {
    /// Converts a place in millimetres, rounded.
    fn from(p: Point) -> Self {
        let um = |mm: f32| (f64::from(mm) * 1e3).round() as i32;
        Self {
            x: um(p.x),
            y: um(p.y),
        }
    }
}

/// Stimulus of an onset at the finger: place by the two centroids, and level over threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FeltAt {
    /// Mean of the wires' places weighted by energy.
    pub energy: PlaceUm,
    /// Mean of the wires' places weighted by amplitude.
    pub amplitude: PlaceUm,
    /// Level of all wires together over threshold, thousandths of a decibel.
    pub level_mdb: i32,
    /// Displacement of the skin under the wire that moves it most, from end to end, thousandths of a micrometre.
    pub skin_nm: i32,
    /// `true` for a stimulus so short that it feels like a tap.
    pub tap: bool,
}

impl FeltAt {
    /// Tells whether the stimulus is felt: the level is not below 0 dB.
    pub const fn is_felt(&self) -> bool {
        self.level_mdb >= 0
    }
}

/// Energy of an onset in thousandths of one wire's at full drive for the same level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct EnergyPermille {
    /// Energy by the widths that the illusion asked for.
    pub requested: u32,
    /// Energy by the widths that the guard applied.
    pub applied: u32,
    /// Energy by the wires' motion, as the filter of a person's skin lets
    /// it through; that of one wire alone and from rest is a thousand.
    pub felt: u32,
}

/// A complete sensor scan went through the core.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Frame {
    /// End of the scan.
    pub t_us: u64,
    /// Zero-based frame number.
    pub frame: u32,
    /// Taxels above the contact threshold.
    pub in_contact: u16,
    /// Largest relative reading (Euclidean norm over the axes), raw counts rounded.
    pub peak_counts: u32,
}

/// A contact the compression found in that frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Contact {
    /// End of the scan.
    pub t_us: u64,
    /// Frame number.
    pub frame: u32,
    /// Module it lies on.
    pub module: u16,
    /// Stable identity.
    pub contact: u32,
    /// Place on the sensor.
    pub place: PlaceUm,
    /// Interpolated intensity, thousandths of a raw count.
    pub intensity_milli: u32,
    /// Level, 1 ..= K_I.
    pub level: u16,
    /// Taxels in its cluster.
    pub members: u32,
}

/// True place of a touch on the skin at the frame's time (emulated skins know).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Truth {
    /// End of the scan.
    pub t_us: u64,
    /// Place on the sensor.
    pub place: PlaceUm,
    /// Normal force, millinewtons.
    pub force_mn: u32,
}

/// A board's PRE_SCALE was set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PreScale {
    /// Time of the change, microseconds.
    pub t_us: u64,
    /// Board.
    pub board: u8,
    /// Register value.
    pub pre_scale: u8,
}

/// Every output of a board was switched off at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct AllOff {
    /// Time of the all-off, microseconds.
    pub t_us: u64,
    /// Board.
    pub board: u8,
    /// Cause, one word or a few with hyphens.
    pub cause: &'static str,
}

/// An output changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Edge {
    /// Time of the edge, nanoseconds.
    pub t_ns: u64,
    /// Board.
    pub board: u8,
    /// Channel.
    pub channel: u8,
    /// New state.
    pub high: bool,
}

/// Sensation of a person at one onset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Felt {
    /// Time of the onset, microseconds.
    pub t_us: u64,
    /// Place of the contact, mapped to the display.
    pub target: PlaceUm,
    /// `true` where that place lies inside the display's hull.
    pub inside: bool,
    /// Stimulus at the finger, felt or not; `None` where no wire moved.
    pub met: Option<FeltAt>,
    /// Energy of all wires together.
    pub energy: EnergyPermille,
}

impl Felt {
    /// Tells whether anything of the onset is felt.
    pub fn is_felt(&self) -> bool {
        self.met.is_some_and(|met| met.is_felt())
    }

    /// Tells whether the contact lies inside the display and nothing is felt.
    pub fn is_break(&self) -> bool {
        self.inside && !self.is_felt()
    }
}

/// A temperature at a wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Temperature {
    /// Time of the temperature, microseconds.
    pub t_us: u64,
    /// Wire index in the display's layout.
    pub wire: u16,
    /// Thousandths of a degree Celsius.
    pub milli_c: i32,
}

/// A Peltier module under the fingertip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Face {
    /// Time of the temperatures, microseconds.
    pub t_us: u64,
    /// Temperature of the face on the skin, thousandths of a degree Celsius.
    pub face_mc: i32,
    /// Temperature that the control aims at now, thousandths of a degree Celsius; `None` while nothing is driven.
    pub aim_mc: Option<i32>,
    /// Temperature of the sink, thousandths of a degree Celsius.
    pub sink_mc: i32,
    /// Current through the module, mA; positive cools the face.
    pub milliamps: i32,
}

/// A joint's angle when a scan ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Joint {
    /// End of the scan.
    pub t_us: u64,
    /// Index among the header's joints.
    pub joint: u16,
    /// Thousandths of a degree.
    pub milli_deg: i32,
}

/// A window of texture ended: where it lies in the latent space, and what that asks of the wires.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Latent {
    /// End of the window.
    pub t_us: u64,
    /// The latent vector z, thousandths.
    pub z_milli: Vec<i32>,
    /// Roughness of that vector, thousandths.
    pub rough_permille: u16,
    /// f_PWM of (3.2), millihertz.
    pub rate_mhz: u32,
}

/// Anything worth a line: a fault, a taxel left out, a degraded bus.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Note {
    /// Time of the line, microseconds.
    pub t_us: u64,
    /// The line.
    pub text: String,
}

/// Something that happened. Times are microseconds since the start of the run unless they say `ns`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub enum Event {
    /// A complete sensor scan went through the core.
    Frame(Frame),
    /// A contact the compression found in that frame.
    Contact(Contact),
    /// True place of a touch on the skin at the frame's time.
    Truth(Truth),
    /// A channel was given a pulse train, or refused one. The end of one is its `until`; it makes no event.
    Schedule(#[serde(serialize_with = "plain")] Entry),
    /// A board's PRE_SCALE was set.
    PreScale(PreScale),
    /// Every output of a board was switched off at once.
    AllOff(AllOff),
    /// An output changed.
    Edge(Edge),
    /// Sensation of a person at one onset.
    Felt(Felt),
    /// Temperature of a wire.
    Wire(Temperature),
    /// Temperature of the skin under a wire, at the guard's depth of 0.1 mm.
    Skin(Temperature),
    /// A Peltier module under the fingertip.
    Face(Face),
    /// A joint's angle when a scan ended.
    Joint(Joint),
    /// A window of texture ended.
    Latent(Latent),
    /// Anything worth a line.
    Note(Note),
}

/// An entry as integers and words.
fn plain<S: Serializer>(entry: &Entry, serializer: S) -> Result<S::Ok, S::Error> {
    // Taken apart by pattern: a new field does not compile until it is written.
    let Entry {
        at,
        board,
        channel,
        on,
        off,
        until,
        requested,
        requested_until,
        current,
        reason,
    } = *entry;
    let times = [at, until, requested_until].map(Instant::as_micros);
    let ticks = [on, off, requested.get()];
    let current = current.map(|current| current.0);
    let reason = reason.map(Reason::word);
    (times, board.0, channel.0, ticks, current, reason).serialize(serializer)
}

impl Event {
    /// A line.
    pub const fn note(at: Instant, text: String) -> Self {
        let t_us = at.as_micros();
        Self::Note(Note { t_us, text })
    }

    /// Time of the event, nanoseconds.
    pub fn t_ns(&self) -> u64 {
        let t_us = match self {
            Self::Edge(e) => return e.t_ns,
            Self::Schedule(e) => e.at.as_micros(),
            Self::Frame(e) => e.t_us,
            Self::Contact(e) => e.t_us,
            Self::Truth(e) => e.t_us,
            Self::PreScale(e) => e.t_us,
            Self::AllOff(e) => e.t_us,
            Self::Felt(e) => e.t_us,
            Self::Wire(e) | Self::Skin(e) => e.t_us,
            Self::Face(e) => e.t_us,
            Self::Joint(e) => e.t_us,
            Self::Latent(e) => e.t_us,
            Self::Note(e) => e.t_us,
        };
        t_us.saturating_mul(1000)
    }
}

/// Content of the events of one variant.
pub trait EventKind: Sized {
    /// Content of this event; `None` for an event of another variant.
    fn content(event: &Event) -> Option<&Self>;
}

macro_rules! kinds {
    ($($variant:ident($kind:ty))*) => {$(
        impl EventKind for $kind {
            fn content(event: &Event) -> Option<&Self> {
                match event {
                    Event::$variant(own) => Some(own),
                    _ => None,
                }
            }
        }
    )*};
}

kinds! {
    Frame(Frame) Contact(Contact) Truth(Truth) Schedule(Entry) AllOff(AllOff) Edge(Edge) Felt(Felt)
    Face(Face) Joint(Joint) Latent(Latent) Note(Note)
}

/// Every one of these events that is of a kind, in their order.
pub fn each<'a, K: EventKind + 'a>(
    events: &'a [Event],
) -> impl DoubleEndedIterator<Item = &'a K> + Clone {
    events.iter().filter_map(K::content)
}

/// Sorts events by their time; those of one time stay in their order.
pub fn sort_by_time(events: &mut [Event]) {
    events.sort_by_key(Event::t_ns);
}
