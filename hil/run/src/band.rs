//! The felt level and error of a bench over all that is not measured: what `hil calibrate` has found, read from a file.
//!
//! A band is of its bench, its law and its evidence alone. Digests tell whether they are still those of the file.

use palpate_files::{
    BandFile, EvidenceFile, FileError, Loaded, PriorsFile, Setup, load_evidence, load_priors,
};
use palpate_records::digest::short_digest;
use serde::Serialize;

/// Felt levels and errors of a bench over all draws of what is not measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FeltBand {
    /// Level over the person's threshold at 5, 50 and 95 %, dB.
    pub level_db: [f64; 3],
    /// Share of the people who feel it.
    pub felt: f64,
    /// Error of the felt place at 5, 50 and 95 %, RMSE over all onsets, mm.
    pub error_mm: [f64; 3],
    /// Number of draws.
    pub draws: u64,
    /// Effective sample size.
    pub effective: f64,
    /// Scene that every draw played.
    pub scene: String,
    /// Evidence by which draws were weighed.
    pub evidence: Vec<String>,
}

impl From<&BandFile> for FeltBand {
    fn from(file: &BandFile) -> Self {
        Self {
            level_db: file.level_db,
            felt: file.felt,
            error_mm: file.error_mm,
            draws: file.draws,
            effective: file.effective,
            scene: file.scene.clone(),
            evidence: file.evidence.clone(),
        }
    }
}

/// Digest of what a band holds for: bench, wire, alloy, limits, display and law, with every value that stands in place of
/// a file's.
pub fn bench_digest(setup: &Setup) -> String {
    // Emulated person, wearer and level are others' business: people are drawn.
    let illusion = palpate_files::Illusion {
        person: String::new(),
        ..setup.scene.value.illusion.clone()
    };
    short_digest(&format!(
        "{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{illusion:?}\n{}",
        setup.bench.value,
        setup.wire.value,
        setup.alloy.value,
        setup.limits.value,
        setup.display.value,
        setup.wearer.is_some(),
    ))
}

/// Digest of priors and evidence.
pub fn evidence_digest(priors: &Loaded<PriorsFile>, evidence: &[Loaded<EvidenceFile>]) -> String {
    let sources = std::iter::once(&priors.source).chain(evidence.iter().map(|file| &file.source));
    let mut text = String::new();
    for source in sources {
        text += &source.values();
        text += "\n";
    }
    short_digest(&text)
}

/// The band of a setup.
///
/// # Errors
/// Words for why there is none, with the command that makes it.
pub(crate) fn band(setup: &Setup) -> Result<FeltBand, String> {
    let name = &setup.bench.value.name;
    let Some(Loaded {
        value: file,
        source,
    }) = &setup.band
    else {
        return Err(format!("not computed: hil calibrate {name}"));
    };
    let label = source.label();
    if file.bench_digest != bench_digest(setup) {
        return Err(format!(
            "{label} is of other values of bench or law: `hil calibrate {name} --band FILE` makes it anew"
        ));
    }
    let read = || -> Result<String, FileError> {
        let evidence = file.evidence.iter().map(|name| load_evidence(name));
        let evidence: Vec<_> = evidence.collect::<Result<_, _>>()?;
        Ok(evidence_digest(&load_priors(&file.priors)?, &evidence))
    };
    match read() {
        Ok(digest) if digest == file.evidence_digest => Ok(FeltBand::from(file)),
        Ok(_) => Err(format!(
            "{label} is of other priors or evidence: `hil calibrate {name} --band FILE` makes it anew"
        )),
        Err(error) => Err(format!("{label}: {error}")),
    }
}

#[cfg(test)]
#[path = "band_tests.rs"]
mod tests;
