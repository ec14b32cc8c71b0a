//! Calibration by evidence: what is felt on a bench, over all wires, fingers and people that priors and evidence allow.
//!
//! A draw plays the bench's own scene through the bench's own loop, on emulated wires of which guard and law do not know,
//! and feels it as a person of its own. Evidence weighs it; effective sample size tells how much that leaves.

mod draw;
mod marginal;
mod posterior;
mod weigh;

pub use crate::band::SCENE;
pub use draw::Draw;
pub use posterior::{Drawn, Kinds, Posterior, Spread, percentiles};

use std::collections::BTreeSet;

use palpate_core::physics::{ParameterError, WireParameters};
use palpate_emulators::display::wire::Wire;
use palpate_emulators::person::channels::Levels;
use palpate_files::{
    BandFile, EvidenceFile, FileKind, Loaded, Pass, PriorsFile, Quantity, Setup, Source, resolve,
};
use palpate_records::trace::{PlaceUm, Trace, event};

use crate::band;
use crate::failure::Failure;
use crate::policy::refuse_hardware;
use crate::{Host, Input, Keep, pass, plan, run_with};
use draw::Draws;
use weigh::Weights;

/// Effective sample size from which percentiles are stated.
pub const ENOUGH: f64 = 200.0;
/// A level below which nothing moves and no place is felt, dB.
const STILL_DB: f64 = -60.0;

/// Draws of a bench.
#[derive(Debug)]
pub struct Calibration {
    setup: Setup,
    bench_wire: WireParameters,
    draws: Draws,
    weights: Weights,
    is_identified: bool,
    seed: u64,
    /// Digest of all values that the draws go back to.
    digest: String,
    /// Wires that the evidence drove, and their alloys.
    driven: [BTreeSet<String>; 2],
    /// Error of a guess at the middle of the path, RMSE, mm: where no place is felt.
    unplaced_mm: f64,
}

impl Calibration {
    /// A calibration of a setup. The law plans with a table of each draw's own wire where `is_identified`, else with the
    /// bench's.
    ///
    /// # Errors
    /// A bench of hardware or of several displays, and evidence that does not fit the priors.
    pub fn new(
        mut setup: Setup,
        priors: &Loaded<PriorsFile>,
        evidence: &[Loaded<EvidenceFile>],
        is_identified: bool,
        seed: u64,
    ) -> Result<Self, Failure> {
        refuse_hardware(&setup.bench.value)?;
        let instead = "no evidence on motors is published; `hil sweep --set bench.haptics.quality=10,20,40` shows what an unknown value does to what is felt";
        plan::wires_only(&setup.bench, instead)?;
        plan::display(&setup)?;
        // Every draw begins as after a hot pass, where the bench has one.
        if pass::is_due(&setup) && pass::lasts(&setup) {
            pass::set_passed(&mut setup);
        }
        setup.pass = Pass::LeftOut;
        let bench_wire = plan::wire(&setup);
        let driven = driven(evidence);
        let sources = sources(&priors.source, evidence, &driven)?;
        let nominal = run_with(&setup, &Input::Scene, 1, Keep::default(), &mut ())?;
        Ok(Self {
            digest: band::digest(&setup, &sources)?,
            driven,
            draws: Draws::new(&priors.value, evidence, &bench_wire, seed)?,
            weights: Weights::new(evidence)?,
            unplaced_mm: unplaced_mm(&nominal.trace),
            bench_wire,
            is_identified,
            seed,
            setup,
        })
    }

    /// The file that lets every run on the bench show a posterior of these draws, by `priors` and `evidence`. `found`
    /// makes the name by which the file finds another one again.
    pub fn band(
        &self,
        posterior: &Posterior,
        priors: &str,
        evidence: &[String],
        found: impl Fn(FileKind, &str) -> String,
    ) -> BandFile {
        let name = self.setup.bench.value.name.clone();
        let [wires, alloys] = &self.driven;
        let evidence = evidence.iter().map(|name| found(FileKind::Evidence, name));
        let wires = wires.iter().map(|name| found(FileKind::Wire, name));
        let alloys = alloys.iter().map(|name| found(FileKind::Alloy, name));
        BandFile {
            description: format!("What is felt on bench {name} over all that is not measured"),
            name,
            digest: self.digest.clone(),
            scene: SCENE.to_owned(),
            law: self.setup.scene.value.illusion.model.name().to_owned(),
            identified: self.is_identified,
            priors: found(FileKind::Priors, priors),
            evidence: evidence.collect(),
            wires: wires.collect(),
            alloys: alloys.collect(),
            seed: self.seed,
            draws: posterior.draws,
            effective: posterior.effective,
            level_db: posterior.after.level_db,
            felt: posterior.after.felt,
            error_mm: posterior.after.error_mm,
        }
    }

    /// Figures of the draw of this number: the same in every order and on every number of cores.
    ///
    /// # Errors
    /// Priors that nothing can be drawn from, and what ends a run.
    pub fn drawn(&self, number: u64, host: &mut dyn Host) -> Result<Drawn, Failure> {
        let bench_tissue = self.setup.bench.value.tissue.parameters();
        let made = |draw: &Draw| {
            let (wire, tissue) = (draw.wire(&self.bench_wire), draw.tissue(&bench_tissue));
            let made = Wire::new(&wire, &tissue, tissue.body_c).and_then(|w| w.worn(&tissue));
            made.map(drop)
        };
        // A wire that pulls itself straight before its first pulse is one that is not felt; any other cannot be.
        let straight = |made: Result<(), ParameterError>| {
            made.is_err_and(|ParameterError { name }| name == "mount.sag_m")
        };
        let draw = self
            .draws
            .draw(number, |draw| made(draw).is_ok() || straight(made(draw)))?;
        let (wire, tissue) = (draw.wire(&self.bench_wire), draw.tissue(&bench_tissue));
        let mut setup = self.setup.clone();
        let person = &mut setup.person.value;
        let of = |quantity, own: f64| draw.value(quantity).unwrap_or(own);
        let vibration = &mut person.vibration.threshold_um.value;
        *vibration = of(Quantity::Vibration, *vibration);
        let flutter = &mut person.flutter.threshold_um.value;
        *flutter = of(Quantity::Flutter, *flutter);
        let log_weights = self.weights.logs(&draw, &wire, &tissue, person)?;
        let mut figures = Drawn {
            draw,
            log_weights,
            level_db: Levels::SILENT.db(),
            error_mm: self.unplaced_mm,
        };
        if made(&figures.draw).is_err() {
            return Ok(figures);
        }
        setup.drawn = Some(palpate_files::Drawn {
            wire,
            tissue,
            is_identified: self.is_identified,
        });
        let summary = run_with(&setup, &Input::Scene, 1, Keep::default(), host)?.summary;
        let level = summary.felt.level_db.map(|level| level.median);
        figures.level_db = level.unwrap_or(figures.level_db);
        let errors = [summary.felt_error_mm, summary.felt_error_amplitude_mm];
        let errors = errors
            .iter()
            .filter_map(|error| Some(error.everywhere?.rmse));
        if let Some(worse) = errors.reduce(f64::max)
            && figures.level_db > STILL_DB
        {
            figures.error_mm = worse;
        }
        Ok(figures)
    }
}

/// Names of the wires that evidence drove, and of their alloys.
fn driven(evidence: &[Loaded<EvidenceFile>]) -> [BTreeSet<String>; 2] {
    let rows = evidence.iter().flat_map(|file| &file.value.row);
    let drives = rows.filter_map(|row| row.drive.as_ref());
    let named = drives.filter_map(|drive| Some((drive.wire.clone()?, drive.alloy().to_owned())));
    let (wires, alloys) = named.unzip();
    [wires, alloys]
}

/// Files of which a band names each, in the order of [`BandFile::named`].
fn sources(
    priors: &Source,
    evidence: &[Loaded<EvidenceFile>],
    [wires, alloys]: &[BTreeSet<String>; 2],
) -> Result<Vec<Source>, Failure> {
    let mut sources = vec![priors.clone()];
    sources.extend(evidence.iter().map(|file| file.source.clone()));
    for (kind, names) in [(FileKind::Wire, wires), (FileKind::Alloy, alloys)] {
        for name in names {
            sources.push(resolve(kind, name)?);
        }
    }
    Ok(sources)
}

/// Root mean square distance of the onsets' true places from their middle, mm.
fn unplaced_mm(trace: &Trace) -> f64 {
    let places: Vec<PlaceUm> = trace
        .each::<event::Felt>()
        .map(|felt| felt.target)
        .collect();
    let count = places.len().max(1) as f64;
    let mean = |of: fn(&PlaceUm) -> f64| places.iter().map(of).sum::<f64>() / count;
    let x = mean(|place| f64::from(place.x));
    let y = mean(|place| f64::from(place.y));
    let squares = places.iter().map(|place| {
        let (dx, dy) = (f64::from(place.x) - x, f64::from(place.y) - y);
        dx * dx + dy * dy
    });
    libm::sqrt(squares.sum::<f64>() / count) * 1e-3
}

#[cfg(test)]
mod tests;
