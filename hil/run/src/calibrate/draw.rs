//! Draws: a wire, a finger and a person that priors and measured figures allow.

use palpate_core::physics::{Alloy, RPhase, TissueParameters, WireParameters};
use palpate_core::random::RandomStream;
use palpate_files::{EvidenceFile, EvidenceRow, Loaded, Measured, Prior, PriorsFile, Quantity};

use super::marginal::{Marginal, log_likelihood};
use crate::failure::Failure;

/// Most draws that are thrown away for one that can be.
const TRIES: usize = 10_000;
/// Largest change of a resistance that a bench states without a prior, as a factor.
const RESISTANCES: f64 = 2.0;

/// A quantity of each kind; `None` where the bench's counts.
pub(super) type Values = [Option<f64>; Quantity::ALL.len()];

/// Wires, a finger and a person.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    /// `true` of wires that were pulled tight.
    pub is_taut: bool,
    /// Values in the units of files.
    pub(super) values: Values,
    /// Logarithm of a weight that the draw has by itself.
    pub(super) log_weight: f64,
}

impl Draw {
    /// Value of a quantity, in the unit of files; `None` where the bench's counts.
    pub fn value(&self, quantity: Quantity) -> Option<f64> {
        self.values[quantity as usize]
    }

    fn si(&self, quantity: Quantity) -> Option<f64> {
        Some(self.value(quantity)? * quantity.factor())
    }

    /// The drawn material in a wire's geometry; its mount, resistance and history stay.
    pub(super) fn material(&self, wire: &WireParameters) -> WireParameters {
        let of = |quantity, own: f64| self.si(quantity).unwrap_or(own);
        let (start, width) = (of(Quantity::RStart, 45.0), of(Quantity::RWidth, 10.0));
        let hysteresis = of(Quantity::RHysteresis, 2.0);
        let bands = Alloy {
            austenite_start_c: start + hysteresis - width,
            austenite_finish_c: start + hysteresis,
            martensite_start_c: start,
            martensite_finish_c: start - width,
            stress_per_kelvin: of(Quantity::RSlope, 15e6),
            reference_stress_pa: 0.0,
        };
        let mut wire = *wire;
        wire.bias_stress_pa = of(Quantity::Stress, wire.bias_stress_pa);
        wire.r_phase = Some(RPhase {
            bands,
            strain: of(Quantity::RStrain, RPhase::LOW.strain),
            latent_heat: of(Quantity::RLatent, RPhase::LOW.latent_heat),
        });
        let strain = &mut wire.mechanics.transformation_strain;
        *strain = of(Quantity::Strain, *strain);
        wire.reversible = of(Quantity::Reversible, wire.reversible);
        wire.specific_heat = of(Quantity::SpecificHeat, wire.specific_heat);
        wire.latent_heat = of(Quantity::Latent, wire.latent_heat);
        wire.wire_share = of(Quantity::WireShare, wire.wire_share);
        wire.ends_c = of(Quantity::Finger, wire.ends_c);
        wire
    }

    /// The drawn wires of a bench.
    pub fn wire(&self, bench: &WireParameters) -> WireParameters {
        let mut wire = self.material(bench);
        let of = |quantity, own: f64| self.si(quantity).unwrap_or(own);
        wire.mount.sag_m = of(Quantity::Sag, wire.mount.sag_m);
        wire.resistance_ohm = of(Quantity::Resistance, wire.resistance_ohm);
        wire.austenite_ratio = of(Quantity::AusteniteRatio, wire.austenite_ratio);
        wire
    }

    /// The drawn finger.
    pub fn tissue(&self, bench: &TissueParameters) -> TissueParameters {
        let of = |quantity, own: f64| self.si(quantity).unwrap_or(own);
        TissueParameters {
            contact_h: of(Quantity::ContactHeat, bench.contact_h),
            contact_fraction: of(Quantity::Contact, bench.contact_fraction),
            modulus_pa: of(Quantity::Skin, bench.modulus_pa),
            body_c: of(Quantity::Finger, bench.body_c),
            ..*bench
        }
    }
}

/// Source of draws.
#[derive(Debug)]
pub(super) struct Draws {
    marginals: Vec<Option<Marginal>>,
    /// Probability of taut wires, once what was measured of the stress counts.
    taut: f64,
    taut_strain: f64,
    seed: u64,
    /// Rows of the strain, which a taut wire's least strain may pass by.
    strains: Vec<EvidenceRow>,
}

/// Rows of quantities by themselves, each with its file and index.
fn rows_of(
    evidence: &[Loaded<EvidenceFile>],
    quantity: Quantity,
) -> impl Iterator<Item = (&Loaded<EvidenceFile>, usize, &EvidenceRow)> {
    let all = evidence.iter().flat_map(|file| {
        let rows = file.value.row.iter().enumerate();
        rows.map(move |(index, row)| (file, index, row))
    });
    all.filter(move |(.., row)| row.measured() == Measured::Itself(quantity))
}

impl Draws {
    /// Draws of these priors and the rows of evidence that measure a quantity by itself.
    ///
    /// # Errors
    /// Names the row that no value of its prior is near.
    pub(super) fn new(
        priors: &PriorsFile,
        evidence: &[Loaded<EvidenceFile>],
        bench: &WireParameters,
        seed: u64,
    ) -> Result<Self, Failure> {
        let marginal = |quantity: Quantity| {
            // A wire's stress is that of loose or of taut ones.
            let measured = match quantity {
                Quantity::TautStress => Quantity::Stress,
                other => other,
            };
            let rows: Vec<_> = rows_of(evidence, measured).collect();
            let alone: Vec<&EvidenceRow> = rows.iter().map(|(.., row)| *row).collect();
            let without = || bench_prior(quantity, bench).filter(|_| !alone.is_empty());
            let Some(prior) = priors.prior(quantity).or_else(without) else {
                return Ok(None);
            };
            let found = Marginal::new(prior, &alone);
            let of_two = matches!(quantity, Quantity::Stress | Quantity::TautStress);
            match (found, rows.first()) {
                (None, Some((file, index, row))) if !of_two => {
                    Err(nowhere(file, *index, row, prior))
                }
                (found, _) => Ok(found),
            }
        };
        let marginals: Vec<Option<Marginal>> = Quantity::ALL
            .into_iter()
            .map(marginal)
            .collect::<Result<_, Failure>>()?;
        let of = |quantity: Quantity| {
            let found = marginals[quantity as usize].as_ref();
            found.map_or(0.0, |m| libm::exp(m.log_evidence))
        };
        let loose = (1.0 - priors.taut) * of(Quantity::Stress);
        let taut = priors.taut * of(Quantity::TautStress);
        if let Some((file, index, row)) = rows_of(evidence, Quantity::Stress).next()
            && loose + taut <= 0.0
        {
            let prior = priors.prior(Quantity::Stress).unwrap_or(Prior::Known(0.0));
            return Err(nowhere(file, index, row, prior));
        }
        let strains = rows_of(evidence, Quantity::Strain).map(|(.., row)| row.clone());
        Ok(Self {
            taut: taut / (loose + taut),
            marginals,
            taut_strain: priors.taut_strain,
            seed,
            strains: strains.collect(),
        })
    }

    /// The draw of this number for which `fits` holds: the same in every order and on every number of cores.
    ///
    /// # Errors
    /// Priors of which next to nothing can be.
    pub(super) fn draw(&self, number: u64, fits: impl Fn(&Draw) -> bool) -> Result<Draw, Failure> {
        let mut stream = RandomStream::new(self.seed, &format!("draw {number}"));
        for _ in 0..TRIES {
            let drawn = self.once(&mut stream);
            let at = |quantity| drawn.value(quantity).unwrap_or(0.0);
            // The R phase lies between austenite and martensite.
            let ordered = at(Quantity::RStrain) <= at(Quantity::Strain)
                && at(Quantity::RLatent) <= at(Quantity::Latent);
            if ordered && fits(&drawn) {
                return Ok(drawn);
            }
        }
        Err(Failure::Input(format!(
            "the priors: expected wires that can be, found none in {TRIES} draws (is the R phase's strain or heat above the martensite's, or no rest in the bench's bow?)"
        )))
    }

    fn once(&self, stream: &mut RandomStream) -> Draw {
        let is_taut = stream.uniform() < self.taut;
        let mut values: Values = [None; Quantity::ALL.len()];
        for (value, marginal) in values.iter_mut().zip(&self.marginals) {
            let u = stream.uniform();
            *value = marginal.as_ref().map(|marginal| marginal.value(u));
        }
        let taut = values[Quantity::TautStress as usize].take();
        let mut log_weight = 0.0;
        if is_taut {
            values[Quantity::Stress as usize] = taut;
            let least = taut.unwrap_or(0.0) * self.taut_strain;
            if let Some(strain) = values[Quantity::Strain as usize].filter(|own| *own < least) {
                let likelihood = |at: f64| {
                    self.strains
                        .iter()
                        .map(|r| log_likelihood(r, at))
                        .sum::<f64>()
                };
                log_weight = likelihood(least) - likelihood(strain);
                values[Quantity::Strain as usize] = Some(least);
            }
        }
        Draw {
            is_taut,
            values,
            log_weight,
        }
    }
}

/// Prior of a quantity that the bench has a value of, where one was measured.
fn bench_prior(quantity: Quantity, bench: &WireParameters) -> Option<Prior> {
    let resistance = bench.resistance_ohm;
    match quantity {
        Quantity::Sag => Some(Prior::Uniform(
            1.0,
            bench.length_m * palpate_core::physics::DEEPEST * 1e6,
        )),
        Quantity::Resistance => Some(Prior::LogUniform(
            resistance / RESISTANCES,
            resistance * RESISTANCES,
        )),
        Quantity::AusteniteRatio => Some(Prior::Uniform(0.2, 5.0)),
        _ => None,
    }
}

fn nowhere(file: &Loaded<EvidenceFile>, index: usize, row: &EvidenceRow, prior: Prior) -> Failure {
    let span = match prior {
        Prior::Uniform(a, b) | Prior::LogUniform(a, b) => format!("{a} to {b}"),
        Prior::Normal(mean, by) => format!("{mean} +- {by}"),
        Prior::LogNormal(median, by) => format!("{median} by a factor of {:.2}", libm::exp(by)),
        Prior::Known(value) => format!("{value}"),
    };
    let expected = format!(
        "a value near the prior of {}, {span} {}",
        row.quantity, row.unit
    );
    Failure::File(file.source.bad(&format!("row[{index}].value"), expected))
}
