//! Bands: what `hil calibrate` has found of a bench, kept so that a run need not compute it.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::bench::Bench;
use super::error::FileError;
use super::loaded::Loaded;
use super::resolve::FileKind;
use super::source::Source;

/// The felt level and error of a bench over all that is not measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BandFile {
    /// The bench's name.
    pub name: String,
    /// The band, in a sentence.
    pub description: String,
    /// Digest of bench, wire, alloy, limits, display and law.
    pub bench_digest: String,
    /// Digest of priors and evidence.
    pub evidence_digest: String,
    /// Priors that wires, fingers and people were drawn from.
    pub priors: String,
    /// Evidence by which they were weighed.
    pub evidence: Vec<String>,
    /// Scene that every draw played.
    pub scene: String,
    /// Seed of the draws.
    pub seed: u64,
    /// Number of draws.
    pub draws: u64,
    /// Effective sample size.
    pub effective: f64,
    /// Level over the person's threshold at 5, 50 and 95 %, dB.
    pub level_db: [f64; 3],
    /// Share of the people who feel it.
    pub felt: f64,
    /// Error of the felt place at 5, 50 and 95 %, RMSE over all onsets, mm.
    pub error_mm: [f64; 3],
}

impl BandFile {
    /// Reads and checks a band.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let file: Self = source.read()?;
        source.heading(&file.name, &file.description)?;
        source.range("effective", &file.effective, 1.0..=1e9, "draws")?;
        source.range("felt", &file.felt, 0.0..=1.0, "")?;
        for (key, values, (low, high)) in [
            ("level_db", &file.level_db, (-1000.0, 1000.0)),
            ("error_mm", &file.error_mm, (0.0, 1000.0)),
        ] {
            source.range(key, values, low..=high, "")?;
            if !values.is_sorted() {
                return Err(source.bad(key, "5, 50 and 95 %, ascending"));
            }
        }
        Ok(file)
    }
}

/// The band beside a bench: a built-in bench's is built in, a file's lies in the folder `bands` beside it under the bench's
/// name.
///
/// # Errors
/// A band of another bench, and what cannot be read.
pub(super) fn band_of(bench: &Loaded<Bench>) -> Result<Option<Loaded<BandFile>>, FileError> {
    let Some(source) = source_of(bench)? else {
        return Ok(None);
    };
    let band = Loaded::<BandFile>::read(source)?;
    if band.value.name != bench.value.name {
        let expected = format!(
            "\"{}\": the band of this bench; `hil calibrate` makes it",
            bench.value.name
        );
        return Err(band.source.bad("name", expected));
    }
    Ok(Some(band))
}

/// Path of the band of a bench that is a file; none for a built-in one.
#[must_use]
pub fn band_path(bench: &Loaded<Bench>) -> Option<PathBuf> {
    let folder = bench.source.folder()?;
    let name = format!("{}.toml", bench.value.name);
    Some(folder.join(FileKind::Band.folder()).join(name))
}

fn source_of(bench: &Loaded<Bench>) -> Result<Option<Source>, FileError> {
    match band_path(bench) {
        Some(path) if path.exists() => Source::open(&path).map(Some),
        Some(_) => Ok(None),
        None => {
            let text = FileKind::Band.built_in(&bench.value.name);
            let label = format!(
                "fixtures/{}/{}.toml",
                FileKind::Band.folder(),
                bench.value.name
            );
            Ok(text.map(|text| Source::new(label, text)))
        }
    }
}
