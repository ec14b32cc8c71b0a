//! Weights of draws: wires of their material driven as the evidence says, felt by their person.

use palpate_core::physics::{TissueParameters, WireParameters};
use palpate_emulators::display::wire::Wire;
use palpate_emulators::person::channels::{Levels, Perceiver, Person};
use palpate_emulators::time::Nanos;
use palpate_files::{
    EvidenceDrive, EvidenceFile, EvidenceRow, Loaded, Measured, PersonFile, Quantity, load_alloy,
    load_wire,
};

use super::draw::Draw;
use super::marginal::log_likelihood;
use crate::failure::Failure;
use crate::plan;

/// Bursts on a wire, and the rows that they gave.
#[derive(Debug)]
struct Bench {
    drive: EvidenceDrive,
    /// The file's wire; `None`: the bench's.
    wire: Option<WireParameters>,
    rows: Vec<(Measured, EvidenceRow)>,
}

/// Evidence that is played.
#[derive(Debug)]
pub(super) struct Weights {
    benches: Vec<Bench>,
}

/// Stroke and level of a last visit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Visit {
    /// Largest stroke within a burst, um.
    pub(super) stroke_um: f64,
    /// Highest level, dB: people feel a visit whose strongest burst they feel.
    pub(super) level_db: f64,
}

impl Visit {
    /// A wire that has pulled itself straight and moves nothing.
    const STILL: Self = Self {
        stroke_um: 0.0,
        level_db: Levels::SILENT.vibration_db,
    };
}

impl Weights {
    /// Reads the wires of all rows that were driven; rows of equal bursts are played once.
    ///
    /// # Errors
    /// A wire or alloy that is not there.
    pub(super) fn new(evidence: &[Loaded<EvidenceFile>]) -> Result<Self, Failure> {
        let mut benches: Vec<Bench> = Vec::new();
        for row in evidence.iter().flat_map(|file| &file.value.row) {
            let Some(drive) = &row.drive else { continue };
            let row = (row.measured(), row.clone());
            if let Some(bench) = benches.iter_mut().find(|bench| bench.drive == *drive) {
                bench.rows.push(row);
                continue;
            }
            let alloy = drive.alloy();
            let wire = drive.wire.as_ref().map(|name| -> Result<_, Failure> {
                Ok(load_wire(name)?.value.parameters(&load_alloy(alloy)?.value))
            });
            benches.push(Bench {
                drive: drive.clone(),
                wire: wire.transpose()?,
                rows: vec![row],
            });
        }
        Ok(Self { benches })
    }

    /// Logarithm of the weight of each row, in the order of the rows' benches.
    ///
    /// # Errors
    /// A person that cannot be.
    pub(super) fn logs(
        &self,
        draw: &Draw,
        own: &WireParameters,
        tissue: &TissueParameters,
        person: &PersonFile,
    ) -> Result<Vec<f64>, Failure> {
        let mut weights = Vec::new();
        for bench in &self.benches {
            let wire = bench.wire.as_ref().map_or(*own, |wire| {
                let mut wire = draw.material(wire);
                let sag = draw.value(Quantity::PublishedSag);
                wire.mount.sag_m = sag.map_or(wire.mount.sag_m, |um| um * 1e-6);
                wire.wire_share = bench.drive.wire_share.unwrap_or(wire.wire_share);
                wire
            });
            let person = plan::person(person, &wire, tissue);
            let visit = visit(&wire, tissue, &bench.drive, person)?;
            weights.extend(bench.rows.iter().map(|(measured, row)| match measured {
                Measured::Stroke => log_likelihood(row, visit.stroke_um),
                _ => log_likelihood(row, visit.level_db),
            }));
        }
        Ok(weights)
    }
}

/// Plays bursts on a wire. A wire that cannot rest in its bow moves nothing.
pub(super) fn visit(
    wire: &WireParameters,
    tissue: &TissueParameters,
    drive: &EvidenceDrive,
    person: Person,
) -> Result<Visit, Failure> {
    let impossible = |e| Failure::Input(format!("evidence: {e}"));
    let mut perceiver = Perceiver::new(person, &[(0.0, 0.0)]).map_err(impossible)?;
    let worn = Wire::new(wire, tissue, tissue.body_c).and_then(|wire| wire.worn(tissue));
    let Ok(mut worn) = worn else {
        return Ok(Visit::STILL);
    };
    worn.keep_stretches();
    let nanos = |micros: f64| libm::round(micros * 1e3) as u64;
    let (amps, every) = (drive.current_ma * 1e-3, nanos(drive.every_ms * 1e3));
    let (width, spacing) = (nanos(drive.width_us).max(1), nanos(drive.spacing_us));
    let (mut begin, mut met) = (0, Visit::STILL);
    for number in 0..drive.visits {
        for _ in 0..drive.bursts {
            perceiver.onset();
            let mut ends: Option<[f64; 2]> = None;
            let mut look = |worn: &mut Wire, at: u64| {
                let um = worn.displacement_m(Nanos(at)) * 1e6;
                let [low, high] = ends.unwrap_or([um; 2]);
                ends = Some([low.min(um), high.max(um)]);
            };
            for pulse in 0..u64::from(drive.pulses) {
                let at = begin + pulse * spacing;
                look(&mut worn, at);
                worn.set_current(Nanos(at), amps);
                look(&mut worn, at + width);
                worn.set_current(Nanos(at + width), 0.0);
            }
            begin += every;
            worn.take_stretches(Nanos(begin), |stretch| perceiver.pass(0, stretch));
            perceiver.settle();
            let (_, deep_c) = worn.tissue(Nanos(begin));
            let felt = perceiver.felt(deep_c);
            if number + 1 == drive.visits {
                let [low, high] = ends.unwrap_or_default();
                met.stroke_um = met.stroke_um.max(high - low);
                met.level_db = met
                    .level_db
                    .max(felt.map_or(Levels::SILENT, |f| f.levels).db());
            }
        }
        begin += nanos(drive.pause_ms * 1e3);
    }
    Ok(met)
}
