//! Bands: what `hil calibrate` found of a bench, for every run on it.

use serde::Deserialize;

use super::error::FileError;
use super::resolve::FileKind;
use super::settings::bounds;
use super::source::Source;

/// Felt level and error of a bench over all that is not measured.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BandFile {
    /// Name of the bench.
    pub name: String,
    /// The band, in a sentence.
    pub description: String,
    /// Digest of the values of all files that the draws go back to.
    pub digest: String,
    /// Scene that every draw played.
    pub scene: String,
    /// Law of illusion of that scene.
    pub law: String,
    /// True if the law planned with each draw's own wire, false if with the bench's.
    pub identified: bool,
    /// Priors: a built-in name or a file.
    pub priors: String,
    /// Evidence: built-in names or files.
    pub evidence: Vec<String>,
    /// Wires that the evidence drove: built-in names or files.
    pub wires: Vec<String>,
    /// Alloys of those wires.
    pub alloys: Vec<String>,
    /// Seed of the draws.
    pub seed: u64,
    /// Number of draws.
    pub draws: usize,
    /// Effective sample size of their weights.
    pub effective: f64,
    /// Level over the person's threshold at 5, 50 and 95 %, dB.
    pub level_db: [f64; 3],
    /// Share of draws whose person feels half of the onsets or more.
    pub felt: f64,
    /// Error of the felt place over all onsets at 5, 50 and 95 %, RMSE, mm.
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
        bounds!(source, "", file;
            draws: 1..=1_000_000;
            effective: 0.0..=1e6;
            level_db: -1000.0..=1000.0, "dB";
            felt: 0.0..=1.0;
            error_mm: 0.0..=1000.0, "mm")?;
        for (key, values) in [("level_db", file.level_db), ("error_mm", file.error_mm)] {
            if !values.is_sorted() {
                return Err(source.bad(key, "values at 5, 50 and 95 %, the lowest first"));
            }
        }
        Ok(file)
    }

    /// Files beside bench and scene that the draws go back to, each with its kind and the key of its name.
    #[must_use]
    pub fn named(&self) -> Vec<(FileKind, &str, String)> {
        let lists = [
            (FileKind::Evidence, "evidence", &self.evidence),
            (FileKind::Wire, "wires", &self.wires),
            (FileKind::Alloy, "alloys", &self.alloys),
        ];
        let listed = lists.into_iter().flat_map(|(kind, key, names)| {
            let numbered = names.iter().enumerate();
            numbered.map(move |(n, name)| (kind, name.as_str(), format!("{key}[{n}]")))
        });
        let priors = (FileKind::Priors, self.priors.as_str(), "priors".to_owned());
        std::iter::once(priors).chain(listed).collect()
    }

    /// The file's text. Figures are rounded to what their draws tell.
    #[must_use]
    pub fn text(&self) -> String {
        let three = |values: [f64; 3]| values.map(|value| format!("{value:.2}")).join(", ");
        format!(
            "# Written by `hil calibrate` of palpate (docs/felt.md).\n\
             name = {:?}\n\
             description = {:?}\n\
             digest = {:?}\n\
             scene = {:?}\n\
             law = {:?}\n\
             identified = {}\n\
             priors = {:?}\n\
             evidence = {:?}\n\
             wires = {:?}\n\
             alloys = {:?}\n\
             seed = {}\n\
             draws = {}\n\
             effective = {:.1}\n\
             # At 5, 50 and 95 %.\n\
             level_db = [{}]\n\
             felt = {:.3}\n\
             error_mm = [{}]\n",
            self.name,
            self.description,
            self.digest,
            self.scene,
            self.law,
            self.identified,
            self.priors,
            self.evidence,
            self.wires,
            self.alloys,
            self.seed,
            self.draws,
            self.effective,
            three(self.level_db),
            self.felt,
            three(self.error_mm)
        )
    }
}
