//! Calibration against the published bench, and draws that do not depend on their order.

use palpate_core::physics::{History, Mechanics, TissueParameters, WireParameters, WireState};
use palpate_core::random::RandomStream;
use palpate_emulators::person::channels::Person;
use palpate_emulators::time::Nanos;
use palpate_files::{EvidenceDrive, Source, load_evidence, load_priors};

use super::weigh::{Visit, visit};
use super::*;
use crate::identify::{Sample, Signal, Subject, identify};

/// Bursts of the published rows: the first module's, the final one's.
fn drives() -> [EvidenceDrive; 2] {
    let rows = load_evidence("published").unwrap().value.row;
    [0, 1].map(|row: usize| rows[row].drive.clone().unwrap())
}

/// Stroke of the first module, and second visit of the final one, for a hypothesis about their wires.
fn published(change: impl Fn(&mut WireParameters)) -> (Visit, Visit) {
    let person = Person {
        vibration_um: 0.45,
        flutter_um: 5.0,
        np2_um: None,
        growth: [0.7, 1.0],
    };
    let played = |base: WireParameters, drive: &EvidenceDrive| {
        let mut wire = base;
        change(&mut wire);
        visit(&wire, &TissueParameters::DEFAULT, drive, person).unwrap()
    };
    let [first, second] = drives();
    (
        played(WireParameters::FIRST, &first),
        played(WireParameters::FINAL, &second),
    )
}

fn strain(strain: f64, sag_um: f64) -> impl Fn(&mut WireParameters) {
    move |wire| {
        wire.mechanics = Mechanics {
            transformation_strain: strain,
            ..wire.mechanics
        };
        wire.reversible = 0.02;
        wire.mount.sag_m = sag_um * 1e-6;
    }
}

/// Holds stroke of the first module, um, and level of the final one's second visit, dB, against the published ones.
fn holds((first, second): (Visit, Visit), stroke_um: Option<f64>, level_db: f64) {
    if let Some(expected) = stroke_um {
        let off = (first.stroke_um - expected).abs();
        assert!(off < 0.6, "{} for {expected} um", first.stroke_um);
    }
    let off = (second.level_db - level_db).abs();
    assert!(off < 0.5, "{} for {level_db} dB", second.level_db);
}

/// Rows of the hypotheses about the published bench whose wires do not pull tight (docs/felt.md).
#[test]
fn hypotheses_about_the_published_modules_play_as_computed_apart() {
    let taut = |w: &mut WireParameters| {
        *w = w.taut();
        w.mount.sag_m = 170e-6;
    };
    holds(published(taut), Some(3.2), 19.0);
    holds(published(strain(0.002, 100.0)), None, 2.8);
    holds(published(strain(0.002, 170.0)), None, 4.6);
    holds(published(strain(0.001, 43.0)), None, 1.5);
    holds(published(strain(0.001, 170.0)), None, 4.0);
    let passed = |sag| {
        move |w: &mut WireParameters| {
            strain(0.01, sag)(w);
            w.history = History {
                state: WireState::Passed,
                sag_state: WireState::Passed,
                coldest_c: None,
            };
        }
    };
    holds(published(passed(43.0)), Some(15.5), 1.9);
    holds(published(passed(170.0)), Some(22.5), 4.8);
}

fn bench() -> Setup {
    Setup::load(SCENE, "emulated").unwrap()
}

fn calibration(evidence: &[Loaded<EvidenceFile>]) -> Calibration {
    let priors = load_priors("default").unwrap();
    Calibration::new(bench(), &priors, evidence, true, 1).unwrap()
}

#[test]
fn a_draw_is_the_same_in_any_order() {
    let published = [load_evidence("published").unwrap()];
    let (one, other) = (calibration(&published), calibration(&published));
    let forth: Vec<Drawn> = (0..6).map(|n| one.drawn(n, &mut ()).unwrap()).collect();
    let back = (0..6).rev().map(|n| other.drawn(n, &mut ()).unwrap());
    let mut back: Vec<Drawn> = back.collect();
    back.reverse();
    assert_eq!(forth, back);
    assert!(forth.windows(2).all(|pair| pair[0] != pair[1]));
    assert!(forth.iter().any(|d| d.error_mm < one.unplaced_mm - 1.0));
}

/// A vibrometer's trace of a wire of the bench that is not quite what its file says, with 0.05 um of noise.
fn trace(wire: &WireParameters, tissue: &TissueParameters) -> Vec<Sample> {
    let mut worn = Wire::new(wire, tissue, 33.0).unwrap().worn(tissue).unwrap();
    let mut noise = RandomStream::new(1, "vibrometer");
    let mut samples = Vec::new();
    for burst in 0..4_u64 {
        let amps = [0.8, 1.2, 1.0, 1.2][burst as usize];
        for pulse in 0..5 {
            let start = burst * 120_000 + pulse * 5_079;
            let edges = [(start, amps), (start + 60, amps)];
            let later = [120, 400, 1_000, 2_500].map(|us| (start + us, 0.0));
            for (time_us, amps) in edges.into_iter().chain(later) {
                let at = Nanos::from_micros(time_us);
                let value = worn.displacement_m(at) * 1e6 + 0.05 * noise.normal();
                worn.set_current(at, amps);
                samples.push(Sample {
                    time_us,
                    value,
                    amps,
                });
            }
        }
    }
    samples
}

/// A wire of the default bench that is not what its file says, and the bench's finger.
fn hidden(setup: &Setup) -> (WireParameters, TissueParameters) {
    let mut hidden = plan::wire(setup);
    hidden.bias_stress_pa = 13e6;
    hidden.mechanics.transformation_strain = 0.0025;
    hidden.mount.sag_m = 235e-6;
    (hidden, setup.bench.value.tissue.parameters())
}

/// The trace whose figures docs/felt.md has; `PALPATE_WRITE_TRACE=1` writes it anew.
#[test]
fn the_shipped_trace_is_of_the_hidden_wire() {
    let (wire, tissue) = hidden(&bench());
    let mut text = String::from("time_us,current_a,displacement_um\n");
    for sample in trace(&wire, &tissue) {
        text += &format!("{},{},{:.3}\n", sample.time_us, sample.amps, sample.value);
    }
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../fixtures/traces/hidden.csv"
    );
    if std::env::var_os("PALPATE_WRITE_TRACE").is_some() {
        std::fs::write(path, &text).unwrap();
    }
    assert!(
        std::fs::read_to_string(path).unwrap_or_default() == text,
        "{path} is out of date: run the tests with PALPATE_WRITE_TRACE=1"
    );
}

#[test]
fn a_wire_that_was_identified_narrows_the_band() {
    let setup = bench();
    let assumed = plan::wire(&setup);
    let (hidden, tissue) = hidden(&setup);
    let subject = Subject {
        wire: assumed,
        tissue,
        start_c: 33.0,
    };
    let samples = trace(&hidden, &tissue);
    let found = identify(&subject, Signal::Displacement, &samples).unwrap();
    let rows = found.evidence("a trace");
    assert!(rows.len() >= 3, "{found:?}");
    let identified = Loaded {
        value: EvidenceFile {
            name: "identified".to_owned(),
            description: "a trace".to_owned(),
            row: rows,
        },
        source: Source::new("identified.toml", ""),
    };
    let published = load_evidence("published").unwrap();
    let band = |evidence: &[Loaded<EvidenceFile>]| {
        let calibration = calibration(evidence);
        let drawn = |n| calibration.drawn(n, &mut ()).unwrap();
        let drawn: Vec<Drawn> = (0..120).map(drawn).collect();
        Posterior::new(&drawn)
    };
    let before = band(std::slice::from_ref(&published));
    let after = band(&[published, identified]);
    // Equal weights: what so few draws leave of the published rows would be noise.
    let width = |of: &Posterior| of.before.level_db[2] - of.before.level_db[0];
    assert!(
        width(&after) < 0.8 * width(&before),
        "{before:?}\n{after:?}"
    );
    assert!(after.kinds_before.taut < 0.01, "{after:?}");
}

#[test]
fn a_row_that_no_prior_is_near_is_named() {
    let text = "name = \"a\"\ndescription = \"a\"\n[[row]]\nquantity = \"strain\"\nvalue = 8.0\nunit = \"%\"\ntolerance = [0.1, 0.1]\nsource = \"a\"\n";
    let evidence = Loaded::read(Source::new("mine.toml", text)).unwrap();
    let priors = load_priors("default").unwrap();
    let refused = Calibration::new(bench(), &priors, &[evidence], true, 1);
    assert_eq!(
        refused.unwrap_err().to_string(),
        "mine.toml:5: row[0].value: expected a value near the prior of strain, 0.1 to 3 %, found 8.0"
    );
}
