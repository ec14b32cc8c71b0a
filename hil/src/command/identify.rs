//! `hil identify`: the figures of a wire that a trace shows.

use std::fmt::Write as _;

use palpate_files::{FileError, Format, Overrides, Rows, Setup, Take, Timing};
use palpate_run::identify::{
    Figure, Identified, MOST_SAMPLES, Sample, Signal, Subject, clipped, identify as find,
};
use palpate_run::{Failure, plan};
use serde_json::json;

use crate::cli::{IdentifyArgs, SignalArg};
use palpate_live::output::Outputs;
use palpate_live::progress::Progress;

/// Temperature of skin and wire before the first pulse, degrees C.
const START_C: f64 = 33.0;

/// Fits the model to a trace and prints what it says.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn identify(args: &IdentifyArgs) -> Result<(), Failure> {
    let (signal, column, unit) = match args.signal {
        SignalArg::Displacement => (Signal::Displacement, "displacement_um", "um"),
        SignalArg::Resistance => (Signal::Resistance, "resistance_ohm", "Ohm"),
    };
    let outputs = Outputs::new(args.force);
    outputs.check_some(args.out.as_deref(), Format::Toml)?;
    let samples = read(args, column)?;
    let shown = Progress::endless("fitting the model");
    let found = find(&subject(args)?, signal, &samples).map_err(|expected| {
        let found = format!("{} samples", samples.len());
        Failure::File(FileError::whole(
            args.trace.display().to_string(),
            expected,
            found,
        ))
    })?;
    drop(shown);
    outputs.write_some(args.out.as_deref(), Format::Toml, || evidence(&found, args))?;
    let object = || object(&found, unit);
    args.voice.tell(object, |out| {
        writeln!(
            out,
            "{:26} {:>12} {:>12}  {:>10}",
            "figure", "value", "95 % +-", "assumed"
        )?;
        for figure in &found.figures {
            writeln!(out, "{}", line(figure))?;
        }
        writeln!(
            out,
            "{} samples, {:.3} {unit} rms from the model",
            found.samples, found.rms
        )
    })
}

/// File of evidence with a row for each figure that the trace shows.
fn evidence(found: &Identified, args: &IdentifyArgs) -> String {
    let trace = args.trace.display();
    let source = format!("hil identify {trace}: {} samples", found.samples);
    let mut text = format!(
        "# Written by `hil identify` of palpate.\nname = \"identified\"\ndescription = {:?}\n",
        format!("Wires of bench {} by a trace", args.bench)
    );
    for row in found.evidence(&source) {
        let [below, above] = row.tolerance.unwrap_or_default();
        let _ = write!(
            text,
            "\n[[row]]\nquantity = {:?}\nvalue = {:?}\nunit = {:?}\ntolerance = [{below:?}, {above:?}]\nsource = {:?}\n",
            row.quantity, row.value, row.unit, row.source
        );
    }
    text
}

fn line(figure: &Figure) -> String {
    let name = format!("{} {}", figure.name, figure.unit);
    match figure.found {
        Some(found) => format!(
            "{name:26} {:>12.4} {:>12.4}  {:>10.4}",
            found.value, found.half, figure.assumed
        ),
        None => format!(
            "{name:26} {:>12} {:>12}  {:>10.4}",
            "not shown", "", figure.assumed
        ),
    }
}

fn object(found: &Identified, unit: &str) -> serde_json::Value {
    let figure = |f: &Figure| {
        json!({
            "name": f.name,
            "unit": f.unit,
            "assumed": f.assumed,
            "value": f.found.map(|found| found.value),
            "half_95": f.found.map(|found| found.half),
        })
    };
    let figures: Vec<_> = found.figures.iter().map(figure).collect();
    json!({"figures": figures, "rms": found.rms, "rms_unit": unit, "samples": found.samples})
}

/// The wire as the bench has it.
fn subject(args: &IdentifyArgs) -> Result<Subject, Failure> {
    let mut overrides = Overrides::default();
    for set in &args.set {
        overrides.set(&format!("--set bench.{set}"), &format!("bench.{set}"))?;
    }
    // A wire needs no scene, but a bench is checked with one.
    let setup = Setup::load("idle", &args.bench)?.with(&overrides)?;
    let instead = "a motor's trace fits no wire; state `resonance_hz`, `quality`, `ohm` and `full_v` of its data sheet in [haptics]";
    plan::wires_only(&setup.bench, instead)?;
    Ok(Subject {
        wire: plan::wire(&setup),
        tissue: setup.bench.value.tissue.parameters(),
        start_c: START_C,
    })
}

/// The trace's rows.
fn read(args: &IdentifyArgs, column: &str) -> Result<Vec<Sample>, Failure> {
    let names = [column.to_owned(), "current_a".to_owned()];
    let take = Take::Features {
        names: &names,
        count: 2,
    };
    let timing = Timing {
        column: args.time.clone(),
        rate_hz: args.rate,
        ..Timing::default()
    };
    let _shown = Progress::reading(&args.trace);
    let mut rows = Rows::open(&args.trace, take, Some(&timing))?;
    let (mut samples, mut lines, mut row) = (Vec::new(), Vec::new(), Vec::<f32>::new());
    while let Some(at) = rows.advance(&mut row)? {
        if samples.len() == MOST_SAMPLES {
            return Err(Failure::File(rows.too_long(at.line)));
        }
        let &[value, amps] = row.as_slice() else {
            continue; // `Take` counts them
        };
        lines.push(at.line);
        if !(0.0..=5.0).contains(&amps) {
            return Err(bad(
                args,
                at.line,
                "current_a",
                "a number from 0 to 5 A",
                format!("{amps}"),
            ));
        }
        samples.push(Sample {
            time_us: at.time_us,
            value: f64::from(value),
            amps: f64::from(amps),
        });
    }
    if let Some((from, count)) = clipped(&samples) {
        let found = format!(
            "{count} equal samples of {}, an end of the range",
            samples[from].value
        );
        let expected = "samples that the instrument has not clipped (choose a wider range)";
        return Err(bad(args, lines[from], column, expected, found));
    }
    Ok(samples)
}

fn bad(args: &IdentifyArgs, line: usize, key: &str, expected: &str, found: String) -> Failure {
    Failure::File(FileError {
        path: args.trace.display().to_string(),
        line: Some(line),
        key: Some(key.into()),
        expected: expected.into(),
        found,
    })
}
