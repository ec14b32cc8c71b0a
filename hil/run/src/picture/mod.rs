//! What a page draws: a head once per session, a picture per step. Lengths in millimetres, times in microseconds.

mod head;
mod painter;

pub use head::style_word;
pub(crate) use painter::Memory;
pub use painter::Painter;

use palpate_core::guard::{Cause, Guard, Used};
use palpate_core::illusion::Map;
use palpate_core::projector::Projector;
use palpate_core::units::Instant;
use palpate_emulators::worn::{DisplayTotals, Standing};
use serde::Serialize;

use crate::display_end::DisplayEnd;

/// What is wanted of a look at a session, beside what costs nothing: each is a copy for every wire, and then work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wants {
    /// Temperatures, and the share of each limit.
    pub readings: bool,
    /// What the run came to so far.
    pub totals: bool,
}

impl Wants {
    /// Everything that no search is needed for.
    pub const READINGS: Self = Self {
        readings: true,
        totals: false,
    };
}

/// How things are at one moment, as far as no event says it. What takes time to compute is copied as it is, and computed
/// where it is read: a loop hands this on to a thread that has the time.
#[derive(Clone, Debug)]
pub struct State {
    /// The moment.
    pub now: Instant,
    /// From the skin to the display.
    pub map: Map,
    /// What the guard holds everything off for.
    pub stopped: Option<&'static str>,
    /// The newest onset's level over everything that is not measured, dB.
    pub band_db: Option<[f64; 2]>,
    /// The guard and when it was copied; none where its shares are not wanted, or no guard is asked, as of a recording.
    guard: Option<(Guard, Instant)>,
    /// The wires, where their temperatures or totals are wanted and measured.
    wires: Option<Standing>,
}

impl State {
    /// Of a recording, that has nothing but events.
    pub(crate) const fn recorded(now: Instant, map: Map) -> Self {
        Self {
            now,
            map,
            stopped: None,
            band_db: None,
            guard: None,
            wires: None,
        }
    }

    /// What the guard counts as used, where that is wanted.
    #[must_use]
    pub fn used(&self) -> Option<Used> {
        self.guard.as_ref().map(|(guard, at)| guard.used(*at))
    }

    /// Each wire and the skin under it, degrees C; empty where they are not wanted, or nothing measures them.
    fn warm(&self) -> Vec<[f64; 2]> {
        let wires = self.wires.as_ref();
        wires.map(Standing::warmth_c).unwrap_or_default()
    }

    /// What the run came to so far, where that is wanted and measured.
    fn totals(&self) -> Option<Totals> {
        let totals = self.wires.as_ref()?.totals()?;
        Some(totals.into())
    }
}

/// Peaks, dose and energy of a run so far.
#[derive(Clone, Copy, Debug)]
pub struct Totals {
    /// Skin 0.1 and 0.4 mm deep, hottest so far (degrees C), and dose (Omega, minutes at 43 C).
    pub hottest: [f64; 4],
    /// Electrical energy, J.
    pub energy_j: f64,
}

impl From<DisplayTotals> for Totals {
    fn from(totals: DisplayTotals) -> Self {
        let (omega, cem43) = totals.dose;
        Self {
            hottest: [totals.hottest_tissue_c, totals.hottest_deep_c, omega, cem43],
            energy_j: totals.electrical_j,
        }
    }
}

/// A look at a session between two turns: it changes nothing that the session does.
#[derive(Debug)]
pub struct Look<'a, D> {
    pub(crate) display: &'a D,
    pub(crate) projector: &'a Projector,
    pub(crate) now: Instant,
}

impl<D: DisplayEnd> Look<'_, D> {
    /// How things are, with what is wanted.
    pub fn state(&self, wants: Wants) -> State {
        let guard = self.projector.guard();
        State {
            now: self.now,
            map: *self.projector.map(),
            stopped: guard.latched().map(Cause::word),
            band_db: self.display.newest_band_db(),
            guard: wants.readings.then(|| (guard.clone(), self.now)),
            wires: (wants.readings || wants.totals)
                .then(|| self.display.standing(wants.totals))
                .flatten(),
        }
    }
}

/// What stays as it is while a session lasts.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)] // the keys say what they are, with their units
pub struct Head {
    pub scene: String,
    pub description: String,
    pub bench: String,
    pub source: &'static str,
    pub seed: u64,
    pub skin: String,
    pub display: String,
    pub illusion: &'static str,
    pub renderer: &'static str,
    pub person: String,
    pub wire: String,
    pub contacts_most: u32,
    pub observed: bool,
    pub rate_hz: f64,
    pub soa_us: u64,
    pub tau_d_us: u64,
    pub period_ns: u64,
    pub pwm_hz: f64,
    pub pitch_mm: f64,
    /// Before this time the reference is taken: nothing may touch.
    pub quiet_us: u64,
    /// When what the scene itself does is over; 0 where it does nothing.
    pub scene_us: u64,
    pub modules: Vec<ModuleHead>,
    pub drives: usize,
    pub wires_mm: Vec<[f32; 2]>,
    pub wire_mm: f64,
    /// Diameter, and the y at which the tip begins; none for a flat display.
    pub finger_mm: Option<[f64; 2]>,
    /// The widest pulse that the guard passes, of 4096.
    pub widest_ticks: u16,
    pub limits_c: LimitsC,
    /// The hottest wire and the hottest skin that the model knows, degrees C.
    pub model_c: [f64; 2],
}

/// A module that is shown.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct ModuleHead {
    pub number: usize,
    pub name: String,
    /// Where its own centre lies on the skin's plane.
    pub place_mm: [f32; 2],
    pub taxels_mm: Vec<[f32; 2]>,
}

/// Limits of the person's skin, degrees C.
#[derive(Clone, Copy, Debug, Serialize)]
#[allow(missing_docs)]
pub struct LimitsC {
    pub mean: f64,
    pub peak: f64,
    pub deep: f64,
}

/// What happened since the last picture, and how things are now.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct Picture {
    pub now_us: u64,
    /// The newest reading of every shown taxel, counts from rest; null for one that is left out.
    pub counts: Vec<Option<u32>>,
    pub frames: u32,
    pub contacts: Vec<Contact>,
    /// Every finger that presses on the driving module, where the display would show it; with its number.
    pub fingers: Vec<(usize, [f32; 2])>,
    /// What the scene itself presses with, on the skin's plane: x, y (mm), force (N), diameter (mm).
    pub spheres: Vec<[f64; 4]>,
    /// Wire and skin under it when they were last looked at, degrees C; NaN (in JSON null) where nothing measures them.
    pub warm: Vec<[f64; 2]>,
    /// Each limit's share then; empty where no guard is asked.
    pub used: Vec<(&'static str, f64)>,
    /// Skin 0.1 and 0.4 mm deep, hottest so far (degrees C), and dose (Omega, minutes at 43 C); none where nothing measures them.
    pub hottest: Option<[f64; 4]>,
    /// Electrical energy so far, J.
    pub energy_j: Option<f64>,
    pub bursts: Vec<Burst>,
    /// Outputs that changed: time (us), wire, whether on.
    pub edges: Vec<(f64, usize, bool)>,
    pub felt: Vec<Felt>,
    pub notes: Vec<(u64, &'static str, String)>,
    /// Whether the guard holds everything off.
    pub stopped: Option<&'static str>,
    /// Events that were lost because no page looked.
    pub dropped: u64,
}

/// A contact of the newest frame.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct Contact {
    pub id: u32,
    pub module: u16,
    pub at_mm: [f64; 2],
    /// Where the display shows it.
    pub on_mm: Option<[f32; 2]>,
    pub counts: f64,
    pub level: u16,
}

/// A stimulus that the guard decided on.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct Burst {
    pub at_us: u64,
    pub until_us: u64,
    pub wire: usize,
    /// Of 4096.
    pub ticks: u16,
    pub asked: u16,
    pub reason: Option<&'static str>,
}

/// What was felt of an onset.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct Felt {
    pub at_us: u64,
    pub target_mm: [f64; 2],
    pub inside: bool,
    /// None where no wire moved.
    pub at_mm: Option<[f64; 2]>,
    pub level_db: f64,
    /// Over everything that is not measured.
    pub band_db: Option<[f64; 2]>,
    pub tap: bool,
}
