//! Felt part of a summary: level and displacement per onset, errors over all onsets and inside the wires.

use palpate_core::projector::Projector;
use palpate_files::Scene;
use palpate_records::felt::{FeltBand, FeltPath};
use palpate_records::measure::Errors;
use palpate_records::trace::Header;
use serde::Serialize;

use crate::path_error::PathError;
use crate::plan;
use crate::states::FeltState;

/// Felt level over threshold, and the person who felt it: the headline.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // the keys say what they are, with their units
pub struct FeltSummary {
    /// The emulated person.
    pub person: String,
    /// The wires' file.
    pub preset: String,
    /// Level over the onsets with a contact inside the display; null where there was none.
    pub level_db: Option<LevelDb>,
    /// Largest displacement of the skin under any wire per onset, over the same onsets as the level.
    pub skin_um: Option<SkinUm>,
    /// Error over all onsets by the energy centroid, with the contact inside the wires' hull or not.
    pub error_energy_all_mm: Option<CountedError>,
    pub error_amplitude_all_mm: Option<CountedError>,
    /// Error over the onsets inside the hull alone.
    pub error_energy_mm: Option<PathError>,
    pub error_amplitude_mm: Option<PathError>,
    /// Number of onsets of those errors.
    pub onsets_inside: u64,
    /// Onsets with a contact inside the display and a level below threshold; null where no onset had a contact there.
    pub breaks: Option<u64>,
    /// Jumps by the energy centroid; null as breaks.
    pub jumps: Option<u64>,
    /// Onsets that feel like taps.
    pub taps: u64,
    /// Level that the scene asks for; null where it asks for none.
    pub asked: Option<AskedLevel>,
    /// Level that one wire at the limits lacks for this person to feel it, dB; null where something is felt.
    pub missing_db: Option<f64>,
    /// Levels and errors of the bench over all that is not measured; null where it has no file that holds.
    pub band: Option<FeltBand>,
    /// Reason why there is no band, with the command that makes one; null where there is one, or nothing shows it.
    pub no_band: Option<String>,
    /// State in which the wires began; left out of a summary over several displays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state: Option<&'static str>,
    /// The run in each state of its wires; left out where nothing shows it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub states: Vec<FeltState>,
}

/// A level that a scene asks for, and the level that heat leaves: all in dB over the threshold that the loop believes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AskedLevel {
    /// Asked level of a contact at the top level.
    pub level_db: f64,
    /// Level that the limits sustain for ten minutes, by their arithmetic, of a contact that moves over all wires.
    pub moving_db: f64,
    /// Level that the limits sustain for ten minutes of a contact at rest on one wire.
    pub resting_db: f64,
    /// Onsets with a contact on the display.
    pub onsets: u64,
    /// Onsets that heat made weaker by more than a just noticeable difference.
    pub weaker: u64,
    /// The least level that was left.
    pub least_db: f64,
}

impl AskedLevel {
    /// Asked level of a run that is over; `None` where the scene asks for none.
    #[must_use]
    pub fn find(scene: &Scene, projector: &Projector) -> Option<Self> {
        let (level_db, renderer) = scene.illusion.level_db.zip(projector.renderer())?;
        let (reached, borne) = (renderer.reached(), renderer.borne());
        let of = |part: f32| level_db + plan::decibels(part.min(1.0));
        Some(Self {
            level_db,
            moving_db: of(borne.moving),
            resting_db: of(borne.resting),
            onsets: reached.onsets,
            weaker: reached.weaker,
            least_db: of(reached.least),
        })
    }
}

/// Level over threshold, dB.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LevelDb {
    /// Level that half of the onsets lie below.
    pub median: f64,
    /// Level that one onset in twenty lies below.
    pub p5: f64,
}

/// Displacement of the skin from end to end, um.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SkinUm {
    /// Half of the onsets moved it less.
    pub median: f64,
    /// No onset moved it more.
    pub most: f64,
}

/// Error over a number of onsets, display mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CountedError {
    /// Root mean square.
    pub rmse: f64,
    /// Largest.
    pub max: f64,
    /// Onsets of both.
    pub onsets: u64,
}

/// Error of the felt place, with the onsets at which nothing was felt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FeltError {
    /// Root mean square, display mm, over the onsets inside the display; `None` where nothing was felt or no truth is known.
    pub rmse: Option<f64>,
    /// Largest.
    pub max: Option<f64>,
    /// Onsets of both figures.
    pub onsets: u64,
    /// Error over all onsets, with the contact inside the display or not.
    pub everywhere: Option<CountedError>,
    /// Onsets with a contact inside the hull and a level below threshold; `None` where no onset had one.
    pub breaks: Option<u64>,
    /// Onsets at which the felt place went further than the contact by a step that can be felt; `None` as breaks.
    pub jumps: Option<u64>,
    /// Centroid by which a place was felt.
    pub perceiver: &'static str,
}

impl From<Errors> for CountedError {
    fn from(errors: Errors) -> Self {
        let PathError { rmse, max } = errors.into();
        Self {
            rmse,
            max,
            onsets: errors.count,
        }
    }
}

impl FeltSummary {
    /// Headline of a run from its errors by both centroids.
    pub(crate) fn new(
        (header, path): (&Header, &FeltPath),
        [energy, amplitude]: [&FeltError; 2],
    ) -> Self {
        let level = path.level();
        let decibels = |mdb: i32| f64::from(mdb) * 1e-3;
        let error = |felt: &FeltError| {
            let (rmse, max) = (felt.rmse?, felt.max?);
            Some(PathError { rmse, max })
        };
        Self {
            person: header.person.clone(),
            preset: header.preset.clone(),
            level_db: level.map(|level| LevelDb {
                median: decibels(level.median_mdb),
                p5: decibels(level.p5_mdb),
            }),
            skin_um: level.map(|level| SkinUm {
                median: f64::from(level.skin_median_nm) * 1e-3,
                most: f64::from(level.skin_most_nm) * 1e-3,
            }),
            error_energy_all_mm: energy.everywhere,
            error_amplitude_all_mm: amplitude.everywhere,
            error_energy_mm: error(energy),
            error_amplitude_mm: error(amplitude),
            onsets_inside: energy.onsets,
            breaks: energy.breaks,
            jumps: energy.jumps,
            taps: level.map_or(0, |level| level.taps),
            asked: None,
            missing_db: None,
            band: None,
            no_band: None,
            state: None,
            states: Vec::new(),
        }
    }
}
