//! `hil study`: studies with people.

use std::io::{self, Write};

use palpate_files::{Protocol, load_protocol};
use palpate_run::Failure;
use palpate_study::{Outcome, Simulation, simulate};
use serde::Serialize;

use crate::cli::{SimulateArgs, StudyAction};
use crate::output::print;

/// Does what is asked.
///
/// # Errors
/// A protocol that cannot be read, too few people.
pub fn study(action: &StudyAction) -> Result<(), Failure> {
    match action {
        StudyAction::Simulate(args) => simulated(args),
    }
}

fn simulated(args: &SimulateArgs) -> Result<(), Failure> {
    let protocol = load_protocol(&args.protocol)?.value;
    let of = Simulation {
        people: args.people,
        seed: args.seed,
    };
    let outcome = simulate(&protocol, of).map_err(|e| Failure::Input(e.to_string()))?;
    print(|out| match args.json {
        true => {
            #[derive(Serialize)]
            struct Whole<'a> {
                protocol: &'a str,
                people: u32,
                seed: u64,
                assumed: Option<&'a str>,
                #[serde(flatten)]
                outcome: Outcome,
            }
            let whole = Whole {
                protocol: &protocol.name,
                people: args.people,
                seed: args.seed,
                assumed: protocol.assumed.as_deref(),
                outcome,
            };
            writeln!(out, "{}", serde_json::to_string(&whole)?)
        }
        false => text(args, &protocol, &outcome, out),
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
    let mut line =
        |name: &str, value: String, words: &str| writeln!(out, "  {name:<20}{value:<10}{words}");
    let percent = |part: f64| format!("{:.1} %", 100.0 * part);
    if let (Some(found), Some(task)) = (&outcome.thresholds, &protocol.absolute_threshold) {
        line(
            "threshold error",
            percent(found.threshold_error_median),
            &format!(
                "of its amplitude, median of {} thresholds; {} trials each",
                found.thresholds, task.trials
            ),
        )?;
        line(
            "coverage",
            percent(found.coverage),
            "of the 95 % intervals hold the true threshold",
        )?;
        let width = format!("{:.1} dB", found.interval_db_median);
        line("interval", width, "wide, median")?;
    }
    if let (Some(found), Some(task)) = (&outcome.ratings, &protocol.rating) {
        let [first, second] = &task.conditions;
        line(
            "false positives",
            percent(found.false_positive_rate),
            &format!(
                "of 1000 studies find {first} and {second} different where they are not (p < 5 %)"
            ),
        )?;
        let difference = task.simulated.difference;
        line(
            "power",
            percent(found.power),
            &format!("find a difference of {difference} in {}", task.question),
        )?;
        let enough = found.people_for_power;
        line(
            "people",
            enough.map_or_else(|| "over 1000".into(), |n| n.to_string()),
            "for that to be found by 80 %",
        )?;
    }
    if let Some(assumed) = &protocol.assumed {
        writeln!(out, "  assumed: {assumed}")?;
    }
    Ok(())
}
