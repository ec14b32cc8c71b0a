//! `hil study simulate`: how well a protocol finds what is true of simulated people.

use std::io::{self, Write};

use palpate_files::{Protocol, load_protocol};
use palpate_run::Failure;
use palpate_study::{Known, Outcome, Session, Simulation, simulate};
use serde::Serialize;

use super::devices::bench;
use crate::cli::SimulateArgs;
use crate::study::{Stimuli, growth, planned};
use palpate_live::output::{print, print_json};

/// Simulates a study and prints its results.
///
/// # Errors
/// [`Failure`] for a protocol that cannot be read or played, too few people.
pub(super) fn simulated(args: &SimulateArgs) -> Result<(), Failure> {
    let loaded = load_protocol(&args.protocol)?;
    let of = Simulation {
        people: args.people,
        seed: args.seed,
    };
    // What the person of the default bench feels, and where its wires and paths lie.
    let stimuli = Stimuli::new(loaded.clone(), bench(None, &[], &[])?)?;
    let mut known = match loaded.value.drawing.is_some() || loaded.value.localisation.is_some() {
        true => {
            let session = Session::new(loaded.value.clone(), 1, args.seed);
            planned(&stimuli, &session)?.known
        }
        false => Known::default(),
    };
    known.growth = growth(&stimuli)?;
    let protocol = &loaded.value;
    let outcome = simulate(protocol, of, &known).map_err(|e| Failure::Input(e.to_string()))?;
    if !args.json {
        return print(|out| text(args, protocol, &outcome, out));
    }
    #[derive(Serialize)]
    struct Whole<'a> {
        protocol: &'a str,
        people: u32,
        seed: u64,
        assumed: Option<&'a str>,
        #[serde(flatten)]
        outcome: Outcome,
    }
    print_json(&Whole {
        protocol: &protocol.name,
        people: args.people,
        seed: args.seed,
        assumed: protocol.assumed.as_deref(),
        outcome,
    })
}

fn text(
    args: &SimulateArgs,
    protocol: &Protocol,
    outcome: &Outcome,
    out: &mut dyn Write,
) -> io::Result<()> {
    let (people, seed) = (args.people, args.seed);
    writeln!(
        out,
        "{} with {people} simulated people, seed {seed}: {}",
        protocol.name, protocol.description
    )?;
    levels(protocol, outcome, out)?;
    places(outcome, out)?;
    groups(protocol, outcome, out)?;
    match &protocol.assumed {
        Some(assumed) => writeln!(out, "  assumed: {assumed}"),
        None => Ok(()),
    }
}

fn line(out: &mut dyn Write, name: &str, value: &str, words: &str) -> io::Result<()> {
    writeln!(out, "  {name:<20}{value:<10}{words}")
}

fn percent(part: f64) -> String {
    format!("{:.1} %", 100.0 * part)
}

/// Prints the errors of thresholds and levels.
fn levels(protocol: &Protocol, outcome: &Outcome, out: &mut dyn Write) -> io::Result<()> {
    if let (Some(found), Some(task)) = (&outcome.thresholds, &protocol.absolute_threshold) {
        let words = format!(
            "of its amplitude, median of {} thresholds; {} trials each",
            found.thresholds, task.trials
        );
        line(
            out,
            "threshold error",
            &percent(found.threshold_error_median),
            &words,
        )?;
        let words = "of the 95 % intervals hold the true threshold";
        line(out, "coverage", &percent(found.coverage), words)?;
        let width = format!("{:.1} dB", found.interval_db_median);
        line(out, "interval", &width, "wide, median")?;
    }
    for (name, found) in [
        ("difference", &outcome.difference),
        ("matching", &outcome.matching),
    ] {
        if let Some(found) = found {
            let error = format!("{:.2} dB", found.error_db_median);
            let words = format!("median of {}", found.levels);
            line(out, &format!("{name} error"), &error, &words)?;
            let words = "of the 95 % intervals hold the truth";
            line(out, "coverage", &percent(found.coverage), words)?;
        }
    }
    Ok(())
}

/// Prints the errors of places and paths.
fn places(outcome: &Outcome, out: &mut dyn Write) -> io::Result<()> {
    if let Some(found) = &outcome.localisation {
        let words = "of answers are nearest to the driven one";
        line(out, "right wire", &percent(found.correct), words)?;
        let mm = format!("{:.1} mm", found.error_mm_median);
        line(out, "distance", &mm, "from it, median")?;
    }
    if let Some(found) = &outcome.drawing {
        let mm = format!("{:.2} mm", found.rmse_mm_median);
        line(out, "drawing RMSE", &mm, "after alignment, median")?;
        let mm = format!("{:.2} mm", found.frechet_mm_median);
        line(out, "drawing Frechet", &mm, "median")?;
        line(
            out,
            "breaks",
            &format!("{:.2}", found.breaks_mean),
            "per drawing",
        )?;
    }
    Ok(())
}

/// Prints how often a difference or a preference is found, and how many people it needs.
fn groups(protocol: &Protocol, outcome: &Outcome, out: &mut dyn Write) -> io::Result<()> {
    let enough = |n: Option<u32>| n.map_or_else(|| "over 1000".into(), |n| n.to_string());
    let people = "for that to be found by 80 %";
    if let (Some(found), Some(task)) = (&outcome.ratings, &protocol.rating) {
        let pairs: Vec<String> = task
            .compare
            .iter()
            .map(|[a, b]| format!("{a} and {b}"))
            .collect();
        let compared = match pairs.is_empty() {
            true => "two groups of people".into(),
            false => pairs.join(", "),
        };
        let words =
            format!("of 1000 studies find {compared} different where they are not (p < 5 %)");
        line(
            out,
            "false positives",
            &percent(found.false_positive_rate),
            &words,
        )?;
        let words = format!(
            "find a difference of {} on a scale of 1 to 6",
            task.simulated.difference
        );
        line(out, "power", &percent(found.power), &words)?;
        line(out, "people", &enough(found.people_for_power), people)?;
    }
    if let Some(found) = &outcome.choice {
        let words = "of 1000 studies find a preference where there is none";
        line(
            out,
            "false positives",
            &percent(found.false_positive_rate),
            words,
        )?;
        line(
            out,
            "power",
            &percent(found.power),
            "find the protocol's preference",
        )?;
        line(out, "people", &enough(found.people_for_power), people)?;
    }
    Ok(())
}
