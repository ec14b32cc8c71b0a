//! Data that a page draws: a head once per session, a picture per step. Lengths in millimetres, times in microseconds.

mod head;
mod painter;

pub(crate) use painter::Memory;
pub use painter::Painter;

use palpate_core::guard::{Cause, Guard};
use palpate_core::illusion::Map;
use palpate_core::projector::Projector;
use palpate_core::units::Instant;
use palpate_emulators::worn::{DisplayTotals, Standing};
use serde::Serialize;

use crate::display_end::DisplayEnd;

/// Used share of each limit of a guard at a time, by the limit's key.
#[must_use]
pub fn used(guard: &Guard, at: Instant) -> Vec<(&'static str, f64)> {
    let of_wires = || guard.used(at).rows().to_vec();
    let of_motors = guard.motors_used(at);
    of_motors.map_or_else(of_wires, |rows| rows.to_vec())
}

/// Costly parts of a session's [`State`] to copy: each is a copy for every wire, and then work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wants {
    /// Temperatures, and the share of each limit.
    pub readings: bool,
    /// Totals of the run so far.
    pub totals: bool,
}

impl Wants {
    /// All parts that need no search.
    pub const READINGS: Self = Self {
        readings: true,
        totals: false,
    };
}

/// State of a session at one moment, as far as no event tells it. Figures that take time to compute are copied raw and
/// computed where they are read: a loop hands the state to a thread that has the time.
#[derive(Clone, Debug)]
pub struct State {
    /// Moment of the state.
    pub now: Instant,
    /// Map from the skin to the display.
    pub map: Map,
    /// Word of the cause for which the guard holds everything off; `None` where it does not.
    pub stopped: Option<&'static str>,
    /// The guard and when it was copied; none where its shares are not wanted, or no guard is asked, as of a recording.
    guard: Option<(Guard, Instant)>,
    /// The wires, where their temperatures or totals are wanted and measured.
    wires: Option<Standing>,
}

impl State {
    /// State of a recording, which has events alone.
    pub(crate) const fn recorded(now: Instant, map: Map) -> Self {
        Self {
            now,
            map,
            stopped: None,
            guard: None,
            wires: None,
        }
    }

    /// Used share of each limit of the guard, where they are wanted.
    #[must_use]
    pub fn used(&self) -> Option<Vec<(&'static str, f64)>> {
        let looked = self.guard.as_ref();
        looked.map(|(guard, at)| used(guard, *at))
    }

    /// Each wire and the skin under it, degrees C; empty where they are not wanted, or nothing measures them.
    fn warm(&self) -> Vec<[f64; 2]> {
        let wires = self.wires.as_ref();
        wires.map(Standing::warmth_c).unwrap_or_default()
    }

    /// Totals of the run so far, where they are wanted and measured.
    fn totals(&self) -> Option<DisplayTotals> {
        self.wires.as_ref()?.totals()
    }
}

/// A look at a session between two turns: the session goes on unchanged.
#[derive(Debug)]
pub struct Look<'a, D> {
    pub(crate) display: &'a D,
    pub(crate) projector: &'a Projector,
    pub(crate) now: Instant,
}

impl<D: DisplayEnd> Look<'_, D> {
    /// Takes the state, with the parts that are wanted.
    pub fn state(&self, wants: Wants) -> State {
        let guard = self.projector.guard();
        State {
            now: self.now,
            map: *self.projector.map(),
            stopped: guard.latched().map(Cause::word),
            guard: wants.readings.then(|| (guard.clone(), self.now)),
            wires: (wants.readings || wants.totals)
                .then(|| self.display.standing(wants.totals))
                .flatten(),
        }
    }
}

/// Facts of a session that stay the same while it lasts.
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
    /// `true` where motors take the place of wires.
    pub motors: bool,
    pub contacts_most: u32,
    pub observed: bool,
    pub rate_hz: f64,
    pub soa_us: u64,
    pub tau_d_us: u64,
    pub period_ns: u64,
    pub pwm_hz: f64,
    pub pitch_mm: f64,
    /// Time before which the reference is taken: nothing may touch.
    pub quiet_us: u64,
    /// Time at which the scene itself is over; 0 for one without touches, strokes, faults and texture.
    pub scene_us: u64,
    pub modules: Vec<ModuleHead>,
    pub drives: usize,
    pub wires_mm: Vec<[f32; 2]>,
    /// Length of a wire, or diameter of a motor's face.
    pub wire_mm: f64,
    /// Diameter, and the y at which the tip begins; none for a flat display.
    pub finger_mm: Option<[f64; 2]>,
    /// The widest pulse that the guard passes, or a motor's highest level, of 4096.
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
    /// Centre of the module on the skin's plane.
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

/// Events since the last picture, and the state now.
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
    /// The scene's own touches on the skin's plane: x, y (mm), force (N), diameter (mm).
    pub spheres: Vec<[f64; 4]>,
    /// Wire and skin under it when they were last looked at, degrees C; NaN (in JSON null) where nothing measures them.
    pub warm: Vec<[f64; 2]>,
    /// Used share of each limit at that look; empty where no guard is asked.
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
    /// Word of the cause for which the guard holds everything off; null where it does not.
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
    /// Place on the display, where it shows the contact.
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
    /// Width of a pulse, 4096ths of a period.
    pub ticks: u16,
    pub asked: u16,
    pub reason: Option<&'static str>,
}

/// Sensation of an onset.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct Felt {
    pub at_us: u64,
    pub target_mm: [f64; 2],
    pub inside: bool,
    /// Felt place; null where no wire moved.
    pub at_mm: Option<[f64; 2]>,
    pub level_db: f64,
    /// Level at 5 and 95 % of all that is not measured of the bench, dB; null where that is not computed.
    pub band_db: Option<[f64; 2]>,
    pub tap: bool,
}
