//! The run through wires in either state: those of the bench as they began, and the same wires in the other state.
//!
//! Heat moves phases, so the other wires are emulated beside, and the same currents flow through them.

use palpate_core::physics::{History, WireParameters, WireState};
use palpate_core::units::Point;
use palpate_emulators::person::channels::Felt;
use palpate_emulators::worn::{Aside, WornDisplay};
use palpate_files::Setup;
use palpate_records::felt::FeltPath;
use palpate_records::trace::{Event, FeltAt, Header, PlaceUm, event};
use serde::Serialize;

use crate::path_error::PathError;
use crate::plan;

/// Figures of a run in each state of its wires, onset by onset.
pub(crate) struct States {
    own: Path,
    /// `None` where the model has no rest for wires in the other state.
    other: Option<Path>,
    /// Onsets of the run so far.
    onsets: usize,
    /// Onsets that count, each with its event by the bench's wires.
    counted: Vec<(usize, event::Felt)>,
}

/// Felt path of one state.
struct Path {
    state: &'static str,
    felt: FeltPath,
}

/// Figures of a run in one state of its wires.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // the keys say what they are, with their units
pub struct FeltState {
    /// State in which the wires began, `cold` or `passed`.
    pub state: &'static str,
    /// Median level over the onsets with a contact inside the display, dB.
    pub level_db: f64,
    pub error_energy_mm: Option<PathError>,
    pub error_amplitude_mm: Option<PathError>,
}

impl States {
    /// Both states of a setup's wires. Those in the other state are put beside the display's own.
    pub fn new(
        setup: &Setup,
        header: &Header,
        (display, aside): (&mut WornDisplay, Option<Aside>),
    ) -> Self {
        let wire = plan::wire(setup);
        let history = wire.history;
        let path = |state| Path {
            state: match state {
                WireState::Cold => "cold",
                WireState::Passed => "passed",
            },
            felt: FeltPath::new(header),
        };
        let state = match history.state {
            WireState::Cold => WireState::Passed,
            WireState::Passed => WireState::Cold,
        };
        let turned = WireParameters {
            history: History {
                state,
                coldest_c: None,
                ..history
            },
            ..wire
        };
        let person = plan::emulated_person(setup);
        let is_known = display.compare(&turned, person, aside).is_ok();
        Self {
            own: path(history.state),
            other: is_known.then(|| path(state)),
            onsets: 0,
            counted: Vec::new(),
        }
    }

    /// Counts an onset that is over.
    pub const fn onset(&mut self) {
        self.onsets += 1;
    }

    /// Adds the newest onset: its event by the bench's wires.
    pub fn add(&mut self, event: event::Felt) {
        self.own.felt.add(&Event::Felt(event));
        if self.other.is_some() {
            self.counted.push((self.onsets - 1, event));
        }
    }

    /// Figures of both states, the other one by the stimuli that wires in it gave, onset by onset; `known` where the run has a
    /// true path. Empty where no contact was inside the display.
    pub fn finish(mut self, known: bool, other: &[Option<Felt>]) -> Vec<FeltState> {
        // Where their computation ended early, nothing is known of the other wires.
        self.other = self.other.filter(|_| other.len() == self.onsets);
        if let Some(path) = &mut self.other {
            for (onset, event) in self.counted {
                let met = other.get(onset).and_then(Option::as_ref);
                path.felt.add(&Event::Felt(event::Felt {
                    met: met.map(felt_at),
                    ..event
                }));
            }
        }
        let paths = std::iter::once(&self.own).chain(&self.other);
        paths.filter_map(|path| path.finish(known)).collect()
    }
}

impl Path {
    fn finish(&self, known: bool) -> Option<FeltState> {
        let scores = self.felt.scores();
        let [energy, amplitude] =
            scores.map(|score| score.errors.filter(|_| known).map(PathError::from));
        Some(FeltState {
            state: self.state,
            level_db: f64::from(self.felt.level()?.median_mdb) * 1e-3,
            error_energy_mm: energy,
            error_amplitude_mm: amplitude,
        })
    }
}

/// A sensation as a trace has it.
pub(super) fn felt_at(met: &Felt) -> FeltAt {
    let place = |(x, y): (f64, f64)| PlaceUm::from(Point::new(x as f32, y as f32));
    FeltAt {
        energy: place(met.energy_mm),
        amplitude: place(met.amplitude_mm),
        level_mdb: (met.levels.db() * 1e3).round() as i32,
        skin_nm: (met.skin_um * 1e3).round() as i32,
        tap: met.tap(),
    }
}
