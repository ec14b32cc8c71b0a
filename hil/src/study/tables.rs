//! Tables of a study as Psych-DS lays them out, and wearers' files.

use std::fmt::Write as _;

use palpate_files::Protocol;
use palpate_records::table::{as_csv, plain};
use palpate_study::{Answer, Estimate, Participant, Record, Reply, Stimulus};
use serde_json::{Value, json};

/// Columns of a participant's table, a line each, with what each holds.
const COLUMNS: &str = include_str!("columns.txt");

fn columns() -> impl Iterator<Item = (&'static str, &'static str)> {
    COLUMNS.lines().filter_map(|line| line.split_once(": "))
}

fn word(stimulus: Option<&Stimulus>) -> String {
    match stimulus {
        None => String::new(),
        Some(Stimulus::Silence) => "silence".into(),
        Some(Stimulus::Wire { wire, level_db }) => format!("wire {wire} at {level_db:.2} dB"),
        Some(Stimulus::Condition(name)) => name.clone(),
    }
}

/// A participant's table: a row per trial that was begun and came to an end.
#[must_use]
pub fn data(record: &Record) -> String {
    let mut text = as_csv([columns().map(|(name, _)| name).collect::<Vec<_>>()]);
    for said in record.replies() {
        let Some(played) = &said.trial else {
            continue;
        };
        let interval = |n: usize| word(played.intervals.get(n).and_then(|i| i.stimulus.as_ref()));
        let number = |n: Option<String>| n.unwrap_or_default();
        let (mut status, mut why) = ("answered", String::new());
        // Interval and whether it counts as yes, x and y, ratings, strokes and points.
        let mut answer: [String; 7] = Default::default();
        match &said.reply {
            Reply::Void(reason) => (status, why) = ("void", reason.clone()),
            Reply::Answer(Answer::Interval(n)) => {
                answer[0] = n.to_string();
                answer[1] = number(played.right.map(|r| u8::from(r == *n).to_string()));
            }
            Reply::Answer(Answer::Place(place)) => {
                [answer[2], answer[3]] = place.map(|mm| format!("{mm:.3}"));
            }
            Reply::Answer(Answer::Ratings(given)) => {
                let given: Vec<String> = given.iter().map(u8::to_string).collect();
                answer[4] = given.join(";");
            }
            Reply::Answer(Answer::Path(drawn)) => {
                answer[5] = drawn.len().to_string();
                answer[6] = drawn.iter().map(Vec::len).sum::<usize>().to_string();
            }
            _ => {}
        }
        let began = played.intervals.first().map(|i| i.began_ms.to_string());
        let stimuli: usize = played.intervals.iter().map(|i| i.bursts.len()).sum();
        let before = [
            record.about.participant.to_string(),
            played.number.to_string(),
            played.attempt.to_string(),
            status.into(),
            played.task.name().into(),
            u8::from(played.practice).to_string(),
            interval(0),
            interval(1),
            number(played.level_db.map(|db| db.to_string())),
            number(played.right.map(|r| r.to_string())),
        ];
        let after = [
            number(began),
            played.asked_ms.to_string(),
            said.at_ms.to_string(),
            stimuli.to_string(),
            why,
        ];
        let row = before.into_iter().chain(answer).chain(after);
        text += &as_csv([row.map(|cell| plain(&cell)).collect::<Vec<_>>()]);
    }
    text
}

/// Description of a table's columns: the JSON beside the table.
#[must_use]
pub fn sidecar(protocol: &Protocol) -> String {
    let columns = columns()
        .map(|(name, what)| json!({ "@type": "PropertyValue", "name": name, "description": what }));
    let columns: Vec<Value> = columns.collect();
    let scales: Vec<&str> = protocol
        .rating
        .iter()
        .flat_map(|task| &task.scales)
        .map(|scale| scale.name.as_str())
        .collect();
    let whole = json!({ "variableMeasured": columns, "scales": scales });
    format!("{whole:#}\n")
}

/// The file that makes a folder a Psych-DS data set.
#[must_use]
pub fn description(protocol: &Protocol) -> String {
    let columns: Vec<&str> = columns().map(|(name, _)| name).collect();
    let whole = json!({
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": protocol.name,
        "description": protocol.description,
        "variableMeasured": columns,
    });
    format!("{whole:#}\n")
}

/// A level, dB of full drive, as a part of it.
fn part(db: f64) -> f64 {
    10f64.powf(db / 20.0)
}

/// Least gain that a wearer's file may state.
const LEAST_GAIN: f64 = 0.01;
/// Largest ratio of a threshold to the gain of its wire.
const BELOW: f64 = 0.99;

/// A wearer's file of a participant's thresholds and matches, for a display of so many wires. `None` without a threshold of
/// every wire.
#[must_use]
pub fn wearer(protocol: &Protocol, participant: &Participant, wires: usize) -> Option<String> {
    let of = |found: &[palpate_study::OfWire], wire: usize| -> Option<Estimate> {
        let mut found = found.iter();
        found
            .find(|of| usize::from(of.wire) == wire)
            .map(|of| of.estimate)
    };
    let thresholds: Option<Vec<Estimate>> = (0..wires)
        .map(|wire| of(&participant.thresholds, wire))
        .collect();
    let thresholds = thresholds?;
    // Where wires were matched: the level of each that feels as the reference does at its own.
    let alike: Vec<(f64, f64, f64)> = (0..wires)
        .map(|wire| {
            let own = protocol
                .matching
                .as_ref()
                .filter(|task| usize::from(task.reference) == wire);
            let own = own.map(|task| (task.level_db, task.level_db, task.level_db));
            let matched = of(&participant.matches, wire).map(|e| (e.value, e.low, e.high));
            own.or(matched).unwrap_or((0.0, 0.0, 0.0))
        })
        .collect();
    // The weakest wire has full drive, and the others as much less as they felt alike with less.
    let weakest = alike
        .iter()
        .map(|level| level.0)
        .fold(f64::NEG_INFINITY, f64::max);
    let gain = |db: f64| part(db - weakest).clamp(LEAST_GAIN, 1.0);
    let mut text = String::new();
    let list = |values: Vec<String>| format!("[{}]", values.join(", "));
    let number = |value: f64| format!("{value:.4}");
    let pair = |(low, high): (f64, f64)| format!("[{low:.4}, {high:.4}]");
    let gains: Vec<f64> = alike.iter().map(|level| gain(level.0)).collect();
    let below: Vec<f64> = thresholds
        .iter()
        .zip(&gains)
        .map(|(e, gain)| part(e.value).min(BELOW * gain))
        .collect();
    let full = |value: f64| part(value).min(1.0);
    let spans = alike
        .iter()
        .map(|level| pair((gain(level.1), gain(level.2))));
    let least = thresholds.iter().map(|e| pair((full(e.low), full(e.high))));
    let n = participant.number;
    // Writing to a text does not fail.
    let _ = write!(
        text,
        "# Participant {n} of `{}`: thresholds from two intervals, gains from wires that felt alike. 95 % intervals beside them.\nname = \"participant-{n}\"\ndescription = \"Participant {n} of the study {}\"\ngain = {}\ngain_interval = {}\nthreshold = {}\nthreshold_interval = {}\n",
        protocol.name,
        protocol.name,
        list(gains.iter().copied().map(number).collect()),
        list(spans.collect()),
        list(below.iter().copied().map(number).collect()),
        list(least.collect()),
    );
    Some(text)
}

#[cfg(test)]
#[path = "tables_tests.rs"]
mod tests;
