//! Spread of the felt level and the felt error over quantities that nobody measured: wires taut or loose, the gain from
//! length to skin, and the person. Twelve corners; `docs/felt.md` gives the source of their ends.
//!
//! Stress and latent heat change temperatures, so each preset has wires of its own, through which the same currents
//! flow. Gain and thresholds only shift levels: both channels are linear, and no wire has a threshold of its own. A
//! loose wire leaves the skin as it does at the headline's gain.

use palpate_core::physics::{Bow, WireParameters};
use palpate_emulators::person::channels::{Felt, Levels, Person};
use palpate_emulators::worn::WornDisplay;
use palpate_files::{Setup, load_person};
use palpate_records::felt::FeltPath;
use palpate_records::trace::{Event, Header};
use serde::Serialize;

use crate::failure::Failure;
use crate::path_error::PathError;
use crate::plan;

/// Ends of the gain from a wire's length to the skin (`docs/wire.md`).
const GAINS: [f64; 2] = [2.4, 9.0];

/// The persons that ship.
const PERSONS: [&str; 3] = ["dull", "sensitive", "typical"];

/// Twelve corners of quantities that nobody measured, onset by onset.
pub(crate) struct Band {
    corners: Vec<Corner>,
    /// `true` where every onset is kept, for [`Self::finish`].
    whole: bool,
    /// Least and most level of the newest onset, dB.
    newest_db: Option<[f64; 2]>,
}

/// One corner: a preset, a gain and a person.
struct Corner {
    preset: &'static str,
    gain: f64,
    person: String,
    /// Index among the wires that are emulated beside the bench's; `None` where the bench's own have the preset's
    /// parameters.
    other: Option<usize>,
    /// Difference of both levels from the headline's, dB.
    shift: Levels,
    path: FeltPath,
}

impl Band {
    /// The corners for a setup. Wires of a preset that differs from the bench's are emulated beside the display's own.
    /// A run that is not `whole` keeps the newest onset alone.
    ///
    /// # Errors
    /// [`Failure::Input`] for a wire or person that cannot be.
    pub fn new(
        setup: &Setup,
        header: &Header,
        display: &mut WornDisplay,
        whole: bool,
    ) -> Result<Self, Failure> {
        let (wire, headline) = (plan::wire(setup), plan::emulated_person(setup));
        let impossible = |e| Failure::Input(format!("bench `{}`: {e}", setup.bench.value.name));
        let tissue = setup.bench.value.tissue.parameters();
        let gain = Bow::new(&wire, &tissue).map_err(impossible)?.gain;
        let persons = PERSONS
            .iter()
            .map(|&name| Ok((name, plan::on_bench(&load_person(name)?.value, setup))));
        let persons: Vec<(&str, Person)> = persons.collect::<Result<_, Failure>>()?;
        let (mut corners, mut others) = (Vec::new(), 0);
        let presets: [(_, WireParameters); 2] = [("taut", wire.taut()), ("loose", wire)];
        for (preset, parameters) in presets {
            let other = (parameters != wire).then_some(others);
            if other.is_some() {
                display.compare(&parameters, headline).map_err(impossible)?;
                others += 1;
            }
            for end in GAINS {
                for (name, person) in &persons {
                    corners.push(Corner {
                        preset,
                        gain: end,
                        person: (*name).to_owned(),
                        other,
                        shift: shift(end / gain, &headline, person),
                        path: FeltPath::new(header),
                    });
                }
            }
        }
        Ok(Self {
            corners,
            whole,
            newest_db: None,
        })
    }

    /// Least and most level over threshold of the newest onset in all corners, dB, where it moved a wire.
    pub const fn newest_db(&self) -> Option<[f64; 2]> {
        self.newest_db
    }

    /// Adds an onset that is over. `event` makes the onset's event from a sensation; `met` is the sensation by the
    /// headline's wires, `others` those by the wires beside.
    pub fn add(
        &mut self,
        event: impl Fn(Option<&Felt>) -> Event,
        met: Option<&Felt>,
        others: &[Option<Felt>],
    ) {
        self.newest_db = None;
        for corner in &mut self.corners {
            let met = match corner.other {
                None => met.copied(),
                Some(other) => others.get(other).copied().flatten(),
            };
            let met = met.map(|met| Felt {
                levels: Levels {
                    vibration_db: met.levels.vibration_db + corner.shift.vibration_db,
                    flutter_db: met.levels.flutter_db + corner.shift.flutter_db,
                    np2_db: met.levels.np2_db + corner.shift.np2_db,
                },
                ..met
            });
            if let Some(db) = met.map(|met| met.levels.db()) {
                let [low, high] = self.newest_db.unwrap_or([db; 2]);
                self.newest_db = Some([low.min(db), high.max(db)]);
            }
            if self.whole {
                corner.path.add(&event(met.as_ref()));
            }
        }
    }

    /// Band of a run; `known` where it has a true path. `None` where no contact was inside the display.
    pub fn finish(&self, known: bool) -> Option<FeltBand> {
        let corners = self.corners.iter().map(|corner| {
            let [energy, amplitude] = corner
                .path
                .scores()
                .map(|score| score.errors.filter(|_| known).map(PathError::from));
            Some(FeltCorner {
                preset: corner.preset,
                gain: corner.gain,
                person: corner.person.clone(),
                level_db: f64::from(corner.path.level()?.median_mdb) * 1e-3,
                error_energy_mm: energy,
                error_amplitude_mm: amplitude,
            })
        });
        let corners: Vec<FeltCorner> = corners.collect::<Option<_>>()?;
        let errors = corners
            .iter()
            .flat_map(|c| [c.error_energy_mm, c.error_amplitude_mm]);
        Some(FeltBand {
            level_db: ends(corners.iter().map(|c| c.level_db))?,
            error_mm: ends(errors.flatten().map(|e| e.rmse)),
            corners,
        })
    }
}

/// Shift of both levels by a gain `gain` times as large and another person's thresholds, dB.
fn shift(gain: f64, headline: &Person, person: &Person) -> Levels {
    let decibels = |ratio: f64| 20.0 * libm::log10(gain * ratio);
    Levels {
        vibration_db: decibels(headline.vibration_um / person.vibration_um),
        flutter_db: decibels(headline.flutter_um / person.flutter_um),
        np2_db: match (headline.np2_um, person.np2_um) {
            (Some(headline), Some(person)) => decibels(headline / person),
            _ => Levels::SILENT.np2_db,
        },
    }
}

/// Least and largest of the values; `None` for none.
fn ends(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |ends, value| {
        let [low, high] = ends.unwrap_or([value; 2]);
        Some([low.min(value), high.max(value)])
    })
}

/// Felt levels and errors over all twelve corners.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FeltBand {
    /// Least and most of the corners' median levels over threshold, dB.
    pub level_db: [f64; 2],
    /// Least and most error of the corners by either centroid, RMSE, mm; null where no true path is known.
    pub error_mm: Option<[f64; 2]>,
    /// Every corner's figures.
    pub corners: Vec<FeltCorner>,
}

/// Figures of one corner.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // the keys say what they are, with their units
pub struct FeltCorner {
    /// Preset of the wires: `taut` or `loose`, on the bench's own geometry.
    pub preset: &'static str,
    /// Displacement of the skin over change of the wire's length, 1.
    pub gain: f64,
    pub person: String,
    /// Median level over the onsets with a contact inside the display, dB.
    pub level_db: f64,
    pub error_energy_mm: Option<PathError>,
    pub error_amplitude_mm: Option<PathError>,
}

#[cfg(test)]
#[path = "band_tests.rs"]
mod tests;
