//! Identification of a wire from a trace: figures of the model that make it follow the trace, with intervals.
//!
//! The model is the emulators' own wire, driven with the trace's current. Least squares by Levenberg and Marquardt; an
//! interval is that of the linearised fit. Nothing here knows a file.

mod fit;

use palpate_core::physics::{DEEPEST, RPhase, TissueParameters, WireParameters};
use palpate_emulators::display::wire::Wire;
use palpate_emulators::time::Nanos;
use palpate_files::{Bound, EvidenceRow, Quantity};

/// Measured quantity of a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// The middle of the wire, um, positive towards the finger, from anywhere.
    Displacement,
    /// Resistance between the terminals, Ohm.
    Resistance,
}

/// A row of a trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time of the row, us.
    pub time_us: u64,
    /// The signal, in its unit.
    pub value: f64,
    /// Current from here on, A.
    pub amps: f64,
}

/// A wire that a trace was taken of, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Subject {
    /// The wire; the search starts from its figures.
    pub wire: WireParameters,
    /// The finger under the wire.
    pub tissue: TissueParameters,
    /// Temperature at the start, degrees C.
    pub start_c: f64,
}

/// A figure that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Name of the figure.
    pub name: &'static str,
    /// Quantity of evidence that the figure is.
    pub quantity: Quantity,
    /// Unit of the figure; empty for a ratio.
    pub unit: &'static str,
    /// Value that the search began with.
    pub assumed: f64,
    /// Fitted value; `None` where the trace does not depend on the figure.
    pub found: Option<Found>,
}

/// A value with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The value.
    pub value: f64,
    /// Half of its 95 % interval.
    pub half: f64,
}

/// Result of an identification.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified {
    /// Every figure that the search looked for.
    pub figures: Vec<Figure>,
    /// Root mean square of the model's error, in the signal's unit.
    pub rms: f64,
    /// Samples that were fitted.
    pub samples: usize,
}

/// Standard normal quantile of a two-sided 95 % interval.
const Z_95: f64 = 1.96;

impl Identified {
    /// Rows of evidence for what the trace shows; `source` says which trace that is.
    pub fn evidence(&self, source: &str) -> Vec<EvidenceRow> {
        let found = self
            .figures
            .iter()
            .filter_map(|figure| Some((figure, figure.found?)));
        let row = |(figure, found): (&Figure, Found)| EvidenceRow {
            quantity: figure.quantity.key().to_owned(),
            value: found.value,
            unit: figure.quantity.unit().to_owned(),
            tolerance: Some([(found.half / Z_95).max(1e-9); 2]),
            factor: None,
            bound: Bound::Near,
            times: 1,
            source: source.to_owned(),
            drive: None,
        };
        found.map(row).collect()
    }
}

/// A figure to look for.
struct Unknown {
    name: &'static str,
    quantity: Quantity,
    unit: &'static str,
    start: f64,
    range: (f64, f64),
    set: fn(&mut Subject, f64),
}

/// Stresses that the search begins with, MPa: bands that lie elsewhere leave no slope towards their place.
const STRESSES_MPA: [f64; 14] = [
    2.0, 5.0, 8.0, 11.0, 15.0, 19.0, 23.0, 28.0, 34.0, 42.0, 55.0, 75.0, 110.0, 172.0,
];
/// Steps from each of these stresses, and places from which the search goes on.
const FIRST_STEPS: usize = 6;
const PLACES: usize = 3;
/// Most steps from each of these places.
const STEPS: usize = 40;
/// Distances at which a lower place is looked for in the end, MPa.
const NEARBY_MPA: [f64; 5] = [1.0, 0.3, 0.1, 0.03, 0.01];
/// Most samples of a trace.
pub const MOST_SAMPLES: usize = 200_000;

fn unknowns(subject: &Subject, signal: Signal) -> Vec<Unknown> {
    let wire = &subject.wire;
    let stress = Unknown {
        name: "bias stress",
        quantity: Quantity::Stress,
        unit: "MPa",
        start: wire.bias_stress_pa * 1e-6,
        range: (0.0, 400.0),
        set: |s, v| s.wire.bias_stress_pa = v * 1e6,
    };
    if signal == Signal::Resistance {
        let resistance = Unknown {
            name: "resistance",
            quantity: Quantity::Resistance,
            unit: "Ohm",
            start: wire.resistance_ohm,
            range: (0.01, 1000.0),
            set: |s, v| s.wire.resistance_ohm = v,
        };
        let ratio = Unknown {
            name: "austenite ratio",
            quantity: Quantity::AusteniteRatio,
            unit: "",
            // At 1 nothing would depend on the stress.
            start: if (wire.austenite_ratio - 1.0).abs() < 0.01 {
                0.9
            } else {
                wire.austenite_ratio
            },
            range: (0.2, 5.0),
            set: |s, v| s.wire.austenite_ratio = v,
        };
        return vec![stress, resistance, ratio];
    }
    let sag = Unknown {
        name: "sag",
        quantity: Quantity::Sag,
        unit: "um",
        start: wire.mount.sag_m * 1e6,
        range: (20.0, wire.length_m * DEEPEST * 1e6),
        set: |s, v| s.wire.mount.sag_m = v * 1e-6,
    };
    let martensite = Unknown {
        name: "strain of martensite",
        quantity: Quantity::Strain,
        unit: "%",
        start: wire.mechanics.transformation_strain * 100.0,
        range: (0.0, 9.0),
        set: |s, v| s.wire.mechanics.transformation_strain = v / 100.0,
    };
    let mut all = vec![stress, sag, martensite];
    if let Some(r) = wire.r_phase {
        all.push(Unknown {
            name: "strain of the R phase",
            quantity: Quantity::RStrain,
            unit: "%",
            start: r.strain * 100.0,
            range: (0.0, 5.0),
            set: |s, v| {
                s.wire.r_phase = s.wire.r_phase.map(|r| RPhase {
                    strain: v / 100.0,
                    ..r
                });
            },
        });
    }
    all
}

/// The signal at every sample, as the model has it.
fn course(subject: &Subject, signal: Signal, samples: &[Sample]) -> Option<Vec<f64>> {
    let tissue = &subject.tissue;
    let mut wire = Wire::new(&subject.wire, tissue, subject.start_c)
        .and_then(|wire| wire.worn(tissue))
        .ok()?;
    let begin = samples.first()?.time_us;
    let value = |sample: &Sample| {
        let at = Nanos::from_micros(sample.time_us - begin);
        let value = match signal {
            Signal::Displacement => wire.displacement_m(at) * 1e6,
            Signal::Resistance => wire.resistance_ohm(at),
        };
        wire.set_current(at, sample.amps);
        value
    };
    Some(samples.iter().map(value).collect())
}

/// The figures that make the model follow a trace.
///
/// # Errors
/// A trace on which the fit does not hold together, in words.
pub fn identify(
    subject: &Subject,
    signal: Signal,
    samples: &[Sample],
) -> Result<Identified, String> {
    let unknowns = unknowns(subject, signal);
    let least = 10 * unknowns.len();
    if samples.len() < least {
        return Err(format!(
            "at least {least} samples for {} figures",
            unknowns.len()
        ));
    }
    // The last one is where a vibrometer counts from.
    let free = usize::from(signal == Signal::Displacement);
    let model = |values: &[f64]| {
        let mut at = *subject;
        for (unknown, value) in unknowns.iter().zip(values) {
            (unknown.set)(&mut at, *value);
        }
        let mut course = course(&at, signal, samples)?;
        if let Some(offset) = values.get(unknowns.len()) {
            course.iter_mut().for_each(|v| *v += offset);
        }
        Some(course)
    };
    let trace: Vec<f64> = samples.iter().map(|s| s.value).collect();
    let mut ranges: Vec<_> = unknowns.iter().map(|u| u.range).collect();
    let mut start: Vec<f64> = unknowns.iter().map(|u| u.start).collect();
    if free > 0 {
        ranges.push((-1e6, 1e6));
        start.push(trace[0]);
    }
    let problem = fit::Problem {
        model: &model,
        trace: &trace,
        ranges: &ranges,
    };
    let stresses = STRESSES_MPA.iter().copied().chain([start[0]]);
    let tried = stresses.filter_map(|stress| {
        let mut from = start.clone();
        from[0] = stress;
        problem.descend(from, FIRST_STEPS)
    });
    let mut tried: Vec<fit::Place> = tried.collect();
    tried.sort_by(|a, b| a.squares.total_cmp(&b.squares));
    tried.truncate(PLACES);
    let ends = tried
        .into_iter()
        .filter_map(|place| problem.descend(place.values, STEPS));
    let best = ends.min_by(|a, b| a.squares.total_cmp(&b.squares));
    let best = best.map(|best| polished(&problem, best));
    let best = best.ok_or("a trace that the model can follow")?;
    let halves = problem.halves(&best);
    let figures = unknowns.iter().zip(best.values.iter().zip(&halves));
    let figures = figures.map(|(unknown, (value, half))| Figure {
        name: unknown.name,
        quantity: unknown.quantity,
        unit: unknown.unit,
        assumed: unknown.start,
        found: half.map(|half| Found {
            value: *value,
            half,
        }),
    });
    Ok(Identified {
        figures: figures.collect(),
        rms: libm::sqrt(best.squares / samples.len() as f64),
        samples: samples.len(),
    })
}

/// Looks beyond the kinks around a place: where a band's end passes a sample, slopes on both sides do not tell of a lower
/// place behind.
fn polished(problem: &fit::Problem<'_>, mut best: fit::Place) -> fit::Place {
    for mpa in NEARBY_MPA {
        for sign in [1.0, -1.0] {
            let mut from = best.values.clone();
            from[0] = (from[0] + sign * mpa).max(0.0);
            let found = problem.descend(from, STEPS);
            best = found.filter(|f| f.squares < best.squares).unwrap_or(best);
        }
    }
    best
}

/// Equal samples at the end of a range that make a trace a clipped one.
const CLIPPED: usize = 5;

/// The first and the number of samples that an instrument has cut off: equal ones at an end of the trace's range, other
/// than those at rest that it begins with.
pub fn clipped(samples: &[Sample]) -> Option<(usize, usize)> {
    let values = || samples.iter().map(|s| s.value);
    let ends = [
        values().fold(f64::INFINITY, f64::min),
        values().fold(f64::NEG_INFINITY, f64::max),
    ];
    let mut from = 0;
    for run in samples.chunk_by(|a, b| a.value.to_bits() == b.value.to_bits()) {
        let later = from > 0;
        let at_end = ends
            .iter()
            .any(|end| end.to_bits() == run[0].value.to_bits());
        if run.len() >= CLIPPED && later && at_end {
            return Some((from, run.len()));
        }
        from += run.len();
    }
    None
}

#[cfg(test)]
mod tests;
